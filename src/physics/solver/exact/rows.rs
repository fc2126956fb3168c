//! The rows of a mechanism's joints at one pose: J, W = M̃⁻¹ and the factor of J W Jᵀ.
//!
//! A joint's rows are the relative motion of its two points, B less A: J = [−1, [r_A]×, 1, −[r_B]×]. Its block on the
//! diagonal is Σ m⁻¹ 1 + [r]× I⁻¹ [r]×ᵀ over the two members, the block of two joints on one member
//! ± (m⁻¹ 1 + [r₁]× I⁻¹ [r₂]×ᵀ), negative where the member is A of one and B of the other.

use nalgebra::{Matrix3, Vector3};

use super::group::cross_matrix;
use super::mechanism::Mechanism;
use crate::physics::solver::linear::{BlockLdl, Triangular};

/// Linear and angular: a velocity, an acceleration, or a force and torque.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Screw {
    pub linear: Vector3<f64>,
    pub angular: Vector3<f64>,
}

impl Screw {
    pub const ZERO: Self = Self { linear: Vector3::new(0.0, 0.0, 0.0), angular: Vector3::new(0.0, 0.0, 0.0) };
}

/// W of one member: zero where nothing moves it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Weight {
    pub linear: Vector3<f64>,
    pub angular: Matrix3<f64>,
}

impl Weight {
    #[inline]
    pub fn of(&self, wrench: &Screw) -> Screw {
        Screw { linear: self.linear.component_mul(&wrench.linear), angular: self.angular * wrench.angular }
    }
}

/// Least and greatest shift of what may be singular, as a share of each block's trace.
const SHIFTS: [f64; 2] = [1e-10, 1e-3];

/// Turns of the method of multipliers: each leaves ε/(σ² + ε) of what acts along a singular value σ.
const TURNS: usize = 6;

/// J, W and the factor.
#[derive(Clone, Debug, Default)]
pub(crate) struct Rows {
    /// r_A and r_B of each link.
    pub arms: Vec<[Vector3<f64>; 2]>,
    /// W of each member.
    pub weights: Vec<Weight>,
    /// Of each link, added to its diagonal: what a spring gives. Empty where there is none.
    pub softness: Vec<Matrix3<f64>>,
    /// I⁻¹ [r]×ᵀ of each link's ends.
    levers: Vec<[Matrix3<f64>; 2]>,
    /// The mean diagonal of each link's block, 1/kg.
    pub mobility: Vec<Vector3<f64>>,
    factor: BlockLdl<f64, Triangular>,
    residual: Vec<Vector3<f64>>,
    motion: Vec<Screw>,
}

impl Rows {
    /// Makes and factors J W Jᵀ for the arms and weights set; `soften` tells what is added to a link's diagonal, whose
    /// own is given.
    /// For what may be singular, `turn` is how far it turns meanwhile, rad: levers shorter than that are not resolved.
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
                    let weight = &self.weights[member as usize];
                    // Rows of I⁻¹ [r]×ᵀ = −I⁻¹ [r]×.
                    levers[end] = lever(&weight.angular, &arms[end]);
                    diagonal += Matrix3::from_diagonal(&weight.linear) + cross_product(&arms[end], &levers[end]);
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
            let weight = &self.weights[coupling.member as usize];
            let arm = &self.arms[coupling.row.0 as usize][coupling.row.1];
            let lever = &self.levers[coupling.column.0 as usize][coupling.column.1];
            let block = Matrix3::from_diagonal(&weight.linear) + cross_product(arm, lever);
            let mut below = factor.below_mut::<3>(coupling.block as usize);
            below += block * coupling.sign;
        }
        let [least, most] = SHIFTS;
        if mechanism.may_be_singular {
            factor.shift(&mechanism.elimination, (4.0 * turn * turn).clamp(least, most));
        }
        factor.factor(&mechanism.elimination);
    }

    /// x ← (A + E)⁻¹ x, once: for those who come back with what is left.
    #[inline]
    pub fn solve_once(&self, mechanism: &Mechanism, x: &mut [Vector3<f64>]) {
        self.factor.solve(&mechanism.elimination, x);
    }

    /// λ ← A⁻¹ b, in a few turns of the method of multipliers from zero where A may be singular.
    pub fn solve(&mut self, mechanism: &Mechanism, b: &[Vector3<f64>], lambda: &mut Vec<Vector3<f64>>) {
        lambda.clear();
        lambda.extend_from_slice(b);
        self.solve_once(mechanism, lambda);
        let turns = if mechanism.may_be_singular { TURNS } else { 1 };
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
        let mut motion = std::mem::take(&mut self.motion);
        self.respond(mechanism, lambda, &mut motion);
        residual.clear();
        for (index, link) in mechanism.links.iter().enumerate() {
            let mut left = b[index] - self.relative(index, link.a, link.b, &motion);
            if let Some(softness) = self.softness.get(index) {
                left -= softness * lambda[index];
            }
            residual.push(left);
        }
        self.motion = motion;
    }

    /// W Jᵀ λ of all members.
    pub fn respond(&self, mechanism: &Mechanism, lambda: &[Vector3<f64>], motion: &mut Vec<Screw>) {
        motion.clear();
        motion.resize(mechanism.members.len(), Screw::ZERO);
        self.add_wrenches(mechanism, lambda, motion);
        for (motion, weight) in motion.iter_mut().zip(&self.weights) {
            *motion = weight.of(motion);
        }
    }

    /// wrenches += Jᵀ λ.
    #[inline]
    pub fn add_wrenches(&self, mechanism: &Mechanism, lambda: &[Vector3<f64>], wrenches: &mut [Screw]) {
        for ((link, arms), force) in mechanism.links.iter().zip(&self.arms).zip(lambda) {
            let a = &mut wrenches[link.a as usize];
            a.linear -= force;
            a.angular -= arms[0].cross(force);
            let b = &mut wrenches[link.b as usize];
            b.linear += force;
            b.angular += arms[1].cross(force);
        }
    }

    /// J of one link times the motion of its members.
    #[inline]
    pub fn relative(&self, link: usize, a: u32, b: u32, motion: &[Screw]) -> Vector3<f64> {
        let [arm_a, arm_b] = &self.arms[link];
        let (a, b) = (&motion[a as usize], &motion[b as usize]);
        b.linear + b.angular.cross(arm_b) - a.linear - a.angular.cross(arm_a)
    }
}

/// I⁻¹ [r]×ᵀ.
#[inline]
fn lever(inverse_inertia: &Matrix3<f64>, arm: &Vector3<f64>) -> Matrix3<f64> {
    inverse_inertia * -cross_matrix(arm)
}

/// [r]× m.
#[inline]
fn cross_product(r: &Vector3<f64>, m: &Matrix3<f64>) -> Matrix3<f64> {
    Matrix3::from_columns(&[r.cross(&m.column(0)), r.cross(&m.column(1)), r.cross(&m.column(2))])
}
