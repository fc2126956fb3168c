//! Rows of bodies on parallel hinges: `hinge_chain`, which swings, and `bridge`, which hangs between its banks.

use std::f64::consts::FRAC_1_SQRT_2;

use bevy::math::{DQuat, DVec3};

use super::gravity::EARTH;
use super::palette;
use crate::physics::Breakable;
use crate::scene::info::Parameter;
use crate::scene::{BodySpec, JointSpec, SceneInfo, SceneSpec, ShapeSpec, Subject, ViewSpec};

pub(super) const HINGE_CHAIN: SceneInfo = SceneInfo {
    name: "hinge_chain",
    title: "Chain of hinges",
    subject: Subject::Joints,
    about: "n boxes 0.2 x 0.1 x 0.1 m of 1 kg on hinges with axes z, then a ball of r kg, released horizontal under \
            gravity that pulls along the axes too, no collision",
    truth: "no body tilts off the axes; energy; limits hold",
    parameters: &[
        Parameter::whole("n", "boxes", 100.0, 1.0, 10_000.0),
        Parameter::real("r", "mass of the ball, kg", 1000.0, 0.001, 1e6),
        Parameter::real("limit", "angle that each hinge may turn either way, degrees; 0: any", 0.0, 0.0, 180.0),
    ],
    seconds: 10.0,
    bodies: |values| values[0] + 2.0,
    build: |values| build_chain(values[0] as usize, values[1], values[2]),
};

pub(super) const BRIDGE: SceneInfo = SceneInfo {
    name: "bridge",
    title: "Hanging bridge",
    subject: Subject::Joints,
    about: "n planks 1 x 0.1 x 2 m of 50 kg hinged end to end between two banks, in equilibrium, breakable; with a load \
            a ball of 500 kg rolls over it",
    truth: "without a load it stays in the discrete catenary; its tensions",
    parameters: &[
        Parameter::whole("n", "planks", 30.0, 2.0, 10_000.0),
        Parameter::whole("load", "1: with the ball", 0.0, 0.0, 1.0),
        Parameter::real("strength", "force at which a hinge breaks, N", 1e6, 1.0, 1e12),
    ],
    seconds: 5.0,
    bodies: |values| values[0] + 2.0 + values[1],
    build: |values| build_bridge(values[0] as usize, values[1] == 1.0, values[2]),
};

fn build_chain(n: usize, ball_mass: f64, limit: f64) -> SceneSpec {
    const LENGTH: f64 = 0.2;
    const RADIUS: f64 = 0.3;
    let mut scene = SceneSpec::new("hinge_chain", 10.0 * FRAC_1_SQRT_2 * DVec3::new(0.0, -1.0, -1.0));
    scene.bodies.push(BodySpec::pin("pivot", DVec3::ZERO));
    for i in 0..=n {
        let start = i as f64 * LENGTH * DVec3::X;
        let body = if i < n {
            let shape = ShapeSpec::Cuboid { size: DVec3::new(LENGTH, 0.1, 0.1) };
            let link = BodySpec::new(format!("link {i}"), shape, start + 0.5 * LENGTH * DVec3::X);
            link.with_mass(1.0).with_color(palette::bright(i))
        } else {
            let ball = BodySpec::new("ball", ShapeSpec::Sphere { radius: RADIUS }, start + RADIUS * DVec3::X);
            ball.with_mass(ball_mass).with_color(palette::SLATE)
        };
        let body = body.without_collision();
        let hinge = JointSpec::hinge(&scene.bodies[i], &body, start, DVec3::Z);
        let range = limit.to_radians();
        scene.joints.push(if limit > 0.0 { hinge.with_range(-range, range) } else { hinge });
        scene.bodies.push(body);
    }
    let length = n as f64 * LENGTH + 2.0 * RADIUS;
    scene.view = Some(ViewSpec::framing(-0.45 * length * DVec3::Y, 1.05 * length, DVec3::new(0.0, 0.12, 1.0)));
    scene
}

