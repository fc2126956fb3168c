//! The inertia of a body with all that hangs on it, about a point.

use nalgebra::{Cholesky, Matrix3, SMatrix, SVector, Vector3};

use crate::physics::constraint::row::{Twist, Wrench};
use crate::physics::solver::joint_tree::{cross_columns, cross_rows};

/// (M, H; Hᵀ, J).
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Articulated {
    pub mass: Matrix3<f64>,
    pub mixed: Matrix3<f64>,
    pub turning: Matrix3<f64>,
}

impl Articulated {
    /// Adds Tᵀ I T.
    #[inline(always)]
    pub fn add(&mut self, Self { mass, mixed, turning }: &Self, lever: &Vector3<f64>) {
        let moved = mixed + cross_rows(mass, lever);
        self.mass += mass;
        self.mixed += moved;
        self.turning += turning + cross_columns(lever, &moved) + cross_columns(lever, mixed).transpose();
    }

    #[inline(always)]
    pub fn of(&self, motion: &Twist<f64>) -> Wrench<f64> {
        Wrench {
            linear: self.mass * motion.linear + self.mixed * motion.angular,
            angular: self.mixed.tr_mul(&motion.linear) + self.turning * motion.angular,
        }
    }

    /// The motion that a momentum gives.
    pub fn solve(&self, momentum: &Wrench<f64>) -> Twist<f64> {
        let entry = |row: usize, column: usize| match (row < 3, column < 3) {
            (true, true) => self.mass[(row, column)],
            (true, false) => self.mixed[(row, column - 3)],
            (false, true) => self.mixed[(column, row - 3)],
            (false, false) => self.turning[(row - 3, column - 3)],
        };
        let right = SVector::<f64, 6>::from_iterator(momentum.linear.iter().chain(&momentum.angular).copied());
        let solution = Cholesky::new(SMatrix::<f64, 6, 6>::from_fn(entry)).map(|factor| factor.solve(&right));
        let solution = solution.unwrap_or_else(SVector::zeros);
        Twist { linear: solution.fixed_rows::<3>(0).into(), angular: solution.fixed_rows::<3>(3).into() }
    }
}
