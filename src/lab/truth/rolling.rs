//! A slab pushed over the ground with balls rolling on it: the slab gains
//! (F − μ M g)/(m + 2/7 Σ m_ball) along the push, each ball 2/7 of that.

use crate::physics::RigidBody;
use crate::scene::{SceneSpec, ShapeSpec};

use super::answer::Truth;
use super::bodies::dynamic;
use crate::lab::simulation::Sample;

/// Share of the slab's acceleration that a solid ball rolling on it gains.
const BALL_SHARE: f64 = 2.0 / 7.0;

pub(super) fn truth(scene: &SceneSpec) -> Option<Truth> {
    let moving = dynamic(scene);
    let is_ball = |index: &usize| matches!(scene.bodies[*index].shape, Some(ShapeSpec::Sphere { .. }));
    let slab_index = *moving.iter().find(|index| !is_ball(index))?;
    let first_ball = *moving.iter().find(|index| is_ball(index))?;
    let slab = &scene.bodies[slab_index];
    let ground = scene.bodies.iter().find(|body| body.kind == RigidBody::Static)?;
    let balls =
        moving.iter().filter(|index| is_ball(index)).map(|&index| scene.bodies[index].mass).sum::<Option<f64>>()?;
    let slab_mass = slab.mass?;
    let friction = (slab.material.friction * ground.material.friction).sqrt();
    let push = slab.force.length();
    let drive = push - friction * (slab_mass + balls) * scene.gravity.length();
    let acceleration = drive / (slab_mass + BALL_SHARE * balls) * slab.force.normalize_or_zero();
    let distance = move |sample: &Sample| {
        let slab_error = sample.bodies[slab_index].linear - acceleration * sample.time;
        let ball_error = sample.bodies[first_ball].linear - BALL_SHARE * acceleration * sample.time;
        Some(slab_error.length_squared() + ball_error.length_squared())
    };
    // Speeds of some 10 m/s are known to 1e-14 m/s, and the error is a square.
    Some(Truth::time_mean("squared velocity errors of slab and first ball", "m²/s²", distance).with_uncertainty(1e-27))
}
