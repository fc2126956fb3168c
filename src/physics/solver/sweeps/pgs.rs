//! Projected Gauss–Seidel (Catto 2005, pp. 14–17).
//!
//! With a = M⁻¹Jᵀλ kept up to date, one update of row i is
//!
//! λ_i ← clamp(λ_i + (η_i − γ_i λ_i − J_i a) / d_i), a ← a + (M⁻¹Jᵀ)_i Δλ_i,
//!
//! with η the row's target and d_i = J_i M⁻¹ J_iᵀ + γ_i. Rows are taken in their order, λ starts
//! from zero or, warm started, from what the rows carried before.

use nalgebra::SimdRealField;

use crate::physics::constraint::row::{Bounds, Row, RowPair, Twist};

/// Sweeps `iterations` times over the rows, from the λ that they hold. `accelerations` must hold
/// a = M⁻¹Jᵀλ of each body ([`add_response`]), and does afterwards.
pub(crate) fn solve<N: SimdRealField + Copy>(rows: &mut [Row<N>], accelerations: &mut [Twist<N>], iterations: u32) {
    for _ in 0..iterations {
        for index in 0..rows.len() {
            update(rows, index, accelerations);
        }
    }
}

/// Updates row `index`. Returns Δλ.
#[inline]
pub(super) fn update<N: SimdRealField + Copy>(rows: &mut [Row<N>], index: usize, accelerations: &mut [Twist<N>]) -> N {
    let (lower, upper) = limits(rows, index);
    let row = &mut rows[index];
    let residual = residual(row, accelerations);
    let lambda = (row.lambda + residual * row.inverse_diagonal).simd_clamp(lower, upper);
    let change = lambda - row.lambda;
    row.lambda = lambda;
    add_response(row, change, accelerations);
    change
}

/// The least and greatest λ of row `index`, those of friction at the present λ of its normal row.
#[inline]
pub(super) fn limits<N: SimdRealField + Copy>(rows: &[Row<N>], index: usize) -> (N, N) {
    match rows[index].bounds {
        Bounds::Fixed(lower, upper) => (lower, upper),
        Bounds::Friction { coefficient, normal_rows_back } => {
            let limit = coefficient * rows[index - normal_rows_back as usize].lambda;
            (-limit, limit)
        }
    }
}

/// η − γλ − J a.
#[inline]
pub(super) fn residual<N: SimdRealField + Copy>(row: &Row<N>, accelerations: &[Twist<N>]) -> N {
    let (a, b) = (row.a as usize, row.b as usize);
    row.target - row.softness * row.lambda - row.jacobian.dot(&accelerations[a], &accelerations[b])
}

/// a ← a + (M⁻¹Jᵀ)_i Δλ.
pub(crate) fn add_response<N: SimdRealField + Copy>(row: &Row<N>, change: N, accelerations: &mut [Twist<N>]) {
    let (a, b) = (row.a as usize, row.b as usize);
    let RowPair { linear_a, angular_a, linear_b, angular_b } = row.response;
    accelerations[a].linear += linear_a * change;
    accelerations[a].angular += angular_a * change;
    accelerations[b].linear += linear_b * change;
    accelerations[b].angular += angular_b * change;
}
