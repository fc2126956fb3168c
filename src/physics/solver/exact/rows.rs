//! The rows of a mechanism's joints at one pose: J, W = M̃⁻¹ and the factor of J W Jᵀ.
//!
//! A joint's rows are the relative velocity of its two points, B less A: J = [−1, [r_A]×, 1, −[r_B]×]. Its block on the
//! diagonal is Σ m⁻¹ 1 + [r]× I⁻¹ [r]×ᵀ over the two members, the block of two joints on one member
//! ± (m⁻¹ 1 + [r₁]× I⁻¹ [r₂]×ᵀ), negative where the member is A of one and B of the other.

use nalgebra::{Matrix3, Vector3};

use super::constants::{MULTIPLIER_ITERATIONS, SHIFTS};
use super::mechanism::Mechanism;
use crate::physics::solver::linear::{BlockLdl, Number, Triangular};

/// Linear and angular: a velocity, an acceleration, or a force and torque.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SpatialVector<N = f64> {
    pub linear: Vector3<N>,
    pub angular: Vector3<N>,
}

impl SpatialVector {
    pub const ZERO: Self = Self { linear: Vector3::new(0.0, 0.0, 0.0), angular: Vector3::new(0.0, 0.0, 0.0) };
}

/// W of one member: zero where constraints do not move it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct InverseMass {
    pub linear: Vector3<f64>,
    pub angular: Matrix3<f64>,
}

impl InverseMass {
    #[inline]
    pub fn of(&self, wrench: &SpatialVector) -> SpatialVector {
        SpatialVector { linear: self.linear.component_mul(&wrench.linear), angular: self.angular * wrench.angular }
    }
}

/// J, W and the factor.
#[derive(Clone, Debug, Default)]
pub(crate) struct MechanismRows {
    /// r_A and r_B of each link.
    pub arms: Vec<[Vector3<f64>; 2]>,
    /// W of each member.
    pub inverse_masses: Vec<InverseMass>,
    /// Softness of each link, added to its diagonal; empty where no link is a spring.
    pub softness: Vec<Matrix3<f64>>,
    /// I⁻¹ [r]×ᵀ of each link's ends.
    levers: Vec<[Matrix3<f64>; 2]>,
    /// The mean diagonal of each link's block, 1/kg.
    pub mobility: Vec<Vector3<f64>>,
    factor: BlockLdl<f64, Triangular>,
    residual: Vec<Vector3<f64>>,
    velocities: Vec<SpatialVector>,
}

impl MechanismRows {
    /// Makes and factors J W Jᵀ for the arms and inverse masses set; `soften` tells the softness of a spring, given the
    /// diagonal without it. Where rows may be redundant, `turn` is the turn of the step, rad: levers that differ by less
    /// are not resolved.
    pub fn assemble(
        &mut self,
        mechanism: &Mechanism,
        turn: f64,
        mut soften: impl FnMut(usize, &Vector3<f64>) -> Matrix3<f64>,
    ) {
        let factor = &mut self.factor;
        factor.clear(&mechanism.elimination);
        self.levers.clear();
        self.softness.clear();
        self.mobility.clear();
        for (index, (link, arms)) in mechanism.links.iter().zip(&self.arms).enumerate() {
            let mut diagonal = Matrix3::zeros();
            let mut levers = [Matrix3::zeros(); 2];
            for (end, member) in [link.a, link.b].into_iter().enumerate() {
                if (member as usize) < mechanism.moving {
                    let inverse_mass = &self.inverse_masses[member as usize];
                    levers[end] = lever(&inverse_mass.angular, &arms[end]);
                    diagonal += Matrix3::from_diagonal(&inverse_mass.linear) + cross_product(&arms[end], &levers[end]);
                }
            }
            let own = diagonal.diagonal();
            if mechanism.gives {
                let softness = if link.spring.is_some() { soften(index, &own) } else { Matrix3::zeros() };
                self.softness.push(softness);
                diagonal += softness;
            }
            self.mobility.push(own);
            self.levers.push(levers);
            factor.diagonal_mut::<3>(index).copy_from(&diagonal);
        }
        for coupling in &mechanism.couplings {
            let inverse_mass = &self.inverse_masses[coupling.member as usize];
            let arm = &self.arms[coupling.row.0 as usize][coupling.row.1];
            let lever = &self.levers[coupling.column.0 as usize][coupling.column.1];
            let block = Matrix3::from_diagonal(&inverse_mass.linear) + cross_product(arm, lever);
            let mut below = factor.below_mut::<3>(coupling.block as usize);
            below += block * coupling.sign;
        }
        let [least, most] = SHIFTS;
        if mechanism.may_be_singular {
            factor.shift(&mechanism.elimination, (4.0 * turn * turn).clamp(least, most));
        }
        factor.factor(&mechanism.elimination);
    }

