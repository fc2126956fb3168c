//! Free rotation of a body that is not isotropic, by a step that keeps energy and angular momentum.
//!
//! In body axes Euler's equations are I Ω̇ = −Ω × I Ω. The implicit midpoint rule
//!
//! I (Ω⁺ − Ω) + h Ω̄ × I Ω̄ = 0,  Ω̄ = (Ω + Ω⁺)/2,
//!
//! keeps both quadratic invariants, Ω·IΩ and |IΩ|²: its product with Ω̄, and with IΩ̄, is zero.
//! If the body is turned by the Cayley map of hΩ̄, the quaternion along (1, ½hΩ̄), then the angular
//! momentum keeps its direction in the world, too: with A = 1 − ½h[Ω̄]× the rotation is A⁻¹Aᵀ in body
//! axes, and the rule is Aᵀ I Ω⁺ = A I Ω (Simo and Wong 1991; Lewis and Simo 1994).
//!
//! Newton's method solves for u = hΩ̄: f(u) = I (u − hΩ) + ½ u × I u = 0, with
//! f′(u) = I + ½([u]× I − [I u]×). Every order in h is like the exact motion but the phase, which
//! is of second order. Where it does not find u, as the body turns by many radians, the time is cut into halves: what is
//! no root of f keeps nothing.

use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};

use super::{is_isotropic, rotation_by};

/// Newton's method doubles the digits: four suffice for |hΩ| ≤ 1; no body turns that far in a step
/// with any accuracy left.
const ITERATIONS: usize = 6;

/// Into how many pieces a step is cut at most, by halves. A body that turns too far for these keeps its Ω, and so its energy.
const PIECES: u32 = 64;

/// Share of hΩ̄ that an iteration changes from which on the next would not be felt: it changes the square of that.
const CONVERGED: f64 = 1e-9;

/// One step of free rotation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FreeRotation {
    /// Ω⁺, body axes, rad/s.
    pub angular: Vector3<f64>,
    /// Turn over the step, body axes: q⁺ = q `turn`.
    pub turn: UnitQuaternion<f64>,
}

/// Turns a body of that principal inertia (kg m²; any common factor cancels) with Ω in body axes
/// over a time h, s.
#[inline(always)]
pub(crate) fn rotate(inertia: &Vector3<f64>, angular: &Vector3<f64>, h: f64) -> FreeRotation {
    let start = angular * h;
    let mean = if turns_steadily(inertia, &start) { Some(start) } else { midpoint(inertia, &start) };
    match mean {
        Some(mean) => turned_by(&mean, angular, h),
        None => rotate_in_pieces(inertia, angular, h),
    }
}

/// The step of length h, s, that has hΩ̄ for its mean.
#[inline(always)]
fn turned_by(mean: &Vector3<f64>, angular: &Vector3<f64>, h: f64) -> FreeRotation {
    let turn = UnitQuaternion::new_normalize(Quaternion::from_parts(1.0, mean * 0.5));
    FreeRotation { angular: if h == 0.0 { *angular } else { mean * (2.0 / h) - angular }, turn }
}

/// The same, which cannot be solved for at once, in as many equal pieces as it takes to solve for each.
#[cold]
#[inline(never)]
fn rotate_in_pieces(inertia: &Vector3<f64>, angular: &Vector3<f64>, h: f64) -> FreeRotation {
    let (mut done, mut pieces) = (0, 2);
    let mut whole = FreeRotation { angular: *angular, turn: UnitQuaternion::identity() };
    while done < pieces {
        let piece = h / f64::from(pieces);
        match midpoint(inertia, &(whole.angular * piece)) {
            Some(mean) => {
                let FreeRotation { angular, turn } = turned_by(&mean, &whole.angular, piece);
                whole = FreeRotation { angular, turn: whole.turn * turn };
                done += 1;
            }
            None if pieces < PIECES => (done, pieces) = (2 * done, 2 * pieces),
            None => {
                let left = piece * f64::from(pieces - done);
                whole.turn *= rotation_by(&(whole.angular * left));
                break;
            }
        }
    }
    whole
}

/// Whether the angular velocity of a body that turns freely changes: its inertia is not that of a ball, and nothing keeps it
/// from turning about any axis.
#[inline(always)]
pub(crate) fn wobbles(inverse_inertia_body: &Vector3<f64>, rotation_freedom: &Vector3<f64>) -> bool {
    let can_turn = inverse_inertia_body.min() > 0.0 && *rotation_freedom == Vector3::repeat(1.0);
    can_turn && !is_isotropic(inverse_inertia_body)
}

/// The step of free rotation over a time h of a body with that angular velocity in world axes; none where that stays what
/// it is.
#[inline(always)]
pub(crate) fn free_step(
    rotation: &UnitQuaternion<f64>,
    angular: &Vector3<f64>,
    inverse_inertia_body: &Vector3<f64>,
    rotation_freedom: &Vector3<f64>,
    h: f64,
) -> Option<FreeRotation> {
    if !wobbles(inverse_inertia_body, rotation_freedom) || *angular == Vector3::zeros() {
        return None;
    }
    let spin = rotation.inverse_transform_vector(angular);
    Some(rotate(&inverse_inertia_body.map(f64::recip), &spin, h))
}

