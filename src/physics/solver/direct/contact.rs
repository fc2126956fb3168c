//! The rows of a contact: one for each point, n·u + q·w with q = ρ × n, ρ from the middle of the manifold, of what bears
//! its friction ([`footing`](crate::physics::contact)), to the point,
//! two rows t·u of friction and one n·w of torsion. What they share goes into 3 × 3 blocks:
//!
//! K_uu = Σρ_i n nᵀ + ρ_t (1 − n nᵀ), K_uw = n Σρ_i q_iᵀ, K_ww = Σρ_i q_i q_iᵀ + ρ_τ n nᵀ.

use nalgebra::{Matrix3, Vector3};

use super::constants::{ARM_CHANGE, BOUNCE_PENALTY, SLIP, TOUCHING};
use super::rows::{Correction, RowBlocks, RowKey, Rows, Side, Stiffness, bits};
use crate::physics::collision::{ContactState, POINTS};
use crate::physics::constraint::row::{Twist, Wrench};
use crate::physics::contact::{rebound, shares};
use crate::physics::lanes::Record;

/// A row whose impulse is not negative.
#[derive(Clone, Copy, Debug, Default)]
struct PointRow {
    /// q.
    lever: Vector3<f64>,
    /// Negative: depth.
    separation: f64,
    /// λ̂.
    expected: f64,
    /// λ.
    impulse: f64,
    /// Speed at which it is to part, m/s, where it bounces.
    rebound: f64,
    is_active: bool,
}

impl PointRow {
    /// n·u + q·w: how fast the point parts at a motion, m/s.
    fn speed(&self, normal: &Vector3<f64>, motion: &Twist<f64>) -> f64 {
        normal.dot(&motion.linear) + self.lever.dot(&motion.angular)
    }
}

/// A contact.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct DirectContact {
    pub sides: [Side; 2],
    pub prescribed: Twist<f64>,
    /// Impulse over speed of its rows, kg.
    pub penalty: f64,
    /// The same of its friction, where that is another.
    slip_penalty: Option<f64>,
    /// 1/h, 1/s.
    pub per_step: f64,
    normal: Vector3<f64>,
    tangents: [Vector3<f64>; 2],
    points: [PointRow; POINTS],
    count: usize,
    coefficient: f64,
    restitution: f64,
    /// Mean distance of the points from the middle.
    radius: f64,
    /// Gap that counts as none.
    touch_tolerance: f64,
    /// Of two tangents and torsion: λ̂.
    expected: [f64; 3],
    /// λ.
    friction: [f64; 3],
    is_sliding: bool,
    is_twisting: bool,
    /// Bound of friction, N·s: μ times the normal impulse.
    limit: f64,
    /// Where it slides: a unit along the tangents across the friction, times the root of how much of the
    /// stiffness is left across it.
    across: [f64; 2],
}

impl DirectContact {
    /// From the state of a contact, with what turns A's and B's axes into the world's, and `offset` the centre of B
    /// less the origin of A's axes, from which A's arms count, and its restitution. Impulses are taken `scale` times.
    pub fn new(
        state: &ContactState,
        [turn_a, turn_b]: &[Matrix3<f64>; 2],
        offset: &Vector3<f64>,
        [restitution, scale]: [f64; 2],
    ) -> Self {
        let ContactState { geometry, impulses } = state;
        let (normal, tangent) = (turn_a * geometry.normal(), turn_a * geometry.tangent());
        let count = geometry.point_count();
        let mut contact = Self {
            normal,
            tangents: [tangent, normal.cross(&tangent)],
            count,
            coefficient: f64::from(geometry.friction()),
            restitution,
            ..Self::default()
        };
        let mut arms = [Vector3::zeros(); POINTS];
        let (mut separations, mut present) = ([0.0; POINTS], [0.0; POINTS]);
        for (index, (point, arm)) in contact.points[..count].iter_mut().zip(&mut arms).enumerate() {
            let (on_a, on_b) = geometry.point(index);
            let (on_a, on_b) = (turn_a * on_a, turn_b * on_b + offset);
            *arm = (on_a + on_b) * 0.5;
            let expected = f64::from(impulses.0[index]) * scale;
            let separation = normal.dot(&(on_b - on_a));
            (separations[index], present[index]) = (separation, 1.0);
            *point = PointRow { separation, expected, impulse: expected, ..PointRow::default() };
        }
        let shares = shares(&arms, &separations, &present);
        let middle = arms.iter().zip(shares).fold(Vector3::zeros(), |sum, (arm, share)| sum + arm * share);
        contact.sides = [Side { body: None, arm: middle }, Side { body: None, arm: middle - offset }];
        contact.touch_tolerance = TOUCHING * contact.sides[1].arm.norm();
        for ((point, arm), share) in contact.points[..count].iter_mut().zip(&arms).zip(shares) {
            let offset = arm - middle;
            point.lever = offset.cross(&normal);
            point.is_active = point.expected > 0.0 || point.separation <= contact.touch_tolerance;
            contact.radius += offset.norm() * share;
        }
        contact.expected = std::array::from_fn(|row| f64::from(impulses.0[POINTS + row]) * scale);
        contact.friction = contact.expected;
        contact.release_apart();
        contact
    }

