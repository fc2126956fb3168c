//! Laws of single coordinates, each one row: limits, motors, springs, friction.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use super::motion::PrescribedMotion;

/// A coordinate of frame B seen from frame A.
#[derive(Reflect, Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum JointAxis {
    /// Translation along A's x, m.
    X,
    /// Translation along A's y, m.
    Y,
    /// Translation along A's z, m.
    Z,
    /// Twist about x, rad.
    Twist,
    /// Angle between A's x and B's x, rad, 0 to π.
    Swing,
    /// Distance of the anchors, m.
    Distance,
}

impl JointAxis {
    /// Whether it is an angle, rad.
    pub fn is_angle(self) -> bool {
        matches!(self, Self::Twist | Self::Swing)
    }
}

/// One row along one coordinate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct CoordinateLaw {
    pub axis: LawAxis,
    pub part: LawPart,
    /// Largest |λ|, N or N·m; may be infinite. Limits have none.
    pub most: f64,
}

/// What a law is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum LawAxis {
    Coordinate(JointAxis),
    /// Turning about x, y or z of A, of which there is a rate alone.
    Turning(usize),
}

/// What it asks of the coordinate q.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum LawPart {
    /// q is at most, or at least, `bound`; e.
    Limit { bound: f64, is_upper: bool, restitution: f64 },
    /// q̇ is that rate; at 0 with a largest force it is friction.
    Rate(f64),
    /// q is that function of time.
    Motion(PrescribedMotion),
    /// λ = −stiffness (q − rest) − damping q̇.
    Spring { rest: f64, stiffness: f64, damping: f64 },
}

impl CoordinateLaw {
    /// With any force.
    pub fn new(axis: JointAxis, part: LawPart) -> Self {
        Self { axis: LawAxis::Coordinate(axis), part, most: f64::INFINITY }
    }

    /// The limits of a range; those at infinity are none.
    pub fn range(axis: JointAxis, bounds: [f64; 2], restitution: f64) -> impl Iterator<Item = Self> {
        let limit = move |(is_upper, bound): (bool, f64)| {
            bound.is_finite().then(|| Self::new(axis, LawPart::Limit { bound, is_upper, restitution }))
        };
        [false, true].into_iter().zip(bounds).filter_map(limit)
    }

    /// Whether its row changes with time alone.
    pub fn is_driven(&self) -> bool {
        match self.part {
            LawPart::Rate(rate) => rate != 0.0,
            LawPart::Motion(motion) => !matches!(motion, PrescribedMotion::Ramp { rate: 0.0, .. }),
            LawPart::Limit { .. } | LawPart::Spring { .. } => false,
        }
    }

    /// The coordinate that it is of.
    pub fn coordinate(&self) -> Option<JointAxis> {
        match self.axis {
            LawAxis::Coordinate(axis) => Some(axis),
            LawAxis::Turning(_) => None,
        }
    }

    /// Whether it may lag behind a place that it is to keep, and then do work on its way there.
    pub fn may_lag(&self) -> bool {
        matches!(self.part, LawPart::Motion(_)) && self.most < f64::INFINITY
    }

    /// Whether it is a spring.
    pub fn is_spring(&self) -> bool {
        matches!(self.part, LawPart::Spring { .. })
    }

    /// Whether laws are of the same kinds along the same coordinates, and differ in numbers alone.
    pub fn is_alike(&self, other: &Self) -> bool {
        self.axis == other.axis
            && std::mem::discriminant(&self.part) == std::mem::discriminant(&other.part)
            && self.most.is_finite() == other.most.is_finite()
            && self.is_driven() == other.is_driven()
    }
}
