//! The rows of a point held at a point, the relative velocity u of a joint's anchors, rigid or as a spring. What other
//! joints hold is in [`super::any_joint`].

use nalgebra::{Matrix3, Vector3};

use super::constants::JOINT_PENALTY;
use super::rows::{Correction, RowBlocks, RowKey, Rows, Side, Stiffness, bits, isotropic, prescribed};
use super::world::World;
use crate::physics::body::{Body, world_inverse_inertia};
use crate::physics::collision::POINTS;
use crate::physics::constraint::row::{Twist, Wrench, bounded};
use crate::physics::joint::{Joint, Softness};
use crate::physics::solver::soft_terms::{SoftTerms, UNLIMITED};

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
    /// Of a joint between members of these places, for `h`, s.
    pub fn of(world: &impl World, joint: &Joint, ends: &[Option<u32>; 2], h: f64) -> Self {
        let bodies = [world.body(joint.a), world.body(joint.b)];
        let anchors = joint.anchors();
        let arms = [bodies[0].rotation * anchors[0], bodies[1].rotation * anchors[1]];
        let sides = [0, 1].map(|side| Side { body: ends[side], arm: arms[side] });
        let separation = bodies[1].position - bodies[0].position + arms[1] - arms[0];
        let softness = joint.softness().map(|Softness { frequency, damping_ratio, max_force }| {
            // As sweeps take it: of the pair's own mass.
            let terms = SoftTerms::<f64>::new(frequency, damping_ratio, UNLIMITED, 0.0, h);
            let inverse_mass: Matrix3<f64> = (0..2).map(|side| inverse_mass_at(bodies[side], &sides[side])).sum();
            let mass = inverse_mass.try_inverse().unwrap_or_else(Matrix3::zeros);
            SoftLaw::new(mass * (terms.mass / terms.impulse), separation * terms.rate, max_force * h)
        });
        let masses = (0..2).filter(|&side| sides[side].body.is_some()).map(|side| bodies[side].mass);
        Self {
            penalty: JOINT_PENALTY * masses.fold(f64::INFINITY, f64::min),
            softness,
            sides,
            prescribed: prescribed(&sides, bodies, arms),
            separation,
            expected: joint.force * h,
            impulse: Vector3::zeros(),
        }
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

/// Velocity at the arm of a body for an impulse there.
fn inverse_mass_at(body: &Body, side: &Side) -> Matrix3<f64> {
    if side.body.is_none() {
        return Matrix3::zeros();
    }
    let arm = side.arm.cross_matrix();
    let inverse_inertia = world_inverse_inertia(&body.inverse_inertia_body, &body.rotation, &body.rotation_freedom);
    Matrix3::from_diagonal(&body.inverse_mass) - arm * inverse_inertia * arm
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
            made: 0,
            penalty: self.penalty,
            arms: self.sides.map(|side| side.arm),
            normal: none,
            levers: [none; POINTS],
            active: bits([self.softness.is_none_or(|soft| !soft.is_saturated)]),
            across: [0.0; 2],
            is_soft: self.softness.is_some(),
        }
    }

    fn blocks(&self) -> RowBlocks {
        match &self.softness {
            None => RowBlocks::at_arms(&self.sides, |x, y| isotropic(self.penalty, x, y)),
            Some(soft) if soft.is_saturated => RowBlocks::default(),
            Some(soft) => {
                let stiffness = Stiffness { uu: soft.stiffness, uw: Matrix3::zeros(), ww: Matrix3::zeros() };
                RowBlocks::at_arms(&self.sides, |x, y| stiffness.between(x, y))
            }
        }
    }

    fn impulse(&self) -> Wrench<f64> {
        Wrench { linear: self.impulse, angular: Vector3::zeros() }
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
