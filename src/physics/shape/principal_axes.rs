//! The principal axes of an inertia.

use bevy::math::{DMat3, DQuat, DVec3};
use nalgebra::{Matrix3, SymmetricEigen, Vector3};

/// Of the moments: products of inertia this small are rounding.
const PRODUCT_ROUNDING: f64 = 1e-12;

/// Of the moments: principal moments that differ by less are equal, and any axes across the third
/// are principal.
const EQUAL_MOMENTS: f64 = 1e-9;

/// The rotation from principal axes to the given ones that turns least, and the moments along
/// these.
pub(super) fn principal_axes(inertia: &Matrix3<f64>) -> (DQuat, DVec3) {
    let given = DVec3::new(inertia.m11, inertia.m22, inertia.m33);
    let largest_product = inertia.m12.abs().max(inertia.m13.abs()).max(inertia.m23.abs());
    if largest_product <= PRODUCT_ROUNDING * given.max_element() {
        return (DQuat::IDENTITY, given);
    }
    let SymmetricEigen { eigenvalues, eigenvectors } = inertia.symmetric_eigen();
    let axis = |index: usize| DVec3::from_array(eigenvectors.column(index).into_owned().into());
    let equal = |a: usize, b: usize| (eigenvalues[a] - eigenvalues[b]).abs() <= EQUAL_MOMENTS * eigenvalues.max();
    let rotation = match (0..3).find(|&odd| equal((odd + 1) % 3, (odd + 2) % 3)) {
        // All three, or two: only the odd one has an axis of its own.
        Some(odd) if equal(odd, (odd + 1) % 3) => DQuat::IDENTITY,
        Some(odd) => {
            let nearest = (0..3).max_by(|&a, &b| axis(odd)[a].abs().total_cmp(&axis(odd)[b].abs())).unwrap_or(0);
            let unit = DVec3::AXES[nearest];
            DQuat::from_rotation_arc(unit, axis(odd) * axis(odd)[nearest].signum())
        }
        None => nearest_to_identity([axis(0), axis(1), axis(2)]),
    };
    let moments = DVec3::AXES.map(|axis| {
        let axis = Vector3::from(rotation * axis);
        axis.dot(&(inertia * axis))
    });
    (rotation, DVec3::from_array(moments))
}

/// Of the rotations whose columns are those axes in some order and sense, the one by the least
/// angle.
fn nearest_to_identity(axes: [DVec3; 3]) -> DQuat {
    const ORDERS: [[usize; 3]; 6] = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]];
    let mut nearest = DQuat::IDENTITY;
    let mut least = f64::INFINITY;
    for [x, y, _] in ORDERS {
        for signs in [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]] {
            let (x, y) = (axes[x] * signs[0], axes[y] * signs[1]);
            let rotation = DQuat::from_mat3(&DMat3::from_cols(x, y, x.cross(y))).normalize();
            let angle = 1.0 - rotation.w.abs();
            if angle < least {
                (nearest, least) = (rotation, angle);
            }
        }
    }
    if nearest.w < 0.0 { -nearest } else { nearest }
}
