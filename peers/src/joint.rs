//! Joints as Plumb makes them of a scene: the numbers that every engine is handed, and what can be told of a joint from
//! the poses of its bodies.

use std::f64::consts::{PI, TAU};

use bevy::math::{DQuat, DVec3};
use plumb::lab::BodyState;
use plumb::physics::{DistanceLaw, JointAxis, JointMotor, MassProperties, MotorTarget, PrescribedMotion};
use plumb::scene::{JointKindSpec, JointSpec, LimitSpec};

use crate::scene::Body;

/// A joint between two bodies, in their principal axes about their centres of mass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Joint {
    pub a: usize,
    pub b: usize,
    /// The joint's point on A, m.
    pub anchor_a: DVec3,
    /// The joint's point on B, m.
    pub anchor_b: DVec3,
    /// From the axes of the joint's frame, whose x is its axis, to those of A.
    pub frame_a: DQuat,
    /// From the axes of the joint's frame, whose x is its axis, to those of B.
    pub frame_b: DQuat,
    /// What it holds.
    pub kind: JointKindSpec,
    /// How far it may go.
    pub limits: Option<LimitSpec>,
    /// What drives it.
    pub motor: Option<Motor>,
    /// Whether the two collide.
    pub collide: bool,
}

/// A motor with the constants that Plumb gives it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motor {
    pub drive: Drive,
    /// N or N·m; may be infinite.
    pub max_force: f64,
}

/// Where a motor drives its joint's coordinate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Drive {
    /// That rate, rad/s or m/s.
    Speed(f64),
    /// That value, by a spring of that stiffness and damping: N·m/rad and N·m·s/rad, or N/m and N·s/m.
    Spring { target: f64, stiffness: f64, damping: f64 },
    /// A motion prescribed in time.
    Motion(PrescribedMotion),
}

impl Joint {
    /// A joint of a scene between bodies A and B, which are `bodies[a]` and `bodies[b]` with those rotations in the scene.
    pub fn of_spec(joint: &JointSpec, [a, b]: [usize; 2], given: [DQuat; 2], bodies: &[Body]) -> Self {
        let [frame_a, frame_b] = joint.axes.frames(given);
        // From the axes that the scene tells a body in to its principal ones.
        let turn = |body: usize, given: DQuat| bodies[body].rotation.inverse() * given;
        let (turn_a, turn_b) = (turn(a, given[0]), turn(b, given[1]));
        let rigid = Self {
            a,
            b,
            anchor_a: turn_a * joint.anchor_a,
            anchor_b: turn_b * joint.anchor_b,
            frame_a: (turn_a * frame_a).normalize(),
            frame_b: (turn_b * frame_b).normalize(),
            kind: joint.kind,
            limits: joint.limits,
            motor: None,
            collide: joint.collide,
        };
        let motor =
            joint.motor.map(|JointMotor { target, max_force }| Motor { drive: rigid.drive(target, bodies), max_force });
        Self { motor, ..rigid }
    }

    fn drive(&self, target: MotorTarget, bodies: &[Body]) -> Drive {
        match target {
            MotorTarget::Speed(speed) => Drive::Speed(speed),
            MotorTarget::Motion(motion) => Drive::Motion(motion),
            MotorTarget::Spring { target, stiffness, damping } => Drive::Spring { target, stiffness, damping },
            MotorTarget::Position { target, frequency, damping_ratio } => {
                let (inertia, omega) = (self.inertia_through_anchor(bodies), TAU * frequency);
                Drive::Spring {
                    target,
                    stiffness: inertia * omega * omega,
                    damping: 2.0 * damping_ratio * omega * inertia,
                }
            }
        }
    }

    /// The coordinate that limits and a motor act on; none where the joint has none, or its limits are of two.
    pub fn axis(&self) -> Option<JointAxis> {
        match self.kind {
            JointKindSpec::Hinge => Some(JointAxis::Twist),
            JointKindSpec::Slider => Some(JointAxis::X),
            JointKindSpec::Distance(_) => Some(JointAxis::Distance),
            JointKindSpec::Generic { axis, .. } => axis,
            JointKindSpec::Ball | JointKindSpec::Fixed => None,
        }
    }

