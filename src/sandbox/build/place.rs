//! Where a body was before it was put elsewhere, and of what size.

use bevy::math::{DQuat, DVec3};
use bevy::prelude::*;

use super::rewriting::write_body;
use crate::physics::{Position, RigidBody, Rotation, Velocity, place};
use crate::scene::BodySpec;

/// A body's pose and velocity, and what it was where its shape changed, too.
#[derive(Clone, Debug)]
pub struct Place {
    pub body: Entity,
    position: DVec3,
    rotation: DQuat,
    velocity: Velocity,
    was: Option<Box<BodySpec>>,
}

impl Place {
    /// Where it is now; and what it is, if that is to change.
    pub fn of(world: &World, body: Entity, changes_shape: bool) -> Option<Self> {
        let entity = world.get_entity(body).ok()?;
        entity.get::<RigidBody>()?;
        let was = if changes_shape { Some(Box::new(BodySpec::of_entity(world, body)?)) } else { None };
        let (position, rotation) = (entity.get::<Position>()?.0, entity.get::<Rotation>()?.0);
        Some(Self { body, position, rotation, velocity: entity.get().copied().unwrap_or_default(), was })
    }

    /// Of which body, and whether it tells the shape.
    pub fn key(&self) -> (Entity, bool) {
        (self.body, self.was.is_some())
    }

    /// Puts the body there; where it was. None: it is gone.
    pub fn write(&self, world: &mut World) -> Option<Self> {
        let now = Self::of(world, self.body, self.was.is_some())?;
        if let Some(was) = &self.was {
            write_body(world, self.body, was)?;
        }
        place(world, self.body, self.position, self.rotation);
        if now.velocity != self.velocity {
            world.entity_mut(self.body).insert(self.velocity);
        }
        Some(now)
    }
}
