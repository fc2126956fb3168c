//! Joints in a scene file: what stands there, and how it is read and written.

use std::ops::Not;

use bevy::math::DVec3;
use serde::{Deserialize, Serialize};

use super::usual::{USUAL_DAMPING_RATIO, unless_same};
use crate::physics::{
    Breakable, BrokenJoint, DistanceLaw, JointAxes, JointAxis, JointMotor, MotorTarget, PrescribedMotion, Softness,
};
use crate::scene::number::{Finite, Fraction, NonNegative, Positive, Quaternion, Vector};
use crate::scene::{JointKindSpec, JointSpec, LimitSpec, MotorKeys};

#[derive(Serialize, Deserialize)]
#[serde(rename = "Joint", deny_unknown_fields)]
pub(super) struct JointEntry {
    pub body_a: String,
    pub body_b: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at: Option<Vector>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub anchor_a: Option<Vector>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub anchor_b: Option<Vector>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub kind: Option<KindEntry>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub axis: Option<Vector>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub axes: Option<(Vector, Vector)>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frames: Option<(Quaternion, Quaternion)>,
    #[serde(default, skip_serializing_if = "Not::not")]
    pub collide: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub softness: Option<SoftnessEntry>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub limits: Option<LimitsEntry>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub motor: Option<MotorEntry>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub friction: Option<NonNegative>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub breakable: Option<BreakableEntry>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub broken: Option<BrokenEntry>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub coordinate: Option<Finite>,
}

#[derive(Serialize, Deserialize)]
#[serde(rename = "Kind", deny_unknown_fields)]
pub(super) enum KindEntry {
    Ball,
    Hinge,
    Slider,
    Fixed,
    Rod {
        length: Positive,
    },
    Distance {
        #[serde(skip_serializing_if = "Option::is_none")]
        min: Option<NonNegative>,
        #[serde(skip_serializing_if = "Option::is_none")]
        max: Option<NonNegative>,
    },
    Spring {
        rest: NonNegative,
        stiffness: NonNegative,
        #[serde(skip_serializing_if = "Option::is_none")]
        damping: Option<NonNegative>,
    },
    Generic {
        #[serde(default)]
        translations: (bool, bool, bool),
        #[serde(default)]
        rotations: (bool, bool, bool),
        #[serde(skip_serializing_if = "Option::is_none")]
        axis: Option<JointAxis>,
    },
}

#[derive(Serialize, Deserialize)]
#[serde(rename = "Softness", deny_unknown_fields)]
pub(super) struct SoftnessEntry {
    pub frequency: Positive,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub damping_ratio: Option<NonNegative>,
    pub max_force: Positive,
}

#[derive(Serialize, Deserialize)]
#[serde(rename = "Limits", deny_unknown_fields)]
pub(super) struct LimitsEntry {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub swing: Option<Positive>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub min: Option<Finite>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max: Option<Finite>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub restitution: Option<Fraction>,
}

#[derive(Serialize, Deserialize)]
#[serde(rename = "Motor", deny_unknown_fields)]
pub(super) struct MotorEntry {
    pub target: TargetEntry,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_force: Option<NonNegative>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub keys: Option<KeysEntry>,
}

#[derive(Serialize, Deserialize)]
#[serde(rename = "Target", deny_unknown_fields)]
pub(super) enum TargetEntry {
    Speed(Finite),
    Position { target: Finite, frequency: Positive, damping_ratio: NonNegative },
    Spring { target: Finite, stiffness: NonNegative, damping: NonNegative },
    Ramp { from: Finite, rate: Finite },
    Sine { mean: Finite, amplitude: Finite, angular_frequency: Finite, phase: Finite },
    Course { at: Finite, position: Finite, velocity: Finite, acceleration: Finite },
}

#[derive(Serialize, Deserialize)]
#[serde(rename = "Keys", deny_unknown_fields)]
pub(super) struct KeysEntry {
    pub forward: String,
    pub back: String,
    pub values: (Finite, Finite),
}

