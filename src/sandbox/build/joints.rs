//! The joints of the running scene, and the pins that hold bodies to the world.

use bevy::prelude::*;

use crate::physics::BallJoint;
use crate::scene::SceneEntity;

/// A body without a shape that stands still, made by [`pin_picked`](super::pin_picked): it goes when it holds nothing.
#[derive(Component)]
pub struct Pin;

/// The joints of the scene and of the user; not the one that drags.
pub fn joints(world: &mut World) -> Vec<(Entity, BallJoint)> {
    let mut joints = world.query_filtered::<(Entity, &BallJoint), With<SceneEntity>>();
    joints.iter(world).map(|(joint, ball)| (joint, *ball)).collect()
}

/// A body's own.
pub fn joints_of(world: &mut World, body: Entity) -> Vec<(Entity, BallJoint)> {
    let mut joints = joints(world);
    joints.retain(|(_, ball)| ball.body_a == body || ball.body_b == body);
    joints
}

/// The pins that would hold nothing without these joints.
pub fn idle_without(world: &mut World, cut: &[(Entity, BallJoint)]) -> Vec<Entity> {
    let all = joints(world);
    let mut idle: Vec<Entity> = cut.iter().flat_map(|(_, ball)| [ball.body_a, ball.body_b]).collect();
    idle.sort_unstable();
    idle.dedup();
    idle.retain(|&end| {
        let stays = |(joint, ball): &(Entity, BallJoint)| {
            (ball.body_a == end || ball.body_b == end) && !cut.iter().any(|(gone, _)| gone == joint)
        };
        world.get::<Pin>(end).is_some() && !all.iter().any(stays)
    });
    idle
}
