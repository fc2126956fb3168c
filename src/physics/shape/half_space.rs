//! The half-space y ≤ 0: nothing moves it.

use bevy::math::DVec3;

pub(super) const VOLUME: f64 = f64::INFINITY;
pub(super) const MOMENTS: DVec3 = DVec3::INFINITY;
pub(super) const BOUNDING_RADIUS: f64 = f64::INFINITY;
