//! Projected Gauss–Seidel primed by conjugate residuals: where sweeps have found which rows their bounds hold but creep
//! towards the forces, the rest is a linear system, and that is solved as one.
//!
//! So do J. Morales, J. Nocedal and M. Smelyanskiy, *An algorithm for the fast solution of symmetric linear
//! complementarity problems*, Numerische Mathematik 111, 2008, by turns: sweeps, then a subspace minimisation over the
//! rows within their bounds, by [conjugate residuals](crate::physics::solver::sweeps::conjugate_residuals) here. It primes the sweeps and does
//! not replace them:
//!
//! - It begins once a sweep has changed no row's side of its bounds and |s|² fell to no less than half, s being the
//!   sweep's change of λ. Sweeps that halve it, as on bodies just landed, are faster than any linear solve; and while
//!   the sides change, as in a wall, what it solves is not yet the question.
//! - The sweep after it tells what came of it. If |s| has grown, λ goes back to what it was. If sweeps at their last
//!   pace had come further, the next attempt waits for as many sweeps as this one took passes, the one after that for
//!   twice as many, and so on.
//! - What remains is never less than a sweep, so that friction follows its normal force and λ ends within its bounds.
//!
//! So about half of the passes are lost at worst, where it does no good: in walls, whose sides never settle, none are.

use super::conjugate_residuals::Face;
use super::pgs;
use crate::physics::constraint::row::{Row, Twist};
use crate::physics::scalar::Scalar;

/// Passes that are worth beginning for: one for the residual, two products, and the sweep after.
const LEAST_PASSES: u32 = 4;

/// Share of |s|² that a sweep must leave for sweeps to count as slow.
const SLOW: f64 = 0.5;

/// Buffers of [`solve`].
#[derive(Clone, Default)]
pub(super) struct Primer<N> {
    sides: Vec<Side>,
    face: Face<N>,
    /// λ and a before the last attempt.
    lambdas: Vec<N>,
    accelerations: Vec<Twist<N>>,
}

/// Where a row's λ is.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Side {
    Lower,
    Within,
    Upper,
}

/// What a sweep did.
struct Sweep {
    /// |s|².
    square: f64,
    /// Whether every row stayed on its side.
    settled: bool,
}

/// Solves from the λ that the rows hold, with `accelerations` as in [`pgs::solve`], until nothing changes or
/// `iterations` passes over the rows are made, sweeps or products; `note` is told `accelerations` after each sweep.
/// Returns the passes.
pub(super) fn solve<N: Scalar>(
    rows: &mut [Row<N>],
    accelerations: &mut [Twist<N>],
    iterations: u32,
    primer: &mut Primer<N>,
    mut note: impl FnMut(&[Twist<N>]),
) -> u32 {
    primer.sides.clear();
    primer.sides.extend((0..rows.len()).map(|index| side(rows, index)));
    let (mut passes, mut last_square, mut patience, mut wait) = (0, f64::INFINITY, 1, 0);
    while passes < iterations {
        let Sweep { square, settled } = primer.sweep(rows, accelerations);
        passes += 1;
        note(accelerations);
        if square == 0.0 {
            break;
        }
        let pace = square / last_square;
        last_square = square;
        if wait > 0 {
            wait -= 1;
            continue;
        }
        if pace < SLOW || !settled || passes + LEAST_PASSES > iterations {
            continue;
        }
        primer.keep(rows, accelerations);
        let spent = primer.face.solve(rows, accelerations, iterations - passes - 1) + 1;
        last_square = primer.sweep(rows, accelerations).square;
        passes += spent;
        if last_square > square * pace.min(1.0).powi(spent as i32) {
            wait = patience * spent;
            patience *= 2;
        }
        if last_square > square {
            primer.restore(rows, accelerations);
            last_square = square;
        }
        note(accelerations);
    }
    passes
}

fn side<N: Scalar>(rows: &[Row<N>], index: usize) -> Side {
    let (lower, upper) = pgs::limits(rows, index);
    let lambda = rows[index].lambda;
    if lambda <= lower {
        Side::Lower
    } else if lambda >= upper || pgs::is_at_norm(rows, index) {
        Side::Upper
    } else {
        Side::Within
    }
}

impl<N: Scalar> Primer<N> {
    fn sweep(&mut self, rows: &mut [Row<N>], accelerations: &mut [Twist<N>]) -> Sweep {
        let mut sweep = Sweep { square: 0.0, settled: true };
        pgs::sweep(rows, accelerations, |rows, index, change| {
            sweep.square += change.to_f64().powi(2);
            let side = side(rows, index);
            sweep.settled &= side == self.sides[index];
            self.sides[index] = side;
        });
        sweep
    }

    fn keep(&mut self, rows: &[Row<N>], accelerations: &[Twist<N>]) {
        self.lambdas.clear();
        self.lambdas.extend(rows.iter().map(|row| row.lambda));
        self.accelerations.clear();
        self.accelerations.extend_from_slice(accelerations);
    }

    fn restore(&self, rows: &mut [Row<N>], accelerations: &mut [Twist<N>]) {
        for (row, &lambda) in rows.iter_mut().zip(&self.lambdas) {
            row.lambda = lambda;
        }
        accelerations.copy_from_slice(&self.accelerations);
    }
}
