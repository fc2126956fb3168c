//! Gauss's collocation method on a mechanism: implicit, symmetric, for any stiffness.
//!
//! Unknown are each stage's accelerations a_i and joint forces λ_i. With positions and velocities from them by the
//! [tableau](super::tableau), stage i holds
//!
//! M a_i = F − (0, ω_i × I ω_i) + Jᵀλ_i,  J a_i + J̇ v_i + d/dt ∂C/∂t = 0,
//!
//! at its own time, so that what moves a joint in time is followed to the same order.
//!
//! Rotations: R(t) = exp φ(t) R_m about the middle rotation R_m = exp ψ R₀, from φ = −ψ to φ = ψ, so that the method is
//! symmetric on the group, too (Hairer, Lubich and Wanner 2006, V.4.3). φ̇_i = k_i = dexp⁻¹_{φ_i} ω_i gives
//! ψ = ½ h Σ b_j k_j and φ_i = h Σ (a_ij − ½ b_j) k_j.
//!
//! Where h²K, with the geometric stiffness K of forces at anchors (see `joint_tree::stiffness`), tells of oscillations
//! that the step is far too long for, Radau's nodes take the place of Gauss's: Gauss's method would keep the energy of
//! those oscillations, with a wrong part of it in each step, and a heavy load on light links would go wild.
//!
//! The unknowns are found by simplified Newton iteration, one stage after the other:
//!
//! [M̃ −Jᵀ; J 0] (δa, δλ) = (residuals of the two lines above),  M̃ = M (1 + c h a_ii) + h² L_ii K,
//!
//! with drag c; K is kept to M's pattern, and L is the lower factor of A² (see [`tableau`](super::tableau)). J and the
//! factor of J M̃⁻¹ Jᵀ are those of the stage as it starts, which is the stages of the step before continued. Where K is
//! left out, as that of torques is, each iteration leaves a share of order h²; where K is large, further sweeps over the
//! same factors bring in what L lacks of A² ([`coupling`]). Else k is that of the iteration before for other stages, so that
//! turns lag behind and each second iteration gains little. With k made anew in each, a sheet of 900 balls took four for five,
//! but lost 1e-10 of its energy as it swung through its plane, for 4e-13, and its joints parted by 3.4e-9 m, for 2.5e-10.
//!
//! Rows that may be redundant are factored and solved from zero in each iteration, so that what is not unique depends on
//! the pose alone, and the method of multipliers bounds what is hardly so, as in a loop that passes a flat pose. Where
//! it shows that no row is nearly redundant, the last iterations keep the factor and correct λ. Where some row is so after
//! all, each of them adds the same to λ along it, and would for hundreds of iterations: what that still changes of the motion
//! is less than what the bound leaves out, so that it is an end of the iterations, too.
//!
//! A spring has rows of its own, λ + kC + cĊ = 0 in place of the second line; its softness
//! 1/(k h² L_ii + c h a_ii) goes on the diagonal of J M̃⁻¹ Jᵀ. At its largest force the size of
//! the force is given, and the spring is softer across it by the factor that its bound takes away.

mod coupling;

use nalgebra::{Matrix3, SVector, UnitQuaternion, Vector3, Vector4};

use super::constants::{
    CHANGE_OVER_SQUARE, CLEAR, CREEPING_CHANGE, CREEPING_SHARE, DIVERGED, ENOUGH_OF_A_CORRECTION, GAUSS_ITERATIONS,
    GAUSS_SOFT, GAUSS_UNCONVERGED, KEEPS_FACTOR, LEAST_CHANGE, NORMAL, SLACK, UNRESOLVED,
};
use super::mechanism::{InverseMass, Mechanism, MemberState, RowSpring};
use super::rotation::{exponential, exponential_less_one, inverse_dexp};
use super::rows::{MechanismRows, add_wrenches};
use super::tableau::Tableau;
use crate::physics::constraint::row::{Twist, Wrench};
use crate::physics::joint::JointRow;
use crate::physics::solver::joint_tree::add_stiffness;

