//! Velocity Verlet: kick by h/2, drift by h, kick by h/2 (second order without constraints).
//!
//! Forces are needed at both ends of the step, so the constraints are solved twice: why the 2009
//! engine dropped it.

use super::System;

/// One substep.
pub(crate) fn substep(system: &mut impl System, h: f64) {
    system.solve(0.5 * h);
    system.kick(0.5 * h);
    system.drift(h);
    system.move_contacts();
    system.solve(0.5 * h);
    system.kick(0.5 * h);
}
