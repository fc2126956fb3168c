//! Components that stand beside a joint on its entity: limits, a motor, friction, and the coordinate that they act on.

use bevy::prelude::*;

use super::axes::JointAxes;
use super::motion::PrescribedMotion;

/// How far a joint may go. On a hinge, a slider, a distance joint or a generic joint with an axis of its own; a ball
/// joint takes [`LimitRange::SwingTwist`].
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component, Debug, PartialEq)]
pub struct JointLimits {
    /// What it may be.
    pub range: LimitRange,
    /// e, 0 to 1: share of the speed at which a limit is met that the joint goes back with, where that speed is over
    /// 0.5 rad/s, or [`SolverSettings::restitution_speed`](crate::physics::SolverSettings::restitution_speed) where
    /// that is less.
    pub restitution: f64,
}

/// What a joint's coordinate may be.
#[derive(Reflect, Clone, Copy, Debug, PartialEq)]
pub enum LimitRange {
    /// Of the angle of a hinge, rad, unwrapped over turns, or of a distance, m.
    Range {
        /// Least.
        min: f64,
        /// Largest.
        max: f64,
    },
    /// Of a ball joint. Zero is where the frames agree: B's x may swing away from A's x, and B may twist about its x.
    SwingTwist {
        /// Largest swing, rad, over 0 and under π.
        swing: f64,
        /// Least twist, rad, over −π.
        min: f64,
        /// Largest twist, rad, under π.
        max: f64,
        /// The frames, whose x is the axis.
        axes: JointAxes,
    },
}

impl JointLimits {
    /// Between two angles, rad, or distances, m, without restitution.
    pub fn range(min: f64, max: f64) -> Self {
        Self { range: LimitRange::Range { min, max }, restitution: 0.0 }
    }

    /// A largest swing and a range of twists, rad, about an axis of the world, without restitution.
    pub fn swing_twist(swing: f64, [min, max]: [f64; 2], axes: JointAxes) -> Self {
        Self { range: LimitRange::SwingTwist { swing, min, max, axes }, restitution: 0.0 }
    }

    /// Sets the restitution.
    pub fn with_restitution(self, restitution: f64) -> Self {
        Self { restitution, ..self }
    }
}

/// Drives a joint along its axis.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component, Debug, PartialEq)]
pub struct JointMotor {
    /// Where to.
    pub target: MotorTarget,
    /// Largest force, N, or torque, N·m; may be infinite.
    pub max_force: f64,
}

/// What a motor makes of its joint's coordinate.
#[derive(Reflect, Clone, Copy, Debug, PartialEq)]
pub enum MotorTarget {
    /// That rate, rad/s or m/s.
    Speed(f64),
    /// That value, by a damped spring whose stiffness comes from the bodies' inertias about the axis through the anchor
    /// (what cannot move counts as infinite), computed when the motor is made or changed.
    Position {
        /// rad or m.
        target: f64,
        /// Undamped, Hz.
        frequency: f64,
        /// ζ; 1 is critical.
        damping_ratio: f64,
    },
    /// That value, by a damped spring.
    Spring {
        /// rad or m.
        target: f64,
        /// N·m/rad or N/m.
        stiffness: f64,
        /// N·m·s/rad or N·s/m.
        damping: f64,
    },
    /// A motion prescribed in time.
    Motion(PrescribedMotion),
}

impl MotorTarget {
    /// The speed or the position that it is.
    pub fn value(&self) -> Option<f64> {
        match *self {
            Self::Speed(target) | Self::Position { target, .. } | Self::Spring { target, .. } => Some(target),
            Self::Motion(_) => None,
        }
    }

    /// The same to another speed or position.
    pub fn with_value(self, value: f64) -> Self {
        match self {
            Self::Speed(_) => Self::Speed(value),
            Self::Position { frequency, damping_ratio, .. } => {
                Self::Position { target: value, frequency, damping_ratio }
            }
            Self::Spring { stiffness, damping, .. } => Self::Spring { target: value, stiffness, damping },
            Self::Motion(_) => self,
        }
    }
}

impl JointMotor {
    /// To a target, whatever force that takes.
    pub fn new(target: MotorTarget) -> Self {
        Self { target, max_force: f64::INFINITY }
    }

    /// Bounds its force, N, or torque, N·m.
    pub fn with_max_force(self, max_force: f64) -> Self {
        Self { max_force, ..self }
    }
}

/// Dry friction of a joint along its axis: a force, N, or torque, N·m, against its motion. On a ball joint, about each
/// of A's axes.
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Component, Debug, Default, PartialEq)]
pub struct JointFriction(pub f64);

/// Where a joint stands along its axis, filled in after each step: hinges and generic joints have it, others where it is
/// added. Of a hinge it is the angle over all turns, which is state: it is saved with a scene, and setting it sets the
/// turns.
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Component, Debug, Default, PartialEq)]
pub struct JointCoordinate {
    /// Angle, rad, or distance, m.
    pub value: f64,
    /// rad/s or m/s.
    pub rate: f64,
}