    /// x ← (A + E)⁻¹ x, once: for iterations that come back with the residual.
    #[inline]
    pub fn solve_once(&self, mechanism: &Mechanism, x: &mut [Vector3<f64>]) {
        self.factor.solve(&mechanism.elimination, x);
    }

    /// λ ← A⁻¹ b; where A may be singular, by a few iterations of the method of multipliers from zero.
    pub fn solve(&mut self, mechanism: &Mechanism, b: &[Vector3<f64>], lambda: &mut Vec<Vector3<f64>>) {
        lambda.clear();
        lambda.extend_from_slice(b);
        self.solve_once(mechanism, lambda);
        let turns = if mechanism.may_be_singular { MULTIPLIER_ITERATIONS } else { 1 };
        let mut residual = std::mem::take(&mut self.residual);
        for _ in 1..turns {
            self.find_residual(mechanism, b, lambda, &mut residual);
            self.solve_once(mechanism, &mut residual);
            for (lambda, more) in lambda.iter_mut().zip(&residual) {
                *lambda += more;
            }
        }
        self.residual = residual;
    }

    /// b − A λ.
    fn find_residual(
        &mut self,
        mechanism: &Mechanism,
        b: &[Vector3<f64>],
        lambda: &[Vector3<f64>],
        residual: &mut Vec<Vector3<f64>>,
    ) {
        let mut velocities = std::mem::take(&mut self.velocities);
        self.respond(mechanism, lambda, &mut velocities);
        residual.clear();
        for (index, link) in mechanism.links.iter().enumerate() {
            let mut left = b[index] - self.relative(index, link.a, link.b, &velocities);
            if let Some(softness) = self.softness.get(index) {
                left -= softness * lambda[index];
            }
            residual.push(left);
        }
        self.velocities = velocities;
    }

    /// W Jᵀ λ of all members.
    pub fn respond(&self, mechanism: &Mechanism, lambda: &[Vector3<f64>], velocities: &mut Vec<SpatialVector>) {
        velocities.clear();
        velocities.resize(mechanism.members.len(), SpatialVector::ZERO);
        self.add_wrenches(mechanism, lambda, velocities);
        for (velocity, inverse_mass) in velocities.iter_mut().zip(&self.inverse_masses) {
            *velocity = inverse_mass.of(velocity);
        }
    }

    /// wrenches += Jᵀ λ.
    #[inline]
    pub fn add_wrenches(&self, mechanism: &Mechanism, lambda: &[Vector3<f64>], wrenches: &mut [SpatialVector]) {
        add_wrenches(mechanism, &self.arms, lambda, wrenches);
    }

    /// J of one link times velocities.
    #[inline]
    pub fn relative(&self, link: usize, a: u32, b: u32, velocities: &[SpatialVector]) -> Vector3<f64> {
        let [arm_a, arm_b] = &self.arms[link];
        let (a, b) = (&velocities[a as usize], &velocities[b as usize]);
        b.linear + b.angular.cross(arm_b) - a.linear - a.angular.cross(arm_a)
    }
}

/// r_A and r_B of all links for rotations of the members.
pub(super) fn place_arms(mechanism: &Mechanism, rotations: &[Matrix3<f64>], arms: &mut Vec<[Vector3<f64>; 2]>) {
    arms.clear();
    for link in &mechanism.links {
        arms.push([rotations[link.a as usize] * link.anchor_a, rotations[link.b as usize] * link.anchor_b]);
    }
}

/// wrenches += Jᵀ λ for those arms; members beyond the wrenches given have none.
#[inline]
pub(super) fn add_wrenches<N: Number>(
    mechanism: &Mechanism,
    arms: &[[Vector3<N>; 2]],
    lambda: &[Vector3<N>],
    wrenches: &mut [SpatialVector<N>],
) {
    for ((link, [arm_a, arm_b]), force) in mechanism.links.iter().zip(arms).zip(lambda) {
        if let Some(a) = wrenches.get_mut(link.a as usize) {
            a.linear -= force;
            a.angular -= arm_a.cross(force);
        }
        if let Some(b) = wrenches.get_mut(link.b as usize) {
            b.linear += force;
            b.angular += arm_b.cross(force);
        }
    }
}

/// I⁻¹ [r]×ᵀ: its columns are those of I⁻¹ r × e.
#[inline]
pub(super) fn lever<N: Number>(inverse_inertia: &Matrix3<N>, r: &Vector3<N>) -> Matrix3<N> {
    let (x, y, z) = (inverse_inertia.column(0), inverse_inertia.column(1), inverse_inertia.column(2));
    Matrix3::from_columns(&[z * r.y - y * r.z, x * r.z - z * r.x, y * r.x - x * r.y])
}

/// [r]× m.
#[inline]
pub(super) fn cross_product<N: Number>(r: &Vector3<N>, m: &Matrix3<N>) -> Matrix3<N> {
    Matrix3::from_columns(&[r.cross(&m.column(0)), r.cross(&m.column(1)), r.cross(&m.column(2))])
}
