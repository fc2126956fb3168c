//! Angles of rotations and between axes.

use std::f64::consts::TAU;

use bevy::math::{DQuat, DVec3};

/// The angle from one rotation to another, rad, to all digits however small; none of what is the same.
pub fn turn_between(from: DQuat, to: DQuat) -> f64 {
    if from == to {
        return 0.0;
    }
    let turn = to * from.inverse();
    2.0 * turn.xyz().length().atan2(turn.w.abs())
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