/// One stage.
#[derive(Clone, Debug, Default)]
struct GaussStage {
    /// a_i of each member.
    accelerations: Vec<Twist<f64>>,
    /// λ_i of all rows.
    lambda: Vec<f64>,
    /// k_i of each member.
    rates: Vec<Vector3<f64>>,
    /// Of the accelerations by the last correction.
    changes: Vec<Twist<f64>>,
    /// K of each member, or none where it is small.
    stiffness: Vec<Matrix3<f64>>,
    /// Torques that the changes of other stages leave to be balanced.
    coupling: Vec<Vector3<f64>>,
    /// By the present accelerations.
    states: Vec<MemberState>,
    rows: Vec<JointRow<f64>>,
    /// As they were when they were factored.
    system: MechanismRows,
}

impl GaussStage {
    /// Sets λ of the rows where it is given.
    fn give(&mut self, mechanism: &Mechanism) {
        if !mechanism.modes.is_empty() {
            let given = self.lambda.iter_mut().zip(&self.rows);
            given.for_each(|(lambda, row)| *lambda = row.given().unwrap_or(*lambda));
        }
    }
}

/// The stages of a step that converged, from which the next is continued.
#[derive(Clone, Debug, Default)]
struct GaussHistory {
    accelerations: Vec<Twist<f64>>,
    lambda: Vec<f64>,
}

/// What rounding took from a member's sums, carried to the next step.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct RoundingCarry {
    angular: Vector3<f64>,
    rotation: Vector4<f64>,
}

impl RoundingCarry {
    /// All its numbers.
    pub fn numbers(&self) -> impl Iterator<Item = f64> + '_ {
        self.angular.iter().chain(self.rotation.iter()).copied()
    }

    /// Adds `gained` to the angular velocity and turns by a rotation vector.
    pub fn advance(&mut self, state: &mut MemberState, gained: Vector3<f64>, turn: &Vector3<f64>) {
        add_carrying(&mut state.angular, gained, &mut self.angular);
        let mut rotation = state.rotation.into_inner();
        let added = exponential_less_one(turn) * rotation;
        add_carrying(&mut rotation.coords, added.coords, &mut self.rotation);
        // Carried sums keep it unit to rounding for long.
        state.rotation = if (rotation.norm_squared() - 1.0).abs() < NORMAL {
            UnitQuaternion::new_unchecked(rotation)
        } else {
            UnitQuaternion::new_normalize(rotation)
        };
    }
}

/// The stages and their buffers.
#[derive(Clone, Debug, Default)]
pub(crate) struct Gauss<const S: usize> {
    /// That of the step at hand, of those two.
    tableau: Tableau<S>,
    methods: Methods<S>,
    stages: Vec<GaussStage>,
    /// At the end of the step.
    now: GaussStage,
    /// Of the last step that converged, and its length, s; 0 where there is none.
    history: Vec<GaussHistory>,
    past: Tableau<S>,
    carries: Vec<RoundingCarry>,
    length: f64,
    /// How much of that step the present state is after its start, s.
    elapsed: f64,
    /// R_m of each member.
    middles: Vec<UnitQuaternion<f64>>,
    /// Of the stage at hand.
    rotations: Vec<Matrix3<f64>>,
    /// Residual of the balance of forces, and then the wrench of its correction.
    wrenches: Vec<Wrench<f64>>,
    unknowns: Vec<f64>,
    /// Share of the right side that the rows of a stage leave, at most, where they may be redundant.
    unclear: f64,
    right: Vec<f64>,
    /// Whether K is large.
    is_stiff: bool,
    trial: Vec<Twist<f64>>,
}

#[derive(Clone, Copy, Debug)]
struct Methods<const S: usize> {
    gauss: Tableau<S>,
    radau: Tableau<S>,
}

impl<const S: usize> Default for Methods<S> {
    fn default() -> Self {
        Self { gauss: Tableau::gauss(), radau: Tableau::radau() }
    }
}

/// How the iterations of a step went.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct StageIterations {
    pub count: u32,
    pub converged: bool,
}

impl StageIterations {
    /// None were made.
    pub const NONE: Self = Self { count: 0, converged: false };
}

impl<const S: usize> Gauss<S> {
    /// Forgets the step before.
    pub fn forget(&mut self) {
        self.length = 0.0;
    }

