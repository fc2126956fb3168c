//! The rows of any joint: a coordinate each, S_X from their Jacobians, which are known to [`joint`](crate::physics::joint)
//! alone. The first half of them are the linear coordinates, the second the angular.
//!
//! A row has λ = λ̂ − ρ (row + b), where it is rigid; λ = −W (row + b), where it is a spring; or the impulse that its
//! bound leaves, where that is less.

use nalgebra::{Matrix3, Vector3};

use super::constants::{BOUND_ROUNDING, JOINT_PENALTY, LIKELY_BOUND};
use super::rows::{Correction, RowBlocks, RowKey, Rows, Side, body_vector, curving_share, halves};
use crate::physics::body::{Body, RigidBody, world_inverse_inertia};
use crate::physics::collision::POINTS;
use crate::physics::constraint::row::{Twist, Wrench, bounded};
use crate::physics::joint::{Bound, Joint, JointRow};
use crate::physics::solver::linear::BodyVector;
use crate::physics::solver::soft_terms::SoftTerms;

/// Rows of a joint at most.
const ROWS: usize = 6;

/// Gap of a limit, m or rad, from which on it is not looked at in the middle of an iteration, besides what its rate closes
/// in so many substeps.
const IDLE_GAP: f64 = 0.05;
const IDLE_SUBSTEPS: f64 = 4.0;

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
    /// Rows of S_A and of S_B.
    maps: [[BodyVector; ROWS]; 2],
    laws: [Law; ROWS],
    /// How many rows the first half has, and the second.
    counts: [usize; 2],
    /// How often the island made its joints' rows.
    pub made: u32,
    /// The link of a tree in whose coordinates its rows stand.
    pub link: Option<u32>,
    /// Whether its limits are so far away, and without impulses, that they are only looked at again when all is solved.
    is_idle: bool,
}

impl AnyJoint {
    /// Takes in the rows at present, for `h`, s; `ahead` is how far into it rows are to turn with their bodies, s, `least`
    /// the approach from which limits bounce, m/s. `keeps`: which rows are active stays.
    pub fn renew(
        &mut self,
        joint: &Joint,
        rows: &[JointRow<f64>],
        bodies: [&Body; 2],
        ends: &[Option<u32>; 2],
        [h, ahead, least]: [f64; 3],
        keeps: bool,
    ) {
        let frames = &joint.definition.frames;
        let first = joint.definition.halves()[0].min(rows.len());
        let counts = [first, rows.len() - first];
        if self.counts != counts {
            *self = Self { counts, made: self.made, link: self.link, ..Self::default() };
        }
        self.sides = [0, 1].map(|side| Side { body: ends[side], arm: bodies[side].rotation * frames[side].anchor });
        let mobilities = [0, 1].map(|side| match ends[side] {
            Some(_) => BodyMobility::of(bodies[side]),
            None => BodyMobility::NONE,
        });
        let ahead = ahead * curving_share(bodies, h);
        self.is_idle = !rows.is_empty();
        for (index, row) in rows.iter().enumerate() {
            let place = self.place(index);
            for (side, sign) in [(0, -1.0), (1, 1.0)] {
                let Twist { linear, angular } = row.jacobian.of(side);
                self.maps[side][place] = body_vector(&linear, &angular) * sign;
            }
            *coordinate_mut(&mut self.prescribed, place) = prescribed(row, bodies, ends, ahead);
            let mobility: f64 = (0..2).map(|side| mobilities[side].along(&row.jacobian.of(side))).sum();
            let mass = if mobility > 0.0 { 1.0 / mobility } else { 0.0 };
            let before = self.laws[place];
            let law = &mut self.laws[place];
            *law = law_of(row, mass, joint.multipliers[index], h, least);
            if keeps && law.bound != Bound::None {
                (law.is_active, law.impulse) = (before.is_active, before.impulse);
            }
            let is_limit = matches!(law.bound, Bound::Within(..)) && !law.bound.is_boxed();
            let reach = IDLE_GAP + IDLE_SUBSTEPS * h * row.rate.abs();
            let is_far = row.bound.open(row.error).abs() > reach;
            self.is_idle &= is_limit && is_far && !law.is_active && law.impulse == 0.0;
        }
    }

    /// Has limits that are far away go on from what a substep of length `h`, s, did, with the geometry that they have, for as
    /// long as they are.
    pub fn advance(&mut self, motion: &Twist<f64>, h: f64) {
        for place in self.places() {
            let bias = &mut self.laws[place].bias;
            *bias += coordinate(motion, place);
            self.is_idle &= bias.abs() * h > 0.5 * IDLE_GAP;
        }
    }

    /// The rows of B that are active, which turn it against A, with their penalties.
    pub fn turning_rows(&self) -> impl Iterator<Item = (Vector3<f64>, f64)> {
        let active = self.places().filter(|&place| self.laws[place].is_active);
        active.map(|place| (self.maps[1][place].fixed_rows::<3>(3).into(), self.laws[place].stiffness))
    }

