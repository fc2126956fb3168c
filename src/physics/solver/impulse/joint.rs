//! Joints of as many pairs as there are lanes, by sweeps: for loops and grids, and whatever is not solved as a tree. A
//! block takes up to three rows of each, the linear parts of which are the world axes ([`WorldAxes`], the rows of a point
//! held at a point), or any ([`Directions`], made of the rows that [`joint`](crate::physics::joint) tells).
//!
//! With Q = −[r]ₓ W the velocity of the anchors' parting is u = v_B − v_A + Q_B ψ_B − Q_A ψ_A, and
//! one update, with K = M_A⁻¹ + M_B⁻¹ + Q_A Q_Aᵀ + Q_B Q_Bᵀ, is λ ← λ − K⁻¹ σ (u + bias) − ι λ with the
//! soft terms of contacts. The error is C + d_B − d_A + Q_B θ'_B − Q_A θ'_A. Other rows have their own linear parts and,
//! in place of Q, their angular parts times W.

use nalgebra::{Matrix3, Vector3};

use super::bodies::{ClaimedPairs, Ends, Frames};
use super::constants::{DEPENDENT_ROWS, LEAST_MOBILITY};
use super::pair::Pair;
use crate::physics::body::Body;
use crate::physics::constraint::row::{Wrench, bounded};
use crate::physics::joint::{Bound, JointRow, Softness};
use crate::physics::lanes::{Lanes, READ_ONLY, WIDTH, add_scaled, dot, inverse};
use crate::physics::scalar::Scalar;
use crate::physics::solver::soft_terms::{Projection, SoftTerms, UNLIMITED};

/// A joint that holds a point at a point, as its lane takes it in.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct JointInput {
    /// On A and on B, from the centres of mass, body axes.
    pub anchors: [Vector3<f64>; 2],
    /// Centre of B less centre of A, m.
    pub offset: Vector3<f64>,
    /// On B in the last substep, N·s.
    pub impulse: Vector3<f64>,
    /// None: rigid.
    pub softness: Option<RowSoftness>,
}

/// Up to three rows of any joint, as its lane takes them in.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct RowsInput {
    pub rows: [Option<JointRow<f64>>; 3],
    /// From B's centre of mass to its anchor, world axes.
    pub arm_b: Vector3<f64>,
    /// In the last substep, N·s.
    pub impulse: Vector3<f64>,
    /// None: rigid.
    pub softness: Option<RowSoftness>,
    /// Approach from which limits bounce, m/s or rad/s.
    pub least_bounce: f64,
}

/// A spring in the terms of a substep.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RowSoftness {
    terms: SoftTerms<f64>,
    /// Largest impulse in a substep, N·s.
    limit: f64,
}

impl RowSoftness {
    /// Over a substep of `h`, s.
    pub fn new(softness: Softness, h: f64) -> Self {
        let Softness { frequency, damping_ratio, max_force } = softness;
        Self { terms: SoftTerms::new(frequency, damping_ratio, UNLIMITED, 0.0, h), limit: (max_force * h).min(1e30) }
    }

    /// Of a row between those bodies, if it is a spring.
    pub fn of(row: &JointRow<f64>, bodies: [&Body; 2], h: f64) -> Option<Self> {
        let constants = row.spring?;
        let mobility = row.mobility(bodies);
        let terms = SoftTerms::of_spring(constants.per_mass(if mobility > 0.0 { 1.0 / mobility } else { 0.0 }), h);
        let most = if let Bound::Norm { most, .. } = row.bound { most } else { f64::INFINITY };
        Some(Self { terms, limit: (most * h).min(1e30) })
    }
}

/// The terms of joints that are soft by themselves, whatever the sweep.
#[derive(Clone, Debug)]
struct JointSoftness<L: Lanes> {
    terms: SoftTerms<L>,
    /// Largest impulse in a substep, N·s.
    limit: L,
}

