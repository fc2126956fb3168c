//! From forces to velocities to poses. One file an integrator; here what they share.
//!
//! Rotations: q ← normalize(q + ½ h ω q) with ω in world axes (Omelyan 1999, p. 5). No gyroscopic
//! torque, as in the 2009 engine.

pub(crate) mod euler;
pub(crate) mod verlet;

#[cfg(test)]
mod tests;

use nalgebra::{Quaternion, UnitQuaternion};

use super::island_solver::LocalBody;
use crate::physics::constraint::row::Twist;

/// What an integrator drives: bodies under constraints.
pub(crate) trait System {
    /// Finds the constraint forces at the present state, to act over a time h, s.
    fn solve(&mut self, h: f64);
    /// Lets external and constraint forces change the velocities over h.
    fn kick(&mut self, h: f64);
    /// Lets the velocities change the poses over h.
    fn drift(&mut self, h: f64);
    /// Brings the contacts' arms and depths to the present poses.
    fn move_contacts(&mut self);
}

/// v ← (v + h (M⁻¹F_ext + a))/(1 + c h), ω likewise, with a = M⁻¹Jᵀλ and c the drag.
pub(crate) fn kick(body: &mut LocalBody, constraint: &Twist<f64>, h: f64) {
    let free = body.free_acceleration();
    body.linear = (body.linear + (free.linear + constraint.linear) * h) / (1.0 + body.drag.0 * h);
    body.angular = (body.angular + (free.angular + constraint.angular) * h) / (1.0 + body.drag.1 * h);
}

/// x ← x + h v, q ← normalize(q + ½ h ω q).
pub(crate) fn drift(body: &mut LocalBody, h: f64) {
    body.position += body.linear * h;
    if body.angular != nalgebra::Vector3::zeros() {
        let omega = Quaternion::from_imag(body.angular);
        let q = body.rotation.into_inner();
        body.rotation = UnitQuaternion::new_normalize(q + omega * q * (0.5 * h));
        body.update_inverse_inertia();
    }
}
