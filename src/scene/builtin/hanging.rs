//! Bodies on ball joints, hung from a pivot at the origin: released horizontal along +x
//! (`pendulum`, `rods`, `chain`) or at rest (`hanging`). Nothing collides.

use bevy::math::DVec3;

use super::gravity::{EARTH, TEN};
use super::palette;
use crate::scene::info::Parameter;
use crate::scene::{BodySpec, JointSpec, SceneInfo, SceneSpec, ShapeSpec, Subject, ViewSpec};

pub(super) const PENDULUM: SceneInfo = SceneInfo {
    name: "pendulum",
    title: "Pendulum",
    subject: Subject::Joints,
    about: "one rod 1 x 0.1 x 0.1 m of 1 kg, pivot at an end, released horizontal",
    truth: "closed form: sin(theta/2) = k sn(w0 t + K, k), k = 1/sqrt 2; energy",
    parameters: &[],
    seconds: 10.0,
    bodies: |_| 2.0,
    build: |_| {
        let mut scene = SceneSpec::new("pendulum", EARTH);
        scene.bodies.push(pivot(DVec3::ZERO));
        hang_rods(&mut scene, DVec3::ZERO, 1, 0.1);
        scene.view = Some(ViewSpec::framing(DVec3::new(0.0, -0.45, 0.0), 1.1, DVec3::new(0.0, 0.15, 1.0)));
        scene
    },
};

pub(super) const RODS: SceneInfo = SceneInfo {
    name: "rods",
    title: "Chain of rods",
    subject: Subject::Joints,
    about: "n rods 1 x 0.1 x 0.1 m of 1 kg in a row, pivot at one end, released horizontal, no collision",
    truth: "reference trajectory of the tip for n = 1, 2, 5; energy",
    parameters: &[Parameter::whole("n", "rods", 5.0, 1.0, 1000.0)],
    seconds: 2.0,
    bodies: |values| values[0] + 1.0,
    build: |values| {
        let mut scene = SceneSpec::new("rods", TEN);
        scene.bodies.push(pivot(DVec3::ZERO));
        hang_rods(&mut scene, DVec3::ZERO, values[0] as usize, 0.1);
        scene.view = Some(swing_view(DVec3::ZERO, values[0]));
        scene
    },
};

pub(super) const CHAIN: SceneInfo = SceneInfo {
    name: "chain",
    title: "Heavy ball on a chain",
    subject: Subject::Joints,
    about: "10 rods 1 x 0.2 x 0.2 m of 1 kg, then a ball of radius 1 m and r kg, released horizontal, no collision",
    truth: "reference trajectory of the ball for r = 1, 100, 1000, 1e6; no joint separates; energy",
    parameters: &[Parameter::real("r", "mass of the ball, kg", 100.0, 0.001, 1e9)],
    seconds: 2.0,
    bodies: |_| 12.0,
    build: |values| {
        let mut scene = SceneSpec::new("chain", TEN);
        hang_chain(&mut scene, DVec3::ZERO, values[0]);
        scene.view = Some(swing_view(DVec3::ZERO, 12.0));
        scene
    },
};

pub(super) const HANGING: SceneInfo = SceneInfo {
    name: "hanging",
    title: "Plumb line of balls",
    subject: Subject::Joints,
    about: "n balls of 1 kg hung one below the other, 1 m apart, no collision",
    truth: "stays put; each joint carries the weight below it",
    parameters: &[Parameter::whole("n", "balls", 10.0, 1.0, 1000.0)],
    seconds: 5.0,
    bodies: |values| values[0] + 1.0,
    build: |values| {
        let mut scene = SceneSpec::new("hanging", TEN);
        scene.bodies.push(pivot(DVec3::ZERO));
        for i in 0..values[0] as usize {
            let top = -(i as f64) * DVec3::Y;
            let ball = BodySpec::new(format!("weight {i}"), ShapeSpec::Sphere { radius: 0.3 }, top - 0.5 * DVec3::Y)
                .with_mass(1.0)
                .without_collision()
                .with_color(palette::bright(i));
            scene.joints.push(JointSpec::at(&scene.bodies[i], &ball, top));
            scene.bodies.push(ball);
        }
        let length = values[0];
        scene.view = Some(ViewSpec::framing(-0.5 * length * DVec3::Y, 0.55 * length + 0.5, DVec3::new(0.2, 0.15, 1.0)));
        scene
    },
};

/// A point of the world to hang things from.
fn pivot(at: DVec3) -> BodySpec {
    BodySpec::pin("pivot", at)
}

/// `n` rods 1 m long, of 1 kg and that thickness, end to end along +x from `start`, the first
/// joined to the last body so far.
fn hang_rods(scene: &mut SceneSpec, start: DVec3, n: usize, thickness: f64) {
    let shape = ShapeSpec::Cuboid { size: DVec3::new(1.0, thickness, thickness) };
    for i in 0..n {
        let left_end = start + i as f64 * DVec3::X;
        let rod = BodySpec::new(format!("rod {i}"), shape.clone(), left_end + 0.5 * DVec3::X)
            .with_mass(1.0)
            .without_collision()
            .with_color(palette::bright(i));
        if let Some(previous) = scene.bodies.last() {
            scene.joints.push(JointSpec::at(previous, &rod, left_end));
        }
        scene.bodies.push(rod);
    }
}

/// The bodies and joints of `chain` with its pivot at `start`.
pub(super) fn hang_chain(scene: &mut SceneSpec, start: DVec3, ball_mass: f64) {
    scene.bodies.push(pivot(start));
    hang_rods(scene, start, 10, 0.2);
    let tip = start + 10.0 * DVec3::X;
    let ball = BodySpec::new("ball", ShapeSpec::Sphere { radius: 1.0 }, tip + DVec3::X)
        .with_mass(ball_mass)
        .without_collision()
        .with_color(palette::SLATE);
    if let Some(last_rod) = scene.bodies.last() {
        scene.joints.push(JointSpec::at(last_rod, &ball, tip));
    }
    scene.bodies.push(ball);
}

/// From the side, all that a pendulum of that length from that pivot sweeps below it.
fn swing_view(pivot: DVec3, length: f64) -> ViewSpec {
    ViewSpec::framing(pivot - 0.45 * length * DVec3::Y, 1.05 * length, DVec3::new(0.0, 0.12, 1.0))
}
