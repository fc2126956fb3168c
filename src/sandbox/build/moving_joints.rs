//! Joints that go over from bodies to what takes their place.

use bevy::math::{DQuat, DVec3};
use bevy::prelude::*;

use super::joints::{Pin, joints};
use super::names::name_of;
use crate::physics::Rotation;
use crate::scene::{JointParts, SceneEntity};

/// The end of a joint on its new body.
pub struct NewEnd {
    pub body: Entity,
    /// From its centre of mass, in its principal axes, m.
    pub anchor: DVec3,
    /// Turns the old body's principal axes into its own.
    pub turn: DQuat,
}

/// What became of joints.
#[derive(Default)]
pub struct Moved {
    /// Those of the bodies.
    pub gone: Vec<Entity>,
    /// Those that hold the same places of what takes the bodies' place.
    pub made: Vec<Entity>,
}

/// Joins what is to take the place of some bodies, which are still there, to what these are joined to. `end` is asked of a body,
/// of the joint's place on it in the world, and of the body's rotation. A joint whose ends go to the same body gets no
/// successor.
pub fn move_joints(world: &mut World, bodies: &[Entity], mut end: impl FnMut(Entity, DVec3, DQuat) -> NewEnd) -> Moved {
    let mut moved = Moved::default();
    for (entity, joint) in joints(world) {
        if !joint.bodies().iter().any(|body| bodies.contains(body)) {
            continue;
        }
        moved.gone.push(entity);
        let Some(mut parts) = JointParts::of_entity(world, entity) else { continue };
        for (side, (body, anchor)) in joint.ends().into_iter().enumerate() {
            let rotation = world.get::<Rotation>(body).map(|rotation| rotation.0);
            let place = super::place_of(world, body, anchor);
            if let (true, Some(rotation), Some(place)) = (bodies.contains(&body), rotation, place) {
                let NewEnd { body, anchor, turn } = end(body, place, rotation);
                parts = parts.with_end(side, (body, anchor), turn);
            }
        }
        let [a, b] = parts.bodies();
        if a != b {
            let mut joint = world.spawn((title(world, [a, b]), SceneEntity));
            parts.insert(&mut joint);
            moved.made.push(joint.id());
        }
    }
    moved
}

fn title(world: &World, [a, b]: [Entity; 2]) -> Name {
    let [first, second] = if world.get::<Pin>(a).is_some() { [b, a] } else { [a, b] };
    let other = if world.get::<Pin>(second).is_some() { "the world".into() } else { name_of(world, second) };
    Name::new(format!("{} to {other}", name_of(world, first)))
}