#[derive(Serialize, Deserialize)]
#[serde(rename = "Breakable", deny_unknown_fields)]
pub(super) struct BreakableEntry {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub force: Option<Positive>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub torque: Option<Positive>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub window: Option<NonNegative>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub from: Option<NonNegative>,
}

#[derive(Serialize, Deserialize)]
#[serde(rename = "Broken", deny_unknown_fields)]
pub(super) struct BrokenEntry {
    pub apart: bool,
}

/// A number, or infinity where none is given.
fn or_infinite<N: Into<f64>>(number: Option<N>) -> f64 {
    number.map_or(f64::INFINITY, N::into)
}

/// A number unless it is infinite.
fn finite<N>(number: f64, of_valid: fn(f64) -> N) -> Option<N> {
    number.is_finite().then(|| of_valid(number))
}

impl JointEntry {
    /// All but where it is.
    pub fn into_joint(self, joint: JointSpec) -> Result<JointSpec, (&'static str, &'static str)> {
        let axes = match (self.axis, self.axes, self.frames) {
            (None, None, None) => joint.axes,
            (Some(axis), None, None) => JointAxes::World(axis.into()),
            (None, Some((a, b)), None) => JointAxes::Bodies(a.into(), b.into()),
            (None, None, Some((a, b))) => JointAxes::Frames(a.into(), b.into()),
            _ => return Err(("axis", "give one of 'axis', 'axes' and 'frames'")),
        };
        let kind = self.kind.map_or(JointKindSpec::Ball, JointKindSpec::from);
        let limits = self.limits.map(|limits| LimitSpec {
            swing: (kind == JointKindSpec::Ball || limits.swing.is_some()).then(|| or_infinite(limits.swing)),
            min: limits.min.map_or(f64::NEG_INFINITY, f64::from),
            max: or_infinite(limits.max),
            restitution: limits.restitution.map_or(0.0, f64::from),
        });
        let keys = self.motor.as_ref().and_then(|motor| {
            let KeysEntry { forward, back, values } = motor.keys.as_ref()?;
            let rest = MotorTarget::from(&motor.target).value().unwrap_or(0.0);
            let keys = [forward.clone(), back.clone()];
            Some(MotorKeys { keys, values: [values.0.into(), values.1.into()], rest })
        });
        let motor = self.motor.map(|MotorEntry { target, max_force, .. }| JointMotor {
            target: (&target).into(),
            max_force: or_infinite(max_force),
        });
        Ok(JointSpec {
            kind,
            axes,
            collide: self.collide,
            softness: self.softness.map(Softness::from),
            limits,
            motor,
            keys,
            friction: self.friction.map_or(0.0, f64::from),
            breakable: self.breakable.map(Breakable::from),
            broken: self.broken.map(|BrokenEntry { apart }| BrokenJoint { apart }),
            coordinate: self.coordinate.map_or(0.0, f64::from),
            ..joint
        })
    }

