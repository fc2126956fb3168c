//! A tall block of large stones that falls to a pile: `convex_pile`, after Box3D's benchmark of that name.

use bevy::math::DVec3;

use super::gravity::TEN;
use super::palette;
use super::random::{any_hull, seeded};
use super::solids::body_at;
use crate::scene::info::Parameter;
use crate::scene::{BodySpec, SceneInfo, SceneSpec, Subject, ViewSpec};

/// Radius of the ball that a stone's corners lie on, m.
const RADIUS: f64 = 2.0;
const CORNERS: usize = 32;
/// Stones along each side of a layer.
const ROW: usize = 8;

pub(super) const CONVEX_PILE: SceneInfo = SceneInfo {
    name: "convex_pile",
    title: "Pile of stones",
    subject: Subject::Large,
    about: "layers of 8 x 8 stones of 4 m, hulls of 32 points, in a block that falls (Box3D's 'convex_pile': layers 80)",
    truth: "comes to rest without an overlap",
    parameters: &[Parameter::whole("layers", "layers of stones", 4.0, 1.0, 1000.0)],
    seconds: 8.0,
    bodies: |values| (ROW * ROW) as f64 * values[0] + 1.0,
    build: |values| build(values[0] as usize),
};

fn build(layers: usize) -> SceneSpec {
    let mut scene = SceneSpec::new("convex_pile", TEN);
    scene.bodies.push(BodySpec::ground().with_color(palette::GROUND));
    let stone = any_hull(&mut seeded(), RADIUS, CORNERS);
    let first = -RADIUS * (ROW - 1) as f64;
    for i in 0..ROW * ROW * layers {
        let [y, z, x] = [i / (ROW * ROW), i / ROW % ROW, i % ROW].map(|k| 2.0 * RADIUS * k as f64);
        let place = DVec3::new(first + x, RADIUS + y, first + z);
        let stone = body_at(format!("stone {i}"), stone.clone(), place);
        scene.bodies.push(stone.with_color(palette::bright(i + i / ROW)));
    }
    let height = (2.0 * RADIUS * layers as f64).min(4.0 * RADIUS * ROW as f64);
    let radius = 0.5 * height + RADIUS * ROW as f64;
    scene.view = Some(ViewSpec::framing(0.4 * height * DVec3::Y, radius, DVec3::new(0.5, 0.35, 1.0)));
    scene
}
