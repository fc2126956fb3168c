//! Gravity of the built-in scenes.

use bevy::math::DVec3;

/// g = 10 m/s² downwards, for scenes that are compared with references and other engines.
pub const TEN: DVec3 = DVec3::new(0.0, -10.0, 0.0);

/// Standard gravity as Plumb rounds it, downwards, m/s².
pub const EARTH: DVec3 = DVec3::new(0.0, -EARTH_G, 0.0);
pub const EARTH_G: f64 = 9.81;