    /// Of a joint between bodies that are called so, at those anchors.
    pub fn of(joint: &JointSpec, [body_a, body_b]: [String; 2], [anchor_a, anchor_b]: [DVec3; 2]) -> Self {
        let usual = JointAxes::World(DVec3::X);
        let (axis, axes, frames) = match joint.axes {
            axes if axes == usual => (None, None, None),
            JointAxes::World(axis) => (Some(axis.into()), None, None),
            JointAxes::Bodies(a, b) => (None, Some((a.into(), b.into())), None),
            JointAxes::Frames(a, b) => (None, None, Some((a.into(), b.into()))),
        };
        let keys = joint.keys.as_ref().map(|MotorKeys { keys: [forward, back], values: [ahead, behind], .. }| {
            let values = (Finite::of_valid(*ahead), Finite::of_valid(*behind));
            KeysEntry { forward: forward.clone(), back: back.clone(), values }
        });
        let motor = joint.motor.map(|JointMotor { target, max_force }| MotorEntry {
            target: target.into(),
            max_force: finite(max_force, NonNegative::of_valid),
            keys,
        });
        Self {
            body_a,
            body_b,
            at: None,
            anchor_a: Some(anchor_a.into()),
            anchor_b: Some(anchor_b.into()),
            kind: (joint.kind != JointKindSpec::Ball).then(|| joint.kind.into()),
            axis,
            axes,
            frames,
            collide: joint.collide,
            softness: joint.softness.map(SoftnessEntry::from),
            limits: joint.limits.map(LimitsEntry::from),
            motor,
            friction: unless_same(joint.friction, 0.0).map(NonNegative::of_valid),
            breakable: joint.breakable.map(BreakableEntry::from),
            broken: joint.broken.map(|BrokenJoint { apart }| BrokenEntry { apart }),
            coordinate: unless_same(joint.coordinate, 0.0).map(Finite::of_valid),
        }
    }
}

impl From<SoftnessEntry> for Softness {
    fn from(entry: SoftnessEntry) -> Self {
        Self {
            frequency: entry.frequency.into(),
            damping_ratio: entry.damping_ratio.map_or(USUAL_DAMPING_RATIO, f64::from),
            max_force: entry.max_force.into(),
        }
    }
}

impl From<Softness> for SoftnessEntry {
    fn from(softness: Softness) -> Self {
        Self {
            frequency: Positive::of_valid(softness.frequency),
            damping_ratio: unless_same(softness.damping_ratio, USUAL_DAMPING_RATIO).map(NonNegative::of_valid),
            max_force: Positive::of_valid(softness.max_force),
        }
    }
}

impl From<KindEntry> for JointKindSpec {
    fn from(entry: KindEntry) -> Self {
        match entry {
            KindEntry::Ball => Self::Ball,
            KindEntry::Hinge => Self::Hinge,
            KindEntry::Slider => Self::Slider,
            KindEntry::Fixed => Self::Fixed,
            KindEntry::Rod { length } => {
                let length = f64::from(length);
                Self::Distance(DistanceLaw::Range { min: length, max: length })
            }
            KindEntry::Distance { min, max } => {
                Self::Distance(DistanceLaw::Range { min: min.map_or(0.0, f64::from), max: or_infinite(max) })
            }
            KindEntry::Spring { rest, stiffness, damping } => Self::Distance(DistanceLaw::Spring {
                rest: rest.into(),
                stiffness: stiffness.into(),
                damping: damping.map_or(0.0, f64::from),
            }),
            KindEntry::Generic { translations, rotations, axis } => {
                Self::Generic { translations: translations.into(), rotations: rotations.into(), axis }
            }
        }
    }
}

impl From<JointKindSpec> for KindEntry {
    fn from(kind: JointKindSpec) -> Self {
        match kind {
            JointKindSpec::Ball => Self::Ball,
            JointKindSpec::Hinge => Self::Hinge,
            JointKindSpec::Slider => Self::Slider,
            JointKindSpec::Fixed => Self::Fixed,
            JointKindSpec::Distance(DistanceLaw::Range { min, max }) if min == max => {
                Self::Rod { length: Positive::of_valid(min) }
            }
            JointKindSpec::Distance(DistanceLaw::Range { min, max }) => Self::Distance {
                min: unless_same(min, 0.0).map(NonNegative::of_valid),
                max: finite(max, NonNegative::of_valid),
            },
            JointKindSpec::Distance(DistanceLaw::Spring { rest, stiffness, damping }) => Self::Spring {
                rest: NonNegative::of_valid(rest),
                stiffness: NonNegative::of_valid(stiffness),
                damping: unless_same(damping, 0.0).map(NonNegative::of_valid),
            },
            JointKindSpec::Generic { translations, rotations, axis } => {
                Self::Generic { translations: translations.into(), rotations: rotations.into(), axis }
            }
        }
    }
}

