//! A chain on parallel hinges keeps to its plane, whatever pulls along the axes.

use bevy::math::DVec3;

use crate::scene::SceneSpec;

use super::answer::Truth;
use super::bodies::dynamic;
use super::limits;
use crate::lab::angle::angle_between;
use crate::lab::simulation::Sample;

pub(super) fn truth(scene: &SceneSpec) -> Option<Truth> {
    let links = dynamic(scene);
    let distance = move |sample: &Sample| {
        let tilt = |&link: &usize| angle_between(sample.bodies[link].rotation * DVec3::Z, DVec3::Z);
        Some(links.iter().map(tilt).fold(0.0, f64::max))
    };
    let truth = Truth::largest("tilt off the hinges' axes", "rad", distance).failing_above(FAILS_ABOVE);
    Some(match limits::overshoot(scene) {
        Some(overshoot) => truth.and(overshoot),
        None => truth,
    })
}

/// What looks broken, rad.
const FAILS_ABOVE: f64 = 0.1;
