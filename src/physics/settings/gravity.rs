//! The acceleration of gravity.

use bevy::math::DVec3;
use bevy::prelude::*;

/// Acceleration of gravity, m/s² (default 9.81 downwards, y up).
#[derive(Resource, Reflect, Clone, Copy, Debug, PartialEq, Deref, DerefMut)]
#[reflect(Resource, Debug, Default, PartialEq)]
pub struct Gravity(pub DVec3);

impl Default for Gravity {
    fn default() -> Self {
        Self(DVec3::new(0.0, -9.81, 0.0))
    }
}
