//! Entities by the numbers that a recording has for them.

use std::collections::HashMap;

use bevy::prelude::*;

use crate::scene::SpawnedScene;

/// Bodies of the scene, its joints, then whatever came, in its order.
#[derive(Clone, Debug, Default)]
pub struct Numbers {
    list: Vec<Entity>,
    of: HashMap<Entity, u32>,
}

impl Numbers {
    /// Of a scene that nothing was done to.
    pub fn of_scene(entities: &SpawnedScene) -> Self {
        let mut numbers = Self::default();
        entities.bodies.iter().chain(&entities.joints).for_each(|&entity| _ = numbers.number(entity));
        numbers
    }

    /// All, in the order of their numbers.
    pub fn entities(&self) -> &[Entity] {
        &self.list
    }

    /// The entity of that number.
    pub fn entity(&self, number: u32) -> Option<Entity> {
        self.list.get(number as usize).copied()
    }

    /// Its number, a new one if it has none.
    pub fn number(&mut self, entity: Entity) -> u32 {
        *self.of.entry(entity).or_insert_with(|| {
            self.list.push(entity);
            self.list.len() as u32 - 1
        })
    }

    /// Another entity has that number from now on.
    pub fn renumber(&mut self, number: u32, entity: Entity) {
        let before = std::mem::replace(&mut self.list[number as usize], entity);
        self.of.remove(&before);
        self.of.insert(entity, number);
    }

    /// Its number, if it has one.
    pub fn known(&self, entity: Entity) -> Option<u32> {
        self.of.get(&entity).copied()
    }
}
