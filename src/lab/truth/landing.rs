//! Things above each other that come straight down, without restitution: each falls freely until it lies on what is
//! under it, which has come to rest by then, and stays there. Boxes lie flat, balls on a box under their centre.

use bevy::math::{DQuat, DVec3};

use crate::physics::{Collider, RigidBody};
use crate::scene::{BodySpec, SceneSpec, ShapeSpec};

use super::answer::Truth;
use super::bodies::{collider, dynamic, largest_displacement};
use crate::lab::simulation::Sample;

/// Time after the last landing from which on nothing moves any more, s.
const SETTLING: f64 = 1.0;

/// Way of a body from where it rests above which a run fails, m: a fifth of a cube.
const MOST_MOVED: f64 = 0.2;

/// Depth of a body under where it rests above which a run fails, m: a tenth of a cube.
const MOST_SUNK: f64 = 0.1;

/// A body and where it rests.
struct Landing {
    index: usize,
    place: DVec3,
    shape: Option<Collider>,
}

pub(super) fn truth(scene: &SceneSpec) -> Option<Truth> {
    let landings = landings(scene)?;
    let fall = landings.iter().map(|landing| scene.bodies[landing.index].position.y - landing.place.y);
    let settled = (2.0 * fall.fold(0.0, f64::max) / scene.gravity.length()).sqrt() + SETTLING;
    let heights: Vec<_> = landings.iter().map(|landing| (landing.index, landing.place.y)).collect();
    let moved = Truth::largest("way of a body from where it should rest", "m", move |sample: &Sample| {
        let moves = landings.iter().map(|Landing { index, place, shape }| {
            let body = &sample.bodies[*index];
            largest_displacement(shape.as_ref(), body.position - *place, [DQuat::IDENTITY, body.rotation])
        });
        (sample.time >= settled).then(|| moves.fold(0.0, f64::max))
    });
    let sunk = Truth::largest("depth of a body under where it should rest", "m", move |sample: &Sample| {
        Some(heights.iter().map(|&(index, height)| height - sample.bodies[index].position.y).fold(0.0, f64::max))
    });
    Some(moved.failing_above(MOST_MOVED).and(sunk.failing_above(MOST_SUNK)))
}

/// Where each comes to rest, the lowest first.
fn landings(scene: &SceneSpec) -> Option<Vec<Landing>> {
    let ground = scene.bodies.iter().find(|body| body.kind == RigidBody::Static)?.position.y;
    let mut order = dynamic(scene);
    order.sort_by(|&a, &b| scene.bodies[a].position.y.total_cmp(&scene.bodies[b].position.y));
    // Upper faces: centre, half their sides.
    let mut tops: Vec<(DVec3, DVec3)> = Vec::new();
    let mut landings = Vec::new();
    for index in order {
        let body = &scene.bodies[index];
        let (height, foot) = half_extents(body)?;
        let is_under = |(top, half): &&(DVec3, DVec3)| {
            let (apart, reach) = ((body.position - *top).abs(), foot + *half);
            apart.x < reach.x && apart.z < reach.z
        };
        let support = tops.iter().filter(is_under).map(|(top, _)| top.y).fold(ground, f64::max);
        let place = DVec3 { y: support + height, ..body.position };
        tops.push((DVec3 { y: support + 2.0 * height, ..place }, foot));
        landings.push(Landing { index, place, shape: collider(body) });
    }
    Some(landings)
}

/// Half the height, and of what it stands on half the sides.
fn half_extents(body: &BodySpec) -> Option<(f64, DVec3)> {
    match body.shape {
        Some(ShapeSpec::Cuboid { size }) => Some((0.5 * size.y, 0.5 * size)),
        Some(ShapeSpec::Sphere { radius }) => Some((radius, DVec3::ZERO)),
        _ => None,
    }
}