impl<L: Lanes> JointSoftness<L> {
    fn new(softness: impl Fn(usize) -> Option<RowSoftness>, h: f64) -> Option<Self> {
        softness(0)?;
        let each = |pick: &dyn Fn(&RowSoftness) -> f64| {
            L::each(|lane| <L::Scalar as Scalar>::of(softness(lane).as_ref().map_or(0.0, pick)))
        };
        Some(Self {
            terms: SoftTerms {
                rate: each(&|softness| softness.terms.rate),
                mass: each(&|softness| softness.terms.mass),
                impulse: each(&|softness| softness.terms.impulse),
                ..SoftTerms::new(1.0, 1.0, UNLIMITED, 0.0, h)
            },
            limit: each(&|softness| softness.limit),
        })
    }
}

/// The linear parts of a block's rows.
pub(crate) trait LinearParts<L: Lanes>: Default {
    /// What they see of the bodies' motions.
    fn seen(&self, pair: &Pair<L>) -> Vector3<L>;

    /// The linear part of an impulse.
    fn apply(&self, pair: &mut Pair<L>, impulse: &Vector3<L>);

    /// Whether [`prescribe`](Self::prescribe) needs the errors.
    const LEAVES_GAPS: bool;

    /// Whether some row has bounds: such rows are solved one at a time, for what one is not to carry the others must.
    fn is_bounded(&self) -> bool {
        false
    }

    /// The errors that impulses within their bounds can still correct.
    fn corrigible(&self, _: &Vector3<L>, error: Vector3<L>) -> Vector3<L> {
        error
    }

    /// Adds to what rows see what is none of their bodies' motion, and gaps that they leave open, which are taken out of
    /// their errors.
    fn prescribe(&self, seen: &mut Vector3<L>, error: &mut Vector3<L>);

    /// What is left of a change of the impulse within bounds of the rows.
    fn admitted(&self, impulse: &Vector3<L>, change: Vector3<L>) -> Vector3<L>;
}

/// The three world axes.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct WorldAxes;

/// Any, with what else rows have that hold no point at a point.
#[derive(Clone, Debug)]
pub(crate) struct Directions<L: Lanes> {
    /// Of A and B.
    linear: [[Vector3<L>; 2]; 3],
    /// ∂C/∂t.
    time_rate: Vector3<L>,
    lower: Vector3<L>,
    upper: Vector3<L>,
    is_bounded: bool,
    /// 1 where positive errors are open gaps, −1 where negative ones are, else 0.
    opens: Vector3<L>,
    /// Rates that limits which are met go back with.
    rebound: Vector3<L>,
    /// 1/h.
    per_step: L,
    /// Of each lane, force and torque about B's anchor for each row's multiplier.
    wrenches: [[Wrench<f64>; 3]; WIDTH],
    /// Rows of one joint.
    scratch: Vec<JointRow<f64>>,
}

impl<L: Lanes> Default for Directions<L> {
    fn default() -> Self {
        let none = Vector3::repeat(L::zero());
        let [time_rate, lower, upper, opens, rebound] = [none; 5];
        let wrenches = [[Wrench::zero(); 3]; WIDTH];
        Self {
            linear: [[none; 2]; 3],
            time_rate,
            lower,
            upper,
            is_bounded: false,
            opens,
            rebound,
            per_step: L::zero(),
            wrenches,
            scratch: Vec::new(),
        }
    }
}

impl<L: Lanes> LinearParts<L> for WorldAxes {
    #[inline(always)]
    fn seen(&self, pair: &Pair<L>) -> Vector3<L> {
        pair.linear()
    }

    #[inline(always)]
    fn apply(&self, pair: &mut Pair<L>, impulse: &Vector3<L>) {
        pair.apply_linear(impulse);
    }

    const LEAVES_GAPS: bool = false;

    #[inline(always)]
    fn prescribe(&self, _: &mut Vector3<L>, _: &mut Vector3<L>) {}

    #[inline(always)]
    fn admitted(&self, _: &Vector3<L>, change: Vector3<L>) -> Vector3<L> {
        change
    }
}

