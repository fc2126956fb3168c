//! The box, by its full extents.

use bevy::math::DVec3;

use super::Measures;

/// Moments (y² + z²)/12 and its turns.
pub(super) fn measures(size: DVec3) -> Measures {
    let square = size * size;
    let moments = DVec3::new(square.y + square.z, square.z + square.x, square.x + square.y) / 12.0;
    Measures { volume: size.element_product(), moments, radius: size.length() / 2.0 }
}
