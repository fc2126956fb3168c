//! Pairs in which a body may move farther in a step than it is thick.

use std::f64::consts::TAU;

use nalgebra::{UnitQuaternion, Vector3};

use super::time_of_impact::advanced;
use crate::physics::collision::manifold::PartPair;
use crate::physics::{Body, Pair};

/// State of a body at the start of the step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Start {
    position: Vector3<f64>,
    rotation: UnitQuaternion<f64>,
    linear: Vector3<f64>,
    angular: Vector3<f64>,
}

impl Start {
    pub fn of(&Body { position, rotation, linear, angular, .. }: &Body) -> Self {
        Self { position, rotation, linear, angular }
    }

    /// Somewhere, with no velocity that is known.
    pub fn at(position: Vector3<f64>, rotation: UnitQuaternion<f64>) -> Self {
        Self { position, rotation, linear: Vector3::zeros(), angular: Vector3::zeros() }
    }

    /// The centre of mass after a time, s.
    pub fn after(&self, time: f64) -> Vector3<f64> {
        self.position + self.linear * time
    }

    /// The body at a time, with the constant velocities that take it to where it is now, a time `left` later.
    pub fn path_to(&self, body: &Body, time: f64, left: f64) -> Body {
        let Self { position, rotation, linear, angular } = *self;
        let (position, rotation) = advanced(&Body { position, rotation, linear, angular, ..body.clone() }, time);
        let mut turn = (body.rotation * rotation.inverse()).scaled_axis();
        // Of all turns between the two poses the one nearest to what the angular velocity makes.
        if let Some(axis) = turn.try_normalize(1e-9) {
            let missing = body.angular.dot(&axis) * left - turn.norm();
            turn += axis * ((missing / TAU).round() * TAU);
        }
        let linear = (body.position - position) / left;
        Body { position, rotation, linear, angular: turn / left, ..body.clone() }
    }
}

/// A pair in which a body may move farther than it is thick.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FastPair {
    pub pair: Pair,
    pub parts: PartPair,
    pub starts: [Start; 2],
    /// Which of the two are fast.
    pub fast: [bool; 2],
    /// When they meet if neither meets anything before, s.
    pub impact: Option<f64>,
}

impl FastPair {
    pub fn new(pair: Pair, parts: PartPair, [a, b]: [&Body; 2], fast: [bool; 2], impact: Option<f64>) -> Self {
        Self { pair, parts, starts: [Start::of(a), Start::of(b)], fast, impact }
    }
}
