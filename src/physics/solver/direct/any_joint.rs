//! The rows of any joint: a coordinate each, S_X from their Jacobians, which are known to [`joint`](crate::physics::joint)
//! alone. The first half of them are the linear coordinates, the second the angular.
//!
//! A row has λ = λ̂ − ρ (row + b), where it is rigid; λ = −W (row + b), where it is a spring; or the impulse that its
//! bound leaves, where that is less.

use nalgebra::{Matrix3, Vector3};

use super::constants::{BOUND_ROUNDING, JOINT_PENALTY, LIKELY_BOUND};
use super::rows::{Correction, RowBlocks, RowKey, Rows, Side, bits, body_vector, curving_share, halves};
use crate::physics::body::{Body, RigidBody, world_inverse_inertia};
use crate::physics::collision::POINTS;
use crate::physics::constraint::row::{Twist, Wrench, bounded};
use crate::physics::joint::{Bound, Joint, JointRow};
use crate::physics::solver::linear::{BodyBlock, BodyVector};
use crate::physics::solver::soft_terms::SoftTerms;

/// Rows of a joint at most.
const ROWS: usize = 6;

/// One row.
#[derive(Clone, Copy, Debug)]
struct Law {
    /// C, m or rad: what there is to correct.
    error: f64,
    is_spring: bool,
    /// ρ or W, impulse over speed.
    stiffness: f64,
    /// b: an open gap is closed at this speed at most.
    bias: f64,
    /// λ̂.
    expected: f64,
    bound: Bound<f64>,
    /// Whether its impulse is within its bound, and which it is.
    is_active: bool,
    impulse: f64,
    /// What it gives to the velocity at hand: where iterations end too early, rows that are to change by then have
    /// another impulse at it than the bodies got.
    carried: f64,
}

impl Default for Law {
    /// Holds nothing.
    fn default() -> Self {
        let bound = Bound::None;
        let (error, stiffness, bias, expected, impulse) = (0.0, 0.0, 0.0, 0.0, 0.0);
        Self { error, is_spring: false, stiffness, bias, expected, bound, is_active: true, impulse, carried: 0.0 }
    }
}

impl Law {
    /// Impulse at a speed, if it is within its bound.
    fn trial(&self, speed: f64) -> f64 {
        self.expected - self.stiffness * (speed + self.bias)
    }
}

/// A joint.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct AnyJoint {
    /// The arms are those of the joint's frames.
    pub sides: [Side; 2],
    pub prescribed: Twist<f64>,
    /// S_Aᵀ and S_Bᵀ: a column for each row.
    maps: [BodyBlock; 2],
    laws: [Law; ROWS],
    /// How often its rows were made.
    revision: u32,
    /// How many rows the first half has, and the second.
    counts: [usize; 2],
}

