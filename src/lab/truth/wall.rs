//! A ball thrown at a wall without restitution: it flies until it touches the wall's face and
//! stays there.

use crate::physics::RigidBody;
use crate::scene::{SceneSpec, ShapeSpec};

use super::answer::{EnergyScale, Truth};
use super::bodies::dynamic;
use crate::lab::simulation::Sample;

/// Share of the ball's diameter that it may sink into the wall, or fly on beyond its face.
const FAILS_ABOVE: f64 = 0.1;

pub(super) fn truth(scene: &SceneSpec) -> Option<Truth> {
    let index = *dynamic(scene).first()?;
    let ball = &scene.bodies[index];
    let wall = scene.bodies.iter().find(|body| body.kind == RigidBody::Static)?;
    let (Some(ShapeSpec::Sphere { radius }), Some(ShapeSpec::Cuboid { size })) = (&ball.shape, &wall.shape) else {
        return None;
    };
    let face = wall.position.x - 0.5 * size.x - radius;
    let (start, speed) = (ball.position.x, ball.linear_velocity.x);
    let energy = 0.5 * ball.mass? * speed * speed;
    let distance = move |sample: &Sample| {
        let expected = (start + speed * sample.time).min(face);
        Some((sample.bodies[index].position.x - expected).abs())
    };
    let beyond = Truth::largest("way of the ball beyond the wall's face", "m", move |sample| {
        Some((sample.bodies[index].position.x - face).max(0.0))
    });
    let truth = Truth::largest("place of the ball", "m", distance).with_energy_scale(EnergyScale::Known(energy));
    Some(truth.and(beyond.failing_above(FAILS_ABOVE * 2.0 * radius)))
}