    /// The mechanism was put back to where the last step started from: the next one is continued from the stages of that
    /// one.
    pub fn rewind(&mut self) {
        self.elapsed = 0.0;
        self.carries.fill(RoundingCarry::default());
    }

    /// All that the next step depends on beside the mechanism's state.
    pub fn memory(&self) -> impl Iterator<Item = f64> + '_ {
        let known = self.history.iter().filter(|_| self.length > 0.0);
        let known = known.flat_map(|past| {
            let twists = past.accelerations.iter().flat_map(|twist| twist.linear.iter().chain(twist.angular.iter()));
            twists.chain(&past.lambda).copied()
        });
        let carries = self.carries.iter().filter(|_| self.length > 0.0);
        let method = (self.length > 0.0).then(|| f64::from(u8::from(self.past.damps())));
        let is_within = self.length > 0.0 && self.elapsed != self.length;
        let within = is_within.then_some([self.elapsed, self.length]).into_iter().flatten();
        known.chain(carries.flat_map(RoundingCarry::numbers)).chain(method).chain(within)
    }

    /// Mean of each link's load over the step.
    pub fn mean_load(&self, mechanism: &Mechanism, link: usize) -> Wrench<f64> {
        let link = &mechanism.links[link];
        let stages = self.tableau.weights.iter().zip(&self.stages);
        stages.fold(Wrench::zero(), |sum, (&weight, GaussStage { states, rows, lambda, .. })| {
            sum.plus(&link.load(&link.arm_b(states), rows, lambda), weight)
        })
    }

    /// Each link's load at the mechanism's states and that time, s: the equations of a stage of no length. Twice, as what
    /// rounding and soft rows leave of the first is made good by the second.
    pub fn find_loads(&mut self, mechanism: &Mechanism, time: f64, loads: &mut Vec<Wrench<f64>>) {
        let mut now = std::mem::take(&mut self.now);
        now.accelerations.clear();
        now.accelerations.resize(mechanism.members.len(), Twist::zero());
        now.changes.clone_from(&now.accelerations);
        now.lambda.clear();
        now.lambda.resize(mechanism.rows(), 0.0);
        now.states.clone_from(&mechanism.states);
        mechanism.place_rows(&now.states, time, &mut now.rows);
        self.rotations.clear();
        self.rotations.extend(now.states.iter().map(|state| state.rotation.to_rotation_matrix().into_inner()));
        self.is_stiff = false;
        let stage = self.stages.len();
        self.stages.push(now);
        self.assemble(mechanism, [0.0; 3], stage);
        for _ in 0..2 {
            if mechanism.may_be_singular {
                self.stages[stage].lambda.fill(0.0);
            }
            self.stages[stage].give(mechanism);
            self.balance(mechanism, stage);
            self.correct(mechanism, stage, mechanism.may_be_singular);
        }
        self.now = self.stages.pop().unwrap_or_default();
        let GaussStage { states, rows, lambda, .. } = &self.now;
        loads.clear();
        loads.extend(mechanism.links.iter().map(|link| link.load(&link.arm_b(states), rows, lambda)));
    }

    /// Takes the mechanism through a step of h, s, from that time. Where the iterations do not converge it stays where it
    /// was.
    pub fn step(&mut self, mechanism: &mut Mechanism, time: f64, h: f64) -> StageIterations {
        self.tableau = self.methods.gauss;
        if let Some(iterations) = self.iterate(mechanism, time, h) {
            return iterations;
        }
        self.tableau = self.methods.radau;
        self.iterate(mechanism, time, h).unwrap_or(StageIterations::NONE)
    }

    /// A step by the present method; None where it is one that does not damp and oscillations are too short for it.
    fn iterate(&mut self, mechanism: &mut Mechanism, time: f64, h: f64) -> Option<StageIterations> {
        self.begin(mechanism, h);
        let (mut before, mut share, mut rising) = (f64::INFINITY, 0.0, 0);
        let mut least = LEAST_CHANGE;
        for count in 1..=GAUSS_ITERATIONS {
            let mut change: f64 = 0.0;
            if count <= 3 {
                let phase_squared = self.find_stiffness(mechanism, h);
                if phase_squared > UNRESOLVED && !self.tableau.damps() {
                    return None;
                }
            }
            let refactors = count == 1
                || ((self.is_stiff || mechanism.gives) && (count <= 4 || share > 0.3))
                || mechanism.may_be_singular && (before > KEEPS_FACTOR || self.unclear > CLEAR);
            let from_zero = mechanism.may_be_singular && refactors;
            if from_zero {
                self.unclear = 0.0;
            }
            self.find_middles(mechanism, h);
            for stage in 0..S {
                if self.is_stiff {
                    self.refresh_rates(mechanism, h);
                    self.find_middles(mechanism, h);
                }
                self.place_stage(mechanism, time, h, stage);
                if refactors {
                    let own = self.tableau.matrix[stage][stage] * h;
                    let own_squared = self.tableau.lower[stage][stage] * h * h;
                    self.assemble(mechanism, [h, own, own_squared], stage);
                }
                if from_zero {
                    self.stages[stage].lambda.fill(0.0);
                }
                self.stages[stage].give(mechanism);
                self.balance(mechanism, stage);
                let stage = self.correct(mechanism, stage, from_zero);
                change = if stage > change || stage.is_nan() { stage } else { change };
            }
            if self.is_stiff {
                self.couple_stages(mechanism, h, change);
            }
            let change = change * h * h;
            rising = if share > 1.0 { rising + 1 } else { 0 };
            if change.is_nan() || change > DIVERGED || rising > 4 && change > GAUSS_UNCONVERGED {
                break;
            }
            if count == 1 {
                least = least.max(change * change * CHANGE_OVER_SQUARE);
            }
            share = change / before;
            let is_converged = count > 1 && (change * share / (1.0 - share).max(0.1) <= least || change == 0.0);
            // Rounding leaves a change that does not fall.
            let is_rounding = share > 0.5 && change < GAUSS_UNCONVERGED;
            // With a factor that is kept, λ creeps along rows that are nearly redundant after all, by the same in each iteration.
            let has_kept = mechanism.may_be_singular && !from_zero;
            let creeps = has_kept && share > CREEPING_SHARE && change < CREEPING_CHANGE;
            let is_stalled = count > 3 && (is_rounding || creeps);
            if is_converged || is_stalled {
                self.finish(mechanism, h);
                self.remember(h);
                return Some(StageIterations { count: count as u32, converged: true });
            }
            before = change;
        }
        Some(StageIterations { count: GAUSS_ITERATIONS as u32, converged: false })
    }

    /// The stages that the iterations start from.
    fn begin(&mut self, mechanism: &Mechanism, h: f64) {
        let count = mechanism.members.len();
        self.stages.resize_with(S, GaussStage::default);
        for stage in &mut self.stages {
            stage.accelerations.clear();
            stage.accelerations.resize(count, Twist::zero());
            stage.lambda.clear();
            stage.lambda.resize(mechanism.rows(), 0.0);
            stage.changes.clear();
            stage.changes.resize(count, Twist::zero());
        }
        if self.length > 0.0 {
            self.extrapolate(mechanism, h);
        } else {
            self.carries.clear();
            self.carries.resize(count, RoundingCarry::default());
        }
        for stage in &mut self.stages {
            stage.rates.clear();
            stage.rates.extend(mechanism.states.iter().map(|state| state.angular));
        }
        self.refresh_rates(mechanism, h);
    }

    /// Keeps the stages for the next step. Those of a longer step from the same start say more.
    fn remember(&mut self, h: f64) {
        let is_part = self.length > h && self.elapsed == 0.0;
        self.elapsed = h;
        if is_part {
            return;
        }
        self.length = h;
        self.past = self.tableau;
        self.history.resize_with(S, GaussHistory::default);
        for (past, stage) in self.history.iter_mut().zip(&self.stages) {
            past.accelerations.clone_from(&stage.accelerations);
            past.lambda.clone_from(&stage.lambda);
        }
    }

    /// Continues the polynomials through the stages of the step before.
    fn extrapolate(&mut self, mechanism: &Mechanism, h: f64) {
        let is_alike = self.past.damps() == self.tableau.damps();
        let ahead = if is_alike && h == self.length && self.elapsed == self.length {
            self.tableau.ahead
        } else {
            self.past.ahead_by(self.elapsed / self.length, h / self.length, &self.tableau.nodes)
        };
        for member in 0..mechanism.moving {
            let old: [Twist<f64>; S] = std::array::from_fn(|j| self.history[j].accelerations[member]);
            for (stage, shares) in self.stages.iter_mut().zip(&ahead) {
                stage.accelerations[member] = combine(&old, shares);
            }
        }
        for row in 0..mechanism.rows() {
            let old: [f64; S] = std::array::from_fn(|j| self.history[j].lambda[row]);
            for (stage, shares) in self.stages.iter_mut().zip(&ahead) {
                stage.lambda[row] = old.iter().zip(shares).map(|(lambda, share)| lambda * share).sum();
            }
        }
    }

    /// Finds whether K is large. h²K over the inertia, at most.
    fn find_stiffness(&mut self, mechanism: &Mechanism, h: f64) -> f64 {
        let stage = &self.stages[S - 1];
        let mut largest: f64 = 0.0;
        for link in &mechanism.links {
            let force: f64 = stage.lambda[link.translations()].iter().map(|lambda| lambda * lambda).sum();
            for (end, member) in link.ends().into_iter().enumerate() {
                let member = &mechanism.members[member as usize];
                if member.moves() {
                    largest = largest.max(force * link.anchor(end).norm_squared() / member.inertia.max().powi(2));
                }
            }
        }
        let phase_squared = largest.sqrt() * h * h;
        self.is_stiff = phase_squared > GAUSS_SOFT;
        phase_squared
    }

    /// R_m from the present rates.
    fn find_middles(&mut self, mechanism: &Mechanism, h: f64) {
        self.middles.resize(mechanism.states.len(), UnitQuaternion::identity());
        for (member, (middle, state)) in self.middles.iter_mut().zip(&mechanism.states).enumerate() {
            let mut half = Vector3::zeros();
            for (stage, weight) in self.stages.iter().zip(&self.tableau.weights) {
                half += stage.rates[member] * (0.5 * h * weight);
            }
            *middle = exponential(&half) * state.rotation;
        }
    }

    /// k of all stages from the present accelerations.
    fn refresh_rates(&mut self, mechanism: &Mechanism, h: f64) {
        let Tableau { weights, matrix, .. } = &self.tableau;
        for (member, state) in mechanism.states.iter().enumerate().take(mechanism.moving) {
            let rates: [Vector3<f64>; S] = std::array::from_fn(|j| self.stages[j].rates[member]);
            for (stage, shares) in (0..S).zip(matrix) {
                let (mut turn, mut angular) = (Vector3::zeros(), state.angular);
                for (j, other) in self.stages.iter().enumerate() {
                    turn += rates[j] * (h * shares[j] - 0.5 * h * weights[j]);
                    angular += other.accelerations[member].angular * (h * shares[j]);
                }
                self.stages[stage].rates[member] = inverse_dexp(&turn, &angular);
            }
        }
    }

    /// States and rows of a stage from the present accelerations.
    fn place_stage(&mut self, mechanism: &Mechanism, time: f64, h: f64, stage: usize) {
        let Tableau { nodes, weights, matrix, squared, lower, .. } = &self.tableau;
        let gain: [f64; S] = std::array::from_fn(|j| h * matrix[stage][j]);
        let turns: [f64; S] = std::array::from_fn(|j| gain[j] - 0.5 * h * weights[j]);
        self.rotations.clear();
        self.stages[stage].states.clear();
        for (member, state) in mechanism.states.iter().enumerate() {
            let MemberState { mut position, mut linear, mut angular, .. } = *state;
            let mut turn = Vector3::zeros();
            position += linear * (h * nodes[stage]);
            for (j, other) in self.stages.iter().enumerate() {
                let acceleration = &other.accelerations[member];
                position += acceleration.linear * (h * h * squared[stage][j]);
                linear += acceleration.linear * gain[j];
                angular += acceleration.angular * gain[j];
                turn += other.rates[member] * turns[j];
            }
            for (j, other) in self.stages.iter().enumerate().take(stage) {
                let (change, share) = (&other.changes[member], h * h * (lower[stage][j] - squared[stage][j]));
                position += change.linear * share;
                turn += change.angular * share;
            }
            let rotation = exponential(&turn) * self.middles[member];
            self.rotations.push(rotation.to_rotation_matrix().into_inner());
            let stage = &mut self.stages[stage];
            stage.rates[member] = inverse_dexp(&turn, &angular);
            stage.states.push(MemberState { position, rotation, linear, angular });
        }
        let GaussStage { states, rows, .. } = &mut self.stages[stage];
        mechanism.place_rows(states, time + h * nodes[stage], rows);
    }

    /// Factors the rows of a stage at its present states, with the step h, and what of it and of its square the stage's
    /// acceleration gives to the stage's velocity and place.
    fn assemble(&mut self, mechanism: &Mechanism, [h, own, own_squared]: [f64; 3], stage: usize) {
        let GaussStage { states, rows, lambda, system, stiffness, .. } = &mut self.stages[stage];
        let turn = h * states.iter().fold(0.0, |most: f64, state| most.max(state.angular.norm_squared())).sqrt();
        stiffness.clear();
        if self.is_stiff {
            stiffness.resize(mechanism.members.len(), Matrix3::zeros());
            for link in &mechanism.links {
                let force = link.load(&Vector3::zeros(), rows, lambda).linear;
                for (end, member, force) in [(0, link.a, -force), (1, link.b, force)] {
                    let arm = states[member as usize].rotation * link.anchor(end);
                    add_stiffness(&mut stiffness[member as usize], &arm, &force);
                }
            }
        }
        system.inverse_masses.clear();
        for (index, member) in mechanism.members.iter().enumerate() {
            let slowed = (1.0 / (1.0 + member.drag.0 * own), 1.0 / (1.0 + member.drag.1 * own));
            let added = self.is_stiff.then(|| stiffness[index] * (own_squared * slowed.1));
            let angular = member.inverse_inertia(&self.rotations[index], added.as_ref());
            let linear = member.inverse_mass * slowed.0;
            system.inverse_masses.push(InverseMass { linear, angular: angular * slowed.1 });
        }
        system.assemble(mechanism, rows, turn, |spring, mobility| softness(spring, mobility, rows, own, own_squared));
    }

    /// The residuals: of the first line into `wrenches`; of the second into `unknowns`, less what the first will do to
    /// it.
    fn balance(&mut self, mechanism: &Mechanism, stage: usize) {
        let GaussStage { accelerations, lambda, states, rows, system, .. } = &self.stages[stage];
        self.wrenches.clear();
        for (index, member) in mechanism.members.iter().enumerate() {
            self.wrenches.push(member.wrench(&states[index], &self.rotations[index], &accelerations[index]));
        }
        add_wrenches(&mechanism.links, rows.iter().map(|row| &row.jacobian), lambda, &mut self.wrenches);
        // The accelerations that the present forces would make.
        self.trial.clear();
        let members = accelerations.iter().zip(&self.wrenches).zip(&system.inverse_masses);
        self.trial.extend(members.map(|((old, wrench), inverse_mass)| old.plus(&inverse_mass.of(wrench), 1.0)));
        self.unknowns.clear();
        for link in &mechanism.links {
            let [a, b] = link.ends().map(|member| &self.trial[member as usize]);
            let own = rows[link.rows.clone()].iter();
            self.unknowns.extend(own.map(|row| -(row.jacobian.dot(a, b) + row.velocity_term)));
        }
        system.given.iter().for_each(|&row| self.unknowns[row] = 0.0);
        for (spring, softness) in &system.springs {
            let pull = spring.pull(rows, &system.mobility(spring));
            let given = softness * (pull - spring.each(|row| lambda[row]));
            let [a, b] = mechanism.links[spring.link as usize]
                .ends()
                .map(|member| system.inverse_masses[member as usize].of(&self.wrenches[member as usize]));
            for (row, given) in spring.rows.clone().zip(&given) {
                self.unknowns[row] = given - rows[row].jacobian.dot(&a, &b);
            }
        }
    }

    /// Corrects a stage's accelerations and forces by the residuals. The largest change of an acceleration.
    fn correct(&mut self, mechanism: &Mechanism, stage: usize, from_zero: bool) -> f64 {
        let GaussStage { accelerations, lambda, changes, system, .. } = &mut self.stages[stage];
        if mechanism.may_be_singular {
            // From zero: so forces that are not unique depend on the pose alone.
            std::mem::swap(&mut self.unknowns, &mut self.right);
            let enough = if from_zero { 0.0 } else { ENOUGH_OF_A_CORRECTION };
            let left = system.solve_to(enough, mechanism, &self.right, &mut self.unknowns);
            if from_zero {
                self.unclear = self.unclear.max(left);
            }
        } else {
            system.solve_once(mechanism, &mut self.unknowns);
        }
        for (lambda, more) in lambda.iter_mut().zip(&self.unknowns) {
            *lambda += more;
        }
        add_wrenches(&mechanism.links, system.jacobians.iter(), &self.unknowns, &mut self.wrenches);
        let mut largest: f64 = 0.0;
        let moved = accelerations.iter_mut().zip(changes).zip(&self.wrenches).zip(&system.inverse_masses);
        for (((acceleration, change), wrench), weight) in moved.take(mechanism.moving) {
            *change = weight.of(wrench);
            acceleration.linear += change.linear;
            acceleration.angular += change.angular;
            let size = change.linear.abs().sum() + change.angular.abs().sum();
            // A NaN stays.
            largest = if size <= largest { largest } else { size };
        }
        largest
    }

    /// From the stages to the end of the step.
    fn finish(&mut self, mechanism: &mut Mechanism, h: f64) {
        let Tableau { weights, last, .. } = &self.tableau;
        for (member, state) in mechanism.states.iter_mut().enumerate() {
            let (mut gained, mut moved, mut half) = (Twist::zero(), Vector3::zeros(), Vector3::zeros());
            for (j, stage) in self.stages.iter().enumerate() {
                let Twist { linear, angular } = &stage.accelerations[member];
                gained.linear += linear * weights[j];
                gained.angular += angular * weights[j];
                moved += linear * last[j];
                half += stage.rates[member] * (0.5 * h * weights[j]);
            }
            state.position += (state.linear + moved * h) * h;
            state.linear += gained.linear * h;
            self.carries[member].advance(state, gained.angular * h, &(half * 2.0));
        }
    }
}

