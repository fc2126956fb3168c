//! A ball thrown along the ground without spin: friction slows it by μg and spins it up until
//! it rolls, from t* = 2v₀/(7μg) on, at 5v₀/7.

use crate::physics::RigidBody;
use crate::scene::{SceneSpec, ShapeSpec};

use super::answer::Truth;
use super::bodies::dynamic;
use crate::lab::simulation::Sample;

pub(super) fn truth(scene: &SceneSpec) -> Option<Truth> {
    let index = *dynamic(scene).first()?;
    let ball = &scene.bodies[index];
    let Some(ShapeSpec::Sphere { radius }) = ball.shape else { return None };
    let ground = scene.bodies.iter().find(|body| body.kind == RigidBody::Static)?;
    let deceleration = (ball.material.friction * ground.material.friction).sqrt() * scene.gravity.length();
    let start = ball.linear_velocity;
    let speed = start.length();
    let forward = start / speed;
    // A ball that rolls along `forward` turns about up × forward.
    let axle = -scene.gravity.normalize().cross(forward);
    let distance = move |sample: &Sample| {
        let expected = motion(sample.time, speed, deceleration);
        let state = sample.bodies[index];
        let linear = state.linear.distance(expected.speed * forward);
        let rim = radius * state.angular.distance(expected.rim_speed / radius * axle);
        Some(linear.max(rim))
    };
    // A speed of 5 m/s after a handful of roundings.
    Some(Truth::largest("speed of centre and rim", "m/s", distance).with_uncertainty(1e-14))
}

struct Motion {
    speed: f64,
    /// ω r.
    rim_speed: f64,
}

fn motion(time: f64, start_speed: f64, deceleration: f64) -> Motion {
    let sliding = time.min(2.0 * start_speed / (7.0 * deceleration));
    // Solid ball, I = 2/5 m r²: the torque μ m g r turns it by 5/2 μg/r.
    Motion { speed: start_speed - deceleration * sliding, rim_speed: 2.5 * deceleration * sliding }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_ends_rolling_at_five_sevenths_and_not_before() {
        let (speed, deceleration) = (5.0, 0.3 * 9.81);
        let rolls_from = 2.0 * speed / (7.0 * deceleration);
        let before = motion(0.99 * rolls_from, speed, deceleration);
        assert!(before.speed > before.rim_speed + 1e-3);
        let after = motion(rolls_from + 3.0, speed, deceleration);
        assert!((after.speed - 5.0 * speed / 7.0).abs() < 1e-14);
        assert!((after.speed - after.rim_speed).abs() < 1e-14);
    }
}
