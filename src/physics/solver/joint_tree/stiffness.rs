//! Geometric stiffness: how joint forces turn with the bodies they act on.
//!
//! A force f at the end of an arm r has the torque r × f, which a rotation δθ changes by
//! (δθ × r) × f = −K δθ with K = (r·f) 1 − r fᵀ (Tournier, Nesme, Gilles and Faure 2015, "Stable
//! constrained dynamics"). A light rod of mass m and length L under tension P swings about the line
//! of the pull at ω² = 12 P/(m L). A step that takes Jᵀλ from its start is leapfrog on that swing,
//! unstable for ωh > 2.
//!
//! The cure is Newmark's: leapfrog with the inertia I + β h² K is stable for any ωh if β > ¼ (β = ¼
//! is the trapezoidal rule, on the border for ωh → ∞). A further δ h² K, whose momentum the swing
//! loses (implicit Euler would be δ = 1), takes out what rounding and the lag of K feed into modes
//! that the step cannot resolve. Both fade with the square of ω²h² where the step resolves the swing.
//!
//! Kept symmetric and positive, K counts only what pulls along each arm, max(0, r·f) (1 − r̂ r̂ᵀ), which
//! is all there is where the force keeps to the arm.

use nalgebra::{Matrix3, Vector3};

use super::JointTree;
use super::factor::product;
use crate::physics::constraint::row::Twist;

/// β. Stability asks for over ¼.
const ADDED_INERTIA: f64 = 0.5;

/// δ where ω²h² is of order 1: keeps `chain 1000` at 1/240 s without a gain of energy, for a loss of
/// 2 % in 10 s.
const DAMPING: f64 = 0.2;

/// δ for ω²h² over [`STRONG`]: with less, `chain 1000000` parts (ω²h² = 6000); with this it loses 4 %
/// in 10 s.
const STRONG_DAMPING: f64 = 0.6;
const STRONG: f64 = 100.0;

/// ω²h² over which arms must be those of the pose to the last digit: a turn of δθ between them and
/// the pose acts like a kick of ω²h δθ. Arms are then to be set after projection, too, and inertias
/// and factors where that turn is not small.
pub(crate) const UNRESOLVED: f64 = 1.0;

/// ω²h² under which the step resolves the swing: both terms would be under 1e-4 of the inertia.
const RESOLVED: f64 = 0.05;

impl JointTree {
    /// Adds geometric stiffness to the inertias set, from the accumulated impulses, taken to have
    /// acted over h, s. To call after [`Self::set_inertia`] and before [`Self::factor`]. Returns the
    /// largest ω²h² found; see [`UNRESOLVED`].
    pub fn stiffen(&mut self, h: f64) -> f64 {
        let mut fastest: f64 = 0.0;
        let stiffness = &mut self.dampings;
        stiffness.fill(Matrix3::zeros());
        for joint in &self.joints {
            if let Some(child) = stiffness.get_mut(joint.child as usize) {
                add_pull(child, &joint.arm_child, &joint.impulse);
            }
            add_pull(&mut stiffness[joint.parent as usize], &joint.arm_parent, &-joint.impulse);
        }
        for (damping, inertia) in self.dampings.iter_mut().zip(&mut self.inertias) {
            let stiffness = *damping * h;
            let inverse = &mut inertia.inverse_inertia;
            // Mean over the two directions across the pull.
            let swing = 0.5 * inverse.dot(&stiffness);
            fastest = fastest.max(swing);
            let Some(Swing { added, damped }) = Swing::of(swing) else {
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

/// Shares of h²K for a swing of ω²h².
#[derive(Clone, Copy, Debug)]
pub(crate) struct Swing {
    /// Added to the inertia.
    pub added: f64,
    /// Whose momentum is lost.
    pub damped: f64,
}

impl Swing {
    /// None where the step resolves the swing.
    pub fn of(swing: f64) -> Option<Self> {
        let weight = swing * swing / (1.0 + swing * swing);
        let damped = DAMPING + (STRONG_DAMPING - DAMPING) * swing / (STRONG + swing);
        (swing >= RESOLVED).then_some(Self { added: weight * ADDED_INERTIA, damped: weight * damped })
    }
}

/// Adds max(0, r·f) (1 − r̂ r̂ᵀ).
pub(crate) fn add_pull(stiffness: &mut Matrix3<f64>, arm: &Vector3<f64>, force: &Vector3<f64>) {
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
