//! The box, by its full extents.

use bevy::math::DVec3;

pub(super) fn volume(size: DVec3) -> f64 {
    size.element_product()
}

/// (y² + z²)/12 and its turns.
pub(super) fn moments(size: DVec3) -> DVec3 {
    let square = size * size;
    DVec3::new(square.y + square.z, square.z + square.x, square.x + square.y) / 12.0
}

pub(super) fn bounding_radius(size: DVec3) -> f64 {
    size.length() / 2.0
}
