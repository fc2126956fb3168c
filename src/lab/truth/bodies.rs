//! What answers ask of a scene's bodies.

use bevy::math::{DQuat, DVec3};

use crate::lab::angle::twist;
use crate::physics::{Collider, RigidBody};
use crate::scene::{BodySpec, SceneSpec};

/// Indices of the bodies that move, in the scene's order.
pub(super) fn dynamic(scene: &SceneSpec) -> Vec<usize> {
    let is_dynamic = |body: &BodySpec| body.kind == RigidBody::Dynamic;
    (0..scene.bodies.len()).filter(|&index| is_dynamic(&scene.bodies[index])).collect()
}

/// What a body is to those who measure how far it moved; none without a shape.
pub(super) fn collider(body: &BodySpec) -> Option<Collider> {
    Some(body.shape.as_ref()?.collider())
}

/// How far the farthest point of a body moves, m; of one without a shape, its centre of mass.
pub(super) fn largest_displacement(shape: Option<&Collider>, centre: DVec3, rotations: [DQuat; 2]) -> f64 {
    shape.map_or(centre.length(), |shape| shape.largest_displacement(centre, rotations))
}

/// The joint that holds the body `index`, as the anchor on it, from its centre of mass in body axes.
pub(super) fn anchor_on(scene: &SceneSpec, index: usize) -> Option<DVec3> {
    let name = &scene.bodies[index].name;
    scene.joints.iter().find_map(|joint| {
        if joint.body_b == *name {
            Some(joint.anchor_b)
        } else if joint.body_a == *name {
            Some(joint.anchor_a)
        } else {
            None
        }
    })
}

/// The turn about an axis since a start, rad, −π to π.
pub(super) fn turn(rotation: DQuat, start: DQuat, axis: DVec3) -> f64 {
    twist(rotation * start.inverse(), axis)
}
