//! A rod that a motor drives to an angle without gravity: the damped oscillator, ẍ + 2ζω ẋ + ω² (x − 1) = 0 from rest
//! at 0.

use std::f64::consts::TAU;

use bevy::math::DVec3;

use crate::physics::MotorTarget;
use crate::scene::SceneSpec;

use super::answer::{EnergyScale, Truth};
use super::bodies::{dynamic, turn};
use crate::lab::angle::wrapped;
use crate::lab::simulation::Sample;

pub(super) fn truth(scene: &SceneSpec) -> Option<Truth> {
    let rod = *dynamic(scene).first()?;
    let MotorTarget::Position { target, frequency, damping_ratio } = scene.joints.first()?.motor?.target else {
        return None;
    };
    let start = scene.bodies[rod].rotation;
    let distance = move |sample: &Sample| {
        let left = remainder(TAU * frequency * sample.time, damping_ratio);
        let angle = turn(sample.bodies[rod].rotation, start, DVec3::Z);
        Some(wrapped(angle - target * (1.0 - left)).abs())
    };
    // A servo that is off by more than the step asked for grows.
    let truth = Truth::largest("angle of the rod", "rad", distance).failing_above(target);
    Some(truth.with_energy_scale(EnergyScale::NotKept))
}

/// The share of the step that is left at a phase ωt, for a damping ratio ζ:
/// e^{−ζωt} (cos ω_d t + ζω/ω_d sin ω_d t), ω_d = ω √(1 − ζ²); beyond ζ = 1 with the hyperbolic functions.
fn remainder(phase: f64, damping_ratio: f64) -> f64 {
    let decay = damping_ratio * phase;
    let squared = 1.0 - damping_ratio * damping_ratio;
    if squared > 0.0 {
        let damped = phase * squared.sqrt();
        let sinc = if damped == 0.0 { 1.0 } else { damped.sin() / damped };
        (-decay).exp() * (damped.cos() + decay * sinc)
    } else {
        // In decaying exponentials, which do not overflow: sinh x/x = e^x (1 − e^{−2x})/2x.
        let slow = phase * (-squared).sqrt();
        let sinhc = if slow == 0.0 { 1.0 } else { -(-2.0 * slow).exp_m1() / (2.0 * slow) };
        let cosh = 0.5 * (1.0 + (-2.0 * slow).exp());
        (slow - decay).exp() * (cosh + decay * sinhc)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_closed_form_solves_the_equation_of_motion() {
        for damping_ratio in [0.0, 0.05, 0.7, 1.0, 1.0 + 1e-9, 3.0] {
            assert_eq!(remainder(0.0, damping_ratio), 1.0);
            let step = 1e-4;
            for phase in [0.3, 2.0, 9.0] {
                let [before, at, after] = [-step, 0.0, step].map(|by| remainder(phase + by, damping_ratio));
                let (rate, gain) = ((after - before) / (2.0 * step), (after - 2.0 * at + before) / (step * step));
                let residual = gain + 2.0 * damping_ratio * rate + at;
                assert!(residual.abs() < 1e-6, "ζ = {damping_ratio}, at {phase}: {residual}");
            }
        }
    }
}
