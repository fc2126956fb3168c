//! Ball joints of as many pairs as there are lanes, by sweeps: for loops and grids, and whatever is
//! not solved as a tree.
//!
//! With Q = −[r]ₓ W the velocity of the anchors' parting is u = v_B − v_A + Q_B ψ_B − Q_A ψ_A, and
//! one update, with K = M_A⁻¹ + M_B⁻¹ + Q_A Q_Aᵀ + Q_B Q_Bᵀ, is λ ← λ − K⁻¹ σ (u + bias) − ι λ with the
//! soft terms of contacts. The error is C + d_B − d_A + Q_B θ'_B − Q_A θ'_A.
#![allow(unsafe_code)]

use nalgebra::{Matrix3, Vector3};

use super::bodies::Frames;
use crate::physics::constraint::row::bounded;
use crate::physics::joint::Softness;
use crate::physics::lanes::{Lanes, READ_ONLY, Record, WIDTH, add_scaled, dot, inverse, vector};
use crate::physics::scalar::Scalar;
use crate::physics::solver::soft_terms::{Projection, SoftTerms, UNLIMITED};
use crate::physics::threads::Shared;

/// One joint as a block takes it in.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct JointSite {
    /// Indices into the group's bodies, [`READ_ONLY`] flagged.
    pub a: u32,
    pub b: u32,
    /// From the centres of mass, body axes.
    pub anchor_a: Vector3<f64>,
    pub anchor_b: Vector3<f64>,
    /// Centre of B less centre of A, m.
    pub apart: Vector3<f64>,
    /// On B, N·s, what it carried in the last substep.
    pub impulse: Vector3<f64>,
    /// None: rigid.
    pub softness: Option<Softness>,
}

/// Joints that are springs, whatever the pass.
#[derive(Clone, Debug)]
struct Springs<L: Lanes> {
    terms: SoftTerms<L>,
    /// Most a spring pushes in a substep, N·s.
    limit: L,
}

