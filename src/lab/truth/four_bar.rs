//! A row of parallelograms with one angle θ from upright: ½J(θ̇² − s²) = G(1 − cos θ), s the rate at the start. With
//! Ω² = s² + 4G/J this is θ = 2ψ − π, F(ψ, k) = K + ½Ωt, of the modulus k² = 1 − s²/Ω².

use std::f64::consts::PI;

use bevy::math::DVec3;

use crate::scene::{SceneSpec, ShapeSpec};

use super::answer::{EnergyScale, Truth};
use super::bodies::{dynamic, turn};
use super::elliptic::{jacobi, quarter_period};
use super::hinges;
use crate::lab::angle::wrapped;
use crate::lab::simulation::Sample;

pub(super) fn truth(scene: &SceneSpec) -> Option<Truth> {
    let rods = dynamic(scene);
    let start = rods.iter().map(|&rod| scene.bodies[rod].angular_velocity.z).fold(0.0, f64::min);
    let gravity = scene.gravity.length();
    let (mut inertia, mut weight_moment) = (0.0, 0.0);
    for &rod in &rods {
        let body = &scene.bodies[rod];
        let (mass, Some(ShapeSpec::Cuboid { size })) = (body.mass?, &body.shape) else { return None };
        let spin = body.angular_velocity.z / start;
        let lever = body.linear_velocity.x / start;
        inertia += mass * (lever * lever + spin * spin * (size.x * size.x + size.y * size.y) / 12.0);
        weight_moment += mass * gravity * body.position.y;
    }
    let angle = Angle::new(start.abs(), weight_moment / inertia);
    let turns: Vec<_> = rods
        .into_iter()
        .map(|rod| (rod, scene.bodies[rod].rotation, scene.bodies[rod].angular_velocity != DVec3::ZERO))
        .collect();
    let distance = move |sample: &Sample| {
        let angle = angle.at(sample.time);
        let error = |&(rod, start, turns): &(usize, _, bool)| {
            // From upright along +x is about −z.
            let should = if turns { -angle } else { 0.0 };
            wrapped(turn(sample.bodies[rod].rotation, start, DVec3::Z) - should).abs()
        };
        Some(turns.iter().map(error).fold(0.0, f64::max))
    };
    let kinetic = 0.5 * inertia * start * start + 2.0 * weight_moment;
    let truth = Truth::largest("angles of the rods", "rad", distance);
    // A quarter of a turn off, it is on another branch.
    let truth = truth.failing_above(0.5 * PI).with_energy_scale(EnergyScale::Known(kinetic));
    Some(truth.and(hinges::tilt(scene)))
}

/// θ in time.
struct Angle {
    /// k′ = s/Ω.
    complement: f64,
    /// ½Ω, 1/s.
    frequency: f64,
    quarter: f64,
}

impl Angle {
    /// From upright with that rate, rad/s, and that G/J, 1/s².
    fn new(start: f64, pull: f64) -> Self {
        let rate = start.hypot(2.0 * pull.sqrt());
        let complement = start / rate;
        Self { complement, frequency: 0.5 * rate, quarter: quarter_period(complement) }
    }

    /// But for whole turns, rad.
    fn at(&self, time: f64) -> f64 {
        let angle = jacobi(self.quarter + self.frequency * time, self.complement);
        2.0 * angle.sn.atan2(angle.cn) - PI
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_angle_keeps_energy() {
        let (start, pull) = (1.0, 11.0);
        let angle = Angle::new(start, pull);
        assert!(angle.at(0.0).abs() < 1e-14);
        let step = 1e-4;
        for time in [0.1, 0.5, 0.9, 3.0, 20.0] {
            let rate = wrapped(angle.at(time + step) - angle.at(time - step)) / (2.0 * step);
            let gained = 0.5 * (rate * rate - start * start);
            let fallen = pull * (1.0 - angle.at(time).cos());
            assert!((gained - fallen).abs() < 1e-4, "at {time} s: {gained}, not {fallen}");
        }
    }
}
