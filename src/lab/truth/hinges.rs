//! How far the axes that a hinge joins are from each other.

use bevy::math::DVec3;

use crate::scene::{JointKindSpec, SceneSpec};

use super::answer::Truth;
use super::bodies::{angle_between, joined};
use crate::lab::simulation::Sample;

/// The largest angle between the axis of a hinge in A and in B. Of any scene, built in or not.
pub fn tilt(scene: &SceneSpec) -> Truth {
    let hinges: Vec<_> = joined(scene)
        .filter(|(joint, _)| joint.kind == JointKindSpec::Hinge)
        .map(|(joint, bodies)| {
            let frames = joint.axes.frames(bodies.map(|body| scene.bodies[body].rotation));
            (bodies, frames.map(|frame| frame * DVec3::X))
        })
        .collect();
    let distance = move |sample: &Sample| {
        let tilt = |(bodies, axes): &([usize; 2], [DVec3; 2])| {
            let [a, b] = [0, 1].map(|end| sample.bodies[bodies[end]].rotation * axes[end]);
            angle_between(a, b)
        };
        Some(hinges.iter().map(tilt).fold(0.0, f64::max))
    };
    Truth::largest("tilt of a hinge", "rad", distance)
}
