//! A ball thrown level at a wall of cubes: were all of them to go along with it, it would keep M/(M + Σ m) of its speed;
//! whatever it leaves behind leaves it more.

use crate::physics::RigidBody;
use crate::scene::{BodySpec, SceneSpec, ShapeSpec};

use super::answer::{EnergyScale, Truth};
use super::bodies::dynamic;
use crate::lab::simulation::Sample;

/// Share of its speed that the ball may lack.
const FAILS_ABOVE: f64 = 0.1;

/// From the middle of the wall to where the ball is past it, in its radii, and to where that no longer counts: it lies on
/// the ground by then.
const PAST: [f64; 2] = [1.5, 3.0];

pub(super) fn truth(scene: &SceneSpec) -> Option<Truth> {
    let is_ball = |body: &BodySpec| matches!(body.shape, Some(ShapeSpec::Sphere { .. }));
    let index = scene.bodies.iter().position(|body| body.kind == RigidBody::Dynamic && is_ball(body))?;
    let ball = &scene.bodies[index];
    let Some(ShapeSpec::Sphere { radius }) = ball.shape else { return None };
    let (mass, speed) = (ball.mass?, ball.linear_velocity.z);
    let all: f64 = dynamic(scene).into_iter().map(|index| scene.bodies[index].mass).sum::<Option<f64>>()?;
    let least = speed * mass / all;
    let lacking = Truth::largest("speed that the ball lacks behind the wall", "m/s", move |sample: &Sample| {
        let ball = &sample.bodies[index];
        let is_past = (PAST[0] * radius..PAST[1] * radius).contains(&ball.position.z);
        is_past.then(|| (least - ball.linear.z).max(0.0))
    });
    let energy = 0.5 * mass * speed * speed;
    Some(lacking.with_energy_scale(EnergyScale::Known(energy)).failing_above(FAILS_ABOVE * speed))
}