    /// Takes over which rows act from the step before, of points that are still where they were.
    pub fn resume(&mut self, before: &Self) {
        let near = ARM_CHANGE * self.radius;
        for (point, old) in self.points[..self.count].iter_mut().zip(&before.points[..before.count]) {
            if point.expected == 0.0 && (point.lever - old.lever).norm_squared() <= near * near {
                point.is_active = old.is_active;
            }
        }
        (self.is_sliding, self.is_twisting, self.across) = (before.is_sliding, before.is_twisting, before.across);
    }

    /// What bears nothing holds nothing back: it may be a gap that is ahead.
    fn release_apart(&mut self) {
        let is_apart = self.active_points().next().is_none();
        (self.is_sliding, self.is_twisting) = (is_apart, is_apart);
    }

    /// Has those points act that come together within the substep by a relative motion, besides those that do.
    pub fn foresee(&mut self, motion: &Twist<f64>) {
        for point in &mut self.points[..self.count] {
            let approach = -point.speed(&self.normal, motion);
            point.is_active |= point.separation * self.per_step < approach;
        }
        self.release_apart();
    }

    /// Goes on from what a substep of length `h`, s, did, with the geometry that it has: points part as they moved.
    pub fn advance(&mut self, motion: &Twist<f64>, h: f64) {
        let Self { normal, points, count, .. } = self;
        for point in &mut points[..*count] {
            point.separation += point.speed(normal, motion) * h;
            point.expected = point.impulse;
        }
        self.expected = self.friction;
    }

    /// Has points part again that come together within the substep faster than `least`, m/s, by the relative motion with
    /// which it begins. Where some do, the contact is [`BOUNCE_PENALTY`] times as stiff as others, of that `penalty`, kg.
    pub fn bounce(&mut self, motion: &Twist<f64>, least: f64, penalty: f64) {
        let mut bounces = false;
        for point in &mut self.points[..self.count] {
            let approach = -point.speed(&self.normal, motion);
            let comes = point.separation * self.per_step <= approach;
            point.rebound = if comes { rebound(self.restitution, approach, least) } else { 0.0 };
            point.is_active |= point.rebound > 0.0;
            bounces |= point.rebound > 0.0;
        }
        self.penalty = if bounces { BOUNCE_PENALTY * penalty } else { penalty };
    }

    /// The impulse expected.
    pub fn expected(&self) -> Wrench<f64> {
        self.wrench(self.points[..self.count].iter().map(|point| (point, point.expected)), self.expected)
    }

    /// Expects a share of what it did.
    pub fn expect_share(&mut self, share: f64) {
        self.points[..self.count].iter_mut().for_each(|point| point.expected *= share);
        self.expected = self.expected.map(|impulse| impulse * share);
    }

    /// Has it do a share of what it did.
    pub fn scale(&mut self, share: f64) {
        self.points[..self.count].iter_mut().for_each(|point| point.impulse *= share);
        self.friction = self.friction.map(|impulse| impulse * share);
    }

    /// Has what it expects be what it did.
    pub fn keep_expected(&mut self) {
        self.points[..self.count].iter_mut().for_each(|point| point.impulse = point.expected);
        self.friction = self.expected;
    }

    /// Bounds friction by the normal impulses expected.
    pub fn expect_limit(&mut self) {
        self.bound_friction(self.points[..self.count].iter().map(|point| point.expected).sum());
    }

    /// Bounds friction by the normal impulses at hand.
    pub fn renew_limit(&mut self) {
        self.bound_friction(self.points[..self.count].iter().map(|point| point.impulse).sum());
    }

    /// Bounds friction by a normal impulse, N·s, and has it give way by [`SLIP`] when at its bound.
    fn bound_friction(&mut self, load: f64) {
        self.limit = self.coefficient * load;
        self.slip_penalty = Some((self.limit / SLIP).min(self.penalty));
    }

    fn friction_penalty(&self) -> f64 {
        self.slip_penalty.unwrap_or(self.penalty)
    }

