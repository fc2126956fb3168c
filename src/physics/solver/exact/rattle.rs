//! RATTLE (Andersen 1983): Strang's splitting into kicks by forces and free motion, with joints held exactly in place
//! and velocity; symmetric, of order 2.
//!
//! v½ = v₀ + ½h W₀(F + J₀ᵀλ) with λ such that joints hold after the free motion: C(q₁) = 0; then
//! v₁ = v½ + ½h W₁(F + J₁ᵀμ) with μ such that J₁ v₁ = 0. λ is found by Newton's method with J₀ W₀ J₀ᵀ in place of
//! J₁ W₁ J₀ᵀ. Bodies turn freely by the midpoint rule of `integrator::gyroscopic`; drag takes e^{−ch/2} with each kick.

use nalgebra::Vector3;

use super::constants::RATTLE_ITERATIONS;
use super::evaluation::Evaluation;
use super::gauss::StageIterations;
use super::mechanism::{Mechanism, Member, MemberState};
use super::projection::{JointErrors, JointProjection};
use super::rows::{InverseMass, SpatialVector};
use crate::physics::body::free_rotation::free_rotation;

/// The joint forces and the buffers.
#[derive(Clone, Debug, Default)]
pub(crate) struct Rattle {
    evaluation: Evaluation,
    projection: JointProjection,
    kicked: Vec<MemberState>,
    impulses: Vec<Vector3<f64>>,
    errors: Vec<Vector3<f64>>,
    wrenches: Vec<SpatialVector>,
    /// Mean force of each link over the step, N.
    pub forces: Vec<Vector3<f64>>,
}

impl Rattle {
    /// A step of order 2, of h, s. Where joints cannot be held the mechanism stays where it was.
    pub fn step(&mut self, mechanism: &mut Mechanism, h: f64) -> StageIterations {
        // The iteration starts from λ at the start of the step, which has the forces of springs, too.
        self.evaluation.evaluate(mechanism, &mechanism.states, h);
        let Some(count) = self.hold_places(mechanism, h) else {
            return StageIterations { count: RATTLE_ITERATIONS as u32, converged: false };
        };
        self.hold_velocities(mechanism, h);
        self.forces.clear();
        self.forces.extend(self.impulses.iter().map(|impulse| impulse * (1.0 / (0.5 * h))));
        StageIterations { count: count + 2, converged: true }
    }

    /// The first kick and the free motion.
    fn hold_places(&mut self, mechanism: &mut Mechanism, h: f64) -> Option<u32> {
        let Self { evaluation, impulses, errors, wrenches, kicked, projection, .. } = self;
        kicked.clone_from(&mechanism.states);
        let start = std::mem::take(kicked);
        impulses.clear();
        impulses.extend(evaluation.forces.iter().map(|force| force * (0.5 * h)));
        let mut before = f64::INFINITY;
        for turn in 1..=RATTLE_ITERATIONS {
            wrenches.clear();
            wrenches.resize(start.len(), SpatialVector::ZERO);
            evaluation.rows.add_wrenches(mechanism, impulses, wrenches);
            for (index, (state, start)) in mechanism.states.iter_mut().zip(&start).enumerate() {
                let member = &mechanism.members[index];
                *state = *start;
                kick(member, state, &wrenches[index], &evaluation.rows.inverse_masses[index], 0.5 * h);
                move_freely(member, state, h);
            }
            let JointErrors { largest, rounding, .. } = projection.errors_of(mechanism, errors);
            if largest <= rounding || largest >= 0.9 * before && largest < 1e-11 {
                *kicked = start;
                return Some(turn as u32);
            }
            if largest.is_nan() || largest > 4.0 * before {
                break;
            }
            before = before.min(largest);
            evaluation.rows.solve_once(mechanism, errors);
            for ((impulse, more), link) in impulses.iter_mut().zip(&*errors).zip(&mechanism.links) {
                if link.spring.is_none() {
                    *impulse += more / h;
                }
            }
        }
        mechanism.states.clone_from(&start);
        *kicked = start;
        None
    }

    /// The second kick.
    fn hold_velocities(&mut self, mechanism: &mut Mechanism, h: f64) {
        self.wrenches.clear();
        self.wrenches.resize(mechanism.members.len(), SpatialVector::ZERO);
        if mechanism.gives {
            self.evaluation.evaluate(mechanism, &mechanism.states, h);
            let forces = mechanism.links.iter().zip(&self.evaluation.forces);
            self.errors.clear();
            self.errors.extend(
                forces.map(|(link, force)| if link.spring.is_some() { force * (0.5 * h) } else { force * 0.0 }),
            );
            self.evaluation.rows.add_wrenches(mechanism, &self.errors, &mut self.wrenches);
        } else {
            self.evaluation.assemble(mechanism, &mechanism.states, h);
        }
        for (index, state) in mechanism.states.iter_mut().enumerate() {
            let member = &mechanism.members[index];
            kick(member, state, &self.wrenches[index], &self.evaluation.rows.inverse_masses[index], 0.5 * h);
        }
        self.projection.assemble(mechanism);
        self.projection.project_velocities(mechanism);
    }
}

/// A kick of forces and drag over h, with an impulse besides.
pub(super) fn kick(
    member: &Member,
    state: &mut MemberState,
    impulse: &SpatialVector,
    inverse_mass: &InverseMass,
    h: f64,
) {
    if !member.moves() {
        return;
    }
    let given =
        SpatialVector { linear: member.force * h + impulse.linear, angular: member.torque * h + impulse.angular };
    let gain = inverse_mass.of(&given);
    let kept = ((-member.drag.0 * h).exp(), (-member.drag.1 * h).exp());
    state.linear = state.linear * kept.0 + gain.linear;
    state.angular = state.angular * kept.1 + gain.angular;
}

/// Free motion over h.
pub(super) fn move_freely(member: &Member, state: &mut MemberState, h: f64) {
    let inverse = member.inertia.map(|inertia| if inertia > 0.0 { inertia.recip() } else { 0.0 });
    let free = free_rotation(&state.rotation, &state.angular, &inverse, &member.freedom, h);
    if let Some((angular, rotation)) = free {
        state.position += state.linear * h;
        (state.angular, state.rotation) = (angular, rotation);
    } else {
        state.drift(h);
    }
}
