//! A heap of unlike things: `pile`.

use bevy::math::DVec3;
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

use super::gravity::EARTH;
use super::palette;
use super::random::{any_hull, any_rotation, seeded};
use crate::scene::info::Parameter;
use crate::scene::{BodySpec, SceneInfo, SceneSpec, ShapeSpec, Subject, ViewSpec};

/// Of the grid that things are dropped from, m: they do not touch, however they are turned.
const PITCH: f64 = 1.1;
/// No thing reaches farther than this from its place in the grid, m.
const REACH: f64 = 0.48;
/// Farthest from that place, along each axis, m.
const JITTER: f64 = 0.05;
/// Of the lowest layer above the ground, m.
const DROP: f64 = 1.0;

/// Side of the tray, and height of its walls, in sides of the grid: full, it would hold all things
/// but for what they heap up in the middle.
const TRAY: f64 = 1.4;
const WALL_HEIGHT: f64 = 0.16;
/// m.
const WALL_THICKNESS: f64 = 0.25;

pub(super) const PILE: SceneInfo = SceneInfo {
    name: "pile",
    title: "Pile in a tray",
    subject: Subject::Large,
    about: "n hulls, cones, boxes and balls of 0.4 to 0.9 m, all different, dropped into a tray",
    truth: "comes to rest in the tray",
    parameters: &[Parameter::whole("n", "things dropped", 100.0, 1.0, 5000.0)],
    seconds: 10.0,
    bodies: |values| values[0] + 5.0,
    build: |values| build_pile(values[0] as usize),
};

/// A grid about as high as wide.
fn build_pile(n: usize) -> SceneSpec {
    let side = (n as f64).cbrt().ceil() as usize;
    let mut scene = SceneSpec::new("pile", EARTH);
    scene.bodies.push(BodySpec::ground().with_color(palette::GROUND));
    let width = PITCH * side as f64;
    let half_tray = 0.5 * TRAY * width;
    add_walls(&mut scene, half_tray, WALL_HEIGHT * width);
    let mut random = seeded();
    for i in 0..n {
        let [layer, row, column] = [i / (side * side), i / side % side, i % side].map(|k| PITCH * k as f64);
        let first = -0.5 * PITCH * (side - 1) as f64;
        let jitter = DVec3::from_array(std::array::from_fn(|_| random.random_range(-JITTER..JITTER)));
        let place = DVec3::new(first + column, DROP + layer, first + row) + jitter;
        scene.bodies.push(thing(i, place, &mut random));
    }
    let target = DVec3::new(0.0, 0.3 * half_tray, 0.0);
    scene.view = Some(ViewSpec::framing(target, 1.5 * half_tray + 0.5, DVec3::new(0.45, 0.65, 1.0)));
    scene
}

/// Four walls around the origin, `half` from it inside.
fn add_walls(scene: &mut SceneSpec, half: f64, height: f64) {
    let out = half + 0.5 * WALL_THICKNESS;
    let (long, short) = (2.0 * (half + WALL_THICKNESS), 2.0 * half);
    for (name, x, z, size_x, size_z) in [
        ("left wall", -out, 0.0, WALL_THICKNESS, short),
        ("right wall", out, 0.0, WALL_THICKNESS, short),
        ("back wall", 0.0, -out, long, WALL_THICKNESS),
        ("front wall", 0.0, out, long, WALL_THICKNESS),
    ] {
        let size = DVec3::new(size_x, height, size_z);
        let position = DVec3::new(x, 0.5 * height, z);
        let wall = BodySpec::new(name, ShapeSpec::Cuboid { size }, position);
        scene.bodies.push(wall.fixed().with_color(palette::SLATE));
    }
}

/// Number `i`, within [`REACH`] of a place.
fn thing(i: usize, place: DVec3, random: &mut Pcg64Mcg) -> BodySpec {
    let (noun, shape) = match i % 4 {
        0 => ("rock", rock(random)),
        1 => {
            let (radius, height) = (random.random_range(0.2..0.36), random.random_range(0.4..0.64));
            ("cone", ShapeSpec::Cone { radius, height })
        }
        2 => {
            let size = DVec3::from_array(std::array::from_fn(|_| random.random_range(0.3..0.55)));
            ("box", ShapeSpec::Cuboid { size })
        }
        _ => ("ball", ShapeSpec::Sphere { radius: random.random_range(0.22..0.4) }),
    };
    let rotation = any_rotation(random);
    // A hull's points surround its place; its centre of mass is somewhere near.
    let center = shape.convex_hull().map_or(DVec3::ZERO, |hull| hull.center());
    let body = BodySpec::new(format!("{noun} {i}"), shape, place + rotation * center);
    // By one more each round of the four, so that each kind comes in every colour.
    let body = body.with_rotation(rotation).with_color(palette::bright(i + i / 4));
    // A ball rolls for ever.
    BodySpec { damping: (0.05, 0.5), ..body }
}

/// The hull of random points on a ball.
fn rock(random: &mut Pcg64Mcg) -> ShapeSpec {
    let radius = random.random_range(0.34..REACH);
    let corners = random.random_range(8..=16);
    any_hull(random, radius, corners)
}
