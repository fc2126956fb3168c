//! Linear and angular momentum of scenes that exchange none with what does not move.

use bevy::math::DVec3;
use serde::Serialize;

use super::moving::Moving;
use crate::lab::joined::joined;
use crate::physics::{BodyState, LockedAxes, RigidBody, SolverSettings};
use crate::scene::SceneSpec;

/// How far momentum strayed from what gravity makes of it. None where static or kinematic bodies
/// take part by joints or contacts, where something damps, pushes or locks a body, and where
/// nothing moves or turns.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct MomentumMetrics {
    /// Largest |p − p₀ − Σ m g t| over the largest Σ m |v|.
    pub linear_max_relative_drift: Option<f64>,
    /// Largest |L − L₀|, about the centre of mass of all that moves, over the largest sum of its
    /// parts' magnitudes. None also where bodies fall differently.
    pub angular_max_relative_drift: Option<f64>,
}

/// Less of the largest angular momentum that the speeds and distances allow is rounding.
const LEAST_SPIN: f64 = 1e-12;

/// Watches the momentum of a run.
pub(super) struct MomentumMeter {
    /// Whether nothing from outside but gravity has acted so far.
    isolated: bool,
    falls_as_one: bool,
    start: Momentum,
    linear_drift: f64,
    angular_drift: f64,
    linear_scale: f64,
    angular_scale: f64,
    /// What the angular scale could be.
    lever_scale: f64,
}

/// Sums over the bodies that move.
#[derive(Clone, Copy)]
struct Momentum {
    linear: DVec3,
    /// About the centre of mass.
    angular: DVec3,
    /// Σ m |v|.
    linear_parts: f64,
    /// Σ |r × m v| + |I ω|.
    angular_parts: f64,
    /// Σ m |v| × the farthest distance of a body's centre from the origin.
    lever: f64,
}

impl Momentum {
    fn of(bodies: &[Moving], states: &[BodyState]) -> Self {
        let mass: f64 = bodies.iter().map(|body| body.mass).sum();
        let mean = |quantity: fn(&BodyState) -> DVec3| {
            bodies.iter().map(|body| body.mass * quantity(&states[body.index])).sum::<DVec3>() / mass
        };
        let (center, velocity) = (mean(|state| state.position), mean(|state| state.linear));
        let mut sum =
            Self { linear: mass * velocity, angular: DVec3::ZERO, linear_parts: 0.0, angular_parts: 0.0, lever: 0.0 };
        let mut farthest: f64 = 0.0;
        for body in bodies {
            let BodyState { position, linear, .. } = states[body.index];
            let orbit = body.mass * (position - center).cross(linear - velocity);
            let spin = body.spin_momentum(states);
            sum.angular += orbit + spin;
            sum.angular_parts += orbit.length() + spin.length();
            sum.linear_parts += body.mass * linear.length();
            farthest = farthest.max(position.length() + body.radius);
        }
        sum.lever = sum.linear_parts * farthest;
        sum
    }
}

impl MomentumMeter {
    pub fn new(scene: &SceneSpec, settings: &SolverSettings, bodies: &[Moving], start: &[BodyState]) -> Self {
        Self {
            isolated: !bodies.is_empty() && settings.drag == 0.0 && is_isolated(scene),
            falls_as_one: bodies.windows(2).all(|pair| pair[0].gravity == pair[1].gravity),
            start: Momentum::of(bodies, start),
            linear_drift: 0.0,
            angular_drift: 0.0,
            linear_scale: 0.0,
            angular_scale: 0.0,
            lever_scale: 0.0,
        }
    }

    /// `touched_outside`: whether a contact with what does not move carried a force in this step.
    pub fn observe(&mut self, bodies: &[Moving], states: &[BodyState], time: f64, touched_outside: bool) {
        self.isolated &= !touched_outside;
        if !self.isolated {
            return;
        }
        let now = Momentum::of(bodies, states);
        let gained = bodies.iter().map(|body| body.mass * time * body.gravity).sum::<DVec3>();
        self.linear_drift = self.linear_drift.max((now.linear - self.start.linear - gained).length());
        self.angular_drift = self.angular_drift.max((now.angular - self.start.angular).length());
        for sums in [&self.start, &now] {
            self.linear_scale = self.linear_scale.max(sums.linear_parts);
            self.angular_scale = self.angular_scale.max(sums.angular_parts);
            self.lever_scale = self.lever_scale.max(sums.lever);
        }
    }

    pub fn metrics(&self) -> MomentumMetrics {
        let turns = self.angular_scale > LEAST_SPIN * self.lever_scale;
        MomentumMetrics {
            linear_max_relative_drift: (self.isolated && self.linear_scale > 0.0)
                .then(|| self.linear_drift / self.linear_scale),
            angular_max_relative_drift: (self.isolated && self.falls_as_one && turns)
                .then(|| self.angular_drift / self.angular_scale),
        }
    }
}

