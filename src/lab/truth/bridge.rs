//! A bridge without a load stays where it is built, in the discrete catenary: with H the pull along the span and w the
//! weight of a plank, hinge k of n planks bears (H, w (k − n/2)), and plank k slopes by w (k − (n − 1)/2)/H.

use bevy::math::DVec3;

use crate::scene::{BodySpec, SceneSpec};

use super::answer::Truth;
use super::bodies::dynamic;
use super::stays_put;
use crate::lab::simulation::Sample;

pub(super) fn truth(scene: &SceneSpec) -> Option<Truth> {
    let planks = dynamic(scene);
    let n = planks.len();
    // One hinge more than planks; a ball that rolls has none.
    if scene.joints.len() != n + 1 {
        return None;
    }
    let first = &scene.bodies[*planks.first()?];
    let weight = first.mass? * scene.gravity.length();
    let slope = |body: &BodySpec| (body.rotation * DVec3::X).y / (body.rotation * DVec3::X).x;
    let pull = -weight * 0.5 * (n - 1) as f64 / slope(first);
    let tension = move |hinge: usize| pull.hypot(weight * (hinge as f64 - 0.5 * n as f64));
    let distance = move |sample: &Sample| {
        let loads = sample.loads.iter().enumerate().filter(|_| sample.step > 0);
        loads.map(|(hinge, load)| (load.force.length() / tension(hinge) - 1.0).abs()).reduce(f64::max)
    };
    let tensions = Truth::largest("tensions of the hinges", "of their own", distance).of_loads();
    Some(stays_put::truth(scene)?.with_statics(None).and(tensions))
}