/// From the banks' edges to each other, over the length of all planks.
const SPAN: f64 = 0.9;

fn build_bridge(n: usize, with_load: bool, strength: f64) -> SceneSpec {
    let size = DVec3::new(1.0, 0.1, 2.0);
    let mut scene = SceneSpec::new("bridge", EARTH);
    let half_span = 0.5 * SPAN * n as f64;
    let bank_size = DVec3::new(6.0, 1.0, size.z);
    for (name, side) in [("left bank", -1.0), ("right bank", 1.0)] {
        // A plank's half thickness below the hinge, so that tops are level.
        let centre = DVec3::new(side * (half_span + 0.5 * bank_size.x), 0.5 * (size.y - bank_size.y), 0.0);
        let bank = BodySpec::new(name, ShapeSpec::Cuboid { size: bank_size }, centre);
        scene.bodies.push(bank.fixed().with_color(palette::SLATE));
    }
    let slopes = catenary(n);
    let mut end = -half_span * DVec3::X;
    for (i, slope) in slopes.iter().enumerate() {
        let along = DVec3::new(1.0, *slope, 0.0).normalize();
        let plank = BodySpec::new(format!("plank {i}"), ShapeSpec::Cuboid { size }, end + 0.5 * along)
            .with_mass(50.0)
            .with_rotation(DQuat::from_rotation_z(slope.atan()))
            .with_color(palette::WOOD);
        scene.bodies.push(if with_load { plank } else { plank.without_collision() });
        end += along;
    }
    let ends = |i: usize| [if i == 0 { 0 } else { i + 1 }, if i == n { 1 } else { i + 2 }];
    for i in 0..=n {
        let [a, b] = ends(i).map(|body| &scene.bodies[body]);
        let at = if i < n { b.point(-0.5 * DVec3::X) } else { a.point(0.5 * DVec3::X) };
        let hinge = JointSpec::hinge(a, b, at, DVec3::Z);
        scene.joints.push(hinge.with_strength(Breakable::at_force(strength)));
    }
    if with_load {
        const RADIUS: f64 = 0.5;
        let place = DVec3::new(-half_span - 1.0, 0.5 * size.y + RADIUS, 0.0);
        let speed = 2.0;
        let ball = BodySpec::new("ball", ShapeSpec::Sphere { radius: RADIUS }, place)
            .with_mass(500.0)
            .with_velocity(speed * DVec3::X, -speed / RADIUS * DVec3::Z)
            .with_color(palette::STEEL);
        scene.bodies.push(ball);
    }
    let middle = -0.2 * SPAN * n as f64 * DVec3::Y;
    scene.view = Some(ViewSpec::framing(middle, 0.6 * n as f64 + 1.0, DVec3::new(0.2, 0.35, 1.0)));
    scene
}

/// Slopes tan θ of n planks of 1 m that hang between level ends `SPAN` n apart: (k − (n − 1)/2) w/H for plank k, with
/// Σ cos θ = `SPAN` n, by Newton's method for H/w, N/N, the pull over the weight of a plank.
fn catenary(n: usize) -> Vec<f64> {
    let place = |k: usize| k as f64 - 0.5 * (n - 1) as f64;
    let mut slackness = 1.0 / n as f64; // w/H
    for _ in 0..100 {
        let (mut span, mut change) = (0.0, 0.0);
        for k in 0..n {
            let slope = place(k) * slackness;
            let cosine = (1.0 + slope * slope).sqrt().recip();
            span += cosine;
            change -= place(k) * slope * cosine.powi(3);
        }
        let step = (span - SPAN * n as f64) / change;
        // Not beyond zero, where planks lie level.
        slackness = (slackness - step).max(0.1 * slackness);
        if step.abs() <= 1e-15 * slackness {
            break;
        }
    }
    (0..n).map(|k| place(k) * slackness).collect()
}
