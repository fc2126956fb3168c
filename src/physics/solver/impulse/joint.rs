//! Ball joints of as many pairs as there are lanes, by sweeps: for loops and grids, and whatever is
//! not solved as a tree.
//!
//! With Q = −[r]ₓ W the velocity of the anchors' parting is u = v_B − v_A + Q_B ψ_B − Q_A ψ_A, and
//! one update, with K = M_A⁻¹ + M_B⁻¹ + Q_A Q_Aᵀ + Q_B Q_Bᵀ, is λ ← λ − K⁻¹ σ (u + bias) − ι λ with the
//! soft terms of contacts. The error is C + d_B − d_A + Q_B θ'_B − Q_A θ'_A.

use nalgebra::{Matrix3, Vector3};

use super::bodies::{ClaimedPairs, Ends, Frames};
use super::pair::Pair;
use crate::physics::constraint::row::bounded;
use crate::physics::joint::Softness;
use crate::physics::lanes::{Lanes, READ_ONLY, WIDTH, add_scaled, dot, inverse};
use crate::physics::scalar::Scalar;
use crate::physics::solver::soft_terms::{Projection, SoftTerms, UNLIMITED};

/// One joint, as its lane takes it in.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct JointInput {
    /// On A and on B, from the centres of mass, body axes.
    pub anchors: [Vector3<f64>; 2],
    /// Centre of B less centre of A, m.
    pub offset: Vector3<f64>,
    /// On B in the last substep, N·s.
    pub impulse: Vector3<f64>,
    /// None: rigid.
    pub softness: Option<Softness>,
}

/// The terms of joints that are soft by themselves, whatever the sweep.
#[derive(Clone, Debug)]
struct JointSoftness<L: Lanes> {
    terms: SoftTerms<L>,
    /// Largest impulse in a substep, N·s.
    limit: L,
}

impl<L: Lanes> JointSoftness<L> {
    fn new(softness: impl Fn(usize) -> Option<Softness>, h: f64) -> Option<Self> {
        softness(0)?;
        let each = |pick: &dyn Fn(Softness) -> f64| {
            L::each(|lane| <L::Scalar as Scalar>::of(softness(lane).map_or(0.0, pick)))
        };
        let terms =
            |softness: Softness| SoftTerms::<f64>::new(softness.frequency, softness.damping_ratio, UNLIMITED, 0.0, h);
        Some(Self {
            terms: SoftTerms {
                rate: each(&|softness| terms(softness).rate),
                mass: each(&|softness| terms(softness).mass),
                impulse: each(&|softness| terms(softness).impulse),
                ..SoftTerms::new(1.0, 1.0, UNLIMITED, 0.0, h)
            },
            limit: each(&|softness| (softness.max_force * h).min(1e30)),
        })
    }
}

/// Joints of [`Lanes::COUNT`] pairs that share no body that moves.
#[derive(Clone, Debug)]
pub(crate) struct JointBlock<L: Lanes> {
    pub ends: Ends,
    inverse_mass: [Vector3<L>; 2],
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
    /// One that does nothing.
    pub fn idle() -> Self {
        let (zero, none) = (L::zero(), Vector3::repeat(L::zero()));
        Self {
            ends: [[READ_ONLY; WIDTH]; 2],
            inverse_mass: [none; 2],
            angular: [[none; 2]; 3],
            error: none,
            mass: [zero; 6],
            impulse: none,
            softness: None,
        }
    }

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

    /// Adds what the impulses at hand do to the velocities.
    pub fn warm_start(&self, pairs: &mut ClaimedPairs<L>) {
        let mut pair = Pair::new(pairs.velocities(), &self.inverse_mass);
        self.apply(&mut pair, &self.impulse);
        pairs.set_velocities(pair.records());
    }

    /// One update, with the terms of `soft` where given, rigid and without bias where not.
    pub fn solve(&mut self, pairs: &mut ClaimedPairs<L>, soft: Option<&SoftTerms<L>>) {
        let mut pair = Pair::new(pairs.velocities(), &self.inverse_mass);
        let mut seen = self.rows(&pair);
        let soft = self.softness.as_ref().map(|softness| &softness.terms).or(soft);
        if let Some(soft) = soft {
            let error = self.error + self.rows(&Pair::new(pairs.displacements(), &self.inverse_mass));
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
        let error = self.error + self.rows(&pair);
        let most = terms.max_correction;
        let share = terms.joint_share * (most / dot(&error, &error).simd_sqrt().simd_max(most));
        self.apply(&mut pair, &(self.effective_mass(&error) * -share));
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
        let linear = pair.linear();
        Vector3::from_fn(|axis, _| pair.row(linear[axis], &self.angular[axis]))
    }

    #[inline(always)]
    fn apply(&self, pair: &mut Pair<L>, impulse: &Vector3<L>) {
        pair.apply_linear(impulse);
        for axis in 0..3 {
            pair.apply_angular(&self.angular[axis], impulse[axis]);
        }
    }

    /// The impulse on B of each joint, N·s.
    pub fn impulse(&self, lane: usize) -> Vector3<f64> {
        self.impulse.map(|lanes| lanes.lane(lane).to_f64())
    }
}
