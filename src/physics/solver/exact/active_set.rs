//! Rows whose λ is bounded, all at one pose: J W Jᵀ λ + w₀ = w with w = 0 where a row holds, w ≥ 0 where λ is its lower
//! bound, w ≤ 0 where it is its upper one. λ are forces and w accelerations, or impulses and speeds.
//!
//! Principal pivoting: solve with the rows that hold at present, let all change that contradict, again. Where that does
//! not lessen their number for some iterations, one alone changes, which ends wherever the matrix is positive definite
//! (Júdice and Pires 1994, after Murty 1974).

use super::constants::{ACTIVE_SET_ERROR, ACTIVE_SET_ITERATIONS, ACTIVE_SET_PATIENCE, EVENT_TURN, NO_ACCELERATION};
use super::mechanism::{InverseMass, Mechanism};
use super::row_mode::RowMode;
use super::rows::{MechanismRows, add_wrenches};
use crate::physics::constraint::row::{Twist, Wrench};
use crate::physics::joint::{Bound, JointRow};

/// The problem, its solution and the buffers.
#[derive(Clone, Debug, Default)]
pub(super) struct ActiveSet {
    /// The rows as joints tell them.
    pub rows: Vec<JointRow<f64>>,
    pub modes: Vec<RowMode>,
    /// What λ may be. Rows that have no part in this have a single value.
    pub bounds: Vec<(f64, f64)>,
    /// w₀.
    pub free: Vec<f64>,
    /// Rows whose mode may change.
    pub candidates: Vec<usize>,
    pub lambda: Vec<f64>,
    /// w.
    pub left: Vec<f64>,
    pub system: MechanismRows,
    /// The rows with those that do not hold masked.
    masked: Vec<JointRow<f64>>,
    right: Vec<f64>,
    /// λ of the rows that hold, zero of others.
    held: Vec<f64>,
    /// W Jᵀ λ of each member.
    gained: Vec<Twist<f64>>,
    wrong: Vec<usize>,
}

impl ActiveSet {
    /// Finds modes and λ at the mechanism's states. False where the iterations come to their end.
    pub fn find(&mut self, mechanism: &Mechanism) -> bool {
        let (mut least, mut patience) = (usize::MAX, ACTIVE_SET_PATIENCE);
        for _ in 0..ACTIVE_SET_ITERATIONS + 2 * self.candidates.len() {
            self.assemble(mechanism);
            self.solve(mechanism);
            self.find_wrong();
            let Some(&last) = self.wrong.last() else { return true };
            if self.wrong.len() < least {
                (least, patience) = (self.wrong.len(), ACTIVE_SET_PATIENCE);
            } else if patience > 0 {
                patience -= 1;
            } else {
                self.wrong = vec![last];
            }
            for &row in &self.wrong {
                self.modes[row] = match self.modes[row] {
                    RowMode::Lower | RowMode::Upper => RowMode::Held,
                    _ if self.lambda[row] < self.bounds[row].0 => RowMode::Lower,
                    _ => RowMode::Upper,
                };
            }
        }
        false
    }

    /// λ of a row that does not hold.
    fn given(&self, row: usize) -> Option<f64> {
        let (lower, upper) = self.bounds[row];
        match self.modes[row] {
            RowMode::Lower if lower.is_finite() => Some(lower),
            RowMode::Upper if upper.is_finite() => Some(upper),
            _ => (lower == upper).then_some(lower),
        }
    }

    /// Factors the rows that hold.
    pub fn assemble(&mut self, mechanism: &Mechanism) {
        let mut masked = std::mem::take(&mut self.masked);
        masked.clone_from(&self.rows);
        for (index, row) in masked.iter_mut().enumerate().filter(|(_, row)| row.spring.is_none()) {
            row.bound = if self.given(index).is_some() { Bound::Within(0.0, 0.0) } else { Bound::None };
        }
        self.system.assemble_rigid(mechanism, &mechanism.states, &masked, EVENT_TURN);
        self.masked = masked;
    }

    /// λ and w for the present modes.
    pub fn solve(&mut self, mechanism: &Mechanism) {
        let (mut lambda, mut held) = (std::mem::take(&mut self.lambda), std::mem::take(&mut self.held));
        lambda.clear();
        lambda.extend((0..self.rows.len()).map(|row| self.given(row).unwrap_or(0.0)));
        self.respond(mechanism, &lambda);
        let mut right = std::mem::take(&mut self.right);
        right.clear();
        let holds = |row: usize| self.rows[row].spring.is_none() && self.given(row).is_none();
        right.extend((0..self.rows.len()).map(|row| if holds(row) { -self.left[row] } else { 0.0 }));
        self.system.solve(mechanism, &right, &mut held);
        lambda.iter_mut().zip(&held).for_each(|(lambda, held)| *lambda += held);
        self.respond(mechanism, &lambda);
        (self.lambda, self.held, self.right) = (lambda, held, right);
    }

    /// W Jᵀ λ, and w.
    fn respond(&mut self, mechanism: &Mechanism, lambda: &[f64]) {
        let Self { rows, free, left, gained, system, .. } = self;
        gained.clear();
        gained.resize(mechanism.members.len(), Wrench::zero());
        add_wrenches(&mechanism.links, rows.iter().map(|row| &row.jacobian), lambda, gained);
        for (gained, inverse_mass) in gained.iter_mut().zip(&system.inverse_masses) {
            *gained = InverseMass::of(inverse_mass, gained);
        }
        left.clone_from(free);
        for link in &mechanism.links {
            let [a, b] = link.ends().map(|member| &gained[member as usize]);
            for row in link.rows.clone() {
                left[row] += rows[row].jacobian.dot(a, b);
            }
        }
    }

    /// How far beyond its bounds λ of a row that holds counts as within them.
    pub fn tolerance(&self, row: usize) -> f64 {
        let mobility = self.system.mobility_of(row);
        let least = if mobility > 0.0 { NO_ACCELERATION / mobility } else { 0.0 };
        ACTIVE_SET_ERROR * largest(&self.lambda) + least
    }

    /// The candidates that contradict their mode.
    fn find_wrong(&mut self) {
        let gain = ACTIVE_SET_ERROR * largest(&self.free) + NO_ACCELERATION;
        let is_wrong = |row: &usize| {
            let (row, (lower, upper)) = (*row, self.bounds[*row]);
            match self.modes[row] {
                _ if lower == upper => false,
                RowMode::Lower => self.left[row] < -gain,
                RowMode::Upper => self.left[row] > gain,
                RowMode::Held => {
                    let tolerance = self.tolerance(row);
                    self.lambda[row] < lower - tolerance || self.lambda[row] > upper + tolerance
                }
                RowMode::Rigid => false,
            }
        };
        self.wrong = self.candidates.iter().copied().filter(is_wrong).collect();
    }

    /// Adds W Jᵀ λ to the velocities.
    pub fn push(&self, mechanism: &mut Mechanism) {
        for (state, gained) in mechanism.states.iter_mut().zip(&self.gained) {
            state.linear += gained.linear;
            state.angular += gained.angular;
        }
    }
}

fn largest(numbers: &[f64]) -> f64 {
    numbers.iter().fold(0.0, |most: f64, number| most.max(number.abs()))
}
