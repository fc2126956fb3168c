//! A block of balls dropped on the ground. Without restitution nothing may overlap: the error is
//! the time mean of Σ depth² over all pairs and the ground. With restitution 1 energy is kept:
//! the time mean of (ΣE − ΣE₀)².

use bevy::math::DVec3;

use crate::physics::{BodyState, RigidBody};
use crate::scene::{SceneSpec, ShapeSpec};

use super::answer::Truth;
use super::bodies::dynamic;
use crate::lab::simulation::Sample;

pub(super) fn truth(scene: &SceneSpec) -> Option<Truth> {
    let balls: Vec<Ball> = dynamic(scene).into_iter().map(|index| Ball::of(scene, index)).collect::<Option<_>>()?;
    let ground = scene.bodies.iter().find(|body| body.kind == RigidBody::Static)?.position.y;
    let restitution = scene.bodies[balls.first()?.index].material.restitution;
    if restitution == 0.0 {
        let depths = move |sample: &Sample| Some(squared_depths(&balls, ground, sample.bodies));
        // No depth is exact. Each of some 1000 is seen to 1e-16 m, and the error is their square.
        Some(Truth::time_mean("squared depths", "m²", depths).with_uncertainty(1e-28))
    } else if restitution == 1.0 {
        let gravity = scene.gravity;
        let mut start = None;
        // A sum of some 500 terms of like size, each rounded.
        let weight: f64 = balls.iter().map(|ball| ball.mass * gravity.length()).sum();
        let uncertainty = (1e-14 * weight).powi(2);
        let distance = move |sample: &Sample| {
            let energy = balls.iter().map(|ball| ball.energy(gravity, &sample.bodies[ball.index])).sum::<f64>();
            Some((energy - *start.get_or_insert(energy)).powi(2))
        };
        Some(Truth::time_mean("squared energy error", "J²", distance).with_uncertainty(uncertainty))
    } else {
        None
    }
}

#[derive(Clone, Copy)]
struct Ball {
    index: usize,
    radius: f64,
    mass: f64,
}

impl Ball {
    fn of(scene: &SceneSpec, index: usize) -> Option<Self> {
        let body = &scene.bodies[index];
        let Some(ShapeSpec::Sphere { radius }) = body.shape else { return None };
        Some(Self { index, radius, mass: body.mass? })
    }

    fn energy(&self, gravity: DVec3, state: &BodyState) -> f64 {
        let spin = 0.4 * self.radius * self.radius * state.angular.length_squared();
        self.mass * (0.5 * (state.linear.length_squared() + spin) - gravity.dot(state.position))
    }
}

fn squared_depths(balls: &[Ball], ground: f64, states: &[BodyState]) -> f64 {
    let square = |depth: f64| depth.max(0.0).powi(2);
    let mut sum = 0.0;
    for (place, a) in balls.iter().enumerate() {
        let position = states[a.index].position;
        sum += square(ground + a.radius - position.y);
        for b in &balls[place + 1..] {
            sum += square(a.radius + b.radius - position.distance(states[b.index].position));
        }
    }
    sum
}
