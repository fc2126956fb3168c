//! What others than the step did to a world between two steps.

use std::any::TypeId;

use bevy::ecs::change_detection::Tick;
use bevy::prelude::*;

use super::bury::{empty, is_empty};
use super::kinds::{AnyValue, Column, Kinds, Removals};

/// What was done between two steps, by the types of what was written.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Deeds {
    /// Bodies and joints that were taken out of the world.
    pub buried: Vec<Entity>,
    /// Components that were taken off.
    pub removed: Vec<(TypeId, Entity)>,
    /// Components that were written or put on.
    pub written: Vec<(TypeId, Entity)>,
    /// Resources that were written.
    pub resources: Vec<TypeId>,
}

/// What was written, added, taken off and buried between two steps.
pub(super) struct Acts {
    written: Vec<Box<dyn Column>>,
    /// Kinds by their place, and whose component it was.
    removed: Vec<(usize, Entity)>,
    /// Kinds by their place.
    resources: Vec<(usize, AnyValue)>,
    /// Entities that were emptied.
    buried: Vec<Entity>,
}

impl Acts {
    /// Those since then.
    pub fn since(world: &mut World, kinds: &mut Kinds, since: Tick) -> Self {
        let removed = world.resource::<Removals>().list.clone();
        let written = kinds.components.iter_mut().filter_map(|kind| kind.written(world, since)).collect();
        let resources = kinds.resources.iter().enumerate();
        let resources = resources.filter_map(|(place, kind)| Some((place, (kind.written)(world, since)?))).collect();
        let mut gone: Vec<Entity> = removed.iter().map(|&(_, entity)| entity).collect();
        gone.sort_unstable();
        gone.dedup();
        gone.retain(|&entity| is_empty(world, entity));
        Self { written, removed, resources, buried: gone }
    }

    /// Whether nothing was done.
    pub fn is_empty(&self) -> bool {
        self.written.is_empty() && self.removed.is_empty() && self.resources.is_empty() && self.buried.is_empty()
    }

    /// Does the same again.
    pub fn repeat(&self, world: &mut World, kinds: &Kinds) {
        // Whole, so that it is known what they looked like.
        for &entity in &self.buried {
            empty(world, entity);
        }
        for &(kind, entity) in &self.removed {
            if let Ok(mut entity) = world.get_entity_mut(entity) {
                kinds.components[kind].remove(&mut entity);
            }
        }
        self.written.iter().for_each(|column| column.put_on(world));
        Removals::dress(world, kinds);
        self.written.iter().for_each(|column| column.write(world));
        for (kind, value) in &self.resources {
            (kinds.resources[*kind].write)(world, value);
        }
    }

    /// What they are.
    pub fn deeds(&self, kinds: &Kinds) -> Deeds {
        let all = self.written.iter();
        let of_column = |column: &dyn Column| {
            let component = column.component();
            column.entities().into_iter().map(move |entity| (component, entity)).collect::<Vec<_>>()
        };
        Deeds {
            buried: self.buried.clone(),
            removed: self.removed.iter().map(|&(kind, entity)| (kinds.components[kind].component(), entity)).collect(),
            written: all.flat_map(|column| of_column(column.as_ref())).collect(),
            resources: self.resources.iter().map(|&(kind, _)| (kinds.resources[kind].resource)()).collect(),
        }
    }

    /// What they take, bytes.
    pub fn bytes(&self) -> usize {
        let removed = size_of_val(&self.removed[..]) + size_of_val(&self.buried[..]);
        self.written.iter().map(|column| column.bytes()).sum::<usize>() + removed
    }
}