    /// Whether some row is in a factor of that key.
    pub fn is_in(&self, factored: &RowKey) -> bool {
        self.places().any(|place| factored.active >> place & 1 == 1 && !self.laws[place].is_spring)
    }

    /// The errors of rows that are not in a factor of that key, each with an impulse of 1 along its row.
    pub fn errors_besides(&self, factored: &RowKey) -> impl Iterator<Item = (f64, Wrench<f64>)> + use<> {
        let (laws, active) = (self.laws, factored.active);
        let wrong = self.places().filter(move |&place| active >> place & 1 == 0 && laws[place].error != 0.0);
        wrong.map(move |place| {
            let mut impulse = Wrench::zero();
            *coordinate_mut(&mut impulse, place) = 1.0;
            (laws[place].error, impulse)
        })
    }

    /// Takes in the errors that are left of its rows: what [`Rows::correction`] corrects next.
    pub fn take_errors(&mut self, rows: &[JointRow<f64>]) -> f64 {
        let mut worst: f64 = 0.0;
        for (index, row) in rows.iter().enumerate().take(self.rows()) {
            let place = self.place(index);
            let is_placed = row.spring.is_none() && !row.is_rate && !row.bound.is_boxed();
            let error = if is_placed { row.error - row.bound.open(row.error) } else { 0.0 };
            self.laws[place].error = error;
            worst = worst.max(error.abs());
        }
        worst
    }

    /// The coordinate of a row.
    fn place(&self, row: usize) -> usize {
        if row < self.counts[0] { row } else { 3 + row - self.counts[0] }
    }

    /// The coordinates of its rows.
    fn places(&self) -> impl Iterator<Item = usize> + use<> {
        let [first, second] = self.counts;
        (0..first).chain(3..3 + second)
    }

    /// How many rows it has.
    pub fn rows(&self) -> usize {
        self.counts[0] + self.counts[1]
    }

    /// λ̂ as a force at the frames' origins, on B.
    pub fn expected_force(&self) -> Vector3<f64> {
        self.wrench_on(1, &self.impulses(|law, _| law.expected, &Twist::zero())).fixed_rows::<3>(0).into()
    }

    /// Takes in the relative motion that was solved for with what is assumed, to which the velocity goes by that share of
    /// the way.
    pub fn carry(&mut self, motion: &Twist<f64>, share: f64) {
        let trial = self.trial(motion);
        for place in self.places() {
            let law = &mut self.laws[place];
            law.carried += share * (coordinate(&trial, place) - law.carried);
        }
    }

    /// What springs and motors give at a motion at most, J.
    pub fn given(&self, motion: &Twist<f64>) -> f64 {
        let is_limit = |law: &Law| matches!(law.bound, Bound::Within(..)) && !law.bound.is_boxed();
        let gives = self.places().filter(|&place| !is_limit(&self.laws[place]));
        gives.map(|place| (self.laws[place].carried * coordinate(motion, place)).max(0.0)).sum()
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
        let mut impulses = Wrench::zero();
        for place in self.places() {
            *coordinate_mut(&mut impulses, place) = of(&self.laws[place], coordinate(motion, place));
        }
        impulses
    }

    /// At a motion, with what is assumed of rows at their bounds.
    fn trial(&self, motion: &Twist<f64>) -> Wrench<f64> {
        self.impulses(|law, speed| if law.is_active { law.trial(speed) } else { law.impulse }, motion)
    }

    /// At a motion, within all bounds.
    fn bounded(&self, motion: &Twist<f64>) -> Wrench<f64> {
        let mut within = self.impulses(
            |law, speed| match law.bound {
                Bound::Within(lower, upper) => law.trial(speed).clamp(lower, upper),
                _ => law.trial(speed),
            },
            motion,
        );
        for (first, half) in [(0, &mut within.linear), (3, &mut within.angular)] {
            if let Bound::Norm { most, .. } = self.laws[first].bound {
                *half = bounded(*half, most);
            }
        }
        within
    }
}

/// A motion's or an impulse's coordinate of that place.
fn coordinate(twist: &Twist<f64>, place: usize) -> f64 {
    if place < 3 { twist.linear[place] } else { twist.angular[place - 3] }
}

fn coordinate_mut(twist: &mut Twist<f64>, place: usize) -> &mut f64 {
    if place < 3 { &mut twist.linear[place] } else { &mut twist.angular[place - 3] }
}