/// sum += added, with the rounding error carried to the next time (Kahan 1965): over a million steps it adds up.
fn add_carrying<const N: usize>(sum: &mut SVector<f64, N>, added: SVector<f64, N>, carry: &mut SVector<f64, N>) {
    let added = added + *carry;
    let new = *sum + added;
    *carry = added - (new - *sum);
    *sum = new;
}

fn combine<const S: usize>(twists: &[Twist<f64>; S], shares: &[f64; S]) -> Twist<f64> {
    twists.iter().zip(shares).fold(Twist::zero(), |sum, (twist, &share)| sum.plus(twist, share))
}

/// 1/(k h² L_ii + c h a_ii) along each axis, 1/m given: the inverse of S, the derivative of the force.
/// Where the unbounded force f is larger than the bound F, the derivative of F f/|f| is F/|f| (1 − f fᵀ/f²) S, which is
/// zero along f.
fn softness(
    spring: &RowSpring,
    mobility: &Vector3<f64>,
    rows: &[JointRow<f64>],
    own: f64,
    own_squared: f64,
) -> Matrix3<f64> {
    let [stiffness, damping] = spring.stiffness(mobility);
    let along = (stiffness * own_squared + damping * own).map(|along| if along > 0.0 { 1.0 / along } else { SLACK });
    let softness = Matrix3::from_diagonal(&along);
    let elastic = spring.elastic(rows, mobility);
    let size = elastic.norm();
    if size <= spring.most {
        return softness;
    }
    let unit = elastic / size;
    let direction = unit * unit.transpose();
    let across = Matrix3::identity() - direction;
    across * softness * across * (size / spring.most).min(SLACK) + direction * (SLACK * along.mean())
}
