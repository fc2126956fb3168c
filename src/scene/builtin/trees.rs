//! Trees that fall to both sides of a row: `trees`, after Box3D's benchmark of that name.

use std::f64::consts::TAU;

use bevy::math::DVec3;

use super::gravity::TEN;
use super::palette;
use super::solids::{body_at, compound, part, prism};
use crate::scene::info::Parameter;
use crate::scene::{BodySpec, SceneInfo, SceneSpec, ShapeSpec, Subject, SurfaceSpec, ViewSpec};

/// Of the ground across the row, and beyond its trees at both ends together, m.
const WIDTH: f64 = 150.0;
const BEYOND: f64 = 50.0;
/// From the ground's edge to the first tree, m.
const BEFORE: f64 = 30.0;
/// Between trees, m.
const PITCH: f64 = 3.0;
/// Height of its waves, m, and how many there are a metre across the row and along it.
const AMPLITUDE: f64 = 0.4;
const WAVES: [f64; 2] = [0.1, 0.05];
/// Parts of a trunk, length of each without its ends, the radius of the lowest, m, and of each over the one below.
const PARTS: usize = 22;
const LENGTH: f64 = 1.5;
const RADIUS: f64 = 0.75;
const TAPER: f64 = 0.95;
/// Of a trunk's cross-section.
const SIDES: usize = 6;
/// Its foot starts so high, m.
const FOOT: f64 = 1.0;
/// The last tree turns so fast at the start, the first nearly half as fast, rad/s.
const TURN: f64 = 0.5;
const FRICTION: f64 = 0.9;
/// kg/m³.
const DENSITY: f64 = 1.0;

pub(super) const TREES: SceneInfo = SceneInfo {
    name: "trees",
    title: "Falling trees",
    subject: Subject::Large,
    about: "n trees 53 m high of 22 hulls each that fall to both sides on waves made of triangles (Box3D's 'trees100', \
            'trees50', 'trees25': n 50, cell 1, 0.5, 0.25)",
    truth: "comes to rest on the ground",
    parameters: &[
        Parameter::whole("n", "trees", 10.0, 1.0, 50.0),
        Parameter::real("cell", "side of the ground's squares, of two triangles each, m", 1.0, 0.25, 5.0),
    ],
    seconds: 10.0,
    bodies: |values| values[0] + 1.0,
    build: |values| build(values[0] as usize, values[1]),
};

fn build(n: usize, cell: f64) -> SceneSpec {
    let mut scene = SceneSpec::new("trees", TEN);
    let length = PITCH * n as f64 + BEYOND;
    scene.bodies.push(ground([WIDTH, length], cell));
    let (tree, foot) = (tree(), FOOT * DVec3::Y);
    for i in 0..n {
        let side = if i % 2 == 0 { -1.0 } else { 1.0 };
        let turn = side * TURN * (0.5 + 0.5 * i as f64 / n as f64) * DVec3::Z;
        let origin = foot + (BEFORE - 0.5 * length + PITCH * i as f64) * DVec3::Z;
        let tree = body_at(format!("tree {i}"), tree.clone(), origin).with_material(FRICTION, 0.0);
        // About its foot.
        let velocity = turn.cross(tree.position - origin);
        let tree = tree.with_velocity(velocity, turn).with_color(palette::bright(i));
        scene.bodies.push(BodySpec { density: DENSITY, ..tree });
    }
    let radius = 0.4 * WIDTH.max(length);
    scene.view = Some(ViewSpec::framing(10.0 * DVec3::Y, radius, DVec3::new(0.5, 0.45, 1.0)));
    scene
}

fn ground(size: [f64; 2], cell: f64) -> BodySpec {
    let squares = size.map(|side| (side / cell).round().max(1.0) as usize);
    let wave = |axis: usize, place: usize| (TAU * WAVES[axis] * size[axis] * place as f64 / squares[axis] as f64).sin();
    let rows = (0..=squares[1]).map(|k| (0..=squares[0]).map(|i| AMPLITUDE * wave(0, i) * wave(1, k)).collect());
    let surface = SurfaceSpec::heights(size, rows.collect()).expect("heights of a grid");
    BodySpec::new("ground", ShapeSpec::Surface(surface), DVec3::ZERO).fixed().with_color(palette::GROUND)
}

/// Prisms one in the other's end, each thinner than the one below, from a foot at the origin up.
fn tree() -> ShapeSpec {
    let (mut height, mut radius) = (1.0, RADIUS);
    let parts = (0..PARTS).map(|_| {
        let length = LENGTH + 2.0 * radius;
        let part = part(prism(radius, height - radius, length, SIDES));
        height += length;
        radius *= TAPER;
        part
    });
    compound(parts.collect())
}
