//! Boxes on boxes: `stack`, `pyramid`, `pyramids`, `sandwich`. Gaps are 0.

use bevy::math::DVec3;
use rand::RngExt;

use super::gravity::TEN;
use super::palette;
use super::random::seeded;
use crate::scene::info::Parameter;
use crate::scene::{BodySpec, SceneInfo, SceneSpec, ShapeSpec, Subject, ViewSpec};

pub(super) const CUBE: ShapeSpec = ShapeSpec::Cuboid { size: DVec3::ONE };

/// Rows of each wall of `pyramids`.
const WALL_BASE: usize = 10;

const JITTER: Parameter = Parameter::real("jitter", "largest sideways offset of a cube, seeded, m", 0.0, 0.0, 0.4);

pub(super) const STACK: SceneInfo = SceneInfo {
    name: "stack",
    title: "Stack of cubes",
    subject: Subject::Contacts,
    about: "a column of n unit cubes",
    truth: "stays put; vertical contact forces sum to the weight above each interface",
    parameters: &[Parameter::whole("n", "cubes", 10.0, 1.0, 1000.0), JITTER],
    seconds: 10.0,
    bodies: |values| values[0] + 1.0,
    build: |values| {
        let n = values[0] as usize;
        let mut scene = SceneSpec::new("stack", TEN);
        scene.bodies.push(BodySpec::ground().with_color(palette::GROUND));
        add_column(&mut scene, n, 0.0);
        jitter(&mut scene, DVec3::new(values[1], 0.0, values[1]));
        let height = n as f64;
        scene.view = Some(ViewSpec::framing(0.5 * height * DVec3::Y, 0.6 * height + 1.0, DVec3::new(0.5, 0.25, 1.0)));
        scene
    },
};

pub(super) const PYRAMID: SceneInfo = SceneInfo {
    name: "pyramid",
    title: "Pyramid of cubes",
    subject: Subject::Contacts,
    about: "a wall of unit cubes in rows of n, n - 1, ... 1",
    truth: "stays put; vertical contact forces sum to the weight above each interface",
    parameters: &[Parameter::whole("n", "cubes in the lowest row", 10.0, 1.0, 1000.0), JITTER],
    seconds: 10.0,
    bodies: |values| values[0] * (values[0] + 1.0) / 2.0 + 1.0,
    build: |values| {
        let mut scene = SceneSpec::new("pyramid", TEN);
        scene.bodies.push(BodySpec::ground().with_color(palette::GROUND));
        add_wall(&mut scene, values[0] as usize, DVec3::ZERO);
        jitter(&mut scene, DVec3::new(0.0, 0.0, values[1]));
        let n = values[0];
        scene.view = Some(ViewSpec::framing(0.42 * n * DVec3::Y, 0.62 * n + 1.0, DVec3::new(0.45, 0.3, 1.0)));
        scene
    },
};

pub(super) const PYRAMIDS: SceneInfo = SceneInfo {
    name: "pyramids",
    title: "Field of pyramids",
    subject: Subject::Large,
    about: "n x n walls of unit cubes in rows of 10, 9, ... 1; 11 m apart along x, 3 m along z",
    truth: "stays put; vertical contact forces sum to the weight above each interface",
    parameters: &[Parameter::whole("n", "walls along each side", 3.0, 1.0, 100.0), JITTER],
    seconds: 10.0,
    bodies: |values| values[0] * values[0] * (WALL_BASE * (WALL_BASE + 1) / 2) as f64 + 1.0,
    build: |values| {
        let n = values[0] as usize;
        let first = -((n - 1) as f64) / 2.0;
        let mut scene = SceneSpec::new("pyramids", TEN);
        scene.bodies.push(BodySpec::ground().with_color(palette::GROUND));
        for i in 0..n {
            for j in 0..n {
                let center = DVec3::new(11.0 * (first + i as f64), 0.0, 3.0 * (first + j as f64));
                add_wall(&mut scene, WALL_BASE, center);
            }
        }
        jitter(&mut scene, DVec3::new(0.0, 0.0, values[1]));
        let radius = 5.5 * values[0] + 3.0;
        scene.view = Some(ViewSpec::framing(3.0 * DVec3::Y, radius, DVec3::new(0.6, 0.7, 1.0)));
        scene
    },
};

pub(super) const SANDWICH: SceneInfo = SceneInfo {
    name: "sandwich",
    title: "Slab on two cubes",
    subject: Subject::Contacts,
    about: "two unit cubes of 1 kg carry a slab 4 x 2 x 2 m of r kg",
    truth: "stays put",
    parameters: &[Parameter::real("r", "mass of the slab, kg", 100.0, 0.001, 1e9)],
    seconds: 10.0,
    bodies: |_| 4.0,
    build: |values| {
        let mut scene = SceneSpec::new("sandwich", TEN);
        let slab = ShapeSpec::Cuboid { size: DVec3::new(4.0, 2.0, 2.0) };
        scene.bodies.extend([
            BodySpec::ground().with_color(palette::GROUND),
            BodySpec::new("left", CUBE, DVec3::new(-1.0, 0.5, 0.0)).with_mass(1.0).with_color(palette::YELLOW),
            BodySpec::new("right", CUBE, DVec3::new(1.0, 0.5, 0.0)).with_mass(1.0).with_color(palette::YELLOW),
            BodySpec::new("slab", slab, DVec3::new(0.0, 2.0, 0.0)).with_mass(values[0]).with_color(palette::SLATE),
        ]);
        scene.view = Some(ViewSpec::framing(1.4 * DVec3::Y, 3.0, DVec3::new(0.4, 0.3, 1.0)));
        scene
    },
};

/// `n` cubes one on the other above (x, 0, 0), the lowest first.
pub(super) fn add_column(scene: &mut SceneSpec, n: usize, x: f64) {
    for i in 0..n {
        let position = DVec3::new(x, i as f64 + 0.5, 0.0);
        scene.bodies.push(BodySpec::new(format!("cube {i}"), CUBE, position).with_color(palette::bright(i)));
    }
}

/// Rows of `base`, `base` − 1, … cubes along x, centred above `center`, the lowest row first.
pub(super) fn add_wall(scene: &mut SceneSpec, base: usize, center: DVec3) {
    for row in 0..base {
        let cubes = base - row;
        for i in 0..cubes {
            let x = i as f64 - (cubes - 1) as f64 / 2.0;
            let name = format!("cube {}", scene.bodies.len() - 1);
            let position = center + DVec3::new(x, row as f64 + 0.5, 0.0);
            scene.bodies.push(BodySpec::new(name, CUBE, position).with_color(palette::bright(row)));
        }
    }
}

/// Moves each cube by a seeded random offset within ±`most`. Walls move across their plane only,
/// where cubes of a row have no neighbour to run into.
fn jitter(scene: &mut SceneSpec, most: DVec3) {
    if most == DVec3::ZERO {
        return;
    }
    let mut random = seeded();
    for cube in scene.bodies.iter_mut().skip(1) {
        cube.position += most * DVec3::from_array(std::array::from_fn(|_| random.random_range(-1.0..=1.0)));
    }
}
