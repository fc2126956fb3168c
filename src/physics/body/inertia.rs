//! Inertia in world axes.

use nalgebra::{Matrix3, UnitQuaternion, Vector3};

/// R I⁻¹ Rᵀ with the locked world axes zeroed; isotropic bodies skip the rotation.
pub(crate) fn world_inverse_inertia(
    principal: &Vector3<f64>,
    rotation: &UnitQuaternion<f64>,
    freedom: &Vector3<f64>,
) -> Matrix3<f64> {
    let isotropic = principal.x == principal.y && principal.y == principal.z;
    let world = if isotropic {
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