    /// A and B, each with its anchor.
    fn ends(&self) -> [(usize, DVec3); 2] {
        [(self.a, self.anchor_a), (self.b, self.anchor_b)]
    }

    /// The axis at the start, in the world.
    fn axis_at_start(&self, bodies: &[Body]) -> DVec3 {
        bodies[self.a].rotation * (self.frame_a * DVec3::X)
    }

    /// Reduced inertia about the axis through the anchor, kg·m², or reduced mass, kg: of which Plumb's motors make their
    /// springs.
    fn inertia_through_anchor(&self, bodies: &[Body]) -> f64 {
        let along = self.axis_at_start(bodies);
        let is_angle = self.axis().is_some_and(JointAxis::is_angle);
        let inverse = |(body, anchor): (usize, DVec3)| {
            let Body { mass: Some(MassProperties { mass, inertia }), rotation, .. } = bodies[body] else { return 0.0 };
            let local = rotation.inverse() * along;
            let about_anchor = (inertia * local).dot(local) + mass * (rotation * anchor).cross(along).length_squared();
            if is_angle { about_anchor.recip() } else { mass.recip() }
        };
        self.ends().into_iter().map(inverse).sum::<f64>().recip()
    }

    /// The mass that the axis alone has at the start, all other coordinates being free, kg·m² or kg: of which Box3D and
    /// Avian make their springs.
    pub fn effective_mass(&self, bodies: &[Body]) -> f64 {
        let along = self.axis_at_start(bodies);
        let is_angle = self.axis().is_some_and(JointAxis::is_angle);
        let inverse = |(body, anchor): (usize, DVec3)| {
            let Body { mass: Some(MassProperties { mass, inertia }), rotation, .. } = bodies[body] else { return 0.0 };
            let lever = if is_angle { along } else { (rotation * anchor).cross(along) };
            let local = rotation.inverse() * lever;
            (local / inertia).dot(local) + if is_angle { 0.0 } else { mass.recip() }
        };
        self.ends().into_iter().map(inverse).sum::<f64>().recip()
    }

    /// B's frame in A's.
    fn turn(&self, a: DQuat, b: DQuat) -> DQuat {
        (a * self.frame_a).inverse() * (b * self.frame_b)
    }

    /// From A's anchor to B's along the axes of A's frame, m.
    fn apart(&self, a: &BodyState, b: &BodyState) -> DVec3 {
        let way = b.position + b.rotation * self.anchor_b - a.position - a.rotation * self.anchor_a;
        (a.rotation * self.frame_a).inverse() * way
    }

    /// The angle of a hinge, rad, the value nearest to `near`, or the distance along a slider, m.
    pub fn coordinate(&self, a: &BodyState, b: &BodyState, near: f64) -> f64 {
        if self.kind == JointKindSpec::Slider {
            return self.apart(a, b).x;
        }
        let turn = self.turn(a.rotation, b.rotation);
        let angle = 2.0 * turn.x.atan2(turn.w);
        angle - TAU * ((angle - near) / TAU).round()
    }

    /// The mean rate of a motion over a step, 1/s, with that share of what the coordinate lags behind made good in it.
    pub fn rate_along(
        &self,
        motion: &PrescribedMotion,
        [time, step]: [f64; 2],
        made_good: f64,
        states: [&BodyState; 2],
    ) -> f64 {
        let [now, ..] = motion.at_time(time);
        let [next, ..] = motion.at_time(time + step);
        let lag = now - self.coordinate(states[0], states[1], now);
        (next - now + made_good * lag) / step
    }

    /// How far its anchors are from where it holds them, m.
    pub fn separation(&self, states: &[BodyState]) -> f64 {
        let apart = self.apart(&states[self.a], &states[self.b]);
        let held = |held: [bool; 3]| DVec3::from_array(held.map(|held| f64::from(u8::from(held))));
        match self.kind {
            JointKindSpec::Ball | JointKindSpec::Hinge | JointKindSpec::Fixed => apart.length(),
            JointKindSpec::Slider => DVec3::new(0.0, apart.y, apart.z).length(),
            JointKindSpec::Generic { translations, .. } => (held(translations) * apart).length(),
            JointKindSpec::Distance(DistanceLaw::Range { min, max }) => {
                (min - apart.length()).max(apart.length() - max).max(0.0)
            }
            JointKindSpec::Distance(DistanceLaw::Spring { .. }) => 0.0,
        }
    }

