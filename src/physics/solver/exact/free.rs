//! A body that nothing holds or touches, in closed form.
//!
//! Under a constant force and drag c: v(t) = v e^{−ct} + a t φ₁(ct), x(t) = x + v t φ₁(ct) + a t² φ₂(ct), with
//! φ₁(z) = (1 − e^{−z})/z and φ₂(z) = (1 − φ₁(z))/z. A body of the same inertia about all axes turns by the vector
//! ∫ω + ½ ∫∫ ω(t) × ω(s) ds dt (Magnus 1954, to fourth order; exact where torque and spin are parallel, or one is
//! zero).

use nalgebra::{UnitQuaternion, Vector3};

use super::mechanism::{Member, MemberState};
use super::rotation::exponential;

/// Whether the closed form is all there is to it.
pub(crate) fn is_closed(member: &Member) -> bool {
    member.is_round()
}

/// Takes a body through h, s.
pub(crate) fn advance(member: &Member, state: &mut MemberState, h: f64) {
    let gain = member.inverse_mass.component_mul(&member.force);
    let (kept, first, second) = decay(member.drag.0 * h);
    state.position += (state.linear * first + gain * (h * second)) * h;
    state.linear = state.linear * kept + gain * (h * first);
    let gain = member.freedom.component_mul(&member.torque) / member.inertia.x;
    let start = state.angular;
    let (kept, first, second) = decay(member.drag.1 * h);
    state.angular = start * kept + gain * (h * first);
    let turn = (start * first + gain * (h * second)) * h + gain.cross(&start) * (h * h * h / 12.0);
    if turn != Vector3::zeros() {
        state.rotation = UnitQuaternion::new_normalize((exponential(&turn) * state.rotation).into_inner());
    }
}

/// e^{−z}, φ₁ and φ₂.
fn decay(z: f64) -> (f64, f64, f64) {
    if z == 0.0 {
        return (1.0, 1.0, 0.5);
    }
    if z < 1e-2 {
        let first = 1.0 - z / 2.0 * (1.0 - z / 3.0 * (1.0 - z / 4.0 * (1.0 - z / 5.0 * (1.0 - z / 6.0))));
        let second = 0.5 - z / 6.0 * (1.0 - z / 4.0 * (1.0 - z / 5.0 * (1.0 - z / 6.0 * (1.0 - z / 7.0))));
        return (1.0 - z * first, first, second);
    }
    let first = -(-z).exp_m1() / z;
    ((-z).exp(), first, (1.0 - first) / z)
}
