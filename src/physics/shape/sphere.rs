//! The ball.

use std::f64::consts::PI;

use bevy::math::DVec3;

pub(super) fn volume(radius: f64) -> f64 {
    4.0 / 3.0 * PI * radius.powi(3)
}

/// 2/5 r².
pub(super) fn moments(radius: f64) -> DVec3 {
    DVec3::splat(0.4 * radius * radius)
}