    /// Takes in a motion: which rows act at it, and their impulses, with the bound of friction as it is.
    pub fn settle(&mut self, motion: &Twist<f64>) {
        for index in 0..self.count {
            let trial = self.trial(&self.points[index], motion);
            let point = &mut self.points[index];
            (point.is_active, point.impulse) = (trial > 0.0, trial.max(0.0));
        }
        if self.coefficient == 0.0 {
            return;
        }
        let trial = self.friction_if_stuck(motion);
        let size = length(trial[0], trial[1]);
        self.is_sliding = size > self.limit;
        self.is_twisting = trial[2].abs() > self.limit * self.radius;
        self.friction = self.bounded(trial);
        self.turn_across(trial, size);
    }

    /// Sets `across` for friction that would be that if it stuck, of that size.
    fn turn_across(&mut self, trial: [f64; 3], size: f64) {
        let left = if self.is_sliding && size > 0.0 { (self.limit / size).sqrt() / size } else { 0.0 };
        self.across = [-trial[1] * left, trial[0] * left];
    }

    /// Twice the energy that it can give in taking back what it expected, J: λ̂²/ρ of a point, and of friction no more than
    /// at [`SLIP`].
    pub fn stored(&self) -> f64 {
        let [x, y, torsion] = self.expected;
        let about = if self.radius > 0.0 { torsion / self.radius } else { 0.0 };
        let points = self.points[..self.count].iter().map(|point| point.expected);
        let of_points = points.map(|impulse| impulse * impulse).sum::<f64>() / self.penalty;
        of_points + 2.0 * SLIP * (length(x, y) + about.abs())
    }

    /// How many points it has.
    pub fn points(&self) -> usize {
        self.count
    }

    /// K of the active rows.
    pub(super) fn stiffness(&self) -> Stiffness {
        let (normal, penalty) = (&self.normal, self.penalty);
        let (mut along, mut lever, mut ww) = (0.0, Vector3::zeros(), Matrix3::zeros());
        for point in self.active_points() {
            along += penalty;
            lever += point.lever * penalty;
            ww += point.lever * point.lever.transpose() * penalty;
        }
        let square = normal * normal.transpose();
        let friction = self.friction_penalty();
        let across = if self.is_sliding || self.coefficient == 0.0 { 0.0 } else { friction };
        if !self.is_twisting && self.coefficient != 0.0 {
            ww += square * (friction * self.radius * self.radius);
        }
        let mut uu = Matrix3::from_diagonal_element(across) + square * (along - across);
        if self.is_sliding {
            let turned = self.tangents[0] * self.across[0] + self.tangents[1] * self.across[1];
            uu += turned * turned.transpose() * friction;
        }
        Stiffness { uu, uw: normal * lever.transpose(), ww }
    }

    fn active_points(&self) -> impl Iterator<Item = &PointRow> {
        self.points[..self.count].iter().filter(|point| point.is_active)
    }

    /// The wrench of impulses of points, each at its own, and of friction.
    fn wrench<'p>(&self, points: impl Iterator<Item = (&'p PointRow, f64)>, friction: [f64; 3]) -> Wrench<f64> {
        let mut wrench = Wrench::zero();
        for (point, impulse) in points {
            wrench.linear += self.normal * impulse;
            wrench.angular += point.lever * impulse;
        }
        if self.coefficient != 0.0 {
            let [x, y, torsion] = friction;
            wrench.linear += self.tangents[0] * x + self.tangents[1] * y;
            wrench.angular += self.normal * torsion;
        }
        wrench
    }

    /// Impulse of a point's row at a motion, if it is active.
    fn trial(&self, point: &PointRow, motion: &Twist<f64>) -> f64 {
        let speed = point.speed(&self.normal, motion);
        let gap = (point.separation - self.touch_tolerance).max(0.0);
        let least = if point.rebound > 0.0 { point.rebound } else { -gap * self.per_step };
        point.expected - self.penalty * (speed - least)
    }

    /// Friction at a motion by the active rows: what slides keeps its impulse.
    fn friction_trial(&self, motion: &Twist<f64>) -> [f64; 3] {
        let stuck = self.friction_if_stuck(motion);
        let [x, y, torsion] = self.friction;
        let [across_x, across_y] = self.across;
        // To first order about where it slid: friction turns with the slip.
        let turned = across_x * stuck[0] + across_y * stuck[1];
        let along = if self.is_sliding { [x + across_x * turned, y + across_y * turned] } else { [stuck[0], stuck[1]] };
        [along[0], along[1], if self.is_twisting { torsion } else { stuck[2] }]
    }

    fn friction_if_stuck(&self, motion: &Twist<f64>) -> [f64; 3] {
        let [slip_x, slip_y] = self.tangents.map(|tangent| tangent.dot(&motion.linear));
        let penalty = self.friction_penalty();
        let torsion = penalty * self.radius * self.radius * self.normal.dot(&motion.angular);
        let [x, y, about] = self.expected;
        [x - penalty * slip_x, y - penalty * slip_y, about - torsion]
    }

    /// The nearest that the limit admits.
    fn bounded(&self, [x, y, torsion]: [f64; 3]) -> [f64; 3] {
        let size = length(x, y);
        let shrink = if size > self.limit { self.limit / size } else { 1.0 };
        let most = self.limit * self.radius;
        // What is no number is found after the step; `clamp` would panic.
        [x * shrink, y * shrink, torsion.min(most).max(-most)]
    }

    /// Its impulses, divided by `scale`, N·s.
    pub fn impulses(&self, scale: f64) -> Record<f32> {
        let mut record = Record::default();
        for (place, point) in record.0.iter_mut().zip(&self.points[..self.count]) {
            *place = (point.impulse / scale) as f32;
        }
        for (place, friction) in record.0[POINTS..].iter_mut().zip(self.friction) {
            *place = (friction / scale) as f32;
        }
        record
    }
}

