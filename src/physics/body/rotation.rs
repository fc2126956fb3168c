//! The exponential map of rotations.

use nalgebra::{Quaternion, UnitQuaternion, Vector3};

/// The rotation by a vector, rad. Small ones by the series of sine and cosine to the sixth order, which is exact to
/// rounding.
pub(crate) fn rotation_by(turned: &Vector3<f64>) -> UnitQuaternion<f64> {
    let squared = turned.norm_squared();
    if squared > 1e-4 {
        return UnitQuaternion::new(*turned);
    }
    let half = squared * 0.25;
    let vector = turned * (0.5 * (1.0 - half / 6.0 * (1.0 - half / 20.0)));
    let scalar = 1.0 - half * 0.5 * (1.0 - half / 12.0 * (1.0 - half / 30.0));
    UnitQuaternion::new_unchecked(Quaternion::from_parts(scalar, vector))
}
