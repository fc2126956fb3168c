//! Gauss's collocation method on a mechanism: implicit, symmetric, for any stiffness.
//!
//! Unknown are each stage's accelerations a_i and joint forces λ_i. With positions and velocities from them by the
//! [tableau](super::tableau), stage i holds
//!
//! M a_i = F − (0, ω_i × I ω_i) + Jᵀλ_i,  J a_i + J̇ v_i = 0.
//!
//! Rotations: R(t) = exp φ(t) R_m about the middle rotation R_m = exp ψ R₀, from φ = −ψ to φ = ψ, so that the method is
//! symmetric on the group, too (Hairer, Lubich and Wanner 2006, V.4.3). φ̇_i = k_i = dexp⁻¹_{φ_i} ω_i gives
//! ψ = ½ h Σ b_j k_j and φ_i = h Σ (a_ij − ½ b_j) k_j.
//!
//! They are found by simplified Newton iteration, one stage after the other:
//!
//! [M̃ −Jᵀ; J 0] (δa, δλ) = (residuals of the two lines above),  M̃ = M (1 + c h a_ii) + h² L_ii K,
//!
//! with drag c, and geometric stiffness K (see `joint_tree::stiffness`), kept to M's pattern; L_ii from the tableau. J
//! and the factor of J M̃⁻¹ Jᵀ are those of the stage as it starts, which is the stages of the step before continued.
//! Where K is left out each iteration leaves a share of order h²; where K is large, it still converges, whatever ωh.
//!
//! A spring has rows of its own, λ + m(ω²C + 2ζωĊ) = 0 in place of the second line; its softness
//! 1/(m(ω² h² L_ii + 2ζω h a_ii)) goes on the diagonal of J M̃⁻¹ Jᵀ. At its largest force the size of
//! the force is given, and the spring is softer across it by the factor that its bound takes away.

use nalgebra::{Matrix3, SVector, UnitQuaternion, Vector3, Vector4};

use super::constants::{
    CHANGE_OVER_SQUARE, DIVERGED, GAUSS_ITERATIONS, GAUSS_SOFT, GAUSS_UNCONVERGED, LEAST_CHANGE, NORMAL, SLACK,
};
use super::mechanism::{JointSpring, Mechanism, MemberState};
use super::rotation::{exponential, exponential_less_one, inverse_dexp};
use super::rows::{InverseMass, MechanismRows, SpatialVector, add_wrenches, place_arms};
use super::tableau::Tableau;

/// One stage.
#[derive(Clone, Debug, Default)]
struct GaussStage {
    /// a_i of each member.
    accelerations: Vec<SpatialVector>,
    /// λ_i.
    forces: Vec<Vector3<f64>>,
    /// k_i of each member.
    rates: Vec<Vector3<f64>>,
    rows: MechanismRows,
}

/// The stages of a step that converged, from which the next is continued.
#[derive(Clone, Debug, Default)]
struct GaussHistory {
    accelerations: Vec<SpatialVector>,
    forces: Vec<Vector3<f64>>,
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
    tableau: Tableau<S>,
    stages: Vec<GaussStage>,
    /// Of the last step that converged, and its length, s; 0 where there is none.
    history: Vec<GaussHistory>,
    carries: Vec<RoundingCarry>,
    length: f64,
    /// R_m of each member.
    middles: Vec<UnitQuaternion<f64>>,
    /// Of the stage at hand.
    rotations: Vec<Matrix3<f64>>,
    angular: Vec<Vector3<f64>>,
    arms: Vec<[Vector3<f64>; 2]>,
    /// Unbounded force of each link's spring for each kg, m/s².
    asked: Vec<Vector3<f64>>,
    /// Residual of the balance of forces, and then the wrench of its correction.
    wrenches: Vec<SpatialVector>,
    unknowns: Vec<Vector3<f64>>,
    right: Vec<Vector3<f64>>,
    stiffness: Vec<Matrix3<f64>>,
    trial: Vec<SpatialVector>,
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

