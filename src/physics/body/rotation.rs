//! The exponential map of rotations, and inertia in the world's axes.

use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};

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

/// Whether rotation about any axis is free of torque.
pub(crate) fn is_isotropic(inertia: &Vector3<f64>) -> bool {
    inertia.x == inertia.y && inertia.y == inertia.z
}

/// R I⁻¹ Rᵀ with the locked world axes zeroed; isotropic bodies skip the rotation.
pub(crate) fn world_inverse_inertia(
    principal: &Vector3<f64>,
    rotation: &UnitQuaternion<f64>,
    freedom: &Vector3<f64>,
) -> Matrix3<f64> {
    let world = if is_isotropic(principal) {
        Matrix3::from_diagonal(principal)
    } else {
        let r = rotation.to_rotation_matrix().into_inner();
        let scaled =
            Matrix3::from_columns(&[r.column(0) * principal.x, r.column(1) * principal.y, r.column(2) * principal.z]);
        scaled * r.transpose()
    };
    if *freedom == Vector3::repeat(1.0) {
        world
    } else {
        let free = Matrix3::from_diagonal(freedom);
        free * world * free
    }
}