impl Rows for DirectContact {
    fn sides(&self) -> &[Side; 2] {
        &self.sides
    }

    fn prescribed(&self) -> &Twist<f64> {
        &self.prescribed
    }

    fn key(&self) -> RowKey {
        let sticks = [self.is_sliding, self.is_twisting].map(|slips| !slips && self.coefficient != 0.0);
        RowKey {
            penalty: self.penalty,
            friction: self.slip_penalty.unwrap_or(0.0),
            arms: self.sides.map(|side| side.arm),
            normal: self.normal,
            levers: self.points.map(|point| point.lever),
            active: bits(self.points.iter().map(|point| point.is_active).chain(sticks)),
            across: if self.is_sliding { self.across } else { [0.0; 2] },
            is_soft: false,
            revision: 0,
        }
    }

    fn blocks(&self, blocks: &mut RowBlocks) {
        let stiffness = self.stiffness();
        blocks.set_at_arms(&self.sides, |x, y| stiffness.between(x, y));
    }

    fn impulse_at_rest(&self) -> Wrench<f64> {
        let points = self.active_points().map(|point| (point, self.trial(point, &self.prescribed)));
        self.wrench(points, self.friction_trial(&self.prescribed))
    }

    fn impulse_at(&self, motion: &Twist<f64>) -> Wrench<f64> {
        let points = self.points[..self.count].iter().map(|point| (point, self.trial(point, motion).max(0.0)));
        // Within the limit at hand.
        self.wrench(points, self.bounded(self.friction_if_stuck(motion)))
    }

    fn take(&mut self, motion: &Twist<f64>, tolerance: f64) -> bool {
        let trials: [f64; POINTS] =
            std::array::from_fn(|index| if index < self.count { self.trial(&self.points[index], motion) } else { 0.0 });
        let mut holds = true;
        for (point, trial) in self.points[..self.count].iter_mut().zip(trials) {
            let is_wrong = (trial > 0.0) != point.is_active;
            if is_wrong && trial.abs() > tolerance {
                holds = false;
                point.is_active = trial > 0.0;
            }
            point.impulse = if is_wrong { 0.0 } else { trial.max(0.0) };
        }
        if self.coefficient == 0.0 {
            return holds;
        }
        // The impulse of a row that is not active yet is not known.
        let load: f64 = self.points[..self.count].iter().map(|point| point.impulse).sum();
        self.limit = self.coefficient * load;
        let trial = self.friction_if_stuck(motion);
        let friction = self.bounded(trial);
        let bound = |most: f64, slips: bool| if slips { most } else { most + tolerance };
        let size = length(trial[0], trial[1]);
        let bears = load > 0.0;
        let is_sliding = !bears || size > bound(self.limit, self.is_sliding);
        let is_twisting = !bears || trial[2].abs() > bound(self.limit * self.radius, self.is_twisting);
        let moved = |row: usize| (friction[row] - self.friction[row]).abs();
        holds &= [is_sliding, is_twisting] == [self.is_sliding, self.is_twisting];
        holds &= !is_sliding || moved(0).max(moved(1)) <= tolerance;
        holds &= !is_twisting || moved(2) <= tolerance * self.radius;
        (self.is_sliding, self.is_twisting, self.friction) = (is_sliding, is_twisting, friction);
        self.turn_across(trial, size);
        holds
    }

    fn correction(&self, factored: &RowKey, correction: &Correction) -> Wrench<f64> {
        let acting = self.points[..self.count].iter().enumerate().filter(|(row, _)| factored.active >> row & 1 == 1);
        let impulses = acting.map(|(_, point)| {
            let depth = (-point.separation - self.touch_tolerance).max(0.0);
            (point, self.penalty * depth * correction.of_depth(depth))
        });
        self.wrench(impulses, [0.0; 3])
    }
}

/// As `hypot`, which guards against overflow at ten times the cost.
fn length(x: f64, y: f64) -> f64 {
    x.mul_add(x, y * y).sqrt()
}
