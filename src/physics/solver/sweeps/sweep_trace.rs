//! What each sweep of a solve changed, for whoever reads it.

use super::local::LocalBody;
use crate::physics::constraint::row::Twist;
use crate::physics::scalar::Scalar;
use crate::physics::solve_trace::Residuals;

/// Follows the accelerations through a solve.
pub(super) struct SweepTrace<'a, N> {
    bodies: &'a [LocalBody],
    /// After the sweep before.
    before: Vec<Twist<N>>,
    /// How long they act, s.
    h: f64,
    residuals: &'a mut Residuals,
}

impl<'a, N: Scalar> SweepTrace<'a, N> {
    /// A solve of these bodies begins, for accelerations that act over h, s.
    pub fn begin(bodies: &'a [LocalBody], accelerations: &[Twist<N>], h: f64, residuals: &'a mut Residuals) -> Self {
        residuals.begin_solve();
        Self { bodies, before: accelerations.to_vec(), h, residuals }
    }

    /// A sweep was made: the largest change of the velocity of a point of a body, m/s.
    pub fn note(&mut self, accelerations: &[Twist<N>]) {
        let mut largest = 0.0_f64;
        for ((local, before), now) in self.bodies.iter().zip(&self.before).zip(accelerations) {
            let linear = (now.linear - before.linear).map(Scalar::to_f64).norm();
            let angular = (now.angular - before.angular).map(Scalar::to_f64).norm();
            // Of what reaches without end, zero times that is not a number, and is passed over.
            largest = largest.max((linear + local.body.radius * angular) * self.h);
        }
        self.residuals.note(largest);
        self.before.copy_from_slice(accelerations);
    }
}