/// The rate of a row that bodies without a place among those that move give, and time, and turning for `ahead`, s.
fn prescribed(row: &JointRow<f64>, bodies: [&Body; 2], ends: &[Option<u32>; 2], ahead: f64) -> f64 {
    let held = (0..2).filter(|&side| ends[side].is_none() && bodies[side].kind != RigidBody::Static);
    let given = held.map(|side| {
        let Body { linear, angular, .. } = *bodies[side];
        row.jacobian.of(side).dot(&Twist { linear, angular })
    });
    let mut given = given.sum::<f64>() + row.time_rate;
    if row.spring.is_none() && ahead != 0.0 {
        // No more than turning can change a rate by: near where a coordinate is singular it would be anything.
        let turning = (0..2).map(|side| row.jacobian.of(side).angular.norm() * bodies[side].angular.norm());
        let most = 0.5 * turning.sum::<f64>();
        given += (ahead * row.velocity_term).clamp(-most, most);
    }
    given
}

/// M⁻¹ of a body.
struct BodyMobility {
    inverse_mass: Vector3<f64>,
    inverse_inertia: Matrix3<f64>,
}

impl BodyMobility {
    const NONE: Self = Self {
        inverse_mass: Vector3::new(0.0, 0.0, 0.0),
        inverse_inertia: Matrix3::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
    };

    fn of(body: &Body) -> Self {
        let inverse_inertia = world_inverse_inertia(&body.inverse_inertia_body, &body.rotation, &body.rotation_freedom);
        Self { inverse_mass: body.inverse_mass, inverse_inertia }
    }

    /// Speed along a row for an impulse along it.
    fn along(&self, row: &Twist<f64>) -> f64 {
        let (linear, angular) = (self.inverse_mass.component_mul(&row.linear), self.inverse_inertia * row.angular);
        row.dot(&Twist { linear, angular })
    }
}

/// The law of a row of that effective mass, which carried a force before; what closes faster than `least` bounces.
fn law_of(row: &JointRow<f64>, mass: f64, force: f64, h: f64, least: f64) -> Law {
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
        let mut speeds = BodyVector::zeros();
        self.places().for_each(|place| speeds[place] = self.maps[side][place].dot(velocity));
        let (linear, angular) = halves(&speeds);
        Twist { linear, angular }
    }

    fn wrench_on(&self, side: usize, impulse: &Wrench<f64>) -> BodyVector {
        let impulses = body_vector(&impulse.linear, &impulse.angular);
        self.places().fold(BodyVector::zeros(), |sum, place| sum + self.maps[side][place] * impulses[place])
    }

    fn prescribed(&self) -> &Twist<f64> {
        &self.prescribed
    }

    fn key(&self) -> RowKey {
        let none = Vector3::zeros();
        RowKey {
            penalty: self.laws[0].stiffness,
            arms: self.sides.map(|side| side.arm),
            normal: none,
            levers: std::array::from_fn::<_, POINTS, _>(|row| self.maps[1][row].fixed_rows::<3>(3).into()),
            active: self.places().filter(|&place| self.laws[place].is_active).fold(0, |bits, place| bits | 1 << place),
            across: [0.0; 2],
            is_soft: false,
            made: self.made,
        }
    }

    fn blocks(&self) -> RowBlocks {
        let mut blocks = RowBlocks::default();
        if self.link.is_some() || self.is_idle {
            return blocks;
        }
        let [moves_a, moves_b] = [0, 1].map(|side| self.sides[side].body.is_some());
        for place in self.places().filter(|&place| self.laws[place].is_active) {
            let ([a, b], stiffness) = (&self.maps, self.laws[place].stiffness);
            let (a, b) = (&a[place], &b[place]);
            for (own, row, moves) in [(0, a, moves_a), (1, b, moves_b)] {
                if moves {
                    blocks.add_own(own, row, stiffness);
                }
            }
            if moves_a && moves_b {
                blocks.add_across(a, b, stiffness);
            }
        }
        blocks
    }

    fn impulse(&self) -> Wrench<f64> {
        self.impulses(|law, _| law.carried, &Twist::zero())
    }

    fn is_idle(&self) -> bool {
        self.is_idle
    }

    fn impulse_at_rest(&self) -> Wrench<f64> {
        self.trial(&self.prescribed)
    }

    fn impulse_at(&self, motion: &Twist<f64>) -> Wrench<f64> {
        self.bounded(motion)
    }

    fn take(&mut self, motion: &Twist<f64>, tolerance: f64) -> bool {
        let (trials, bounded) = (self.impulses(Law::trial, motion), self.bounded(motion));
        let mut holds = true;
        for place in self.places() {
            let law = &mut self.laws[place];
            let (trial, impulse) = (coordinate(&trials, place), coordinate(&bounded, place));
            let exceeds = match law.bound {
                // What is at its bound leaves it where it would do less, by however much.
                Bound::Within(_, upper) if !law.is_active && law.impulse >= upper => trial > upper,
                Bound::Within(lower, _) if !law.is_active && law.impulse <= lower => trial < lower,
                _ => (trial - impulse).abs() > if law.is_active { tolerance } else { 0.0 },
            };
            holds &= law.is_active != exceeds && (law.is_active || (impulse - law.impulse).abs() <= tolerance);
            (law.is_active, law.impulse) = (!exceeds, impulse);
        }
        self.is_idle &= holds;
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
