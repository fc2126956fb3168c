//! Heavy things that come down on light ones: `slab`, `column`, `boulder`, `wrecking_ball`. Cubes are unit cubes; all
//! but every other one of `column` weigh 1 kg.

use bevy::math::DVec3;

use super::gravity::TEN;
use super::palette;
use super::stacking::{CUBE, add_wall};
use crate::scene::info::Parameter;
use crate::scene::{BodySpec, SceneInfo, SceneSpec, ShapeSpec, Subject, ViewSpec};

/// Of a ball, m.
const RADIUS: f64 = 1.0;

/// From the face of the wall to the ball that is thrown at it, m.
const AHEAD: f64 = 0.5;

const BASE: Parameter = Parameter::whole("n", "cubes in the lowest row", 10.0, 1.0, 100.0);

pub(super) const SLAB: SceneInfo = SceneInfo {
    name: "slab",
    title: "Slab on a row of cubes",
    subject: Subject::Contacts,
    about: "a slab of r kg, 2 m high and deep, falls on a row of n cubes, 2 m apart",
    truth: "closed form: it falls freely until it lies on the cubes, and stays there; they stay put",
    parameters: &[
        Parameter::whole("n", "cubes", 2.0, 1.0, 1000.0),
        Parameter::real("r", "mass of the slab, kg", 1000.0, 0.001, 1e9),
        Parameter::real("drop", "height of its fall, m", 0.05, 0.0, 100.0),
    ],
    seconds: 3.0,
    bodies: |values| values[0] + 2.0,
    build: |values| build_slab(values[0] as usize, values[1], values[2]),
};

pub(super) const COLUMN: SceneInfo = SceneInfo {
    name: "column",
    title: "Heavy on light",
    subject: Subject::Contacts,
    about: "n cubes of 1 and r kg in turns, above each other, with gaps",
    truth: "closed form: each falls freely until it lies on the one below, and stays there",
    parameters: &[
        Parameter::whole("n", "cubes", 15.0, 1.0, 1000.0),
        Parameter::real("r", "mass of every other cube, kg", 100.0, 0.001, 1e9),
        Parameter::real("gap", "between each cube and what is below, m", 0.01, 0.0, 10.0),
    ],
    seconds: 3.0,
    bodies: |values| values[0] + 1.0,
    build: |values| build_column(values[0] as usize, values[1], values[2]),
};

pub(super) const BOULDER: SceneInfo = SceneInfo {
    name: "boulder",
    title: "Boulder on a wall",
    subject: Subject::Contacts,
    about: "a ball of r kg and 1 m radius falls on the top of a wall of cubes in rows of n, n - 1, ... 1",
    truth: "closed form: it falls freely until it lies on the top, and stays there; the cubes stay put",
    parameters: &[
        BASE,
        Parameter::real("r", "mass of the ball, kg", 1e4, 0.001, 1e9),
        Parameter::real("drop", "height of its fall, m", 1.0, 0.0, 100.0),
    ],
    seconds: 3.0,
    bodies: |values| wall_bodies(values[0]),
    build: |values| build_boulder(values[0] as usize, values[1], values[2]),
};

pub(super) const WRECKING_BALL: SceneInfo = SceneInfo {
    name: "wrecking_ball",
    title: "Wrecking ball",
    subject: Subject::Contacts,
    about: "a ball of r kg and 1 m radius thrown level at the face of a wall of cubes in rows of n, n - 1, ... 1",
    truth: "behind the wall the ball is no slower than if it had taken all cubes along: v r/(r + sum m)",
    parameters: &[
        BASE,
        Parameter::real("r", "mass of the ball, kg", 1e4, 0.001, 1e9),
        Parameter::real("v", "speed of the ball, m/s", 10.0, 1.0, 1e3),
    ],
    seconds: 2.0,
    bodies: |values| wall_bodies(values[0]),
    build: |values| build_wrecking_ball(values[0] as usize, values[1], values[2]),
};