/// Whether nothing but gravity and contacts can act on the bodies from outside.
fn is_isolated(scene: &SceneSpec) -> bool {
    let moves = |body: usize| scene.bodies[body].kind == RigidBody::Dynamic;
    let free = scene.bodies.iter().filter(|body| body.kind == RigidBody::Dynamic).all(|body| {
        body.force == DVec3::ZERO
            && body.torque == DVec3::ZERO
            && body.damping == (0.0, 0.0)
            && body.locked == LockedAxes::default()
    });
    free && joined(scene).flat_map(|(_, bodies)| bodies).all(moves)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{BodySpec, JointSpec, ShapeSpec};

    const BALL: ShapeSpec = ShapeSpec::Sphere { radius: 0.5 };

    /// Two balls of 2 kg that turn about each other at 3 m/s, 1 m from their centre of mass.
    fn pair() -> (SceneSpec, [Moving; 2], [BodyState; 2]) {
        let gravity = -10.0 * DVec3::Y;
        let mut scene = SceneSpec::new("pair", gravity);
        let bodies = [0, 1].map(|index| Moving {
            index,
            mass: 2.0,
            inertia: DVec3::splat(0.5),
            gravity,
            force: DVec3::ZERO,
            size: 1.0,
            radius: 0.5,
        });
        let states = [-1.0, 1.0].map(|side| BodyState {
            position: DVec3::new(7.0 + side, 0.0, 0.0),
            linear: DVec3::new(0.0, 3.0 * side, 0.0),
            ..BodyState::default()
        });
        scene.bodies.extend(["a", "b"].map(|name| BodySpec::new(name, BALL, DVec3::ZERO)));
        (scene, bodies, states)
    }

    fn observed(scene: &SceneSpec, change: impl Fn(&mut [BodyState; 2]), touched: bool) -> MomentumMetrics {
        let (_, bodies, start) = pair();
        let mut meter = MomentumMeter::new(scene, &SolverSettings::default(), &bodies, &start);
        let mut states = start;
        for state in &mut states {
            state.position += DVec3::new(0.0, -5.0, 0.0);
            state.linear += DVec3::new(0.0, -10.0, 0.0);
        }
        change(&mut states);
        meter.observe(&bodies, &states, 1.0, touched);
        meter.metrics()
    }

    #[test]
    fn what_gravity_gives_is_no_drift_and_all_else_is() {
        let (scene, ..) = pair();
        let falling = observed(&scene, |_| (), false);
        assert!(falling.linear_max_relative_drift.unwrap() < 1e-15);
        assert!(falling.angular_max_relative_drift.unwrap() < 1e-15);
        // 2 kg at 13 m/s and 7 m/s are 40 N·s; 2 kg · 1 m · 3 m/s twice are 12 N·m·s.
        let pushed = observed(&scene, |states| states.iter_mut().for_each(|state| state.linear.x += 0.5), false);
        let speeds = 2.0 * (7.0_f64.hypot(0.5) + 13.0_f64.hypot(0.5));
        assert!((pushed.linear_max_relative_drift.unwrap() - 2.0 / speeds).abs() < 1e-15);
        assert!(pushed.angular_max_relative_drift.unwrap() < 1e-15);
        let spun = observed(&scene, |states| states[0].angular.z = 4.0, false);
        assert!((spun.angular_max_relative_drift.unwrap() - 2.0 / 14.0).abs() < 1e-15);
    }

    #[test]
    fn there_is_none_where_something_outside_takes_part() {
        let none = |scene: &SceneSpec, touched| {
            let MomentumMetrics { linear_max_relative_drift, angular_max_relative_drift } =
                observed(scene, |_| (), touched);
            linear_max_relative_drift.is_none() && angular_max_relative_drift.is_none()
        };
        let (scene, ..) = pair();
        assert!(!none(&scene, false));
        assert!(none(&scene, true), "a contact with the ground");
        let mut joined = scene.clone();
        joined.joints.push(JointSpec::at(&scene.bodies[0], &scene.bodies[1], DVec3::ZERO));
        assert!(!none(&joined, false), "a joint between the two");
        joined.bodies.push(BodySpec::pin("pin", DVec3::ZERO));
        joined.joints.push(JointSpec::at(&joined.bodies[2], &scene.bodies[1], DVec3::ZERO));
        assert!(none(&joined, false), "a joint with the world");
        let mut pushed = scene.clone();
        pushed.bodies[1].torque.x = 1.0;
        assert!(none(&pushed, false));
    }

    #[test]
    fn a_ball_that_only_falls_has_no_angular_momentum_to_drift() {
        let (scene, [ball, _], start) = pair();
        let mut meter = MomentumMeter::new(&scene, &SolverSettings::default(), std::slice::from_ref(&ball), &start);
        let falling = BodyState { linear: DVec3::new(0.1, -13.0, 0.3), ..start[0] };
        meter.observe(&[ball], &[falling], 1.0, false);
        assert_eq!(meter.metrics().angular_max_relative_drift, None);
    }
}
