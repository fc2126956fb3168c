//! The present impulses, with the velocities that follow from them and the linear system that changes them.

use nalgebra::{Matrix3, Vector3};

use super::constants::{LEAST_JAM, ROUNDINGS};
use super::linear::LinearSystem;
use super::{BodyVector, ConeOutcome, ConePoint, Deadline, Elimination, Law};
use crate::physics::{Refill, Residuals};

/// The iterate of all methods.
#[derive(Clone, Debug, Default)]
pub(super) struct Iterate {
    /// Contacts, then joints.
    pub points: Vec<ConePoint>,
    pub elimination: Elimination,
    /// L of each body, linear and angular.
    pub roots: Vec<[Matrix3<f64>; 2]>,
    pub linear: LinearSystem,
    /// c, in the frame of each point, as are the next four.
    pub free: Vec<Vector3<f64>>,
    /// λ.
    pub impulses: Vec<Vector3<f64>>,
    /// u.
    pub velocities: Vec<Vector3<f64>>,
    /// λ_k, to go back to.
    pub kept: Vec<Vector3<f64>>,
    /// λ of the least residual so far.
    pub best: Vec<Vector3<f64>>,
    /// z, by place in the order of elimination.
    pub scaled: Vec<BodyVector>,
    /// The residual that is asked for, m/s.
    pub tolerance: f64,
    pub outcome: ConeOutcome,
    /// When to end, but not before so many iterations.
    pub deadline: Deadline,
    pub least: u32,
    /// The residual of each iteration, while somebody reads it.
    pub trace: Option<Residuals>,
}

/// Largest and root of the sum of squares of |r|, m/s; infinite where a number is not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Residual {
    pub largest: f64,
    pub norm: f64,
}

impl Iterate {
    /// z = Ĵᵀλ, then u = Ĵ z + c.
    pub fn refresh(&mut self) {
        self.scaled.reset(self.elimination.count(), BodyVector::zeros());
        for (point, impulse) in self.points.iter().zip(&self.impulses) {
            point.apply(&mut self.scaled, impulse);
        }
        self.velocities
            .refill(self.points.iter().zip(&self.free).map(|(point, free)| free + point.relative(&self.scaled)));
    }

    /// How far λ and u are from the laws.
    pub fn residual(&self) -> Residual {
        let (mut largest, mut sum) = (0.0, 0.0);
        for ((point, impulse), velocity) in self.points.iter().zip(&self.impulses).zip(&self.velocities) {
            if point.is_movable() {
                let square = point.law.natural_map(impulse, velocity, point.mass).norm_squared();
                largest = f64::max(largest, square);
                sum += square;
            }
        }
        if f64::is_finite(sum) {
            Residual { largest: largest.sqrt(), norm: sum.sqrt() }
        } else {
            Residual { largest: f64::INFINITY, norm: f64::INFINITY }
        }
    }

    /// Whether it is time to end.
    pub fn is_late(&self) -> bool {
        self.outcome.steps >= self.least && self.deadline.is_over()
    }

    /// Sweeps of projected Gauss–Seidel, point by point with the friction that its normal impulse allows: of what is far from
    /// solved they make little, but never worse than another sweep would mend.
    pub fn sweep(&mut self, count: u32) {
        let Self { points, free, impulses, scaled, .. } = self;
        for _ in 0..count {
            for ((point, free), impulse) in points.iter().zip(&*free).zip(&mut *impulses) {
                if point.is_movable() {
                    let velocity = free + point.relative(scaled);
                    let next = point.law.clamp(&(*impulse - velocity.component_mul(&point.masses())));
                    point.apply(scaled, &(next - *impulse));
                    *impulse = next;
                }
            }
        }
        self.refresh();
    }

    /// The residual, noted for whoever reads it.
    pub fn traced_residual(&mut self) -> Residual {
        let residual = self.residual();
        if let Some(trace) = &mut self.trace {
            trace.note(residual.largest);
        }
        residual
    }

    /// The residual; notes λ if it is the best so far.
    pub fn note(&mut self) -> Residual {
        let residual = self.traced_residual();
        if residual.largest < self.outcome.residual {
            self.outcome.residual = residual.largest;
            self.best.clone_from(&self.impulses);
        }
        residual
    }

    /// What rounding makes of a residual, m/s.
    pub fn rounding(&self) -> f64 {
        let movable = self.points.iter().zip(&self.impulses).filter(|(point, _)| point.is_movable());
        ROUNDINGS * f64::EPSILON * movable.map(|(point, impulse)| impulse.norm() / point.mass).fold(0.0, f64::max)
    }

    /// Whether λ says that no motion obeys the points: with λ ∈ K, λ·û ≥ 0 for all û ∈ K*, so that −λ·c ≤ z·Ĵᵀλ + Σ
    /// μ|u_t| λ_n for the z sought; impulses that press (λ·c < 0) and yet move nothing (Ĵᵀλ ≈ 0) leave none (Farkas).
    pub fn is_jammed(&self) -> bool {
        let (mut pressing, mut load) = (0.0, 0.0);
        for (((point, impulse), free), velocity) in
            self.points.iter().zip(&self.impulses).zip(&self.free).zip(&self.velocities)
        {
            // No cone: what it may bear is no direction in which impulses grow.
            if matches!(point.law, Law::Within(..)) {
                continue;
            }
            pressing -= impulse.dot(free) + point.law.shift(velocity) * impulse.x;
            load += impulse.norm();
        }
        // At rest nothing moves and rounding presses.
        pressing > LEAST_JAM * load && pressing > 1e4 * self.scaled.iter().map(BodyVector::norm_squared).sum::<f64>()
    }
}