impl<L: Lanes> LinearParts<L> for Directions<L> {
    fn seen(&self, pair: &Pair<L>) -> Vector3<L> {
        Vector3::from_fn(|row, _| pair.along(&self.linear[row]))
    }

    fn apply(&self, pair: &mut Pair<L>, impulse: &Vector3<L>) {
        (0..3).for_each(|row| pair.apply_along(&self.linear[row], impulse[row]));
    }

    const LEAVES_GAPS: bool = true;

    fn is_bounded(&self) -> bool {
        self.is_bounded
    }

    fn corrigible(&self, impulse: &Vector3<L>, error: Vector3<L>) -> Vector3<L> {
        Vector3::from_fn(|row, _| {
            let (error, impulse) = (error[row], impulse[row]);
            let is_up = error.simd_lt(L::zero()) & impulse.simd_ge(self.upper[row]);
            let is_down = error.simd_gt(L::zero()) & impulse.simd_le(self.lower[row]);
            L::zero().select(is_up | is_down, error)
        })
    }

    fn prescribe(&self, seen: &mut Vector3<L>, error: &mut Vector3<L>) {
        for row in 0..3 {
            // What bounces does so at once: a gap that is left open is not closed besides.
            let closes = self.rebound[row].simd_eq(L::zero());
            let open = self.opens[row] * (self.opens[row] * error[row]).simd_max(L::zero());
            error[row] -= open;
            seen[row] += self.time_rate[row] + (open * self.per_step).select(closes, -self.rebound[row]);
        }
    }

    fn admitted(&self, impulse: &Vector3<L>, change: Vector3<L>) -> Vector3<L> {
        let bounded = |row: usize| (impulse[row] + change[row]).simd_clamp(self.lower[row], self.upper[row]);
        Vector3::from_fn(|row, _| bounded(row) - impulse[row])
    }
}

/// One component of a vector, the others zero.
fn only<L: Lanes>(row: usize, of: Vector3<L>) -> Vector3<L> {
    Vector3::from_fn(|index, _| if index == row { of[index] } else { L::zero() })
}

/// Joints of [`Lanes::COUNT`] pairs that share no body that moves.
#[derive(Clone, Debug)]
pub(crate) struct JointBlock<L: Lanes, P = WorldAxes> {
    pub ends: Ends,
    inverse_mass: [Vector3<L>; 2],
    linear: P,
    /// Rows of Q_A and Q_B.
    angular: [[Vector3<L>; 2]; 3],
    error: Vector3<L>,
    /// Inverse of K: xx, xy, xz, yy, yz, zz.
    mass: [L; 6],
    impulse: Vector3<L>,
    softness: Option<JointSoftness<L>>,
}

/// Inverse of a symmetric positive matrix, by cofactors; zero where it is singular.
fn inverse_symmetric<L: Lanes>(k: &Matrix3<L>) -> [L; 6] {
    let (xx, xy, xz, yy, yz, zz) = (k.m11, k.m12, k.m13, k.m22, k.m23, k.m33);
    let (a, b, c) = (yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy);
    let scale = inverse(xx * a + xy * b + xz * c);
    [a, b, c, xx * zz - xz * xz, xy * xz - xx * yz, xx * yy - xy * xy].map(|cofactor| cofactor * scale)
}

