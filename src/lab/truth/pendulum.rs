//! The rigid pendulum released horizontal, in closed form:
//! sin(θ/2) = k sn(ω₀ t + K, k), k = sin(θ₀/2), ω₀² = m g (L/2)/I_pivot.

use std::f64::consts::{FRAC_1_SQRT_2, TAU};

use bevy::math::DVec3;

use crate::scene::{SceneSpec, ShapeSpec};

use super::elliptic::{jacobi, quarter_period};
use super::{EnergyScale, Truth, anchor_on, dynamic};

/// sin(θ₀/2) and cos(θ₀/2) for θ₀ = 90°.
const MODULUS: f64 = FRAC_1_SQRT_2;

pub(super) fn truth(scene: &SceneSpec) -> Option<Truth> {
    let index = *dynamic(scene).first()?;
    let rod = &scene.bodies[index];
    let Some(ShapeSpec::Cuboid { size }) = rod.shape else { return None };
    let to_centre = -anchor_on(scene, index)?; // from the pivot, body axes
    let lever = to_centre.length();
    let gravity = scene.gravity.length();
    let down = scene.gravity / gravity;
    let outward = rod.rotation * to_centre / lever;

    let pivot_inertia_per_mass = (size.x * size.x + size.y * size.y) / 12.0 + lever * lever;
    let frequency = (gravity * lever / pivot_inertia_per_mass).sqrt();
    let fall = rod.mass? * gravity * lever;

    let distance = move |sample: &super::Sample| {
        let along: DVec3 = sample.bodies[index].rotation * to_centre;
        let angle = along.dot(outward).atan2(along.dot(down));
        Some(wrapped(angle - angle_at(frequency * sample.time)).abs())
    };
    Some(Truth::largest("angle of the rod", "rad", distance).with_energy_scale(EnergyScale::Known(fall)))
}

/// Angle from hanging at ω₀ t, released at rest from 90°.
fn angle_at(phase: f64) -> f64 {
    let quarter = quarter_period(MODULUS);
    2.0 * (MODULUS * jacobi(phase + quarter, MODULUS).sn).asin()
}

/// The same angle, −π to π.
fn wrapped(angle: f64) -> f64 {
    angle - TAU * (angle / TAU).round()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, PI};

    use super::*;

    /// θ″ = −sin θ in units of ω₀, classical Runge–Kutta.
    #[test]
    fn angle_follows_the_equation_of_motion() {
        let step = 1e-4;
        let slope = |(angle, rate): (f64, f64)| (rate, -angle.sin());
        let along = |state: (f64, f64), slope: (f64, f64), by: f64| (state.0 + by * slope.0, state.1 + by * slope.1);
        let mut state = (FRAC_PI_2, 0.0);
        for n in 0..200_000 {
            let phase = f64::from(n) * step;
            // h⁴ = 1e-16 a unit of time; rounding of 2e5 steps adds some 1e-12.
            assert!((angle_at(phase) - state.0).abs() < 1e-11, "at {phase}");
            let k1 = slope(state);
            let k2 = slope(along(state, k1, 0.5 * step));
            let k3 = slope(along(state, k2, 0.5 * step));
            let k4 = slope(along(state, k3, step));
            state.0 += step / 6.0 * (k1.0 + 2.0 * k2.0 + 2.0 * k3.0 + k4.0);
            state.1 += step / 6.0 * (k1.1 + 2.0 * k2.1 + 2.0 * k3.1 + k4.1);
        }
    }

    #[test]
    fn angle_differences_do_not_depend_on_turns() {
        assert!((wrapped(PI + 0.1) - (0.1 - PI)).abs() < 1e-15);
        assert_eq!(wrapped(0.3), 0.3);
    }
}