    /// Least and largest angle or distance, for engines that know no turns: where a range has no end on one side, an
    /// angle's ends short of half a turn.
    pub fn range(&self) -> Option<[f64; 2]> {
        let LimitSpec { min, max, .. } = self.limits?;
        let is_angle = self.axis().is_none_or(JointAxis::is_angle);
        let most = if is_angle { MOST_ANGLE } else { f64::from(f32::MAX) };
        Some([min.max(-most), max.min(most)])
    }

    /// Whether its limits are of an angle that counts turns.
    pub fn limits_turns(&self) -> bool {
        let of_angle = |limits: &LimitSpec| {
            [limits.min, limits.max].iter().any(|bound| bound.is_finite() && bound.abs() > MOST_ANGLE)
        };
        self.axis().is_none_or(JointAxis::is_angle) && self.limits.as_ref().is_some_and(of_angle)
    }
}

/// As far as Box3D lets a limit reach, rad.
const MOST_ANGLE: f64 = 0.99 * PI;

/// Frequency, Hz, and damping ratio of a spring on that mass.
pub fn frequency_and_ratio(stiffness: f64, damping: f64, mass: f64) -> (f64, f64) {
    let omega = (stiffness / mass).sqrt();
    (omega / TAU, damping / (2.0 * mass * omega))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Scene;

    fn state(position: DVec3, rotation: DQuat) -> BodyState {
        BodyState { position, rotation, ..BodyState::default() }
    }

    #[test]
    fn a_hinges_angle_is_about_its_own_axis_and_the_nearest_turn() {
        let scene = Scene::parse("hinge_chain 1").unwrap();
        let (pivot, link) =
            (state(DVec3::ZERO, DQuat::IDENTITY), |angle| state(DVec3::ZERO, DQuat::from_rotation_z(angle)));
        let joint = &scene.joints[0];
        assert!((joint.coordinate(&pivot, &link(0.3), 0.0) - 0.3).abs() < 1e-12);
        assert!((joint.coordinate(&pivot, &link(0.3), 6.0) - 0.3 - TAU).abs() < 1e-12);
        // About an axis across, it is no angle of the hinge.
        let across = state(DVec3::ZERO, DQuat::from_rotation_x(0.3));
        assert!(joint.coordinate(&pivot, &across, 0.0).abs() < 1e-12);
    }

    #[test]
    fn what_a_joint_leaves_free_is_no_gap() {
        let scene = Scene::parse("car 1").unwrap();
        let states = scene.at_rest();
        let joint = scene.joints.iter().find(|joint| joint.kind == JointKindSpec::Slider).unwrap();
        assert!(joint.separation(&states) < 1e-12);
        let moved = |way: DVec3| {
            let mut moved = states.clone();
            moved[joint.b].position += way;
            joint.separation(&moved)
        };
        assert!(moved(0.1 * DVec3::Y) < 1e-12 && (moved(0.1 * DVec3::X) - 0.1).abs() < 1e-12);
    }

    #[test]
    fn a_servos_spring_is_that_of_the_rod_about_its_hinge() {
        // A rod of 1 m and 1 kg: (1 + 0.01)/12 + 1/4 kg·m² about its end, (1 + 0.01)/12 about its centre.
        let scene = Scene::parse("servo 2").unwrap();
        let (about_end, about_centre) = (1.01 / 12.0 + 0.25, 1.01 / 12.0);
        let joint = &scene.joints[0];
        let Some(Motor { drive: Drive::Spring { stiffness, damping, .. }, .. }) = joint.motor else {
            panic!("{joint:?}")
        };
        assert!((stiffness - about_end * (2.0 * TAU).powi(2)).abs() < 1e-9, "{stiffness}");
        assert!((joint.effective_mass(&scene.bodies) - about_centre).abs() < 1e-12);
        let (frequency, ratio) = frequency_and_ratio(stiffness, damping, about_end);
        assert!((frequency - 2.0).abs() < 1e-12 && (ratio - 1.0).abs() < 1e-12);
    }
}
