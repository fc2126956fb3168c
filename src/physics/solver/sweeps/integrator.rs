//! From forces to velocities to poses.
//!
//! Rotations: q ← normalize(q + ½ h ω q) with ω in world axes (Omelyan 1999, p. 5). No gyroscopic
//! torque, as in the 2009 engine.

#[cfg(test)]
mod tests;

use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use super::local::LocalBody;
use crate::physics::constraint::row::Twist;

/// What an integrator drives: bodies under constraints.
pub(super) trait System {
    /// Finds the constraint forces at the present state, to act over a time h, s.
    fn solve(&mut self, h: f64);
    /// Lets external and constraint forces change the velocities over h.
    fn kick(&mut self, h: f64);
    /// Lets the velocities change the poses over h.
    fn drift(&mut self, h: f64);
    /// Brings the contacts' arms and depths to the present poses.
    fn move_contacts(&mut self);
}

/// One substep of Euler as the 2009 engine ran it: v += h a, then x += h v with the new v (first order).
pub(super) fn euler(system: &mut impl System, h: f64) {
    system.solve(h);
    system.kick(h);
    system.drift(h);
}

/// One substep of velocity Verlet: kick by h/2, drift by h, kick by h/2 (second order without constraints).
///
/// Forces are needed at both ends of the step, so the constraints are solved twice: why the 2009
/// engine dropped it.
pub(super) fn verlet(system: &mut impl System, h: f64) {
    system.solve(0.5 * h);
    system.kick(0.5 * h);
    system.drift(h);
    system.move_contacts();
    system.solve(0.5 * h);
    system.kick(0.5 * h);
}

/// v ← (v + h (M⁻¹F_ext + a))/(1 + c h), ω likewise, with a = M⁻¹Jᵀλ and c the drag.
pub(super) fn kick(local: &mut LocalBody, constraint: &Twist<f64>, h: f64) {
    let free = local.free_acceleration();
    let body = &mut local.body;
    body.linear = (body.linear + (free.linear + constraint.linear) * h) / (1.0 + body.drag.0 * h);
    body.angular = (body.angular + (free.angular + constraint.angular) * h) / (1.0 + body.drag.1 * h);
}

/// x ← x + h v, q ← normalize(q + ½ h ω q).
pub(super) fn drift(local: &mut LocalBody, h: f64) {
    let body = &mut local.body;
    body.position += body.linear * h;
    if body.angular != Vector3::zeros() {
        let omega = Quaternion::from_imag(body.angular);
        let q = body.rotation.into_inner();
        body.rotation = UnitQuaternion::new_normalize(q + omega * q * (0.5 * h));
        local.update_inverse_inertia();
    }
}