impl AnyJoint {
    /// Takes over the rows at present, for `h`, s; `ahead` is how far into it rows are to turn with their bodies, s, `least`
    /// the approach from which limits bounce, m/s. Where it `resumes`, which rows are active stays as iterations left it.
    pub fn renew(
        &mut self,
        joint: &Joint,
        rows: &[JointRow<f64>],
        bodies: [&Body; 2],
        ends: &[Option<u32>; 2],
        [h, ahead, least]: [f64; 3],
        resumes: bool,
    ) {
        let frames = &joint.definition.frames;
        let sides = [0, 1].map(|side| Side { body: ends[side], arm: bodies[side].rotation * frames[side].anchor });
        let ahead = ahead * curving_share(bodies, h);
        let first = joint.definition.halves()[0].min(rows.len());
        let counts = [first, rows.len() - first];
        if counts != self.counts {
            (self.maps, self.laws) = Default::default();
        }
        self.sides = sides;
        self.counts = counts;
        self.prescribed = Twist::zero();
        self.revision = self.revision.wrapping_add(1);
        let inverse_inertias = bodies
            .map(|body| world_inverse_inertia(&body.inverse_inertia_body, &body.rotation, &body.rotation_freedom));
        for (index, row) in rows.iter().enumerate() {
            let place = self.place(index);
            for (side, sign) in [(0, -1.0), (1, 1.0)] {
                let Twist { linear, angular } = row.jacobian.of(side);
                self.maps[side].column_mut(place).copy_from(&(body_vector(&linear, &angular) * sign));
            }
            let held = (0..2).filter(|&side| sides[side].body.is_none() && bodies[side].kind != RigidBody::Static);
            let given = held.map(|side| {
                let Body { linear, angular, .. } = *bodies[side];
                row.jacobian.of(side).dot(&Twist { linear, angular })
            });
            let mut given = given.sum::<f64>() + row.time_rate;
            if row.spring.is_none() {
                // No more than turning can change a rate by: near where a coordinate is singular it would be anything.
                let turning = (0..2).map(|side| row.jacobian.of(side).angular.norm() * bodies[side].angular.norm());
                let most = 0.5 * turning.sum::<f64>();
                // What is no number is found after the step; `clamp` would panic.
                given += (ahead * row.velocity_term).min(most).max(-most);
            }
            if place < 3 {
                self.prescribed.linear[place] = given
            } else {
                self.prescribed.angular[place - 3] = given
            }
            let mobility: f64 = (0..2)
                .filter(|&side| sides[side].body.is_some())
                .map(|side| mobility(&row.jacobian.of(side), bodies[side], &inverse_inertias[side]))
                .sum();
            let mass = if mobility > 0.0 { 1.0 / mobility } else { 0.0 };
            let law = law(row, mass, joint.multipliers[index], h, least);
            let before = std::mem::replace(&mut self.laws[place], law);
            if resumes && law.bound != Bound::None {
                (self.laws[place].is_active, self.laws[place].impulse) = (before.is_active, before.impulse);
            }
        }
    }

    /// The coordinate of a row.
    fn place(&self, row: usize) -> usize {
        if row < self.counts[0] { row } else { 3 + row - self.counts[0] }
    }

    /// How many rows it has.
    pub fn rows(&self) -> usize {
        self.counts[0] + self.counts[1]
    }

    /// How far the points that it holds rigidly are apart, m.
    pub fn gap(&self) -> f64 {
        let shifts = |place: usize| self.maps.iter().any(|map| map.fixed_view::<3, 1>(0, place) != Vector3::zeros());
        let laws = self.laws[..self.counts[0]].iter().enumerate();
        let errors = laws.filter(|(place, law)| !law.is_spring && !law.bound.is_boxed() && shifts(*place));
        errors.map(|(_, law)| law.error * law.error).sum::<f64>().sqrt()
    }

    /// Starts from no impulse.
    pub fn forget(&mut self) {
        self.laws.iter_mut().for_each(|law| law.expected = 0.0);
    }

    /// λ̂ of all rows.
    pub fn expected(&self) -> Wrench<f64> {
        self.impulses(|law, _| law.expected, &Twist::zero())
    }

    /// Expects a share of what it did.
    pub fn expect_share(&mut self, share: f64) {
        self.laws.iter_mut().for_each(|law| law.expected *= share);
    }

    /// λ̂ as a force at the frames' origins, on B.
    pub fn expected_force(&self) -> Vector3<f64> {
        self.wrench_on(1, &self.expected()).fixed_rows::<3>(0).into()
    }

    /// Takes in the relative motion that was solved for with what is assumed, to which the velocity goes by that share of
    /// the way.
    pub fn carry(&mut self, motion: &Twist<f64>, share: f64) {
        let trial = self.trial(motion);
        for (law, trial) in self.laws.iter_mut().zip(trial.linear.iter().chain(&trial.angular)) {
            law.carried += share * (trial - law.carried);
        }
    }

    /// What springs and motors give at a motion at most, J.
    pub fn given(&self, motion: &Twist<f64>) -> f64 {
        let speeds = motion.linear.iter().chain(&motion.angular);
        let is_limit = |law: &Law| matches!(law.bound, Bound::Within(..)) && !law.bound.is_boxed();
        let gives = self.laws.iter().zip(speeds).filter(|(law, _)| !is_limit(law));
        gives.map(|(law, speed)| (law.carried * speed).max(0.0)).sum()
    }

    /// Has it carry another share of what it did.
    pub fn scale(&mut self, share: f64) {
        self.laws.iter_mut().for_each(|law| law.carried *= share);
    }