/// The angular velocity, world axes, and the rotation after a time h of a body that is not round; none
/// where the angular velocity stays what it is.
#[inline(always)]
pub(crate) fn free_rotation(
    rotation: &UnitQuaternion<f64>,
    angular: &Vector3<f64>,
    inverse_inertia_body: &Vector3<f64>,
    rotation_freedom: &Vector3<f64>,
    h: f64,
) -> Option<(Vector3<f64>, UnitQuaternion<f64>)> {
    let turned = free_step(rotation, angular, inverse_inertia_body, rotation_freedom, h)?;
    let rotation = rotation * turned.turn;
    Some((rotation * turned.angular, rotation))
}

/// Turns a body without torque over a time h.
#[inline(always)]
pub(crate) fn turn_freely(
    rotation: &mut UnitQuaternion<f64>,
    angular: &mut Vector3<f64>,
    inverse_inertia_body: &Vector3<f64>,
    rotation_freedom: &Vector3<f64>,
    h: f64,
) {
    match free_rotation(rotation, angular, inverse_inertia_body, rotation_freedom, h) {
        Some(turned) => (*angular, *rotation) = turned,
        None if *angular != Vector3::zeros() => *rotation = rotation_by(&(*angular * h)) * *rotation,
        None => {}
    }
}

/// Share of hΩ that a step may change before it is worth to solve for.
const NEGLIGIBLE: f64 = 1e-12;

/// Whether Ω stays what it is over the step: the body is round, or turns about a principal axis.
#[inline]
fn turns_steadily(inertia: &Vector3<f64>, start: &Vector3<f64>) -> bool {
    let torque = start.cross(&inertia.component_mul(start));
    torque.amax() <= NEGLIGIBLE * inertia.min() * start.amax()
}

/// hΩ̄ from hΩ, where it is found.
#[inline(never)]
fn midpoint(inertia: &Vector3<f64>, start: &Vector3<f64>) -> Option<Vector3<f64>> {
    match (0..3).find(|&axis| inertia[(axis + 1) % 3] == inertia[(axis + 2) % 3]) {
        Some(axis) => Some(midpoint_of_symmetric(inertia, start, axis)),
        None => midpoint_by_newton(inertia, start),
    }
}

/// The same for two equal moments across an axis: there u = hΩ along the axis, of which f is linear in the rest. With κ =
/// ½ (I_axis/I_across − 1) u, u_y + κ u_z = hΩ_y and u_z − κ u_y = hΩ_z for y and z after the axis.
fn midpoint_of_symmetric(inertia: &Vector3<f64>, start: &Vector3<f64>, axis: usize) -> Vector3<f64> {
    let [next, last] = [(axis + 1) % 3, (axis + 2) % 3];
    let turn = 0.5 * (inertia[axis] / inertia[next] - 1.0) * start[axis];
    let share = 1.0 / (1.0 + turn * turn);
    let mut mean = *start;
    mean[next] = (start[next] - turn * start[last]) * share;
    mean[last] = (start[last] + turn * start[next]) * share;
    mean
}

fn midpoint_by_newton(inertia: &Vector3<f64>, start: &Vector3<f64>) -> Option<Vector3<f64>> {
    let scale = 1.0 / inertia.amax();
    let inertia = inertia * scale;
    let mut mean = *start;
    for _ in 0..ITERATIONS {
        let momentum = inertia.component_mul(&mean);
        let residual = inertia.component_mul(&(mean - start)) + mean.cross(&momentum) * 0.5;
        let tangent = Matrix3::from_diagonal(&inertia) + tangent_of_torque(&inertia, &mean) * 0.5;
        let step = tangent.try_inverse()? * residual;
        mean -= step;
        if step.amax() <= CONVERGED * mean.amax() {
            return Some(mean);
        }
    }
    None
}

