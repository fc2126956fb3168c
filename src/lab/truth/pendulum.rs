//! The rigid pendulum released at rest, in closed form:
//! sin(θ/2) = k sn(ω₀ t + K, k), k = sin(θ₀/2), ω₀² = m g l/I_pivot.

use bevy::math::{DQuat, DVec3};

use crate::scene::{SceneSpec, ShapeSpec};

use super::answer::{EnergyScale, Poses, Truth};
use super::bodies::{anchor_on, dynamic};
use super::elliptic::{jacobi, quarter_period};
use crate::lab::angle::wrapped;
use crate::lab::simulation::Sample;

pub(super) fn truth(scene: &SceneSpec) -> Option<Truth> {
    let Rod { index, to_centre, outward, down, swing, start, .. } = Rod::of(scene)?;
    let fall = scene.bodies[index].mass? * scene.gravity.length() * to_centre.length() * (1.0 - start.cos());
    let distance = move |sample: &Sample| {
        let along = sample.bodies[index].rotation * to_centre;
        let angle = along.dot(outward).atan2(along.dot(down));
        Some(wrapped(angle - swing.angle(sample.time)).abs())
    };
    let truth = Truth::largest("angle of the rod", "rad", distance).with_uncertainty(UNCERTAINTY);
    Some(truth.with_energy_scale(EnergyScale::Known(fall)))
}

/// The rod where the answer has it.
pub(super) fn poses(scene: &SceneSpec) -> Option<Poses> {
    let Rod { index, to_centre, outward, down, swing, start } = Rod::of(scene)?;
    let body = &scene.bodies[index];
    let rotation = body.rotation;
    let pivot = body.position - rotation * to_centre;
    let axis = down.cross(outward);
    Some(Box::new(move |time| {
        let rotation = DQuat::from_axis_angle(axis, swing.angle(time) - start) * rotation;
        vec![(index, pivot + rotation * to_centre, rotation)]
    }))
}

/// What the answer needs to know of the scene.
struct Rod {
    index: usize,
    /// From the pivot, body axes.
    to_centre: DVec3,
    /// Level, to the side that it starts on.
    outward: DVec3,
    down: DVec3,
    swing: Swing,
    /// Angle from hanging, rad.
    start: f64,
}

impl Rod {
    fn of(scene: &SceneSpec) -> Option<Self> {
        let index = *dynamic(scene).first()?;
        let rod = &scene.bodies[index];
        let Some(ShapeSpec::Cuboid { size }) = rod.shape else { return None };
        let to_centre = -anchor_on(scene, index)?;
        let lever = to_centre.length();
        let gravity = scene.gravity.length();
        let down = scene.gravity / gravity;
        let along = rod.rotation * to_centre / lever;
        let outward = (along - along.dot(down) * down).normalize();
        let start = outward.dot(along).atan2(down.dot(along));
        let pivot_inertia_per_mass = (size.x * size.x + size.y * size.y) / 12.0 + lever * lever;
        let swing = Swing::new(start, gravity * lever / pivot_inertia_per_mass);
        Some(Self { index, to_centre, outward, down, swing, start })
    }
}

/// ω₀ t, up to 40 rad in a scene's time, is known to a few roundings; the rate of the angle to it is
/// below 2, rad.
pub(super) const UNCERTAINTY: f64 = 1e-13;

/// A pendulum released at rest.
pub(super) struct Swing {
    /// k = sin(θ₀/2).
    modulus: f64,
    /// k′.
    complement: f64,
    /// ω₀, rad/s.
    frequency: f64,
    quarter: f64,
}

impl Swing {
    /// From an angle between 0 and π from hanging, where small swings would have that squared
    /// frequency, 1/s².
    pub fn new(start: f64, squared_frequency: f64) -> Self {
        let (modulus, complement) = (0.5 * start).sin_cos();
        Self { modulus, complement, frequency: squared_frequency.sqrt(), quarter: quarter_period(complement) }
    }

    /// Angle from hanging, rad.
    pub fn angle(&self, time: f64) -> f64 {
        2.0 * (self.modulus * jacobi(self.frequency * time + self.quarter, self.complement).sn).asin()
    }

    /// When it first is at an angle between 0 and its start, s, by bisection.
    pub fn time_to(&self, angle: f64) -> f64 {
        let (mut before, mut after) = (0.0, self.quarter / self.frequency);
        loop {
            let middle = 0.5 * (before + after);
            if middle <= before || middle >= after {
                return middle;
            }
            *(if self.angle(middle) > angle { &mut before } else { &mut after }) = middle;
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, FRAC_PI_6, PI};

    use super::*;

    /// θ″ = −ω₀² sin θ, classical Runge–Kutta.
    #[test]
    fn angle_follows_the_equation_of_motion() {
        for (start, squared_frequency) in [(FRAC_PI_2, 1.0), (FRAC_PI_6, 9.0), (3.0, 1.0)] {
            let swing = Swing::new(start, squared_frequency);
            let step = 1e-4;
            let slope = |(angle, rate): (f64, f64)| (rate, -squared_frequency * angle.sin());
            let along = |at: (f64, f64), slope: (f64, f64), by: f64| (at.0 + by * slope.0, at.1 + by * slope.1);
            let mut state = (start, 0.0);
            for n in 0..200_000 {
                let time = f64::from(n) * step;
                // (ω₀ h)⁴ = 1e-14 a unit of time at most; rounding of 2e5 steps adds some 1e-12.
                assert!((swing.angle(time) - state.0).abs() < 1e-10, "from {start} at {time}");
                let k1 = slope(state);
                let k2 = slope(along(state, k1, 0.5 * step));
                let k3 = slope(along(state, k2, 0.5 * step));
                let k4 = slope(along(state, k3, step));
                state.0 += step / 6.0 * (k1.0 + 2.0 * k2.0 + 2.0 * k3.0 + k4.0);
                state.1 += step / 6.0 * (k1.1 + 2.0 * k2.1 + 2.0 * k3.1 + k4.1);
            }
        }
    }

    #[test]
    fn angle_differences_do_not_depend_on_turns() {
        assert!((wrapped(PI + 0.1) - (0.1 - PI)).abs() < 1e-15);
        assert_eq!(wrapped(0.3), 0.3);
    }
}