    /// Writes what it carried in `h`, s.
    pub fn store(&self, joint: &mut Joint, h: f64) {
        let (force, torque) = halves(&self.wrench_on(1, &self.impulses(|law, _| law.carried, &Twist::zero())));
        (joint.force, joint.torque) = (force / h, (torque - self.sides[1].arm.cross(&force)) / h);
        for row in 0..self.rows() {
            joint.multipliers[row] = self.laws[self.place(row)].carried / h;
        }
    }

    fn impulses(&self, of: impl Fn(&Law, f64) -> f64, motion: &Twist<f64>) -> Wrench<f64> {
        let half = |first: usize, speeds: &Vector3<f64>| {
            Vector3::from_fn(|index, _| of(&self.laws[first + index], speeds[index]))
        };
        Wrench { linear: half(0, &motion.linear), angular: half(3, &motion.angular) }
    }

    /// At a motion, with what is assumed of rows at their bounds.
    fn trial(&self, motion: &Twist<f64>) -> Wrench<f64> {
        self.impulses(|law, speed| if law.is_active { law.trial(speed) } else { law.impulse }, motion)
    }

    /// At a motion, within all bounds.
    fn bounded(&self, motion: &Twist<f64>) -> Wrench<f64> {
        let trial = self.impulses(Law::trial, motion);
        let half = |first: usize, trial: Vector3<f64>| match self.laws[first].bound {
            Bound::Norm { most, .. } => bounded(trial, most),
            _ => Vector3::from_fn(|index, _| match self.laws[first + index].bound {
                Bound::Within(lower, upper) => trial[index].clamp(lower, upper),
                _ => trial[index],
            }),
        };
        Wrench { linear: half(0, trial.linear), angular: half(3, trial.angular) }
    }
}

/// Speed along a row for an impulse along it, of one body.
fn mobility(row: &Twist<f64>, body: &Body, inverse_inertia: &Matrix3<f64>) -> f64 {
    let (linear, angular) = (body.inverse_mass.component_mul(&row.linear), inverse_inertia * row.angular);
    row.dot(&Twist { linear, angular })
}

/// The law of a row of that effective mass, which carried a force before; what closes faster than `least` bounces.
fn law(row: &JointRow<f64>, mass: f64, force: f64, h: f64, least: f64) -> Law {
    let bound = match row.bound {
        Bound::None => Bound::None,
        Bound::Within(lower, upper) => Bound::Within(lower * h, upper * h),
        Bound::Norm { most, place, count } => Bound::Norm { most: most * h, place, count },
    };
    if let Some(constants) = row.spring {
        // As sweeps take it: of the row's own mass.
        let terms = SoftTerms::<f64>::of_spring(constants.per_mass(mass), h);
        let (stiffness, bias) = (mass * (terms.mass / terms.impulse), row.error * terms.rate);
        return Law { error: row.error, is_spring: true, stiffness, bias, bound, ..Law::default() };
    }
    let (open, allowed) = (row.bound.open(row.error), row.allowed_rate(h, least));
    let expected = match bound {
        Bound::Within(lower, upper) => (force * h).clamp(lower, upper),
        _ => force * h,
    };
    let ahead = row.error + row.rate * h;
    let mut law = Law {
        error: row.error - open,
        stiffness: JOINT_PENALTY * mass,
        bias: -allowed,
        expected,
        bound,
        is_active: expected != 0.0 || ahead * open <= 0.0,
        ..Law::default()
    };
    // What takes up much of its largest force alone, or took all before, is likely to take all: from there rows get free
    // one by one, while one that does too much at first may lift what it is to drive.
    if row.bound.is_boxed()
        && let Bound::Within(lower, upper) = bound
    {
        let needed = mass * (allowed - row.rate);
        let at = |share: f64| [share * lower, share * upper];
        let ([least, most], [low, high]) = (at(LIKELY_BOUND), at(1.0 - BOUND_ROUNDING));
        if needed < least || expected <= low {
            (law.is_active, law.impulse) = (false, lower);
        } else if needed > most || expected >= high {
            (law.is_active, law.impulse) = (false, upper);
        }
    }
    law
}

