//! The ball.

use std::f64::consts::PI;

use bevy::math::DVec3;

use super::Measures;

/// Moments 2/5 r².
pub(super) fn measures(radius: f64) -> Measures {
    Measures { volume: 4.0 / 3.0 * PI * radius.powi(3), moments: DVec3::splat(0.4 * radius * radius), radius }
}
