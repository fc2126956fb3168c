//! Scenes in equilibrium: any motion is error, and forces carry weights.

use crate::scene::SceneSpec;

use super::Statics;
use super::answer::{Poses, Truth};
use super::bodies::{collider, dynamic, largest_displacement};
use crate::lab::simulation::Sample;

pub(super) fn truth(scene: &SceneSpec) -> Option<Truth> {
    // Gravity turned out of the plane of a joint grid makes it swing.
    if scene.gravity.x != 0.0 || scene.gravity.z != 0.0 {
        return None;
    }
    let start = |index: usize| {
        let body = &scene.bodies[index];
        (index, body.position, body.principal_rotation(), collider(body))
    };
    let starts: Vec<_> = dynamic(scene).into_iter().map(start).collect();
    // The answer is exact; a place is kept to a rounding of its distance from the origin.
    let extent = starts.iter().map(|(_, start, ..)| start.length()).fold(0.0, f64::max);
    let distance = move |sample: &Sample| {
        let moves = starts.iter().map(|(index, start, rotation, shape)| {
            let body = &sample.bodies[*index];
            largest_displacement(shape.as_ref(), body.position - *start, [*rotation, body.rotation])
        });
        Some(moves.fold(0.0, f64::max))
    };
    let truth = Truth::largest("largest move of a body that should stay", "m", distance);
    let truth = truth.that_stays().with_uncertainty(f64::EPSILON * extent);
    Some(truth.with_statics(Statics::of(scene)))
}

/// Every body where it starts.
pub(super) fn poses(scene: &SceneSpec) -> Poses {
    let start = |index: usize| (index, scene.bodies[index].position, scene.bodies[index].principal_rotation());
    let starts: Vec<_> = dynamic(scene).into_iter().map(start).collect();
    Box::new(move |_| starts.clone())
}
