//! What answers ask of a scene's bodies.

use std::collections::HashMap;
use std::f64::consts::TAU;

use bevy::math::{DQuat, DVec3};

use crate::physics::RigidBody;
use crate::scene::{BodySpec, JointSpec, SceneSpec};

/// Indices of the bodies that move, in the scene's order.
pub(super) fn dynamic(scene: &SceneSpec) -> Vec<usize> {
    let is_dynamic = |body: &BodySpec| body.kind == RigidBody::Dynamic;
    (0..scene.bodies.len()).filter(|&index| is_dynamic(&scene.bodies[index])).collect()
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

/// Each joint with the places of its bodies A and B.
pub(super) fn joined(scene: &SceneSpec) -> impl Iterator<Item = (&JointSpec, [usize; 2])> {
    let places: HashMap<&str, usize> = scene.bodies.iter().map(|body| body.name.as_str()).zip(0..).collect();
    let bodies = move |joint: &JointSpec| {
        let place = |name: &str| places.get(name).copied();
        Some([place(&joint.body_a)?, place(&joint.body_b)?])
    };
    scene.joints.iter().filter_map(move |joint| Some((joint, bodies(joint)?)))
}

/// The turn about an axis since a start, rad, −π to π.
pub(super) fn turn(rotation: DQuat, start: DQuat, axis: DVec3) -> f64 {
    twist(rotation * start.inverse(), axis)
}

/// The part of a rotation that is about an axis, rad, −π to π.
pub(super) fn twist(rotation: DQuat, axis: DVec3) -> f64 {
    wrapped(2.0 * rotation.xyz().dot(axis).atan2(rotation.w))
}

/// The same angle, −π to π.
pub(super) fn wrapped(angle: f64) -> f64 {
    angle - TAU * (angle / TAU).round()
}

/// Exact for small angles, where acos is not.
pub(super) fn angle_between(a: DVec3, b: DVec3) -> f64 {
    a.cross(b).length().atan2(a.dot(b))
}
