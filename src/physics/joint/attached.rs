//! From the components beside a joint to the laws that they are.

use std::f64::consts::{PI, TAU};

use bevy::prelude::*;
use nalgebra::Vector3;

use super::attachments::{JointFriction, JointLimits, JointMotor, LimitRange, MotorTarget};
use super::axes::JointAxes;
use super::definition::{Frame, JointDefinition};
use super::law::{CoordinateLaw, JointAxis, LawAxis, LawPart};
use crate::physics::body::{Body, QuarantineReason, RigidBody, world_inverse_inertia};

/// The components of a joint's entity that stand for laws.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Attached<'a> {
    pub limits: Option<&'a JointLimits>,
    pub motor: Option<&'a JointMotor>,
    pub friction: Option<&'a JointFriction>,
}

impl Attached<'_> {
    /// The definition of a joint between those bodies with the laws of these components, the stiffness of motors from
    /// inertias.
    ///
    /// # Errors
    /// The joint has no such coordinate, or a number makes no sense.
    pub fn attach(&self, joint: &JointDefinition, bodies: [&Body; 2]) -> Result<JointDefinition, QuarantineReason> {
        let mut whole = joint.clone();
        let mut laws: Vec<CoordinateLaw> = joint.laws.iter().flat_map(|laws| laws.iter().copied()).collect();
        if let Some(limits) = self.limits {
            self.add_limits(limits, &mut whole, bodies, &mut laws)?;
        }
        if let Some(motor) = self.motor {
            let axis = joint.axis.ok_or(QuarantineReason::NoSuchAxis)?;
            let part = motor_part(motor, || inertia_along(joint, axis, bodies));
            laws.push(CoordinateLaw { most: motor.max_force, ..CoordinateLaw::new(axis, part) });
        }
        if let Some(&JointFriction(most)) = self.friction.filter(|friction| friction.0 != 0.0) {
            let law = |axis| CoordinateLaw { axis, part: LawPart::Rate(0.0), most };
            match joint.axis {
                Some(axis) => laws.push(law(LawAxis::Coordinate(axis))),
                None if joint.is_ball() => laws.extend((0..3).map(|axis| law(LawAxis::Turning(axis)))),
                None => return Err(QuarantineReason::NoSuchAxis),
            }
        }
        if !laws.iter().all(is_valid) {
            return Err(QuarantineReason::BadJointLaw);
        }
        whole.laws = if laws.is_empty() { None } else { Some(laws.into()) };
        Ok(whole)
    }

    fn add_limits(
        &self,
        limits: &JointLimits,
        joint: &mut JointDefinition,
        bodies: [&Body; 2],
        laws: &mut Vec<CoordinateLaw>,
    ) -> Result<(), QuarantineReason> {
        let restitution = limits.restitution;
        match limits.range {
            LimitRange::Range { min, max } => {
                let axis = joint.axis.ok_or(QuarantineReason::NoSuchAxis)?;
                let is_range = min <= max;
                if !is_range || !(0.0..=1.0).contains(&restitution) {
                    return Err(QuarantineReason::BadJointLaw);
                }
                laws.extend(CoordinateLaw::range(axis, [min, max], restitution));
            }
            LimitRange::SwingTwist { swing, min, max, axes } => {
                if !joint.is_ball() {
                    return Err(QuarantineReason::NoSuchAxis);
                }
                // What is infinite is no limit.
                let is_twist = |angle: f64| angle.abs() < PI || angle.is_infinite();
                let is_swing = 0.0 < swing && (swing < PI || swing == f64::INFINITY);
                let is_range = is_twist(min) && is_twist(max) && min <= max && is_swing;
                if !is_range || !axes.is_valid() || !(0.0..=1.0).contains(&restitution) {
                    return Err(QuarantineReason::BadJointLaw);
                }
                set_axes(joint, &axes, bodies);
                laws.extend(CoordinateLaw::range(JointAxis::Twist, [min, max], restitution));
                laws.extend(CoordinateLaw::range(JointAxis::Swing, [f64::NEG_INFINITY, swing], restitution));
            }
        }
        Ok(())
    }
}

/// Gives a joint's frames those axes, its anchors as they are.
fn set_axes(joint: &mut JointDefinition, axes: &JointAxes, bodies: [&Body; 2]) {
    let rotations = axes.rotations(bodies.map(|body| body.rotation.into()));
    let [a, b] = joint.frames.map(|frame| frame.anchor);
    joint.frames = [Frame { anchor: a, rotation: rotations[0] }, Frame { anchor: b, rotation: rotations[1] }];
}

fn motor_part(motor: &JointMotor, inertia: impl Fn() -> f64) -> LawPart {
    match motor.target {
        MotorTarget::Speed(speed) => LawPart::Rate(speed),
        MotorTarget::Motion(motion) => LawPart::Motion(motion),
        MotorTarget::Spring { target, stiffness, damping } => LawPart::Spring { rest: target, stiffness, damping },
        MotorTarget::Position { target, frequency, damping_ratio } => {
            let (inertia, omega) = (inertia(), TAU * frequency);
            let (stiffness, damping) = (inertia * omega * omega, 2.0 * damping_ratio * omega * inertia);
            LawPart::Spring { rest: target, stiffness, damping }
        }
    }
}

/// What a coordinate moves: the reduced mass of both bodies, kg, or, of an angle, the reduced inertia about the axis
/// through the anchor, kg·m².
fn inertia_along(joint: &JointDefinition, axis: JointAxis, bodies: [&Body; 2]) -> f64 {
    let along = bodies[0].rotation * (joint.frames[0].rotation * Vector3::x());
    let inverse = |body: &Body, anchor: &Vector3<f64>| {
        if body.kind != RigidBody::Dynamic {
            return 0.0;
        }
        if !axis.is_angle() {
            return 1.0 / body.mass;
        }
        let turn = world_inverse_inertia(&body.inverse_inertia_body, &body.rotation, &body.rotation_freedom);
        let own = turn.try_inverse().map_or(0.0, |inertia| along.dot(&(inertia * along)));
        let arm = body.rotation * anchor;
        1.0 / (own + body.mass * arm.cross(&along).norm_squared())
    };
    let sum: f64 = (0..2).map(|body| inverse(bodies[body], &joint.frames[body].anchor)).sum();
    if sum > 0.0 { 1.0 / sum } else { 0.0 }
}

fn is_valid(law: &CoordinateLaw) -> bool {
    let is_part_valid = match law.part {
        LawPart::Limit { bound, .. } => bound.is_finite(),
        LawPart::Rate(rate) => rate.is_finite(),
        LawPart::Motion(motion) => motion.is_finite(),
        LawPart::Spring { rest, stiffness, damping } => {
            rest.is_finite() && [stiffness, damping].iter().all(|number| *number >= 0.0 && number.is_finite())
        }
    };
    is_part_valid && law.most >= 0.0
}
