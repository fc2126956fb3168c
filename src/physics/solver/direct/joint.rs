//! The rows of a point held at a point, the relative velocity u of a joint's anchors, rigid or as a spring. What other
//! joints hold is in [`super::any_joint`].

use nalgebra::{Matrix3, Vector3};

use super::rows::{Correction, RowBlocks, RowKey, Rows, Side, Stiffness, bits, isotropic};
use crate::physics::collision::POINTS;
use crate::physics::constraint::row::{Twist, Wrench, bounded};

/// A soft joint: λ = −W (u + b), its norm within a limit.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct SoftLaw {
    /// W, N·s over m/s.
    pub stiffness: Matrix3<f64>,
    /// b, m/s.
    pub bias: Vector3<f64>,
    /// Largest norm, N·s.
    pub limit: f64,
    /// Whether the impulse is the largest it may be, and which it is then.
    is_saturated: bool,
    impulse: Vector3<f64>,
}

impl SoftLaw {
    pub fn new(stiffness: Matrix3<f64>, bias: Vector3<f64>, limit: f64) -> Self {
        Self { stiffness, bias, limit, ..Self::default() }
    }

    /// Takes over from the substep before whether the impulse is the largest it may be.
    pub fn resume(&mut self, before: &Self) {
        (self.is_saturated, self.impulse) = (before.is_saturated, before.impulse);
    }

    fn trial(&self, motion: &Twist<f64>) -> Vector3<f64> {
        -(self.stiffness * (motion.linear + self.bias))
    }

    /// Within the limit, whatever was assumed.
    fn bounded(&self, motion: &Twist<f64>) -> Vector3<f64> {
        bounded(self.trial(motion), self.limit)
    }

    /// See [`Rows::take`].
    fn take(&mut self, motion: &Twist<f64>, tolerance: f64) -> bool {
        let (was_saturated, before) = (self.is_saturated, self.impulse);
        self.is_saturated = self.trial(motion).norm() > self.limit;
        self.impulse = self.bounded(motion);
        self.is_saturated == was_saturated && (!was_saturated || (self.impulse - before).amax() <= tolerance)
    }
}

/// A joint that holds a point at a point.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct DirectJoint {
    pub sides: [Side; 2],
    pub prescribed: Twist<f64>,
    /// Anchor of B less anchor of A, m.
    pub separation: Vector3<f64>,
    /// λ̂.
    pub expected: Vector3<f64>,
    /// λ on B.
    pub impulse: Vector3<f64>,
    /// Impulse over speed of its rows where it is rigid, kg.
    pub penalty: f64,
    /// None: rigid.
    pub softness: Option<SoftLaw>,
}

impl DirectJoint {
    /// The impulse expected.
    pub fn expected(&self) -> Wrench<f64> {
        Wrench { linear: self.expected, angular: Vector3::zeros() }
    }

    /// Expects a share of what it did.
    pub fn expect_share(&mut self, share: f64) {
        self.expected *= share;
    }

    /// Impulse on B at a motion, with what is assumed of a soft joint.
    fn trial(&self, motion: &Twist<f64>) -> Vector3<f64> {
        match &self.softness {
            None => self.expected - motion.linear * self.penalty,
            Some(soft) if soft.is_saturated => soft.impulse,
            Some(soft) => soft.trial(motion),
        }
    }
}

impl Rows for DirectJoint {
    fn sides(&self) -> &[Side; 2] {
        &self.sides
    }

    fn prescribed(&self) -> &Twist<f64> {
        &self.prescribed
    }

    fn key(&self) -> RowKey {
        let none = Vector3::zeros();
        RowKey {
            penalty: self.penalty,
            friction: 0.0,
            arms: self.sides.map(|side| side.arm),
            normal: none,
            levers: [none; POINTS],
            active: bits([self.softness.is_none_or(|soft| !soft.is_saturated)]),
            across: [0.0; 2],
            is_soft: self.softness.is_some(),
            revision: 0,
        }
    }

    fn blocks(&self, blocks: &mut RowBlocks) {
        match &self.softness {
            None => blocks.set_at_arms(&self.sides, |x, y| isotropic(self.penalty, x, y)),
            Some(soft) if soft.is_saturated => *blocks = RowBlocks::default(),
            Some(soft) => {
                let stiffness = Stiffness { uu: soft.stiffness, uw: Matrix3::zeros(), ww: Matrix3::zeros() };
                blocks.set_at_arms(&self.sides, |x, y| stiffness.between(x, y));
            }
        }
    }

    fn impulse_at_rest(&self) -> Wrench<f64> {
        Wrench { linear: self.trial(&self.prescribed), angular: Vector3::zeros() }
    }

    fn impulse_at(&self, motion: &Twist<f64>) -> Wrench<f64> {
        let linear = self.softness.map_or_else(|| self.trial(motion), |soft| soft.bounded(motion));
        Wrench { linear, angular: Vector3::zeros() }
    }

    fn take(&mut self, motion: &Twist<f64>, tolerance: f64) -> bool {
        let holds = self.softness.as_mut().is_none_or(|soft| soft.take(motion, tolerance));
        self.impulse = self.trial(motion);
        holds
    }

    fn correction(&self, _: &RowKey, correction: &Correction) -> Wrench<f64> {
        let mut wrench = Wrench::zero();
        if self.softness.is_none() {
            wrench.linear = self.separation * (-self.penalty * correction.of_gap(self.separation.norm()));
        }
        wrench
    }
}
