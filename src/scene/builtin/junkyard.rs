//! Rocks that fall into a yard and are pushed round in it: `junkyard`, after Box3D's benchmark of that name.

use std::f64::consts::TAU;

use bevy::math::{DVec3, FloatExt};

use super::gravity::TEN;
use super::palette;
use super::solids::{body_at, compound, part, prism};
use crate::physics::RigidBody;
use crate::scene::info::Parameter;
use crate::scene::{BodySpec, SceneInfo, SceneSpec, ShapeSpec, Subject, ViewSpec};

/// Rocks along a side of a layer for which the yard has Box3D's size; for others it is scaled.
const FULL: f64 = 21.0;
/// Of the yard at that size, m: half its side, height and half thickness of its walls.
const HALF_SIDE: f64 = 50.0;
const WALL: f64 = 16.0;
const HALF_WALL: f64 = 1.0;
/// Of a pusher, m, its distance from the yard's middle, m, and how it goes round, degrees a second.
const PUSHER_RADIUS: f64 = 4.0;
const PUSHER_HEIGHT: f64 = 24.0;
const PUSHER_SIDES: usize = 16;
const OUT: f64 = 35.0;
const TURN: f64 = 6.0;
/// Radius of a rock, of the grid that rocks are dropped from, and of its lowest layer above the pushers, m.
const ROCK: f64 = 1.5;
const PITCH: f64 = 4.0;
const DROP: f64 = 2.0;
/// Corners of a rock.
const CORNERS: usize = 10;

pub(super) const JUNKYARD: SceneInfo = SceneInfo {
    name: "junkyard",
    title: "Rocks pushed round",
    subject: Subject::Large,
    about: "layers of n x n rocks dropped into a yard where two pushers go round (Box3D's 'junkyard': n 21, layers 24, \
            and one pusher)",
    truth: "the rocks stay in the yard",
    parameters: &[
        Parameter::whole("n", "rocks along each side of a layer; the yard grows with it", 9.0, 3.0, 40.0),
        Parameter::whole("layers", "layers of rocks", 2.0, 1.0, 60.0),
    ],
    seconds: 8.0,
    bodies: |values| values[0] * values[0] * values[1] + 6.0,
    build: |values| build(values[0] as usize, values[1] as usize),
};

fn build(n: usize, layers: usize) -> SceneSpec {
    let mut scene = SceneSpec::new("junkyard", TEN);
    scene.bodies.push(BodySpec::ground().with_color(palette::GROUND));
    let scale = n as f64 / FULL;
    add_walls(&mut scene, scale);
    // Two, opposite to each other: a kinematic body turns about its centre, which is in the middle then.
    let pusher = |side: f64| {
        let out = side * OUT * scale * DVec3::X;
        let prism = prism(PUSHER_RADIUS * scale, 0.0, PUSHER_HEIGHT * scale, PUSHER_SIDES);
        part(prism.into_iter().map(|corner| corner + out).collect())
    };
    let pushers = body_at("pushers", compound(vec![pusher(1.0), pusher(-1.0)]), DVec3::ZERO);
    let pushers = pushers.with_velocity(DVec3::ZERO, TURN.to_radians() * DVec3::Y).with_color(palette::ORANGE);
    scene.bodies.push(BodySpec { kind: RigidBody::Kinematic, ..pushers });
    let rock = ShapeSpec::hull(rock());
    let first = -0.5 * PITCH * (n - 1) as f64;
    for i in 0..n * n * layers {
        let [y, x, z] = [i / (n * n), i / n % n, i % n].map(|k| PITCH * k as f64);
        let place = DVec3::new(first + x, PUSHER_HEIGHT * scale + DROP + y, first + z);
        scene.bodies.push(body_at(format!("rock {i}"), rock.clone(), place).with_color(palette::bright(i + i / n)));
    }
    scene.view = Some(ViewSpec::framing(DVec3::ZERO, 1.2 * HALF_SIDE * scale, DVec3::new(0.45, 0.9, 1.0)));
    scene
}

fn add_walls(scene: &mut SceneSpec, scale: f64) {
    for (name, out) in [("left", -DVec3::X), ("right", DVec3::X), ("back", -DVec3::Z), ("front", DVec3::Z)] {
        let across = out.abs();
        let along = DVec3::new(across.z, 0.0, across.x);
        // Two are between the other two.
        let length = HALF_SIDE + if out.x == 0.0 { HALF_WALL } else { -HALF_WALL };
        let half = HALF_WALL * across + length * along + 0.5 * WALL * DVec3::Y;
        let size = ShapeSpec::Cuboid { size: 2.0 * scale * half };
        let place = scale * (HALF_SIDE * out + 0.5 * WALL * DVec3::Y);
        scene.bodies.push(BodySpec::new(format!("{name} wall"), size, place).fixed().with_color(palette::SLATE));
    }
}

/// Points of a spiral round a ball, spread evenly over it (a Fibonacci lattice).
fn rock() -> Vec<DVec3> {
    let golden = (1.0 + 5.0_f64.sqrt()) / 2.0;
    let corner = |i: usize| {
        let height = (-1.0).lerp(1.0, (i as f64 + 0.5) / CORNERS as f64);
        let (sin, cos) = (TAU * i as f64 / golden).sin_cos();
        let across = (1.0_f64 - height * height).sqrt();
        ROCK * DVec3::new(across * cos, across * sin, -height)
    };
    (0..CORNERS).map(corner).collect()
}