impl Rows for AnyJoint {
    fn sides(&self) -> &[Side; 2] {
        &self.sides
    }

    fn motion_of(&self, side: usize, velocity: &BodyVector) -> Twist<f64> {
        let (map, [first, second], mut motion) = (&self.maps[side], self.counts, Twist::zero());
        for row in 0..first {
            motion.linear[row] = map.column(row).dot(velocity);
        }
        for row in 0..second {
            motion.angular[row] = map.column(3 + row).dot(velocity);
        }
        motion
    }

    fn wrench_on(&self, side: usize, impulse: &Wrench<f64>) -> BodyVector {
        let (map, [first, second], mut wrench) = (&self.maps[side], self.counts, BodyVector::zeros());
        for row in 0..first {
            wrench += map.column(row) * impulse.linear[row];
        }
        for row in 0..second {
            wrench += map.column(3 + row) * impulse.angular[row];
        }
        wrench
    }

    fn acts(&self) -> bool {
        self.laws.iter().any(|law| if law.is_active { law.stiffness != 0.0 } else { law.impulse != 0.0 })
    }

    fn prescribed(&self) -> &Twist<f64> {
        &self.prescribed
    }

    fn key(&self) -> RowKey {
        let none = Vector3::zeros();
        RowKey {
            penalty: self.laws[0].stiffness,
            friction: 0.0,
            arms: self.sides.map(|side| side.arm),
            normal: none,
            levers: std::array::from_fn::<_, POINTS, _>(|row| self.maps[1].fixed_view::<3, 1>(3, row).into()),
            active: bits(self.laws.iter().map(|law| law.is_active && law.stiffness != 0.0)),
            across: [0.0; 2],
            is_soft: false,
            revision: self.revision,
        }
    }

    fn blocks(&self, blocks: &mut RowBlocks) {
        let [a, b] = &self.maps;
        blocks.set(&self.sides, [a, b], |x, y| {
            let mut block = BodyBlock::zeros();
            for (row, law) in self.laws.iter().enumerate() {
                if law.is_active && law.stiffness != 0.0 {
                    block += x.column(row) * (y.column(row) * law.stiffness).transpose();
                }
            }
            block
        });
    }

    fn impulse_at_rest(&self) -> Wrench<f64> {
        self.trial(&self.prescribed)
    }

    fn impulse_at(&self, motion: &Twist<f64>) -> Wrench<f64> {
        self.bounded(motion)
    }

    fn take(&mut self, motion: &Twist<f64>, tolerance: f64) -> bool {
        let (trial, bounded) = (self.impulses(Law::trial, motion), self.bounded(motion));
        let mut holds = true;
        for (index, law) in self.laws.iter_mut().enumerate() {
            let of = |wrench: &Wrench<f64>| if index < 3 { wrench.linear[index] } else { wrench.angular[index - 3] };
            let (trial, impulse) = (of(&trial), of(&bounded));
            let exceeds = match law.bound {
                // What is at its bound leaves it where it would do less, by however much.
                Bound::Within(_, upper) if !law.is_active && law.impulse >= upper => trial > upper,
                Bound::Within(lower, _) if !law.is_active && law.impulse <= lower => trial < lower,
                _ => (trial - impulse).abs() > if law.is_active { tolerance } else { 0.0 },
            };
            holds &= law.is_active != exceeds && (law.is_active || (impulse - law.impulse).abs() <= tolerance);
            (law.is_active, law.impulse) = (!exceeds, impulse);
        }
        holds
    }

    fn correction(&self, factored: &RowKey, correction: &Correction) -> Wrench<f64> {
        let half = |first: usize| {
            let laws = &self.laws[first..first + 3];
            let is_held = |index: usize| !laws[index].is_spring && factored.active >> (first + index) & 1 == 1;
            let errors = Vector3::from_fn(|index, _| if is_held(index) { laws[index].error } else { 0.0 });
            let rate = correction.of_gap(errors.norm());
            Vector3::from_fn(|index, _| -laws[index].stiffness * errors[index] * rate)
        };
        Wrench { linear: half(0), angular: half(3) }
    }
}