fn build_slab(n: usize, mass: f64, drop: f64) -> SceneSpec {
    let mut scene = SceneSpec::new("slab", TEN);
    scene.bodies.push(BodySpec::ground().with_color(palette::GROUND));
    for i in 0..n {
        let x = 2.0 * i as f64 - (n - 1) as f64;
        scene.bodies.push(cube(format!("cube {i}"), DVec3::new(x, 0.5, 0.0), 1.0).with_color(palette::YELLOW));
    }
    let length = 2.0 * n as f64;
    let shape = ShapeSpec::Cuboid { size: DVec3::new(length, 2.0, 2.0) };
    let slab = BodySpec::new("slab", shape, (2.0 + drop) * DVec3::Y);
    scene.bodies.push(slab.with_mass(mass).with_color(palette::SLATE));
    let radius = 0.6 * length + 0.5 * drop + 1.5;
    scene.view = Some(ViewSpec::framing((1.4 + 0.5 * drop) * DVec3::Y, radius, DVec3::new(0.4, 0.3, 1.0)));
    scene
}

fn build_column(n: usize, heavy: f64, gap: f64) -> SceneSpec {
    let mut scene = SceneSpec::new("column", TEN);
    scene.bodies.push(BodySpec::ground().with_color(palette::GROUND));
    for i in 0..n {
        let place = (i as f64 + 0.5 + (i + 1) as f64 * gap) * DVec3::Y;
        let (mass, color) = if i % 2 == 0 { (1.0, palette::YELLOW) } else { (heavy, palette::SLATE) };
        scene.bodies.push(cube(format!("cube {i}"), place, mass).with_color(color));
    }
    let height = n as f64 * (1.0 + gap);
    scene.view = Some(ViewSpec::framing(0.5 * height * DVec3::Y, 0.6 * height + 1.0, DVec3::new(0.5, 0.25, 1.0)));
    scene
}

fn build_boulder(n: usize, mass: f64, drop: f64) -> SceneSpec {
    let mut scene = light_wall("boulder", n);
    let top = n as f64 + RADIUS + drop;
    scene.bodies.push(ball(top * DVec3::Y, mass));
    scene.view = Some(ViewSpec::framing(0.5 * top * DVec3::Y, 0.6 * top + 1.0, DVec3::new(0.45, 0.3, 1.0)));
    scene
}

fn build_wrecking_ball(n: usize, mass: f64, speed: f64) -> SceneSpec {
    let mut scene = light_wall("wrecking_ball", n);
    let place = DVec3::new(0.0, RADIUS.max(0.5 * n as f64), -(0.5 + AHEAD + RADIUS));
    scene.bodies.push(ball(place, mass).with_velocity(speed * DVec3::Z, DVec3::ZERO));
    let size = n as f64;
    scene.view = Some(ViewSpec::framing(0.42 * size * DVec3::Y, 0.7 * size + 2.0, DVec3::new(1.0, 0.3, -0.6)));
    scene
}

fn wall_bodies(n: f64) -> f64 {
    n * (n + 1.0) / 2.0 + 2.0
}

/// Ground and a wall of cubes of 1 kg.
fn light_wall(name: &'static str, n: usize) -> SceneSpec {
    let mut scene = SceneSpec::new(name, TEN);
    scene.bodies.push(BodySpec::ground().with_color(palette::GROUND));
    add_wall(&mut scene, n, DVec3::ZERO);
    scene.bodies.iter_mut().skip(1).for_each(|cube| cube.mass = Some(1.0));
    scene
}

fn cube(name: String, place: DVec3, mass: f64) -> BodySpec {
    BodySpec::new(name, CUBE, place).with_mass(mass)
}

fn ball(place: DVec3, mass: f64) -> BodySpec {
    BodySpec::new("ball", ShapeSpec::Sphere { radius: RADIUS }, place).with_mass(mass).with_color(palette::SLATE)
}
