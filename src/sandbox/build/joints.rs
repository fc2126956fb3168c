//! The joints of the running scene, and the pins that hold bodies to the world.

use bevy::prelude::*;

use crate::sandbox::any_joint::IsJoint;
use crate::scene::{JointComponent, JointParts, SceneEntity};

/// A body without a shape that stands still, made by [`pin_picked`](super::pin_picked): it goes when it holds nothing.
#[derive(Component, Clone, Copy)]
pub struct Pin;

/// The joints of the scene and of the user; not the one that drags.
pub fn joints(world: &mut World) -> Vec<(Entity, JointComponent)> {
    let mut query = world.query_filtered::<Entity, (IsJoint, With<SceneEntity>)>();
    let joints: Vec<Entity> = query.iter(world).collect();
    joints.into_iter().filter_map(|joint| Some((joint, JointParts::of_entity(world, joint)?.joint))).collect()
}

/// The pins that would hold nothing without these joints.
pub fn idle_without(world: &mut World, cut: &[Entity]) -> Vec<Entity> {
    let (cut, kept): (Vec<_>, Vec<_>) = joints(world).into_iter().partition(|(joint, _)| cut.contains(joint));
    let mut idle: Vec<Entity> = cut.iter().flat_map(|(_, joint)| joint.bodies()).collect();
    idle.sort_unstable();
    idle.dedup();
    idle.retain(|end| world.get::<Pin>(*end).is_some() && !kept.iter().any(|(_, joint)| joint.bodies().contains(end)));
    idle
}
