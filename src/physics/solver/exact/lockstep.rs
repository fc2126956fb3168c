//! Gauss's method of four stages (order 8), all four at once in the lanes of a register, for mechanisms that are not
//! stiff and whose joints are points: for each, arms r_A and r_B say all of its rows.
//!
//! The stages of a collocation method do the same work, each on its own numbers. Here a number is one of
//! [`WideF64x4`], with the stages in its lanes; sums over the stages mix the lanes. The equations are those of
//! [`gauss`](super::gauss); an iteration changes all stages at once (Jacobi's way instead of Gauss and Seidel's), with
//! M̃ = M.

use nalgebra::{Matrix3, UnitQuaternion, Vector3};
use simba::simd::{SimdValue, WideF64x4};

use super::constants::{
    CHANGE_OVER_SQUARE, LEAST_CHANGE, LOCKSTEP_ITERATIONS, LOCKSTEP_SOFT, LOCKSTEP_UNCONVERGED, MOST_FACTORS,
    SERIES_TURN, SLOW_ITERATION,
};
use super::gauss::{RoundingCarry, StageIterations};
use super::mechanism::Mechanism;
use super::rotation::{exponential, in_world, small_exponential, small_inverse_dexp};
use super::tableau::Tableau;
use crate::physics::constraint::row::Twist;
use crate::physics::solver::linear::{BlockLdl, Triangular};

type Lane = WideF64x4;
type Vector = Vector3<Lane>;
type Matrix = Matrix3<Lane>;

const STAGES: usize = 4;

/// The stages and their buffers.
#[derive(Clone, Debug, Default)]
pub(crate) struct Lockstep {
    tableau: Tableau<STAGES>,
    /// Length of the last step, s; 0 where there is none.
    length: f64,
    carries: Vec<RoundingCarry>,
    accelerations: Vec<Twist<Lane>>,
    forces: Vec<Vector>,
    rates: Vec<Vector>,
    rotations: Vec<Matrix>,
    angular: Vec<Vector>,
    /// At the present poses, and at those of the rows.
    arms: Vec<[Vector; 2]>,
    row_arms: Vec<[Vector; 2]>,
    inverse_inertia: Vec<Matrix>,
    levers: Vec<[Matrix; 2]>,
    factor: BlockLdl<Lane, Triangular>,
    wrenches: Vec<Twist<Lane>>,
    trial: Vec<Twist<Lane>>,
    unknowns: Vec<Vector>,
}

#[inline]
fn lane(value: f64) -> Lane {
    Lane::splat(value)
}

#[inline]
fn all(v: &Vector3<f64>) -> Vector {
    Vector::new(lane(v.x), lane(v.y), lane(v.z))
}

fn zero() -> Vector {
    all(&Vector3::zeros())
}

#[inline]
fn one(v: &Vector, stage: usize) -> Vector3<f64> {
    Vector3::new(v.x.extract(stage), v.y.extract(stage), v.z.extract(stage))
}

/// Columns of a matrix over the stages.
fn columns(matrix: &[[f64; STAGES]; STAGES]) -> [Lane; STAGES] {
    std::array::from_fn(|j| Lane::from([matrix[0][j], matrix[1][j], matrix[2][j], matrix[3][j]]))
}

/// A matrix over the stages, by columns, times what is in the stages.
#[inline]
fn mix(columns: &[Lane; STAGES], v: &Vector) -> Vector {
    v.map(|value| {
        columns[0] * lane(value.extract(0))
            + columns[1] * lane(value.extract(1))
            + (columns[2] * lane(value.extract(2)) + columns[3] * lane(value.extract(3)))
    })
}

/// Σ w v over the stages.
#[inline]
fn sum(weights: &[f64; STAGES], v: &Vector) -> Vector3<f64> {
    v.map(|value| (0..STAGES).map(|stage| value.extract(stage) * weights[stage]).sum())
}

impl Lockstep {
    /// Forgets the step before.
    pub fn forget(&mut self) {
        self.length = 0.0;
    }

