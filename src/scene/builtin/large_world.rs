//! A few balls on a floor of very many slabs: `large_world`, after Box3D's benchmark of that name.

use bevy::math::DVec3;

use super::gravity::TEN;
use super::palette;
use crate::scene::info::Parameter;
use crate::scene::{BodySpec, SceneInfo, SceneSpec, ShapeSpec, Subject, ViewSpec};

/// Side and thickness of a slab, m.
const SLAB: f64 = 10.0;
const THICKNESS: f64 = 0.5;
/// Balls along each side of their grid, which is spread over that share of the floor.
const ROW: usize = 10;
const SHARE: f64 = 0.8;
/// Of a ball, and height of its middle at the start, m.
const RADIUS: f64 = 0.5;
const DROP: f64 = 1.5;

pub(super) const LARGE_WORLD: SceneInfo = SceneInfo {
    name: "large_world",
    title: "Floor of many slabs",
    subject: Subject::Large,
    about: "100 balls dropped on a floor of n x n static slabs of 10 m (Box3D's 'large_world' has n 1000)",
    truth: "comes to rest on the floor",
    parameters: &[Parameter::whole("n", "slabs along each side", 12.0, 2.0, 316.0)],
    seconds: 4.0,
    bodies: |values| values[0] * values[0] + (ROW * ROW) as f64,
    build: |values| build(values[0] as usize),
};

fn build(n: usize) -> SceneSpec {
    let mut scene = SceneSpec::new("large_world", TEN);
    let slab = ShapeSpec::Cuboid { size: DVec3::new(SLAB, THICKNESS, SLAB) };
    for i in 0..n * n {
        let color = if (i / n + i % n).is_multiple_of(2) { palette::GROUND } else { palette::STEEL };
        let slab = BodySpec::new(format!("slab {i}"), slab.clone(), place(SLAB, n, i, 0.0));
        scene.bodies.push(slab.fixed().with_color(color));
    }
    let pitch = SHARE * SLAB * n as f64 / ROW as f64;
    for i in 0..ROW * ROW {
        let ball = ShapeSpec::Sphere { radius: RADIUS };
        let ball = BodySpec::new(format!("ball {i}"), ball, place(pitch, ROW, i, DROP));
        scene.bodies.push(ball.with_color(palette::bright(i)));
    }
    // Of a floor of any size, as much as shows that there are balls.
    let radius = (0.5 * SLAB * n as f64).min(60.0);
    scene.view = Some(ViewSpec::framing(DVec3::ZERO, radius, DVec3::new(0.45, 0.5, 1.0)));
    scene
}

/// Number `i` of a square grid about the origin with so many along each side.
fn place(pitch: f64, side: usize, i: usize, height: f64) -> DVec3 {
    let [x, z] = [i / side, i % side].map(|k| pitch * (k as f64 - 0.5 * (side - 1) as f64));
    DVec3::new(x, height, z)
}
