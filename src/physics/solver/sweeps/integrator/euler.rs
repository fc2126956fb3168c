//! Euler as the 2009 engine ran it: v += h a, then x += h v with the new v (first order).

use super::System;

/// One substep.
pub(crate) fn substep(system: &mut impl System, h: f64) {
    system.solve(h);
    system.kick(h);
    system.drift(h);
}