impl<L: Lanes> JointBlock<L> {
    /// Takes in at most [`Lanes::COUNT`] joints, all rigid or all soft, whose bodies are at the block's `ends`. Lanes
    /// left over do nothing.
    pub fn take_in(&mut self, inputs: &[JointInput], pairs: &ClaimedPairs<L>, h: f64) {
        let input = |lane: usize| &inputs[lane.min(inputs.len() - 1)];
        let each = |pick: fn(&JointInput) -> &Vector3<f64>| {
            Vector3::from_fn(|axis, _| L::each(|lane| <L::Scalar as Scalar>::of(pick(input(lane))[axis])))
        };
        let frames = pairs.frames();
        let arm = |frame: &Frames<L>, anchor: Vector3<L>| frame.turn_on(&frame.turn(&anchor));
        let arm_a = arm(&frames[0], each(|input| &input.anchors[0]));
        let arm_b = arm(&frames[1], each(|input| &input.anchors[1]));
        let rows = |frame: &Frames<L>, arm: &Vector3<L>| {
            let zero = L::zero();
            // Row i of −[r]ₓ is (r × e_i)ᵀ.
            [Vector3::new(zero, arm.z, -arm.y), Vector3::new(-arm.z, zero, arm.x), Vector3::new(arm.y, -arm.x, zero)]
                .map(|row| frame.whiten(&row))
        };
        let (of_a, of_b) = (rows(&frames[0], &arm_a), rows(&frames[1], &arm_b));
        self.inverse_mass = frames.map(|frame| frame.inverse_mass);
        let k = Matrix3::from_fn(|row, column| {
            let [a, b] = &self.inverse_mass;
            let linear = if row == column { a[row] + b[row] } else { L::zero() };
            linear + dot(&of_a[row], &of_a[column]) + dot(&of_b[row], &of_b[column])
        });
        self.angular = [0, 1, 2].map(|row| [of_a[row], of_b[row]]);
        self.error = each(|input| &input.offset) + arm_b - arm_a;
        self.mass = inverse_symmetric(&k);
        self.impulse = each(|input| &input.impulse);
        self.softness = JointSoftness::new(|lane| input(lane).softness, h);
    }
}

impl<L: Lanes> JointBlock<L, Directions<L>> {
    /// Takes in the rows of at most [`Lanes::COUNT`] joints, all rigid or all soft, whose bodies are at the block's
    /// `ends`. Lanes left over, and rows that a joint does not have, do nothing.
    pub fn take_in_rows(&mut self, inputs: &[RowsInput], pairs: &ClaimedPairs<L>, h: f64) {
        let number = |row: usize, of: &dyn Fn(&JointRow<f64>) -> f64| {
            L::each(|lane| {
                let row = inputs.get(lane).and_then(|input| input.rows[row].as_ref());
                <L::Scalar as Scalar>::of(row.map_or(0.0, of))
            })
        };
        let numbers = |of: fn(&JointRow<f64>) -> f64| Vector3::from_fn(|row, _| number(row, &of));
        let vectors = |of: fn(&JointRow<f64>) -> Vector3<f64>| {
            [0, 1, 2].map(|row| Vector3::from_fn(|axis, _| number(row, &|joint_row| of(joint_row)[axis])))
        };
        let frames = pairs.frames();
        let (linear_a, linear_b) = (vectors(|row| -row.jacobian.linear_a), vectors(|row| row.jacobian.linear_b));
        let angular_a = vectors(|row| -row.jacobian.angular_a).map(|row| frames[0].whiten(&row));
        let angular_b = vectors(|row| row.jacobian.angular_b).map(|row| frames[1].whiten(&row));
        let limits = |row: &JointRow<f64>| match row.bound {
            Bound::Within(lower, upper) => (lower, upper),
            Bound::None | Bound::Norm { .. } => (f64::NEG_INFINITY, f64::INFINITY),
        };
        let limit = |of: &dyn Fn(&JointRow<f64>) -> f64| {
            Vector3::from_fn(|row, _| number(row, &|row| (of(row) * h).clamp(-UNLIMITED, UNLIMITED)))
        };
        self.linear = Directions {
            linear: [0, 1, 2].map(|row| [linear_a[row], linear_b[row]]),
            time_rate: numbers(|row| row.time_rate),
            lower: limit(&|row| limits(row).0),
            upper: limit(&|row| limits(row).1),
            is_bounded: inputs
                .iter()
                .flat_map(|input| input.rows.iter().flatten())
                .any(|row| matches!(row.bound, Bound::Within(..))),
            opens: numbers(|row| row.bound.open(1.0) + row.bound.open(-1.0)),
            rebound: Vector3::from_fn(|row, _| {
                L::each(|lane| {
                    let input = inputs.get(lane);
                    let rebound = input.and_then(|input| input.rows[row]?.rebound(h, input.least_bounce));
                    <L::Scalar as Scalar>::of(rebound.unwrap_or(0.0))
                })
            }),
            per_step: L::of(1.0 / h),
            wrenches: std::array::from_fn(|lane| {
                let input = inputs.get(lane).copied().unwrap_or_default();
                input.rows.map(|row| row.map_or_else(Wrench::zero, |row| row.wrench_about(&input.arm_b)))
            }),
            scratch: std::mem::take(&mut self.linear.scratch),
        };
        self.angular = [0, 1, 2].map(|row| [angular_a[row], angular_b[row]]);
        self.error = numbers(|row| row.error);
        self.inverse_mass = frames.map(|frame| frame.inverse_mass);
        let [mass_a, mass_b] = &self.inverse_mass;
        let mut k = Matrix3::from_fn(|row, column| {
            let linear = dot(&linear_a[row].component_mul(mass_a), &linear_a[column])
                + dot(&linear_b[row].component_mul(mass_b), &linear_b[column]);
            linear + dot(&angular_a[row], &angular_a[column]) + dot(&angular_b[row], &angular_b[column])
        });
        for row in 0..3 {
            // Rows that say the same share what they carry; those that nothing moves, as those there are not, do nothing.
            let own = k[(row, row)];
            k[(row, row)] = (own * L::of(1.0 + DEPENDENT_ROWS)).select(own.simd_gt(L::of(LEAST_MOBILITY)), L::one());
        }
        if self.linear.is_bounded {
            k = Matrix3::from_diagonal(&k.diagonal());
        }
        self.mass = inverse_symmetric(&k);
        let impulse = |lane: usize| inputs.get(lane).map_or_else(Vector3::zeros, |input| input.impulse);
        self.impulse = Vector3::from_fn(|row, _| L::each(|lane| <L::Scalar as Scalar>::of(impulse(lane)[row])));
        self.softness = JointSoftness::new(|lane| inputs[lane.min(inputs.len() - 1)].softness, h);
    }