impl<L: Lanes> Springs<L> {
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
    a: [u32; WIDTH],
    b: [u32; WIDTH],
    inverse_mass_a: Vector3<L>,
    inverse_mass_b: Vector3<L>,
    /// Rows of Q.
    angular_a: [Vector3<L>; 3],
    angular_b: [Vector3<L>; 3],
    error: Vector3<L>,
    /// Inverse of K: xx, xy, xz, yy, yz, zz.
    mass: [L; 6],
    impulse: Vector3<L>,
    springs: Option<Springs<L>>,
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
            a: [READ_ONLY; WIDTH],
            b: [READ_ONLY; WIDTH],
            inverse_mass_a: none,
            inverse_mass_b: none,
            angular_a: [none; 3],
            angular_b: [none; 3],
            error: none,
            mass: [zero; 6],
            impulse: none,
            springs: None,
        }
    }

    /// Takes in at most [`Lanes::COUNT`] joints, all rigid or all springs. Lanes left over do nothing.
    ///
    /// # Safety
    /// Nobody may be writing the frames.
    pub unsafe fn new(sites: &[JointSite], frames: Shared<Record<L::Scalar>>, h: f64) -> Self {
        let site = |lane: usize| &sites[lane.min(sites.len() - 1)];
        let idle = |lane: usize| if lane < sites.len() { 0 } else { READ_ONLY };
        let a: [u32; WIDTH] = std::array::from_fn(|lane| site(lane).a | idle(lane));
        let b: [u32; WIDTH] = std::array::from_fn(|lane| site(lane).b | idle(lane));
        let each = |pick: fn(&JointSite) -> &Vector3<f64>| {
            Vector3::from_fn(|axis, _| L::each(|lane| <L::Scalar as Scalar>::of(pick(site(lane))[axis])))
        };
        // SAFETY: as the caller promises.
        let (of_a, of_b) = unsafe { (Frames::<L>::gather(frames, &a), Frames::<L>::gather(frames, &b)) };
        let arm_a = of_a.turn_on(&of_a.turn(&each(|site| &site.anchor_a)));
        let arm_b = of_b.turn_on(&of_b.turn(&each(|site| &site.anchor_b)));
        let rows = |frames: &Frames<L>, arm: &Vector3<L>| {
            let zero = L::zero();
            // Row i of −[r]ₓ is (r × e_i)ᵀ.
            [Vector3::new(zero, arm.z, -arm.y), Vector3::new(-arm.z, zero, arm.x), Vector3::new(arm.y, -arm.x, zero)]
                .map(|row| frames.whiten(&row))
        };
        let (angular_a, angular_b) = (rows(&of_a, &arm_a), rows(&of_b, &arm_b));
        let k = Matrix3::from_fn(|row, column| {
            let linear = if row == column { of_a.inverse_mass[row] + of_b.inverse_mass[row] } else { L::zero() };
            linear + dot(&angular_a[row], &angular_a[column]) + dot(&angular_b[row], &angular_b[column])
        });
        Self {
            a,
            b,
            inverse_mass_a: of_a.inverse_mass,
            inverse_mass_b: of_b.inverse_mass,
            angular_a,
            angular_b,
            error: each(|site| &site.apart) + arm_b - arm_a,
            mass: inverse_symmetric(&k),
            impulse: each(|site| &site.impulse),
            springs: Springs::new(|lane| site(lane).softness, h),
        }
    }

    /// Adds what the impulses at hand do to the velocities.
    ///
    /// # Safety
    /// Nobody else may be using the bodies of its pairs.
    pub unsafe fn warm_start(&self, velocity: Shared<Record<L::Scalar>>) {
        // SAFETY: as the caller promises.
        let mut pair = unsafe { self.gather(velocity) };
        self.apply(&mut pair, &self.impulse);
        // SAFETY: as the caller promises.
        unsafe { self.scatter(pair, velocity) };
    }

    /// One update, with springs where `soft` says how, rigid and without bias where not.
    ///
    /// # Safety
    /// Nobody else may be using the bodies of its pairs.
    pub unsafe fn solve(
        &mut self,
        velocity: Shared<Record<L::Scalar>>,
        moved: Shared<Record<L::Scalar>>,
        soft: Option<&SoftTerms<L>>,
    ) {
        // SAFETY: as the caller promises.
        let mut pair = unsafe { self.gather(velocity) };
        let mut parting = self.along(&pair);
        let soft = self.springs.as_ref().map(|springs| &springs.terms).or(soft);
        if let Some(soft) = soft {
            // SAFETY: positions rest during a sweep.
            let moved = unsafe { [L::gather(moved, &self.a), L::gather(moved, &self.b)] };
            let error = self.error + self.along(&moved);
            let speed = dot(&error, &error).simd_sqrt() * soft.rate;
            let rate = soft.rate * (soft.push / speed.simd_max(soft.push));
            parting = add_scaled(&parting, &error, rate) * soft.mass;
        }
        let mut change = -self.against(&parting);
        if let Some(soft) = soft {
            change = add_scaled(&change, &self.impulse, -soft.impulse);
        }
        if let Some(Springs { limit, .. }) = self.springs {
            change = bounded(self.impulse + change, limit) - self.impulse;
        }
        self.impulse += change;
        self.apply(&mut pair, &change);
        // SAFETY: as the caller promises.
        unsafe { self.scatter(pair, velocity) };
    }

    /// Forgets the impulses at hand.
    pub fn forget(&mut self) {
        self.impulse = Vector3::repeat(L::zero());
    }

    /// Moves the bodies out of a share of the error. Springs have none.
    ///
    /// # Safety
    /// Nobody else may be using the bodies of its pairs.
    pub unsafe fn project(&self, moved: Shared<Record<L::Scalar>>, terms: &Projection<L>) {
        if self.springs.is_some() {
            return;
        }
        // SAFETY: as the caller promises.
        let mut pair = unsafe { self.gather(moved) };
        let error = self.error + self.along(&pair);
        let share = terms.joint * (terms.most / dot(&error, &error).simd_sqrt().simd_max(terms.most));
        self.apply(&mut pair, &(self.against(&error) * -share));
        // SAFETY: as the caller promises.
        unsafe { self.scatter(pair, moved) };
    }

    /// K⁻¹ times what the rows see.
    #[inline(always)]
    fn against(&self, seen: &Vector3<L>) -> Vector3<L> {
        let [xx, xy, xz, yy, yz, zz] = self.mass;
        Vector3::new(
            dot(&Vector3::new(xx, xy, xz), seen),
            dot(&Vector3::new(xy, yy, yz), seen),
            dot(&Vector3::new(xz, yz, zz), seen),
        )
    }

    /// What the rows make of velocities or moves of the two bodies.
    #[inline(always)]
    fn along(&self, [a, b]: &[[L; WIDTH]; 2]) -> Vector3<L> {
        let (turn_a, turn_b) = (vector(&a[3..]), vector(&b[3..]));
        Vector3::from_fn(|axis, _| {
            b[axis] - a[axis] + dot(&self.angular_b[axis], &turn_b) - dot(&self.angular_a[axis], &turn_a)
        })
    }

    #[inline(always)]
    fn apply(&self, [a, b]: &mut [[L; WIDTH]; 2], impulse: &Vector3<L>) {
        let (mut turn_a, mut turn_b) = (vector(&a[3..]), vector(&b[3..]));
        for axis in 0..3 {
            a[axis] -= self.inverse_mass_a[axis] * impulse[axis];
            b[axis] += self.inverse_mass_b[axis] * impulse[axis];
            turn_a = add_scaled(&turn_a, &self.angular_a[axis], -impulse[axis]);
            turn_b = add_scaled(&turn_b, &self.angular_b[axis], impulse[axis]);
        }
        a[3..6].copy_from_slice(turn_a.as_slice());
        b[3..6].copy_from_slice(turn_b.as_slice());
    }

    #[inline(always)]
    unsafe fn gather(&self, velocity: Shared<Record<L::Scalar>>) -> [[L; WIDTH]; 2] {
        // SAFETY: as the caller promises.
        unsafe { [L::gather(velocity, &self.a), L::gather(velocity, &self.b)] }
    }

    #[inline(always)]
    unsafe fn scatter(&self, [a, b]: [[L; WIDTH]; 2], velocity: Shared<Record<L::Scalar>>) {
        // SAFETY: as the caller promises.
        unsafe {
            L::scatter(a, velocity, &self.a);
            L::scatter(b, velocity, &self.b);
        }
    }

    /// The impulse on B of each joint, N·s.
    pub fn impulse(&self, lane: usize) -> Vector3<f64> {
        self.impulse.map(|lanes| lanes.lane(lane).to_f64())
    }
}
