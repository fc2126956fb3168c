//! A box at rest on a slope (gravity turned by θ over level ground): it sticks where tan θ ≤ μ,
//! else it slides s = ½ g (sin θ − μ cos θ) t². A run fails that moves what sticks, or slides by a tenth more or less.

use bevy::math::DVec3;

use crate::physics::RigidBody;
use crate::scene::SceneSpec;

use super::answer::{Poses, Truth};
use super::bodies::dynamic;
use crate::lab::simulation::Sample;

pub(super) fn truth(scene: &SceneSpec) -> Option<Truth> {
    let (index, acceleration) = acceleration(scene)?;
    let start = scene.bodies[index].position;
    let distance = move |sample: &Sample| {
        let expected = 0.5 * sample.time * sample.time * acceleration;
        Some(level(sample.bodies[index].position - start).distance(expected))
    };
    // A way of up to 40 m after a handful of roundings.
    let truth = Truth::largest("way down the slope", "m", distance).with_uncertainty(1e-13);
    if acceleration == DVec3::ZERO {
        return Some(truth.that_stays());
    }
    let share = move |sample: &Sample| {
        let expected = 0.5 * sample.time * sample.time * acceleration;
        let way = level(sample.bodies[index].position - start);
        (sample.step > 0).then(|| way.distance(expected) / expected.length())
    };
    let share = Truth::last("way down the slope, as a share", "of the way", share);
    Some(truth.and(share.failing_above(WAY_SHARE)))
}

/// A run fails whose way is off by over this share of it: below it lies what the last of 60 steps a second adds, above
/// it another law of friction.
const WAY_SHARE: f64 = 0.1;

/// The box where the answer has it.
pub(super) fn poses(scene: &SceneSpec) -> Option<Poses> {
    let (index, acceleration) = acceleration(scene)?;
    let (start, rotation) = (scene.bodies[index].position, scene.bodies[index].rotation);
    Some(Box::new(move |time| vec![(index, start + 0.5 * time * time * acceleration, rotation)]))
}

/// The box, as its index, and its acceleration along the ground, m/s².
fn acceleration(scene: &SceneSpec) -> Option<(usize, DVec3)> {
    let index = *dynamic(scene).first()?;
    let ground = scene.bodies.iter().find(|body| body.kind == RigidBody::Static)?;
    let sliding = &scene.bodies[index];
    let friction = (sliding.material.friction * ground.material.friction).sqrt();
    let downhill = level(scene.gravity);
    let acceleration = (downhill.length() + friction * scene.gravity.y).max(0.0);
    Some((index, acceleration * downhill.normalize_or_zero()))
}

/// The part along the ground: how deep the box rests is not the question here.
fn level(vector: DVec3) -> DVec3 {
    DVec3::new(vector.x, 0.0, vector.z)
}
