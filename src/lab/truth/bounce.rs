//! Balls dropped on the ground: fall t₀ = √(2H/g), then bounces of e^k times the first landing
//! speed, at rest after t₀ (1 + e)/(1 − e).

use bevy::math::DVec3;

use crate::physics::RigidBody;
use crate::scene::{SceneSpec, ShapeSpec};

use super::answer::{EnergyScale, Poses, Truth};
use super::bodies::dynamic;
use crate::lab::simulation::Sample;

pub(super) fn truth(scene: &SceneSpec) -> Option<Truth> {
    let balls = dynamic(scene);
    let (bounce, rest) = bounce(scene)?;
    let weight: f64 = balls.iter().map(|&index| scene.bodies[index].mass).sum::<Option<f64>>()? * bounce.gravity;
    let fall = weight * bounce.drop;
    let landing_speed = (2.0 * bounce.gravity * bounce.drop).sqrt();
    let distance = move |sample: &Sample| {
        let expected = rest + bounce.height(sample.time);
        let heights = balls.iter().map(|&index| sample.bodies[index].position.y);
        Some(heights.map(|height| (height - expected).abs()).fold(0.0, f64::max))
    };
    let truth = Truth::largest("height of the balls", "m", distance).with_uncertainty(TIME_UNCERTAINTY * landing_speed);
    Some(truth.with_energy_scale(EnergyScale::Known(fall)))
}

/// Every ball where the answer has it.
pub(super) fn poses(scene: &SceneSpec) -> Option<Poses> {
    let (bounce, rest) = bounce(scene)?;
    let start = |index: usize| (index, scene.bodies[index].position, scene.bodies[index].rotation);
    let starts: Vec<_> = dynamic(scene).into_iter().map(start).collect();
    Some(Box::new(move |time| {
        let height = rest + bounce.height(time);
        let place = |&(index, start, rotation)| (index, DVec3 { y: height, ..start }, rotation);
        starts.iter().map(place).collect()
    }))
}

/// The motion of the balls, and the height of their centres at rest.
fn bounce(scene: &SceneSpec) -> Option<(Bounce, f64)> {
    let balls = dynamic(scene);
    let first = &scene.bodies[*balls.first()?];
    let Some(ShapeSpec::Sphere { radius }) = first.shape else { return None };
    let ground = scene.bodies.iter().find(|body| body.kind == RigidBody::Static)?;
    let bounce = Bounce {
        gravity: scene.gravity.length(),
        drop: first.position.y - ground.position.y - radius,
        restitution: first.material.restitution.max(ground.material.restitution),
    };
    Some((bounce, ground.position.y + radius))
}

/// A landing's time, up to 20 s, is known to a rounding of each of up to 100 flights before it, s.
const TIME_UNCERTAINTY: f64 = 100.0 * 20.0 * f64::EPSILON;

struct Bounce {
    gravity: f64,
    /// Of the lowest point above the ground at the start, m.
    drop: f64,
    restitution: f64,
}

impl Bounce {
    /// Height of the lowest point above the ground.
    fn height(&self, time: f64) -> f64 {
        let fall_time = (2.0 * self.drop / self.gravity).sqrt();
        if time < fall_time {
            return self.drop - 0.5 * self.gravity * time * time;
        }
        let mut since = time - fall_time;
        let mut flight = 2.0 * fall_time * self.restitution;
        // What is left is lower than a rounding error of the drop.
        while flight > 1e-9 * fall_time {
            if since < flight {
                return 0.5 * self.gravity * since * (flight - since);
            }
            since -= flight;
            flight *= self.restitution;
        }
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bounce(restitution: f64) -> Bounce {
        Bounce { gravity: 9.81, drop: 4.9, restitution }
    }

    #[test]
    fn apexes_and_landings_are_those_of_the_closed_form() {
        let fall_time = (9.8_f64 / 9.81).sqrt();
        for e in [0.3_f64, 0.8, 1.0] {
            let mut landing = fall_time;
            for k in 1..6 {
                let half = fall_time * e.powi(k);
                let apex = bounce(e).height(landing + half);
                assert!((apex - 4.9 * e.powi(2 * k)).abs() < 1e-12, "e = {e}, bounce {k}: {apex}");
                landing += 2.0 * half;
                assert!(bounce(e).height(landing).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn it_rests_after_the_last_bounce() {
        let fall_time = (9.8_f64 / 9.81).sqrt();
        for e in [0.0, 0.5, 0.9] {
            let rests_from = fall_time * (1.0 + e) / (1.0 - e);
            assert_eq!(bounce(e).height(rests_from * (1.0 + 1e-7)), 0.0);
            assert!(e == 0.0 || bounce(e).height(0.9 * rests_from) > 0.0);
        }
    }
}