    /// Room for the rows of one joint.
    pub fn scratch(&mut self) -> &mut Vec<JointRow<f64>> {
        &mut self.linear.scratch
    }

    /// Impulse on B of a joint, N·s, and its moment about B's anchor.
    pub fn wrench(&self, lane: usize) -> Wrench<f64> {
        let impulse = self.impulse(lane);
        let of_rows = self.linear.wrenches[lane].iter().zip(impulse.iter());
        of_rows.fold(Wrench::zero(), |sum, (wrench, &impulse)| sum.plus(wrench, impulse))
    }
}

impl<L: Lanes, P: LinearParts<L>> JointBlock<L, P> {
    /// One that does nothing.
    pub fn idle() -> Self {
        let (zero, none) = (L::zero(), Vector3::repeat(L::zero()));
        Self {
            ends: [[READ_ONLY; WIDTH]; 2],
            inverse_mass: [none; 2],
            linear: P::default(),
            angular: [[none; 2]; 3],
            error: none,
            mass: [zero; 6],
            impulse: none,
            softness: None,
        }
    }

    /// Adds what the impulses at hand do to the velocities.
    pub fn warm_start(&self, pairs: &mut ClaimedPairs<L>) {
        let mut pair = Pair::new(pairs.velocities(), &self.inverse_mass);
        self.apply(&mut pair, &self.impulse);
        pairs.set_velocities(pair.records());
    }

    /// One update, with the terms of `soft` where given, rigid and without bias where not.
    pub fn solve(&mut self, pairs: &mut ClaimedPairs<L>, soft: Option<&SoftTerms<L>>) {
        if self.linear.is_bounded() {
            (0..3).for_each(|row| self.update(pairs, soft, |of| only(row, of)));
        } else {
            self.update(pairs, soft, |of| of);
        }
    }

