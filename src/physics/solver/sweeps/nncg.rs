//! Nonsmooth nonlinear conjugate gradients (Silcowitz, Niebe and Erleben, *A nonsmooth nonlinear conjugate gradient
//! method for interactive contact force problems*, The Visual Computer 26, 2010).
//!
//! A sweep of projected Gauss–Seidel maps λ to PGS(λ), and what is sought is its fixed point. Its step stands for the
//! negative gradient of a merit function, s = PGS(λ) − λ = −∇f, and the directions are those of Fletcher and Reeves:
//!
//! β = |s_k|²/|s_{k−1}|²,  λ ← PGS(λ) + β p,  p ← β p + s_k,
//!
//! without a line search: the sweep is one. Where β > 1 the method starts afresh from p = 0. The first step is no
//! direction either: it goes from what was carried over to where the friction bounds have their size, and led astray
//! (residuals twice those of plain sweeps on columns just landed).
//!
//! The last thing done is a sweep, so that λ ends within its bounds. M⁻¹Jᵀp is kept for each body beside p: a sweep
//! changes a by M⁻¹Jᵀs, so that an iteration costs one pass over the rows, as a sweep does.

use super::pgs;
use crate::physics::constraint::row::{Row, Twist};
use crate::physics::scalar::Scalar;

/// The conjugate direction and what the last sweep did, in rows and in bodies.
#[derive(Clone, Default)]
pub(super) struct Directions<N> {
    /// s.
    steps: Vec<N>,
    /// p.
    direction: Vec<N>,
    /// a before the sweep.
    before: Vec<Twist<N>>,
    /// M⁻¹Jᵀp.
    response: Vec<Twist<N>>,
}

/// Iterates from the λ that the rows hold, with `accelerations` as in [`pgs::solve`], until nothing changes or
/// `iterations` passes over the rows are made; `note` is told `accelerations` after each. Returns the passes.
pub(super) fn solve<N: Scalar>(
    rows: &mut [Row<N>],
    accelerations: &mut [Twist<N>],
    iterations: u32,
    directions: &mut Directions<N>,
    mut note: impl FnMut(&[Twist<N>]),
) -> u32 {
    directions.forget(rows.len(), accelerations.len());
    let mut last_square = 0.0;
    for pass in 1..iterations {
        let square = directions.sweep(rows, accelerations);
        if square == 0.0 {
            return pass;
        }
        if square > last_square {
            directions.forget(rows.len(), accelerations.len());
        } else {
            directions.advance(rows, accelerations, N::of(square / last_square));
        }
        last_square = square;
        note(accelerations);
    }
    pgs::solve(rows, accelerations, 1, note);
    iterations
}

impl<N: Scalar> Directions<N> {
    /// p ← 0.
    fn forget(&mut self, rows: usize, bodies: usize) {
        self.direction.clear();
        self.direction.resize(rows, N::zero());
        self.response.clear();
        self.response.resize(bodies, Twist::zero());
    }

    /// One sweep. Returns |s|².
    fn sweep(&mut self, rows: &mut [Row<N>], accelerations: &mut [Twist<N>]) -> f64 {
        self.before.clear();
        self.before.extend_from_slice(accelerations);
        self.steps.clear();
        let mut square = 0.0;
        pgs::sweep(rows, accelerations, |_, _, step| {
            square += step.to_f64().powi(2);
            self.steps.push(step);
        });
        square
    }

    /// λ ← λ + β p, then p ← β p + s.
    fn advance(&mut self, rows: &mut [Row<N>], accelerations: &mut [Twist<N>], beta: N) {
        for ((row, direction), &step) in rows.iter_mut().zip(&mut self.direction).zip(&self.steps) {
            let way = beta * *direction;
            row.lambda += way;
            *direction = way + step;
        }
        for ((now, response), before) in accelerations.iter_mut().zip(&mut self.response).zip(&self.before) {
            let way = Twist { linear: response.linear * beta, angular: response.angular * beta };
            response.linear = way.linear + (now.linear - before.linear);
            response.angular = way.angular + (now.angular - before.angular);
            now.linear += way.linear;
            now.angular += way.angular;
        }
    }
}
