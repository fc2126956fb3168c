//! Impacts: `bounce`, `spheres`, `cradle`, `wall`. All frictionless.

use bevy::math::{DQuat, DVec3};
use rand::RngExt;

use super::gravity::EARTH;
use super::palette;
use super::random::seeded;
use crate::scene::info::Parameter;
use crate::scene::{BodySpec, JointSpec, SceneInfo, SceneSpec, ShapeSpec, Subject, ViewSpec};

/// Of every ball in this file, m.
const RADIUS: f64 = 0.1;

pub(super) const BOUNCE: SceneInfo = SceneInfo {
    name: "bounce",
    title: "Bouncing balls",
    subject: Subject::Contacts,
    about: "7 x 7 balls of 10 kg and radius R = 0.1 m on a grid of 2 m, dropped, frictionless",
    truth: "closed form: the apex after k bounces is R + (height - R) e^(2k); at rest after t0 (1 + e)/(1 - e)",
    parameters: &[
        Parameter::real("e", "restitution", 0.5, 0.0, 1.0),
        Parameter::real("height", "of the centres at the start, m", 5.0, 0.2, 1e4),
    ],
    seconds: 20.0,
    bodies: |_| 50.0,
    build: |values| {
        let mut scene = SceneSpec::new("bounce", EARTH);
        scene.bodies.push(BodySpec::ground().with_material(0.0, 0.0).with_color(palette::GROUND));
        for i in 0..49 {
            let (x, z) = (2.0 * f64::from(i / 7) - 6.0, 2.0 * f64::from(i % 7) - 6.0);
            scene.bodies.push(ball(i as usize, DVec3::new(x, values[1], z), 10.0, values[0]));
        }
        let middle = 0.5 * values[1];
        scene.view = Some(ViewSpec::framing(middle * DVec3::Y, middle.hypot(7.6), DVec3::new(0.4, 0.25, 1.0)));
        scene
    },
};

pub(super) const SPHERES: SceneInfo = SceneInfo {
    name: "spheres",
    title: "Cube of balls",
    subject: Subject::Large,
    about: "6 x 6 x 6 balls of 10 kg and radius 0.1 m, almost in a cube, dropped; frictionless",
    truth: "e = 0: depths of all contacts 0; e = 1: total energy constant",
    parameters: &[Parameter::real("e", "restitution; the drop is e metres higher", 0.0, 0.0, 1.0)],
    seconds: 10.0,
    bodies: |_| 217.0,
    build: |values| build_spheres(values[0]),
};

pub(super) const CRADLE: SceneInfo = SceneInfo {
    name: "cradle",
    title: "Newton's cradle",
    subject: Subject::Contacts,
    about: "5 touching balls of 1 kg and radius 0.1 m on pendulums of 1 m, the first lifted 30 degrees, restitution 1",
    truth: "after the first impact only the last ball moves, at the first one's speed; energy",
    parameters: &[],
    seconds: 5.0,
    bodies: |_| 10.0,
    build: |_| build_cradle(),
};

pub(super) const WALL: SceneInfo = SceneInfo {
    name: "wall",
    title: "Ball at a thin wall",
    subject: Subject::Contacts,
    about: "a ball of 1 kg and radius 0.1 m thrown at v m/s at a static wall t m thick, no gravity, restitution 0",
    truth: "closed form: it flies v t, then rests on the wall's face",
    parameters: &[
        Parameter::real("v", "speed of the ball, m/s", 10.0, 0.1, 1e4),
        Parameter::real("t", "thickness of the wall, m", 0.1, 1e-3, 10.0),
    ],
    seconds: 1.0,
    bodies: |_| 2.0,
    build: |values| build_wall(values[0], values[1]),
};

fn ball(i: usize, position: DVec3, mass: f64, restitution: f64) -> BodySpec {
    BodySpec::new(format!("ball {i}"), ShapeSpec::Sphere { radius: RADIUS }, position)
        .with_mass(mass)
        .with_material(0.0, restitution)
        .with_color(palette::bright(i))
}

fn build_spheres(restitution: f64) -> SceneSpec {
    const SIDE: usize = 6;
    const PITCH: f64 = 0.21;
    let lowest = 0.101 + restitution;
    let first = -PITCH * (SIDE - 1) as f64 / 2.0;
    let mut random = seeded();
    let mut scene = SceneSpec::new("spheres", EARTH);
    scene.bodies.push(BodySpec::ground().with_material(0.0, 0.0).with_color(palette::GROUND));
    for i in 0..SIDE.pow(3) {
        let [layer, row, column] = [i / (SIDE * SIDE), i / SIDE % SIDE, i % SIDE].map(|k| PITCH * k as f64);
        let offset = DVec3::from_array(std::array::from_fn(|_| random.random_range(0.0..0.001)));
        let position = DVec3::new(first + column, lowest + layer, first + row) + offset;
        scene.bodies.push(ball(i, position, 10.0, restitution));
    }
    scene.view = Some(ViewSpec::framing(DVec3::new(0.0, 0.5 + restitution / 2.0, 0.0), 1.8, DVec3::new(0.5, 0.5, 1.0)));
    scene
}

fn build_cradle() -> SceneSpec {
    const LENGTH: f64 = 1.0;
    const LIFT_DEGREES: f64 = 30.0;
    let mut scene = SceneSpec::new("cradle", EARTH);
    for i in 0..5 {
        let pivot = DVec3::new(2.0 * RADIUS * (i as f64 - 2.0), LENGTH, 0.0);
        let lift = if i == 0 { -LIFT_DEGREES.to_radians() } else { 0.0 };
        let rotation = DQuat::from_rotation_z(lift);
        let pin = BodySpec::pin(format!("pivot {i}"), pivot);
        let bob = ball(i, pivot + rotation * (-LENGTH * DVec3::Y), 1.0, 1.0).with_rotation(rotation);
        scene.joints.push(JointSpec::new(&pin, DVec3::ZERO, &bob, LENGTH * DVec3::Y));
        scene.bodies.extend([pin, bob]);
    }
    scene.view = Some(ViewSpec::framing(DVec3::new(0.0, 0.4, 0.0), 1.0, DVec3::new(0.25, 0.2, 1.0)));
    scene
}

/// The wall's face is at x = 0. The ball meets it after 0.62 m, or sooner where it is slow: in the
/// midst of a step at the usual speeds and steps.
fn build_wall(speed: f64, thickness: f64) -> SceneSpec {
    let way = 0.62 * speed.min(1.0);
    let mut scene = SceneSpec::new("wall", DVec3::ZERO);
    let wall = ShapeSpec::Cuboid { size: DVec3::new(thickness, 2.0, 2.0) };
    scene.bodies.push(
        BodySpec::new("wall", wall, 0.5 * thickness * DVec3::X)
            .fixed()
            .with_material(0.0, 0.0)
            .with_color(palette::SLATE),
    );
    let start = -(RADIUS + way) * DVec3::X;
    scene.bodies.push(ball(0, start, 1.0, 0.0).with_velocity(speed * DVec3::X, DVec3::ZERO));
    scene.view = Some(ViewSpec::framing(-0.3 * DVec3::X, 1.5, DVec3::new(-0.5, 0.35, 1.0)));
    scene
}
