//! Projected Gauss–Seidel (Catto 2005, pp. 14–17).
//!
//! With a = M⁻¹Jᵀλ kept up to date, one update of row i is
//!
//! λ_i ← clamp(λ_i + (η_i − γ_i λ_i − J_i a) / d_i), a ← a + (M⁻¹Jᵀ)_i Δλ_i,
//!
//! with η the row's target and d_i = J_i M⁻¹ J_iᵀ + γ_i. Rows are taken in their order, λ starts
//! from zero or, warm started, from what the rows carried before.
//!
//! Rows whose norm is bounded (a spring's) are updated together. If their updates in turn come beyond the
//! bound, what they started from is taken half-way to where each alone would go, and scaled to the bound: in the end
//! the force is along what the spring asks for, whatever the order of its axes. Whole ways could overshoot for ever,
//! as the rows may be one and the same.

use std::ops::Range;

use nalgebra::{SimdRealField, Vector3};

use crate::physics::constraint::row::{Bounds, Row, RowPair, Twist, bounded};
use crate::physics::scalar::Scalar;

/// Sweeps `iterations` times over the rows, from the λ that they hold. `accelerations` must hold
/// a = M⁻¹Jᵀλ of each body ([`add_response`]), and does afterwards; `note` is told it after each sweep.
pub(crate) fn solve<N: SimdRealField + Copy>(
    rows: &mut [Row<N>],
    accelerations: &mut [Twist<N>],
    iterations: u32,
    mut note: impl FnMut(&[Twist<N>]),
) {
    for _ in 0..iterations {
        sweep(rows, accelerations, |_, _, _| {});
        note(accelerations);
    }
}

/// Sweeps once; `note` is told the rows, which of them was updated last, and by how much.
#[inline]
pub(super) fn sweep<N: SimdRealField + Copy>(
    rows: &mut [Row<N>],
    accelerations: &mut [Twist<N>],
    mut note: impl FnMut(&[Row<N>], usize, N),
) {
    let mut index = 0;
    while index < rows.len() {
        if let Bounds::Norm { most, count, .. } = rows[index].bounds {
            let changes = update_group(rows, index..index + count as usize, most, accelerations);
            (0..count as usize).for_each(|place| note(rows, index + place, changes[place]));
            index += count as usize;
        } else {
            let change = update(rows, index, accelerations);
            note(rows, index, change);
            index += 1;
        }
    }
}

/// A number of each row of a group; zero for the rows that it is short of three.
fn each<N: SimdRealField + Copy>(group: &Range<usize>, mut number: impl FnMut(usize) -> N) -> Vector3<N> {
    Vector3::from_fn(|place, _| if place < group.len() { number(group.start + place) } else { N::zero() })
}

/// Updates a group of rows, whose norm is at most so much. Returns their Δλ.
fn update_group<N: SimdRealField + Copy>(
    rows: &mut [Row<N>],
    group: Range<usize>,
    most: N,
    accelerations: &mut [Twist<N>],
) -> Vector3<N> {
    let old = each(&group, |row| rows[row].lambda);
    let alone = each(&group, |row| residual(&rows[row], accelerations) * rows[row].inverse_diagonal);
    let free = old + each(&group, |row| update(rows, row, accelerations));
    let half_way = bounded(old + alone * (N::one() + N::one()).simd_recip(), most);
    let is_beyond = free.dot(&free).simd_gt(most * most);
    for (row, half_way) in rows[group.clone()].iter_mut().zip(&half_way) {
        let change = (*half_way - row.lambda).select(is_beyond, N::zero());
        row.lambda += change;
        add_response(row, change, accelerations);
    }
    each(&group, |row| rows[row].lambda) - old
}

/// Updates row `index` within bounds of its own. Returns Δλ.
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

/// The least and greatest λ of row `index`, those of friction at the present λ of its normal row. Of rows with a
/// bounded norm, what each could be alone.
#[inline]
pub(super) fn limits<N: SimdRealField + Copy>(rows: &[Row<N>], index: usize) -> (N, N) {
    match rows[index].bounds {
        Bounds::Fixed(lower, upper) => (lower, upper),
        Bounds::Friction { coefficient, normal_rows_back } => {
            let limit = coefficient * rows[index - normal_rows_back as usize].lambda;
            (-limit, limit)
        }
        Bounds::Norm { most, .. } => (-most, most),
    }
}

/// Share of a norm's square from which on it counts as at its bound: but for rounding in `f32`.
const AT_NORM: f64 = 1.0 - 1e-5;

/// Whether row `index` is one of those that are at the bound of their norm.
pub(super) fn is_at_norm<N: Scalar>(rows: &[Row<N>], index: usize) -> bool {
    let Bounds::Norm { most, place, count } = rows[index].bounds else { return false };
    let first = index - place as usize;
    let lambda = each(&(first..first + count as usize), |row| rows[row].lambda);
    lambda.dot(&lambda) >= most * most * N::of(AT_NORM)
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