    /// All that the next step depends on beside the mechanism's state.
    pub fn memory(&self) -> impl Iterator<Item = f64> + '_ {
        let known = self.length > 0.0;
        let vectors = self.accelerations.iter().flat_map(|vector| [vector.linear, vector.angular]);
        let stages = vectors.chain(self.forces.iter().copied()).filter(move |_| known);
        let numbers = stages.flat_map(|v| (0..STAGES).flat_map(move |stage| <[f64; 3]>::from(one(&v, stage))));
        numbers.chain(self.carries.iter().filter(move |_| known).flat_map(RoundingCarry::numbers))
    }

    /// Mean of each link's load over the step.
    pub fn mean_load(&self, link: usize) -> Twist<f64> {
        Twist { linear: sum(&self.tableau.weights, &self.forces[link]), ..Twist::zero() }
    }

    /// Takes the mechanism through a step of h, s; none where it is none for this method, or the iterations do not
    /// converge quickly.
    pub fn step(&mut self, mechanism: &mut Mechanism, h: f64) -> Option<StageIterations> {
        let fixed = mechanism.states[mechanism.moving..].iter();
        let rests = fixed.clone().all(|state| state.linear == Vector3::zeros() && state.angular == Vector3::zeros());
        let turns =
            mechanism.states.iter().any(|state| state.angular.norm_squared() * h * h > SERIES_TURN * SERIES_TURN);
        let plain = rests && !turns && mechanism.tree.is_some();
        if !plain || mechanism.members.iter().any(|member| member.drag != (0.0, 0.0)) {
            return None;
        }
        self.begin(mechanism, h);
        if self.is_stiff(mechanism, h) {
            self.forget();
            return None;
        }
        let (mut before, mut least) = (f64::INFINITY, LEAST_CHANGE);
        let (mut factors, mut refactors) = (0, true);
        for count in 1..=LOCKSTEP_ITERATIONS {
            self.place_stages(mechanism, h);
            if refactors {
                self.assemble(mechanism);
                factors += 1;
            }
            self.balance(mechanism);
            let change = self.correct(mechanism) * h * h;
            let share = change / before;
            if count == 1 {
                least = least.max(change * change * CHANGE_OVER_SQUARE);
            }
            refactors = count > 1 && share > SLOW_ITERATION && change > LOCKSTEP_UNCONVERGED && factors < MOST_FACTORS;
            let is_stalled = count > 3 && share > 0.5 && !refactors;
            if change.is_nan() || is_stalled && change > LOCKSTEP_UNCONVERGED {
                break;
            }
            if count > 1 && (change * share / (1.0 - share).max(0.1) <= least || is_stalled) {
                self.finish(mechanism, h);
                return Some(StageIterations { count: count as u32 * STAGES as u32, converged: true });
            }
            before = change;
        }
        self.forget();
        None
    }

    fn begin(&mut self, mechanism: &Mechanism, h: f64) {
        if self.length == 0.0
            || self.accelerations.len() != mechanism.moving
            || self.forces.len() != mechanism.links.len()
        {
            let none = Twist { linear: zero(), angular: zero() };
            self.accelerations.clear();
            self.accelerations.resize(mechanism.moving, none);
            self.forces.clear();
            self.forces.resize(mechanism.links.len(), zero());
            self.carries.clear();
            self.carries.resize(mechanism.moving, RoundingCarry::default());
        } else {
            let ahead = if h == self.length {
                self.tableau.ahead
            } else {
                self.tableau.ahead_by(1.0, h / self.length, &self.tableau.nodes)
            };
            let ahead = columns(&ahead);
            for vector in &mut self.accelerations {
                *vector = Twist { linear: mix(&ahead, &vector.linear), angular: mix(&ahead, &vector.angular) };
            }
            for force in &mut self.forces {
                *force = mix(&ahead, force);
            }
        }
        let gain = columns(&self.tableau.matrix).map(|column| column * lane(h));
        self.rates.clear();
        for (state, acceleration) in mechanism.states.iter().zip(&self.accelerations) {
            self.rates.push(all(&state.angular) + mix(&gain, &acceleration.angular));
        }
        self.rotations.resize(mechanism.moving, Matrix::from_element(lane(0.0)));
        self.angular.resize(mechanism.moving, zero());
        self.wrenches.resize(mechanism.moving, Twist { linear: zero(), angular: zero() });
        self.trial.resize(mechanism.moving, Twist { linear: zero(), angular: zero() });
        self.unknowns.resize(mechanism.links.len(), zero());
        self.arms.clear();
        for link in &mechanism.links {
            let arm = |member: u32, anchor: &Vector3<f64>| all(&(mechanism.states[member as usize].rotation * anchor));
            self.arms.push([arm(link.a, link.anchor(0)), arm(link.b, link.anchor(1))]);
        }
    }

    fn is_stiff(&self, mechanism: &Mechanism, h: f64) -> bool {
        mechanism.links.iter().zip(&self.forces).any(|(link, force)| {
            let force = one(force, STAGES - 1).norm();
            [(link.a, link.anchor(0)), (link.b, link.anchor(1))].into_iter().any(|(member, anchor)| {
                let member = &mechanism.members[member as usize];
                member.moves() && force * anchor.norm() * h * h > LOCKSTEP_SOFT * member.inertia.max()
            })
        })
    }

    /// Rotations, angular velocities and arms of all stages.
    fn place_stages(&mut self, mechanism: &Mechanism, h: f64) {
        let Tableau { weights, matrix, .. } = &self.tableau;
        let gain = columns(matrix).map(|column| column * lane(h));
        let turns: [Lane; STAGES] = std::array::from_fn(|j| gain[j] - lane(0.5 * h * weights[j]));
        let half = weights.map(|weight| 0.5 * h * weight);
        for (member, state) in mechanism.states[..mechanism.moving].iter().enumerate() {
            let angular = all(&state.angular) + mix(&gain, &self.accelerations[member].angular);
            let rate = self.rates[member];
            let turn = mix(&turns, &rate);
            let middle = exponential(&sum(&half, &rate)) * state.rotation;
            self.rates[member] = small_inverse_dexp(&turn, &angular);
            self.rotations[member] = turned(&turn, &middle);
            self.angular[member] = angular;
        }
        for (link, arms) in mechanism.links.iter().zip(&mut self.arms) {
            if let Some(rotation) = self.rotations.get(link.a as usize) {
                arms[0] = times(rotation, link.anchor(0));
            }
            if let Some(rotation) = self.rotations.get(link.b as usize) {
                arms[1] = times(rotation, link.anchor(1));
            }
        }
    }

    /// J, M⁻¹ and the factor of J M⁻¹ Jᵀ at the present rotations.
    fn assemble(&mut self, mechanism: &Mechanism) {
        self.row_arms.clone_from(&self.arms);
        self.inverse_inertia.clear();
        for (member, rotation) in mechanism.members.iter().zip(&self.rotations) {
            let inverse = member.inertia.map(f64::recip);
            let inverse = all(&inverse);
            let is_round = member.is_round();
            self.inverse_inertia.push(if is_round {
                Matrix::from_diagonal(&inverse)
            } else {
                in_world(&inverse, rotation)
            });
        }
        let nothing = Matrix::from_element(lane(0.0));
        self.levers.clear();
        self.factor.clear(&mechanism.elimination);
        for (index, (link, arms)) in mechanism.links.iter().zip(&self.row_arms).enumerate() {
            let (mut block, mut levers) = (nothing, [nothing; 2]);
            for (end, member) in [link.a, link.b].into_iter().enumerate() {
                if let Some(inverse) = self.inverse_inertia.get(member as usize) {
                    levers[end] = lever(inverse, &arms[end]);
                    block += cross_product(&arms[end], &levers[end]);
                    let mass = &mechanism.members[member as usize].inverse_mass;
                    (0..3).for_each(|axis| block[(axis, axis)] += lane(mass[axis]));
                }
            }
            self.levers.push(levers);
            self.factor.diagonal_mut::<3>(index).copy_from(&block);
        }
        for coupling in &mechanism.couplings {
            let arm = &self.row_arms[coupling.row.0 as usize][coupling.row.1];
            let mut block = cross_product(arm, &self.levers[coupling.column.0 as usize][coupling.column.1]);
            let mass = &mechanism.members[coupling.member as usize].inverse_mass;
            (0..3).for_each(|axis| block[(axis, axis)] += lane(mass[axis]));
            let mut below = self.factor.below_mut::<3>(coupling.block as usize);
            below += block * lane(coupling.sign);
        }
        self.factor.factor(&mechanism.elimination);
    }

    /// The residuals of the balance of forces and of joints.
    fn balance(&mut self, mechanism: &Mechanism) {
        for (index, member) in mechanism.members[..mechanism.moving].iter().enumerate() {
            let Twist { linear, angular } = &self.accelerations[index];
            let force = all(&member.force) - linear * lane(member.mass);
            let mut torque = all(&member.torque);
            if member.is_round() {
                torque -= angular * lane(member.inertia.x);
            } else {
                let rotation = &self.rotations[index];
                let (spin, gain) = (rotation.tr_mul(&self.angular[index]), rotation.tr_mul(angular));
                let inertia = all(&member.inertia);
                let momentum = inertia.component_mul(&spin);
                torque -= rotation * (inertia.component_mul(&gain) + spin.cross(&momentum));
            }
            self.wrenches[index] = Twist { linear: force, angular: torque };
        }
        add_wrenches(mechanism, &self.arms, &self.forces, &mut self.wrenches);
        for (index, member) in mechanism.members[..mechanism.moving].iter().enumerate() {
            let (wrench, old) = (&self.wrenches[index], &self.accelerations[index]);
            self.trial[index] = Twist {
                linear: old.linear + all(&member.inverse_mass).component_mul(&wrench.linear),
                angular: old.angular + self.inverse_inertia[index] * wrench.angular,
            };
        }
        for ((link, [arm_a, arm_b]), unknown) in mechanism.links.iter().zip(&self.arms).zip(&mut self.unknowns) {
            let gain = |member: u32, arm: &Vector| match self.trial.get(member as usize) {
                Some(trial) => {
                    let omega = &self.angular[member as usize];
                    trial.linear + trial.angular.cross(arm) + omega.cross(&omega.cross(arm))
                }
                None => zero(),
            };
            *unknown = gain(link.a, arm_a) - gain(link.b, arm_b);
        }
    }

    /// Corrects accelerations and forces by the residuals; the largest change of an acceleration.
    fn correct(&mut self, mechanism: &Mechanism) -> f64 {
        let x = &mut self.unknowns;
        self.factor.solve(&mechanism.elimination, &mut x[..]);
        for (force, more) in self.forces.iter_mut().zip(&*x) {
            *force += more;
        }
        add_wrenches(mechanism, &self.row_arms, x, &mut self.wrenches);
        let mut largest = lane(0.0);
        for (index, member) in mechanism.members[..mechanism.moving].iter().enumerate() {
            let wrench = &self.wrenches[index];
            let linear = all(&member.inverse_mass).component_mul(&wrench.linear);
            let angular = self.inverse_inertia[index] * wrench.angular;
            let old = &mut self.accelerations[index];
            old.linear += linear;
            old.angular += angular;
            // Squares: a NaN stays in the sum.
            largest += linear.dot(&linear) + angular.dot(&angular);
        }
        (0..STAGES).map(|stage| largest.extract(stage)).sum::<f64>().sqrt()
    }

    fn finish(&mut self, mechanism: &mut Mechanism, h: f64) {
        let Tableau { weights, last, .. } = &self.tableau;
        for (member, state) in mechanism.states[..mechanism.moving].iter_mut().enumerate() {
            let Twist { linear, angular } = &self.accelerations[member];
            state.position += (state.linear + sum(last, linear) * h) * h;
            state.linear += sum(weights, linear) * h;
            let turn = sum(weights, &self.rates[member]) * h;
            self.carries[member].advance(state, sum(weights, angular) * h, &turn);
        }
        self.length = h;
    }
}