    /// One update of the rows that `own` leaves of a vector of them.
    #[inline(always)]
    fn update(
        &mut self,
        pairs: &mut ClaimedPairs<L>,
        soft: Option<&SoftTerms<L>>,
        own: impl Fn(Vector3<L>) -> Vector3<L>,
    ) {
        let mut pair = Pair::new(pairs.velocities(), &self.inverse_mass);
        let mut seen = self.rows(&pair);
        let soft = self.softness.as_ref().map(|softness| &softness.terms).or(soft);
        let mut error = Vector3::repeat(L::zero());
        if soft.is_some() || P::LEAVES_GAPS {
            error = self.error + self.rows(&Pair::new(pairs.displacements(), &self.inverse_mass));
        }
        self.linear.prescribe(&mut seen, &mut error);
        if let Some(soft) = soft {
            let speed = dot(&error, &error).simd_sqrt() * soft.rate;
            let rate = soft.rate * (soft.max_speed / speed.simd_max(soft.max_speed));
            seen = add_scaled(&seen, &error, rate) * soft.mass;
        }
        let mut change = -self.effective_mass(&seen);
        if let Some(soft) = soft {
            change = add_scaled(&change, &self.impulse, -soft.impulse);
        }
        if let Some(JointSoftness { limit, .. }) = self.softness {
            change = bounded(self.impulse + change, limit) - self.impulse;
        }
        let change = own(self.linear.admitted(&self.impulse, change));
        self.impulse += change;
        self.apply(&mut pair, &change);
        pairs.set_velocities(pair.records());
    }

    /// Forgets the impulses at hand.
    pub fn forget(&mut self) {
        self.impulse = Vector3::repeat(L::zero());
    }

    /// Moves the bodies out of a share of the error. Joints that are soft by themselves have none.
    pub fn project(&self, pairs: &mut ClaimedPairs<L>, terms: &Projection<L>) {
        if self.softness.is_some() {
            return;
        }
        let mut pair = Pair::new(pairs.displacements(), &self.inverse_mass);
        let rounds = if self.linear.is_bounded() { 3 } else { 1 };
        for row in 0..rounds {
            let mut error = self.error + self.rows(&pair);
            self.linear.prescribe(&mut Vector3::repeat(L::zero()), &mut error);
            error = self.linear.corrigible(&self.impulse, error);
            if rounds > 1 {
                error = only(row, error);
            }
            let most = terms.max_correction;
            let share = terms.joint_share * (most / dot(&error, &error).simd_sqrt().simd_max(most));
            self.apply(&mut pair, &(self.effective_mass(&error) * -share));
        }
        pairs.set_displacements(pair.records());
    }

    /// K⁻¹ times that.
    #[inline(always)]
    fn effective_mass(&self, seen: &Vector3<L>) -> Vector3<L> {
        let [xx, xy, xz, yy, yz, zz] = self.mass;
        Vector3::new(
            dot(&Vector3::new(xx, xy, xz), seen),
            dot(&Vector3::new(xy, yy, yz), seen),
            dot(&Vector3::new(xz, yz, zz), seen),
        )
    }

    /// What the rows see of the bodies' motions.
    #[inline(always)]
    fn rows(&self, pair: &Pair<L>) -> Vector3<L> {
        let linear = self.linear.seen(pair);
        Vector3::from_fn(|axis, _| pair.row(linear[axis], &self.angular[axis]))
    }

    #[inline(always)]
    fn apply(&self, pair: &mut Pair<L>, impulse: &Vector3<L>) {
        self.linear.apply(pair, impulse);
        for axis in 0..3 {
            pair.apply_angular(&self.angular[axis], impulse[axis]);
        }
    }

    /// The impulse of each row of a joint, N·s: of a point's on B.
    pub fn impulse(&self, lane: usize) -> Vector3<f64> {
        self.impulse.map(|lanes| lanes.lane(lane).to_f64())
    }
}
