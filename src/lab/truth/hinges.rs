//! How far the axes that a hinge joins are from each other.

use crate::scene::{JointKindSpec, SceneSpec};

use super::answer::Truth;
use crate::lab::joined::{Joined, joined};
use crate::lab::simulation::Sample;

/// The largest angle between the axis of a hinge in A and in B. Of any scene, built in or not.
pub fn tilt(scene: &SceneSpec) -> Truth {
    let hinges: Vec<Joined> = joined(scene)
        .filter(|(joint, _)| joint.kind == JointKindSpec::Hinge)
        .map(|(joint, bodies)| Joined::of(joint, bodies, scene))
        .collect();
    let distance = move |sample: &Sample| {
        let tilts = hinges.iter().map(|hinge| hinge.relative(sample.bodies).swing());
        Some(tilts.fold(0.0, f64::max))
    };
    Truth::largest("tilt of a hinge", "rad", distance)
}
