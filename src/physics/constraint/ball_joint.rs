//! The ball joint's three rows, one along each world axis.
//!
//! C = x_B + r_B − x_A − r_A, J = [−1, [r_A]×, 1, −[r_B]×]: row k is the point row along e_k, since
//! e_kᵀ[r]× = (e_k × r)ᵀ. (Erleben 2005, p. 71.)

use nalgebra::{SimdRealField, Vector3};

use super::row::RowPair;

/// The Jacobian of a ball joint with arms r_A and r_B, world axes.
pub(crate) fn jacobian<N: SimdRealField + Copy>(arm_a: Vector3<N>, arm_b: Vector3<N>) -> [RowPair<N>; 3] {
    [Vector3::x(), Vector3::y(), Vector3::z()].map(|axis| RowPair::along(axis, arm_a, arm_b))
}