/// Derivative of u × I u: [u]× I − [I u]×.
fn tangent_of_torque(inertia: &Vector3<f64>, u: &Vector3<f64>) -> Matrix3<f64> {
    let (yz, zx, xy) = (inertia.z - inertia.y, inertia.x - inertia.z, inertia.y - inertia.x);
    Matrix3::new(0.0, yz * u.z, yz * u.y, zx * u.z, 0.0, zx * u.x, xy * u.y, xy * u.x, 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::testing::Random;

    /// Inertia, Ω and q of the scene `top`: half sizes (0.5, 0.3, 0.1), about the middle axis.
    fn top() -> (Vector3<f64>, Vector3<f64>, UnitQuaternion<f64>) {
        let [x, y, z] = [0.25, 0.09, 0.01];
        (Vector3::new(y + z, z + x, x + y) * (120.0 / 3.0), Vector3::new(0.01, 10.0, 0.0), UnitQuaternion::identity())
    }

    fn energy(inertia: &Vector3<f64>, angular: &Vector3<f64>) -> f64 {
        0.5 * angular.dot(&inertia.component_mul(angular))
    }

    /// Ω and q after many steps.
    fn run(
        inertia: &Vector3<f64>,
        mut angular: Vector3<f64>,
        mut q: UnitQuaternion<f64>,
        time: f64,
        steps: u32,
    ) -> (Vector3<f64>, UnitQuaternion<f64>) {
        for _ in 0..steps {
            let step = rotate(inertia, &angular, time / f64::from(steps));
            angular = step.angular;
            q *= step.turn;
        }
        (angular, q)
    }

    /// The same by the classical Runge–Kutta method on Ω̇ = −I⁻¹(Ω × IΩ), q̇ = ½ q Ω.
    fn runge_kutta(
        inertia: &Vector3<f64>,
        mut angular: Vector3<f64>,
        q: UnitQuaternion<f64>,
        time: f64,
        steps: u32,
    ) -> (Vector3<f64>, UnitQuaternion<f64>) {
        let slope = |w: &Vector3<f64>, q: &Quaternion<f64>| {
            (-w.cross(&inertia.component_mul(w)).component_div(inertia), q * Quaternion::from_imag(*w) * 0.5)
        };
        let (h, mut q) = (time / f64::from(steps), q.into_inner());
        for _ in 0..steps {
            let (w1, q1) = slope(&angular, &q);
            let (w2, q2) = slope(&(angular + w1 * (h / 2.0)), &(q + q1 * (h / 2.0)));
            let (w3, q3) = slope(&(angular + w2 * (h / 2.0)), &(q + q2 * (h / 2.0)));
            let (w4, q4) = slope(&(angular + w3 * h), &(q + q3 * h));
            angular += (w1 + (w2 + w3) * 2.0 + w4) * (h / 6.0);
            q += (q1 + (q2 + q3) * 2.0 + q4) * (h / 6.0);
        }
        (angular, UnitQuaternion::new_normalize(q))
    }

    #[test]
    fn energy_and_angular_momentum_stay() {
        let (inertia, angular, q) = top();
        let momentum = q * inertia.component_mul(&angular);
        for hz in [60_u32, 240] {
            let (mut w, mut rotation) = (angular, q);
            for _ in 0..100 * hz {
                (w, rotation) = run(&inertia, w, rotation, 1.0 / f64::from(hz), 1);
                rotation.renormalize();
                let drift = energy(&inertia, &w) / energy(&inertia, &angular) - 1.0;
                assert!(drift.abs() < 1e-11, "energy at {hz} Hz: {drift:e}");
                let turned = (rotation * inertia.component_mul(&w) - momentum).norm() / momentum.norm();
                assert!(turned < 1e-11, "angular momentum at {hz} Hz: {turned:e}");
            }
        }
    }

    #[test]
    fn converges_to_a_fine_runge_kutta_in_second_order() {
        let mut random = Random::new(11);
        for _ in 0..5 {
            let inertia = Vector3::new(random.within(0.5, 1.0), random.within(0.5, 1.0), 1.2);
            let (angular, q) = (random.vector() * 5.0, random.rotation());
            let (w, rotation) = runge_kutta(&inertia, angular, q, 1.0, 20_000);
            let error = |steps| {
                let (w1, q1) = run(&inertia, angular, q, 1.0, steps);
                ((w1 - w).norm(), q1.angle_to(&rotation))
            };
            let (coarse, fine) = (error(500), error(1000));
            assert!(fine.0 < 1e-3 && fine.1 < 1e-3, "{fine:?}");
            for order in [(coarse.0 / fine.0).log2(), (coarse.1 / fine.1).log2()] {
                assert!((order - 2.0).abs() < 0.05, "order {order}");
            }
        }
    }

    #[test]
    fn fast_spin_and_long_steps_stay_finite_and_keep_energy() {
        let mut random = Random::new(12);
        for _ in 0..3000 {
            let inertia = Vector3::new(random.within(0.4, 1.0), random.within(0.5, 1.0), 0.6);
            let angular = random.vector() * 10.0_f64.powf(random.within(-3.0, 7.0));
            let step = rotate(&inertia, &angular, 1.0 / 60.0);
            let drift = energy(&inertia, &step.angular) / energy(&inertia, &angular) - 1.0;
            assert!(drift.abs() < 1e-9, "{angular:?}: {drift:e}");
        }
    }

    #[test]
    fn of_two_equal_moments_the_closed_form_is_what_newton_finds() {
        let mut random = Random::new(13);
        for round in 0..300 {
            let (along, across) = (random.within(0.3, 1.0), random.within(0.5, 1.0));
            let mut inertia = Vector3::repeat(across);
            inertia[round % 3] = along;
            let start = random.vector() * 0.5;
            let [closed, found] =
                [midpoint_of_symmetric(&inertia, &start, round % 3), midpoint_by_newton(&inertia, &start).unwrap()];
            assert!((closed - found).norm() < 1e-14, "{inertia:?} {start:?}: {closed:?} or {found:?}");
        }
    }

    #[test]
    fn an_isotropic_body_keeps_its_spin_exactly() {
        let angular = Vector3::new(3.0, -2.0, 0.5);
        let step = rotate(&Vector3::repeat(0.7), &angular, 0.25);
        assert_eq!(step.angular, angular);
    }
}