    /// All that the next step depends on beside the mechanism's state.
    pub fn memory(&self) -> impl Iterator<Item = f64> + '_ {
        let known = self.history.iter().filter(|_| self.length > 0.0);
        let known = known.flat_map(|past| {
            let screws = past.accelerations.iter().flat_map(|screw| screw.linear.iter().chain(screw.angular.iter()));
            screws.chain(past.forces.iter().flatten()).copied()
        });
        let carries = self.carries.iter().filter(|_| self.length > 0.0);
        known.chain(carries.flat_map(RoundingCarry::numbers))
    }

    /// Mean of the forces over the step.
    pub fn mean_force(&self, link: usize) -> Vector3<f64> {
        let weights = self.tableau.weights.iter();
        weights.zip(&self.stages).map(|(weight, stage)| stage.forces[link] * *weight).sum()
    }

    /// Takes the mechanism through a step of h, s. Where the iterations do not converge it stays where it was.
    pub fn step(&mut self, mechanism: &mut Mechanism, h: f64) -> StageIterations {
        self.begin(mechanism, h);
        let (mut before, mut share, mut rising) = (f64::INFINITY, 0.0, 0);
        let mut least = LEAST_CHANGE;
        for count in 1..=GAUSS_ITERATIONS {
            let mut change: f64 = 0.0;
            if count <= 3 {
                self.find_stiffness(mechanism, h);
            }
            let refactors = count == 1
                || ((!self.stiffness.is_empty() || mechanism.gives) && (count <= 4 || share > 0.3))
                || mechanism.may_be_singular;
            self.find_middles(mechanism, h);
            for stage in 0..S {
                if stage > 0 && !self.stiffness.is_empty() {
                    self.refresh_rates(mechanism, h);
                    self.find_middles(mechanism, h);
                }
                self.place_stage(mechanism, h, stage);
                if refactors {
                    self.assemble(mechanism, h, stage);
                }
                if mechanism.may_be_singular {
                    self.stages[stage].forces.fill(Vector3::zeros());
                }
                self.balance(mechanism, h, stage);
                let stage = self.correct(mechanism, stage);
                change = if stage > change || stage.is_nan() { stage } else { change };
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
            let is_stalled = count > 3 && share > 0.5 && change < GAUSS_UNCONVERGED;
            if is_converged || is_stalled {
                self.finish(mechanism, h);
                self.remember(h);
                return StageIterations { count: count as u32, converged: true };
            }
            before = change;
        }
        StageIterations { count: GAUSS_ITERATIONS as u32, converged: false }
    }

    /// The stages that the iterations start from.
    fn begin(&mut self, mechanism: &Mechanism, h: f64) {
        let count = mechanism.members.len();
        self.stages.resize_with(S, GaussStage::default);
        for stage in &mut self.stages {
            stage.accelerations.clear();
            stage.accelerations.resize(count, SpatialVector::ZERO);
            stage.forces.clear();
            stage.forces.resize(mechanism.links.len(), Vector3::zeros());
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

    /// Keeps the stages for the next step.
    fn remember(&mut self, h: f64) {
        self.length = h;
        self.history.resize_with(S, GaussHistory::default);
        for (past, stage) in self.history.iter_mut().zip(&self.stages) {
            past.accelerations.clone_from(&stage.accelerations);
            past.forces.clone_from(&stage.forces);
        }
    }

    /// Continues the polynomials through the stages of the step before.
    fn extrapolate(&mut self, mechanism: &Mechanism, h: f64) {
        let ahead = if h == self.length { self.tableau.ahead } else { self.tableau.ahead_by(h / self.length) };
        for member in 0..mechanism.moving {
            let old: [SpatialVector; S] = std::array::from_fn(|j| self.history[j].accelerations[member]);
            for (stage, shares) in self.stages.iter_mut().zip(&ahead) {
                stage.accelerations[member] = combine(&old, shares);
            }
        }
        for link in 0..mechanism.links.len() {
            let old: [Vector3<f64>; S] = std::array::from_fn(|j| self.history[j].forces[link]);
            for (stage, shares) in self.stages.iter_mut().zip(&ahead) {
                stage.forces[link] = old.iter().zip(shares).map(|(force, share)| force * *share).sum();
            }
        }
    }

    /// Makes room for K of all members, or none where K is small.
    fn find_stiffness(&mut self, mechanism: &Mechanism, h: f64) {
        self.stiffness.clear();
        let stage = &self.stages[S - 1];
        let mut largest: f64 = 0.0;
        for (link, force) in mechanism.links.iter().zip(&stage.forces) {
            for (member, anchor) in [(link.a, &link.anchor_a), (link.b, &link.anchor_b)] {
                let member = &mechanism.members[member as usize];
                if member.moves() {
                    largest = largest.max(force.norm_squared() * anchor.norm_squared() / member.inertia.max().powi(2));
                }
            }
        }
        if largest.sqrt() * h * h > GAUSS_SOFT {
            self.stiffness.resize(mechanism.members.len(), Matrix3::zeros());
        }
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

    /// Rotations, angular velocities and arms of a stage from the present accelerations.
    fn place_stage(&mut self, mechanism: &Mechanism, h: f64, stage: usize) {
        let Tableau { weights, matrix, .. } = &self.tableau;
        let gain: [f64; S] = std::array::from_fn(|j| h * matrix[stage][j]);
        let turns: [f64; S] = std::array::from_fn(|j| gain[j] - 0.5 * h * weights[j]);
        self.rotations.clear();
        self.angular.clear();
        for (member, state) in mechanism.states.iter().enumerate() {
            let (mut turn, mut angular) = (Vector3::zeros(), state.angular);
            for (j, other) in self.stages.iter().enumerate() {
                turn += other.rates[member] * turns[j];
                angular += other.accelerations[member].angular * gain[j];
            }
            self.stages[stage].rates[member] = inverse_dexp(&turn, &angular);
            let rotation = exponential(&turn) * self.middles[member];
            self.rotations.push(rotation.to_rotation_matrix().into_inner());
            self.angular.push(angular);
        }
        place_arms(mechanism, &self.rotations, &mut self.arms);
    }

    /// Factors the rows of a stage at its present rotations.
    fn assemble(&mut self, mechanism: &Mechanism, h: f64, stage: usize) {
        let own = self.tableau.matrix[stage][stage] * h;
        let own_squared = self.tableau.pivots[stage] * h * h;
        let turn = h * self.angular.iter().fold(0.0, |most: f64, angular| most.max(angular.norm_squared())).sqrt();
        if mechanism.gives {
            let mut asked = std::mem::take(&mut self.asked);
            asked.clear();
            asked.extend((0..mechanism.links.len()).map(|link| self.ask(mechanism, h, stage, link)));
            self.asked = asked;
        }
        let GaussStage { rows, forces, .. } = &mut self.stages[stage];
        let stiff = !self.stiffness.is_empty();
        if stiff {
            self.stiffness.fill(Matrix3::zeros());
            for ((link, arms), force) in mechanism.links.iter().zip(&self.arms).zip(&*forces) {
                add_pull(&mut self.stiffness[link.a as usize], &arms[0], &-force);
                add_pull(&mut self.stiffness[link.b as usize], &arms[1], force);
            }
        }
        rows.arms.clone_from(&self.arms);
        rows.inverse_masses.clear();
        for (index, member) in mechanism.members.iter().enumerate() {
            let slowed = (1.0 / (1.0 + member.drag.0 * own), 1.0 / (1.0 + member.drag.1 * own));
            let added = stiff.then(|| self.stiffness[index] * (own_squared * slowed.1));
            let angular = member.inverse_inertia(&self.rotations[index], added.as_ref());
            rows.inverse_masses
                .push(InverseMass { linear: member.inverse_mass * slowed.0, angular: angular * slowed.1 });
        }
        rows.assemble(mechanism, turn, |link, diagonal| {
            let spring = mechanism.links[link].spring.as_ref();
            spring.map_or(Matrix3::zeros(), |spring| softness(spring, diagonal, &self.asked[link], own, own_squared))
        });
    }

    /// The residuals: of the first line into `wrenches`; of the second into `unknowns`, less what the first will do to
    /// it.
    fn balance(&mut self, mechanism: &Mechanism, h: f64, stage: usize) {
        let GaussStage { accelerations, forces, rows, .. } = &self.stages[stage];
        self.wrenches.clear();
        for (index, member) in mechanism.members.iter().enumerate() {
            if !member.moves() {
                self.wrenches.push(SpatialVector::ZERO);
                continue;
            }
            let SpatialVector { linear, angular } = &accelerations[index];
            let omega = &self.angular[index];
            let mut force = member.force - linear * member.mass;
            let mut torque = member.torque;
            if member.is_round() {
                torque -= angular * member.inertia.x;
            } else {
                // In body axes, where the inertia is diagonal.
                let rotation = &self.rotations[index];
                let (spin, gain) = (rotation.tr_mul(omega), rotation.tr_mul(angular));
                let momentum = member.inertia.component_mul(&spin);
                torque -= rotation * (member.inertia.component_mul(&gain) + spin.cross(&momentum));
            }
            if member.drag != (0.0, 0.0) {
                let shares = &self.tableau.matrix[stage];
                let gained: Vector3<f64> = shares
                    .iter()
                    .zip(&self.stages)
                    .map(|(share, other)| other.accelerations[index].linear * (*share * h))
                    .sum();
                force -= (mechanism.states[index].linear + gained) * (member.mass * member.drag.0);
                torque -= member.world_inertia(&self.rotations[index]) * omega * member.drag.1;
            }
            self.wrenches.push(SpatialVector { linear: force, angular: torque });
        }
        add_wrenches(mechanism, &self.arms, forces, &mut self.wrenches);
        // The accelerations that the present forces would make.
        self.trial.clear();
        for ((acceleration, wrench), weight) in accelerations.iter().zip(&self.wrenches).zip(&rows.inverse_masses) {
            let more = weight.of(wrench);
            let (linear, angular) = (acceleration.linear + more.linear, acceleration.angular + more.angular);
            self.trial.push(SpatialVector { linear, angular });
        }
        self.unknowns.clear();
        for (index, (link, [arm_a, arm_b])) in mechanism.links.iter().zip(&self.arms).enumerate() {
            let gain = |member: u32, arm: &Vector3<f64>| {
                let (trial, omega) = (&self.trial[member as usize], &self.angular[member as usize]);
                trial.linear + trial.angular.cross(arm) + omega.cross(&omega.cross(arm))
            };
            let unknown = match &link.spring {
                None => gain(link.a, arm_a) - gain(link.b, arm_b),
                Some(spring) => {
                    let asked = self.ask(mechanism, h, stage, index);
                    let pull = spring.give(&asked, &rows.mobility[index]);
                    let given = rows.softness[index] * (pull - forces[index]);
                    let left = |member: u32, arm: &Vector3<f64>| {
                        let left = rows.inverse_masses[member as usize].of(&self.wrenches[member as usize]);
                        left.linear + left.angular.cross(arm)
                    };
                    given + left(link.a, arm_a) - left(link.b, arm_b)
                }
            };
            self.unknowns.push(unknown);
        }
    }

    /// −(ω²C + 2ζωĊ) of a spring at a stage, m/s²: its unbounded force on B for each kg.
    fn ask(&self, mechanism: &Mechanism, h: f64, stage: usize, index: usize) -> Vector3<f64> {
        let Tableau { nodes, matrix, squared, .. } = &self.tableau;
        let link = &mechanism.links[index];
        let Some(spring) = &link.spring else { return Vector3::zeros() };
        let [a, b] = [(link.a, 0), (link.b, 1)].map(|(member, end)| {
            let (member, arm) = (member as usize, &self.arms[index][end]);
            let state = &mechanism.states[member];
            let (mut place, mut speed) = (state.position + state.linear * (h * nodes[stage]), state.linear);
            for (j, other) in self.stages.iter().enumerate() {
                place += other.accelerations[member].linear * (h * h * squared[stage][j]);
                speed += other.accelerations[member].linear * (h * matrix[stage][j]);
            }
            (place + arm, speed + self.angular[member].cross(arm))
        });
        spring.ask(&(b.0 - a.0), &(b.1 - a.1))
    }

    /// Corrects a stage's accelerations and forces by the residuals. The largest change of an acceleration.
    fn correct(&mut self, mechanism: &Mechanism, stage: usize) -> f64 {
        let GaussStage { accelerations, forces, rows, .. } = &mut self.stages[stage];
        if mechanism.may_be_singular {
            // From zero: so forces that are not unique depend on the pose alone.
            std::mem::swap(&mut self.unknowns, &mut self.right);
            rows.solve(mechanism, &self.right, &mut self.unknowns);
        } else {
            rows.solve_once(mechanism, &mut self.unknowns);
        }
        for (force, more) in forces.iter_mut().zip(&self.unknowns) {
            *force += more;
        }
        rows.add_wrenches(mechanism, &self.unknowns, &mut self.wrenches);
        let mut largest: f64 = 0.0;
        let moved = accelerations.iter_mut().zip(&self.wrenches).zip(&rows.inverse_masses);
        for ((acceleration, wrench), weight) in moved.take(mechanism.moving) {
            let change = weight.of(wrench);
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
            let (mut gained, mut moved, mut half) = (SpatialVector::ZERO, Vector3::zeros(), Vector3::zeros());
            for (j, stage) in self.stages.iter().enumerate() {
                let SpatialVector { linear, angular } = &stage.accelerations[member];
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

fn combine<const S: usize>(screws: &[SpatialVector; S], shares: &[f64; S]) -> SpatialVector {
    screws.iter().zip(shares).fold(SpatialVector::ZERO, |sum, (screw, &share)| SpatialVector {
        linear: sum.linear + screw.linear * share,
        angular: sum.angular + screw.angular * share,
    })
}

/// 1/(m(ω² h² L_ii + 2ζω h a_ii)) along each axis, 1/m given: the inverse of S, the derivative of the force.
/// Where the unbounded force f is larger than the bound F, the derivative of F f/|f| is F/|f| (1 − f fᵀ/f²) S, which is
/// zero along f.
fn softness(
    spring: &JointSpring,
    mobility: &Vector3<f64>,
    asked: &Vector3<f64>,
    own: f64,
    own_squared: f64,
) -> Matrix3<f64> {
    let along = mobility / (spring.frequency * (spring.frequency * own_squared + 2.0 * spring.damping_ratio * own));
    let softness = Matrix3::from_diagonal(&along);
    let elastic = spring.elastic(asked, mobility);
    let size = elastic.norm();
    if size <= spring.most {
        return softness;
    }
    let unit = elastic / size;
    let direction = unit * unit.transpose();
    let across = Matrix3::identity() - direction;
    across * softness * across * (size / spring.most).min(SLACK) + direction * (SLACK * along.mean())
}

/// Adds max(0, r·f) (1 − r̂ r̂ᵀ).
fn add_pull(stiffness: &mut Matrix3<f64>, arm: &Vector3<f64>, force: &Vector3<f64>) {
    let along = arm.dot(force);
    if along > 0.0 {
        let unit = arm * (along / arm.norm_squared());
        *stiffness += Matrix3::from_diagonal_element(along) - unit * arm.transpose();
    }
}