impl From<LimitSpec> for LimitsEntry {
    fn from(limits: LimitSpec) -> Self {
        Self {
            swing: limits.swing.and_then(|swing| finite(swing, Positive::of_valid)),
            min: finite(limits.min, Finite::of_valid),
            max: finite(limits.max, Finite::of_valid),
            restitution: unless_same(limits.restitution, 0.0).map(Fraction::of_valid),
        }
    }
}

impl From<&TargetEntry> for MotorTarget {
    fn from(entry: &TargetEntry) -> Self {
        match *entry {
            TargetEntry::Speed(speed) => Self::Speed(speed.into()),
            TargetEntry::Position { target, frequency, damping_ratio } => Self::Position {
                target: target.into(),
                frequency: frequency.into(),
                damping_ratio: damping_ratio.into(),
            },
            TargetEntry::Spring { target, stiffness, damping } => {
                Self::Spring { target: target.into(), stiffness: stiffness.into(), damping: damping.into() }
            }
            TargetEntry::Ramp { from, rate } => {
                Self::Motion(PrescribedMotion::Ramp { from: from.into(), rate: rate.into() })
            }
            TargetEntry::Sine { mean, amplitude, angular_frequency, phase } => Self::Motion(PrescribedMotion::Sine {
                mean: mean.into(),
                amplitude: amplitude.into(),
                angular_frequency: angular_frequency.into(),
                phase: phase.into(),
            }),
            TargetEntry::Course { at, position, velocity, acceleration } => Self::Motion(PrescribedMotion::Course {
                at: at.into(),
                position: position.into(),
                velocity: velocity.into(),
                acceleration: acceleration.into(),
            }),
        }
    }
}

impl From<MotorTarget> for TargetEntry {
    fn from(target: MotorTarget) -> Self {
        let number = Finite::of_valid;
        match target {
            MotorTarget::Speed(speed) => Self::Speed(number(speed)),
            MotorTarget::Position { target, frequency, damping_ratio } => Self::Position {
                target: number(target),
                frequency: Positive::of_valid(frequency),
                damping_ratio: NonNegative::of_valid(damping_ratio),
            },
            MotorTarget::Spring { target, stiffness, damping } => Self::Spring {
                target: number(target),
                stiffness: NonNegative::of_valid(stiffness),
                damping: NonNegative::of_valid(damping),
            },
            MotorTarget::Motion(PrescribedMotion::Ramp { from, rate }) => {
                Self::Ramp { from: number(from), rate: number(rate) }
            }
            MotorTarget::Motion(PrescribedMotion::Sine { mean, amplitude, angular_frequency, phase }) => Self::Sine {
                mean: number(mean),
                amplitude: number(amplitude),
                angular_frequency: number(angular_frequency),
                phase: number(phase),
            },
            MotorTarget::Motion(PrescribedMotion::Course { at, position, velocity, acceleration }) => Self::Course {
                at: number(at),
                position: number(position),
                velocity: number(velocity),
                acceleration: number(acceleration),
            },
        }
    }
}

impl From<BreakableEntry> for Breakable {
    fn from(entry: BreakableEntry) -> Self {
        let usual = Self::at_force(or_infinite(entry.force));
        Self {
            torque: or_infinite(entry.torque),
            window: entry.window.map_or(usual.window, f64::from),
            from: entry.from.map_or(usual.from, f64::from),
            ..usual
        }
    }
}

impl From<Breakable> for BreakableEntry {
    fn from(breakable: Breakable) -> Self {
        let usual = Breakable::at_force(breakable.force);
        Self {
            force: finite(breakable.force, Positive::of_valid),
            torque: finite(breakable.torque, Positive::of_valid),
            window: unless_same(breakable.window, usual.window).map(NonNegative::of_valid),
            from: unless_same(breakable.from, usual.from).map(NonNegative::of_valid),
        }
    }
}
