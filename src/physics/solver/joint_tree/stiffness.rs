//! Geometric stiffness: how joint forces turn with the bodies they act on.
//!
//! A force f at the end of an arm r has the torque r × f, which a rotation δθ changes by
//! (δθ × r) × f = −K δθ with K = (r·f) 1 − r fᵀ (Tournier, Nesme, Gilles and Faure 2015, "Stable
//! constrained dynamics"). A light rod of mass m and length L under tension P swings about the line
//! of the tension at ω² = 12 P/(m L). A step that takes Jᵀλ from its start is leapfrog on that oscillation,
//! unstable for ωh > 2.
//!
//! The cure is Newmark's: leapfrog with the inertia I + β h² K is stable for any ωh if β > ¼ (β = ¼
//! is the trapezoidal rule, on the border for ωh → ∞). A further δ h² K, whose momentum the
//! oscillation loses (implicit Euler would be δ = 1), takes out what rounding and the lag of K feed into modes
//! that the step cannot resolve. Both fade with the square of ω²h² where the step resolves the oscillation.
//!
//! Kept symmetric and positive, K counts only what pulls along each arm, max(0, r·f) (1 − r̂ r̂ᵀ), which
//! is all there is where the force keeps to the arm.

use nalgebra::{Matrix3, Vector3};

use super::constants::{ADDED_INERTIA, DAMPING, RESOLVED, STRONG, STRONG_DAMPING};
use super::factor::product;
use super::tree::JointTree;
use crate::physics::constraint::row::Twist;

impl JointTree {
    /// Adds geometric stiffness to the inertias set, from the accumulated impulses, taken to have
    /// acted over h, s. To call after [`Self::set_inertia`] and before [`Self::factor`]. Returns the
    /// largest ω²h² found; see [`UNRESOLVED`](super::UNRESOLVED).
    pub fn stiffen(&mut self, h: f64) -> f64 {
        let mut fastest: f64 = 0.0;
        let stiffness = &mut self.dampings;
        stiffness.fill(Matrix3::zeros());
        for joint in &self.joints {
            if let Some(child) = stiffness.get_mut(joint.child as usize) {
                add_stiffness(child, &joint.arm_child, &joint.impulse);
            }
            add_stiffness(&mut stiffness[joint.parent as usize], &joint.arm_parent, &-joint.impulse);
        }
        for (damping, inertia) in self.dampings.iter_mut().zip(&mut self.inertias) {
            let stiffness = *damping * h;
            let inverse = &mut inertia.inverse_inertia;
            // Mean over the two directions across the pull.
            let phase_squared = 0.5 * inverse.dot(&stiffness);
            fastest = fastest.max(phase_squared);
            let Some(StiffnessShares { added, damped }) = StiffnessShares::of(phase_squared) else {
                *damping = Matrix3::identity();
                continue;
            };
            // (I + S)⁻¹ for all of S; what is damped leaves 1 − (I + S)⁻¹ S_δ = (I + S)⁻¹ (I + S_β) of ω.
            let stiffened = product(&share(inverse, &(stiffness * (added + damped))), inverse);
            *inverse = (stiffened + stiffened.transpose()) * 0.5;
            *damping = Matrix3::identity() - product(inverse, &stiffness) * damped;
        }
        fastest
    }

    /// Takes from the angular velocities (local order) what [`Self::stiffen`] found to be lost in a
    /// substep. To call once a substep, before the velocities are solved.
    pub fn damp(&self, twists: &mut [Twist<f64>]) {
        for (twist, damping) in twists.iter_mut().zip(&self.dampings) {
            twist.angular = damping * twist.angular;
        }
    }

    /// Inverse inertia of a moving body as it is now used, world axes: contacts on the body should
    /// use it, too.
    #[cfg(test)]
    pub fn inverse_inertia(&self, body: usize) -> &Matrix3<f64> {
        &self.inertias[body].inverse_inertia
    }
}

/// Shares of h²K that a step needs.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StiffnessShares {
    /// Added to the inertia.
    pub added: f64,
    /// Whose momentum is lost.
    pub damped: f64,
}

impl StiffnessShares {
    /// For an oscillation of that ω²h²; none where the step resolves it.
    pub fn of(phase_squared: f64) -> Option<Self> {
        let share = phase_squared * phase_squared / (1.0 + phase_squared * phase_squared);
        let damped = DAMPING + (STRONG_DAMPING - DAMPING) * phase_squared / (STRONG + phase_squared);
        (phase_squared >= RESOLVED).then_some(Self { added: share * ADDED_INERTIA, damped: share * damped })
    }
}

/// Adds the stiffness of a force at the end of an arm, max(0, r·f) (1 − r̂ r̂ᵀ).
pub(crate) fn add_stiffness(stiffness: &mut Matrix3<f64>, arm: &Vector3<f64>, force: &Vector3<f64>) {
    let along = arm.dot(force);
    if along > 0.0 {
        let unit = arm * (along / arm.norm_squared());
        *stiffness += Matrix3::from_diagonal_element(along) - unit * arm.transpose();
    }
}

/// P = (1 + I⁻¹ S)⁻¹: P I⁻¹ is the inverse of I + S. For a positive S the determinant inverted is at least 1.
fn share(inverse_inertia: &Matrix3<f64>, stiffness: &Matrix3<f64>) -> Matrix3<f64> {
    let matrix = Matrix3::identity() + product(inverse_inertia, stiffness);
    matrix.try_inverse().unwrap_or_else(Matrix3::identity)
}
