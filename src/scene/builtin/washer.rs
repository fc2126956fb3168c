//! Cubes in a drum that turns: `washer`, after Box3D's benchmark of that name.

use std::f64::consts::PI;

use bevy::math::DVec3;

use super::gravity::TEN;
use super::palette;
use super::solids::{body_at, compound, part};
use crate::physics::RigidBody;
use crate::scene::info::Parameter;
use crate::scene::{BodySpec, ChildSpec, SceneInfo, SceneSpec, ShapeSpec, Subject, ViewSpec};

/// Cubes along each side of the block for which the drum has Box3D's size; for others it is scaled.
const FULL: f64 = 20.0;
/// The drum at that size, m: inner edge of its blades, its inside, its outside; half its length; its axis above the ground.
const BLADES: f64 = 14.0;
const INSIDE: f64 = 16.0;
const OUTSIDE: f64 = 18.0;
const HALF_LENGTH: f64 = 10.0;
const AXIS: f64 = 21.0;
/// Staves of its wall; every ninth carries a blade.
const STAVES: usize = 36;
const BLADE_EVERY: usize = 9;
/// Of a rim at each end, at that size: its inner edge and thickness, m; and pieces of it.
const RIM: f64 = 11.0;
const RIM_THICKNESS: f64 = 0.5;
const RIM_PIECES: usize = 12;
/// Share of a stave by which it overlaps its neighbours.
const OVERLAP: f64 = 0.1;
/// It turns by so many degrees a second, and drifts a little, so that nothing stays exactly the same, m/s.
const TURN: f64 = 25.0;
const DRIFT: DVec3 = DVec3::new(0.001, -0.002, 0.0);
/// Side of a cube, and of the grid that they start in, m.
const CUBE: f64 = 0.4;
const PITCH: f64 = 0.8;

pub(super) const WASHER: SceneInfo = SceneInfo {
    name: "washer",
    title: "Drum full of cubes",
    subject: Subject::Large,
    about: "n x n x n cubes of 0.4 m in a drum of hulls that turns by 25 degrees a second (Box3D's 'washer': n 20, rim 0)",
    truth: "the cubes stay in the drum",
    parameters: &[
        Parameter::whole("n", "cubes along each side of their block; the drum grows with it", 8.0, 2.0, 40.0),
        Parameter::whole("rim", "1: a rim at both ends keeps the cubes in; 0: there is none", 1.0, 0.0, 1.0),
    ],
    seconds: 10.0,
    bodies: |values| values[0].powi(3) + 2.0,
    build: |values| build(values[0] as usize, values[1] != 0.0),
};

fn build(n: usize, rim: bool) -> SceneSpec {
    let mut scene = SceneSpec::new("washer", TEN);
    scene.bodies.push(BodySpec::ground().with_color(palette::GROUND));
    let scale = n as f64 / FULL;
    let middle = AXIS * scale * DVec3::Y;
    let drum = body_at("drum", drum(scale, rim), middle).with_velocity(DRIFT, TURN.to_radians() * DVec3::Z);
    scene.bodies.push(BodySpec { kind: RigidBody::Kinematic, ..drum }.with_color(palette::STEEL));
    let first = middle - 0.5 * PITCH * n as f64 * DVec3::ONE;
    for i in 0..n * n * n {
        let [x, y, z] = [i / (n * n), i / n % n, i % n].map(|k| PITCH * k as f64);
        let cube = ShapeSpec::Cuboid { size: DVec3::splat(CUBE) };
        let cube = BodySpec::new(format!("cube {i}"), cube, first + DVec3::new(x, y, z));
        scene.bodies.push(cube.with_color(palette::bright(i + i / n)));
    }
    scene.view = Some(ViewSpec::framing(middle, 1.05 * OUTSIDE * scale, DVec3::new(0.3, 0.2, 1.0)));
    scene
}

/// About its axis, z.
fn drum(scale: f64, rim: bool) -> ShapeSpec {
    let stave = 2.0 * PI / STAVES as f64;
    let slab = |from: f64, to: f64, radii: [f64; 2], [back, front]: [f64; 2]| -> ChildSpec {
        let corner = |i: usize| {
            let radius = scale * radii[i & 1];
            let (sin, cos) = if i & 2 == 0 { from.sin_cos() } else { to.sin_cos() };
            let z = if i & 4 == 0 { back } else { front };
            DVec3::new(radius * cos, radius * sin, scale * z)
        };
        part((0..8).map(corner).collect())
    };
    let length = [-HALF_LENGTH, HALF_LENGTH];
    let mut parts = Vec::new();
    for i in 0..STAVES {
        let from = stave * i as f64;
        let to = from + stave;
        parts.push(slab(from - OVERLAP * stave, to + OVERLAP * stave, [INSIDE, OUTSIDE], length));
        if i.is_multiple_of(BLADE_EVERY) {
            parts.push(slab(from, to, [BLADES, INSIDE], length));
        }
    }
    let piece = 2.0 * PI / RIM_PIECES as f64;
    for i in (0..RIM_PIECES).filter(|_| rim) {
        let (from, to) = (piece * i as f64, piece * (i + 1) as f64);
        for end in [-1.0, 1.0] {
            let thick = [end * HALF_LENGTH, end * (HALF_LENGTH + RIM_THICKNESS)];
            parts.push(slab(from, to, [RIM, OUTSIDE], thick));
        }
    }
    compound(parts)
}