/// exp φ R_m as matrices.
#[inline]
fn turned(turn: &Vector, middle: &UnitQuaternion<f64>) -> Matrix {
    let (w, v) = small_exponential(turn);
    let (mw, m) = (lane(middle.w), Vector::new(lane(middle.i), lane(middle.j), lane(middle.k)));
    let scalar = w * mw - v.dot(&m);
    let vector = m * w + v * mw + v.cross(&m);
    let (x, y, z) = (vector.x, vector.y, vector.z);
    let two = lane(2.0);
    let (xx, yy, zz) = (two * x * x, two * y * y, two * z * z);
    let (xy, xz, yz) = (two * x * y, two * x * z, two * y * z);
    let (wx, wy, wz) = (two * scalar * x, two * scalar * y, two * scalar * z);
    let one = lane(1.0);
    Matrix::new(one - yy - zz, xy - wz, xz + wy, xy + wz, one - xx - zz, yz - wx, xz - wy, yz + wx, one - xx - yy)
}

#[inline]
fn times(rotation: &Matrix, v: &Vector3<f64>) -> Vector {
    rotation.column(0) * lane(v.x) + rotation.column(1) * lane(v.y) + rotation.column(2) * lane(v.z)
}

/// wrenches += Jᵀ λ for those arms; members beyond the wrenches given have none.
#[inline]
fn add_wrenches(mechanism: &Mechanism, arms: &[[Vector; 2]], lambda: &[Vector], wrenches: &mut [Twist<Lane>]) {
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
fn lever(inverse_inertia: &Matrix, r: &Vector) -> Matrix {
    let (x, y, z) = (inverse_inertia.column(0), inverse_inertia.column(1), inverse_inertia.column(2));
    Matrix::from_columns(&[z * r.y - y * r.z, x * r.z - z * r.x, y * r.x - x * r.y])
}

/// [r]× m.
#[inline]
fn cross_product(r: &Vector, m: &Matrix) -> Matrix {
    Matrix::from_columns(&[r.cross(&m.column(0)), r.cross(&m.column(1)), r.cross(&m.column(2))])
}
