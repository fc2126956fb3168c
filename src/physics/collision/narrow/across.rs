//! The part of a direction across an axis of revolution, y.

use nalgebra::Vector3;

/// The part of a direction across the axis, as a unit vector (x, z); any if there is none.
pub(crate) fn unit_across(direction: &Vector3<f64>) -> [f64; 2] {
    let across = length_across(direction);
    if across > 0.0 { [direction.x / across, direction.z / across] } else { [1.0, 0.0] }
}

/// Of the part of a direction across the axis. The care of hypot is not needed, and costs more than all else here.
pub(crate) fn length_across(direction: &Vector3<f64>) -> f64 {
    (direction.x * direction.x + direction.z * direction.z).sqrt()
}
