//! One mechanism through one step, by the integrator that the settings ask for.
//!
//! Where the iterations of a step do not converge, because it is too long for the forces, it is halved, again and again,
//! and later steps begin with substeps of that length; after some that converged longer ones are tried. A step in which
//! a free body would turn by more than [`LONGEST_TURN`] is divided, too. How often is counted. The shortest substep that
//! does not converge is an Euler step, and is reported, as when a mechanism at speed comes to the end of its reach; so is
//! the rest of a step that has taken [`MOST_EVALUATIONS`] and [`MOST_JOINT_EVALUATIONS`]. Whatever becomes of a
//! mechanism, a step ends.

use super::constants::{
    CONVERGED_BEFORE_LONGER, ENERGY_OF_ANOTHER, EULER_DIVISIONS, LONGEST_TURN, MOST_DIVISIONS, MOST_EVALUATIONS,
    MOST_JOINT_EVALUATIONS, NO_ENERGY, PARTED, RESTING_SPEED,
};
use super::gauss::{Gauss, StageIterations};
use super::lockstep::Lockstep;
use super::mechanism::{Mechanism, MemberState, kinetic_energies, only_forces_work};
use super::projection::JointProjection;
use super::rattle::Rattle;
use crate::physics::constraint::row::Wrench;
use crate::physics::settings::ExactIntegrator;

/// Stages.
const STAGES: usize = 3;

/// The work of a step, and what went wrong in it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct StepEffort {
    /// Evaluations of all rows.
    pub solves: u32,
    /// Substeps beyond those asked for.
    pub cuts: u32,
    /// Substeps that did not converge however short.
    pub unsettled: u32,
    /// Sliding points that no rigid motion satisfies.
    pub jammed: u32,
}

impl StepEffort {
    /// Whether a step of so many joints has taken the work that it may, in evaluations times joints.
    pub(super) fn is_spent(&self, joints: usize, most: u64) -> bool {
        self.solves >= MOST_EVALUATIONS && u64::from(self.solves) * joints as u64 >= most
    }
}

/// Integrators with what they keep from step to step.
#[derive(Clone, Debug, Default)]
pub(crate) struct Stepper {
    gauss: Gauss<STAGES>,
    lockstep: Lockstep,
    /// Which of the two had the last step.
    in_lockstep: bool,
    rattle: Rattle,
    pub(super) projection: JointProjection,
    /// Steps are divided into 2 to this power substeps.
    divisions: u32,
    /// Substeps in a row that converged.
    converged: u32,
    /// Whether the mechanism was moved, or tied together, by somebody else since the last step.
    is_new: bool,
    /// Where it was before the step at hand.
    before: Vec<MemberState>,
    /// Mean of each link's load over the step: force on B, and torque about B's anchor.
    pub loads: Vec<Wrench<f64>>,
}

impl Stepper {
    /// Forgets the steps before: the mechanism was moved by somebody else.
    pub fn forget(&mut self) {
        self.gauss.forget();
        self.lockstep.forget();
        self.in_lockstep = false;
        self.divisions = 0;
        self.converged = 0;
        self.is_new = true;
    }

    /// Forgets how the last step went, from which the next would be continued.
    pub(super) fn forget_history(&mut self) {
        self.gauss.forget();
        self.lockstep.forget();
    }

    /// The mechanism was put back to where the last step started from.
    pub(super) fn rewind(&mut self) {
        self.gauss.rewind();
        self.lockstep.forget();
    }

    /// All that the next step depends on beside the mechanism.
    pub fn memory(&self) -> impl Iterator<Item = f64> + '_ {
        let kept = self.gauss.memory().chain(self.lockstep.memory());
        kept.chain([f64::from(self.divisions), f64::from(self.converged), f64::from(u8::from(self.in_lockstep))])
    }

    /// Takes the mechanism through that many substeps of h, s, each, the first from that time.
    pub fn advance(
        &mut self,
        mechanism: &mut Mechanism,
        integrator: ExactIntegrator,
        time: f64,
        h: f64,
        substeps: u32,
    ) -> StepEffort {
        self.loads.clear();
        self.loads.resize(mechanism.links.len(), Wrench::zero());
        let mut effort = StepEffort::default();
        if std::mem::replace(&mut self.is_new, false) {
            self.tie(mechanism, time, h * f64::from(substeps), &mut effort);
        }
        for substep in 0..substeps {
            let start = time + h * f64::from(substep);
            self.advance_substep(mechanism, integrator, start, h, 1.0 / f64::from(substeps), &mut effort);
        }
        effort
    }

    /// What joints hold apart from now on, and had another speed until now, gets it by an impulse: v⁺ = v⁻ − M⁻¹Jᵀ(J M⁻¹Jᵀ)⁻¹
    /// (J v⁻ + ∂C/∂t), which takes energy only. Integrators, which know of accelerations alone, would go on from that speed.
    /// `step` is the length of the whole step, s.
    fn tie(&mut self, mechanism: &mut Mechanism, time: f64, step: f64, effort: &mut StepEffort) {
        let Self { projection, loads, .. } = self;
        projection.assemble(mechanism, time);
        if projection.fastest_parting(mechanism) <= RESTING_SPEED {
            return;
        }
        projection.project_velocities(mechanism);
        effort.solves += 1;
        for (load, link) in loads.iter_mut().zip(&mechanism.links) {
            let impulse = link.load(&link.arm_b(&mechanism.states), &projection.rows, &projection.impulses);
            *load = load.plus(&impulse, 1.0 / step);
        }
    }

    /// One step of h, s, from that time. Where it does not converge, or to a motion that takes energy from nowhere, the
    /// mechanism stays where it was.
    pub(super) fn step(
        &mut self,
        mechanism: &mut Mechanism,
        integrator: ExactIntegrator,
        time: f64,
        h: f64,
    ) -> StageIterations {
        let Mechanism { members, moving, states, links, .. } = &*mechanism;
        if !only_forces_work(members, *moving, states, links) {
            return self.integrate(mechanism, integrator, time, h);
        }
        self.before.clone_from(&mechanism.states);
        let iterations = self.integrate(mechanism, integrator, time, h);
        if !iterations.converged || !has_gained(mechanism, &self.before) {
            return iterations;
        }
        mechanism.states.clone_from(&self.before);
        self.forget_history();
        StageIterations { converged: false, ..iterations }
    }

    fn integrate(
        &mut self,
        mechanism: &mut Mechanism,
        integrator: ExactIntegrator,
        time: f64,
        h: f64,
    ) -> StageIterations {
        match integrator {
            ExactIntegrator::Rattle => self.rattle.step(mechanism, time, h),
            ExactIntegrator::Gauss => {
                if let Some(iterations) = self.lockstep.step(mechanism, h) {
                    self.in_lockstep = true;
                    return iterations;
                }
                if std::mem::replace(&mut self.in_lockstep, false) {
                    self.gauss.forget();
                }
                let iterations = self.gauss.step(mechanism, time, h);
                StageIterations { count: iterations.count * STAGES as u32, ..iterations }
            }
        }
    }

    /// Each link's load at the mechanism's states and that time, s.
    pub(super) fn find_loads(&mut self, mechanism: &Mechanism, time: f64, loads: &mut Vec<Wrench<f64>>) {
        self.gauss.find_loads(mechanism, time, loads);
    }

    /// Mean load of a link over the last step, of h.
    pub(super) fn load(&self, mechanism: &Mechanism, integrator: ExactIntegrator, link: usize, h: f64) -> Wrench<f64> {
        match integrator {
            ExactIntegrator::Rattle => self.rattle.mean_load(mechanism, link, h),
            ExactIntegrator::Gauss if self.in_lockstep => self.lockstep.mean_load(link),
            ExactIntegrator::Gauss => self.gauss.mean_load(mechanism, link),
        }
    }

    fn advance_substep(
        &mut self,
        mechanism: &mut Mechanism,
        integrator: ExactIntegrator,
        time: f64,
        h: f64,
        share: f64,
        effort: &mut StepEffort,
    ) {
        let whole = 1_u32 << MOST_DIVISIONS;
        let (mut left, mut substeps) = (whole, 0);
        while left > 0 {
            while self.divisions < MOST_DIVISIONS && turn_of(mechanism, h, self.divisions) > LONGEST_TURN {
                self.divisions += 1;
                self.converged = 0;
            }
            let mut size = left.min(whole >> self.divisions);
            let share_of = |size: u32| f64::from(size) / f64::from(whole);
            let start = time + h * share_of(whole - left);
            let is_spent = effort.is_spent(mechanism.links.len(), MOST_JOINT_EVALUATIONS);
            let part = h * share_of(size);
            let iterations =
                if is_spent { StageIterations::NONE } else { self.step(mechanism, integrator, start, part) };
            effort.solves += iterations.count;
            if iterations.converged {
                for link in 0..self.loads.len() {
                    let load = self.load(mechanism, integrator, link, part);
                    self.loads[link] = self.loads[link].plus(&load, share_of(size) * share);
                }
            } else if !is_spent && self.divisions < MOST_DIVISIONS {
                self.divisions += 1;
                self.converged = 0;
                continue;
            } else {
                size = left.min(whole >> EULER_DIVISIONS);
                self.euler_step(mechanism, start, h * share_of(size), h / share);
                effort.unsettled += 1;
                (self.divisions, self.converged) = (EULER_DIVISIONS, 0);
            }
            left -= size;
            let end = time + h * share_of(whole - left);
            effort.unsettled += u32::from(self.projection.project(mechanism, end) > PARTED);
            substeps += 1;
            self.converged += 1;
            if self.converged >= CONVERGED_BEFORE_LONGER
                && self.divisions > 0
                && left.is_multiple_of(2 * size)
                && turn_of(mechanism, h, self.divisions - 1) <= LONGEST_TURN
            {
                self.divisions -= 1;
                self.converged = 0;
            }
        }
        effort.cuts += substeps - 1;
    }

    /// v += h a of forces, springs and drag without the other joints, which the projection brings back, then x += h v;
    /// `step` is the length of the whole step, s.
    pub(super) fn euler_step(&mut self, mechanism: &mut Mechanism, time: f64, h: f64, step: f64) {
        let Self { projection, loads, .. } = self;
        projection.assemble(mechanism, time);
        projection.kick(mechanism, h, |spring, rows, mobility| {
            spring.pull_in_kick(rows, &spring.each(|row| rows[row].rate), mobility, h)
        });
        projection.project_velocities(mechanism);
        for (load, link) in loads.iter_mut().zip(&mechanism.links) {
            let arm = link.arm_b(&mechanism.states);
            for impulses in [&projection.pulls, &projection.impulses] {
                *load = load.plus(&link.load(&arm, &projection.rows, impulses), 1.0 / step);
            }
        }
        for state in &mut mechanism.states {
            state.drift(h);
        }
        self.forget_history();
    }
}

/// Whether it has more energy than it had before and than forces have given it.
fn has_gained(Mechanism { members, states, moving, .. }: &Mechanism, before: &[MemberState]) -> bool {
    let members = &members[..*moving];
    let [was, is] = [before, states].map(|states| kinetic_energies(members, states).sum::<f64>());
    let ways = members.iter().zip(states.iter().zip(before));
    let work: f64 = ways.map(|(member, (state, before))| member.force.dot(&(state.position - before.position))).sum();
    let mass: f64 = members.iter().map(|member| member.mass).sum();
    is - was - work > ENERGY_OF_ANOTHER * is.max(was) + NO_ENERGY * mass
}

/// Turn of a free body in a substep of a step of h, s, that is divided so often, rad. Joined bodies need no such bound:
/// their iterations tell by not converging.
fn turn_of(mechanism: &Mechanism, h: f64, divisions: u32) -> f64 {
    if !mechanism.links.is_empty() {
        return 0.0;
    }
    let squares = mechanism.states.iter().map(|state| state.angular.norm_squared());
    squares.fold(0.0, f64::max).sqrt() * h / f64::from(1_u32 << divisions)
}

#[cfg(test)]
mod tests {
    use bevy::prelude::default;
    use nalgebra::Vector3;

    use super::*;
    use crate::physics::joint::{Frame, JointDefinition, Laws, Softness};
    use crate::physics::solver::exact::mechanism::{MechanismLink, Member};

    /// A ball of 2 kg under a fixed point, on a spring and a rod of 1 m that hangs from it, all by Euler's steps: at rest
    /// the spring carries both, and its stretch is what the weight makes of it for the masses of its two bodies alone.
    #[test]
    fn what_falls_back_hangs_on_its_springs() {
        let gravity = Vector3::y() * -9.81;
        let body = |mass: f64| Member {
            mass,
            inverse_mass: Vector3::repeat(1.0 / mass),
            inertia: Vector3::repeat(0.1 * mass),
            force: gravity * mass,
            ..Member::FIXED
        };
        let mut states = vec![MemberState::REST; 3];
        states[1].position = Vector3::y() * -1.0;
        let spring = Softness { frequency: 1.0, damping_ratio: 0.5, max_force: 1e9 };
        let links =
            [(2, 0, Vector3::zeros(), Some(spring)), (0, 1, Vector3::y(), None)].map(|(a, b, anchor, spring)| {
                let frames = [Frame::at(Vector3::zeros()), Frame::at(anchor)];
                let definition = JointDefinition { frames, translation: Laws { spring, ..Laws::LOCKED }, ..default() };
                MechanismLink::new(&definition, [a, b], [&states[a as usize], &states[b as usize]], 0.0)
            });
        let (order, mut mechanism) = Mechanism::plan(2, false, &links);
        mechanism.members = vec![body(2.0), body(1.0), Member::FIXED];
        mechanism.states = states;
        let mut stepper = Stepper::default();
        let h = 1.0 / 240.0;
        for _ in 0..4800 {
            stepper.loads = vec![Wrench::zero(); 2];
            stepper.euler_step(&mut mechanism, 0.0, h, h);
            stepper.projection.project(&mut mechanism, 0.0);
        }
        let rest = -9.81 * 3.0 / (2.0 * std::f64::consts::TAU.powi(2));
        assert!((mechanism.states[0].position.y - rest).abs() < 1e-6, "{}", mechanism.states[0].position.y);
        assert!((mechanism.states[1].position.y - (rest - 1.0)).abs() < 1e-6);
        for (&link, load) in order.iter().zip(&stepper.loads) {
            let carried = -gravity * [3.0, 1.0][link as usize];
            assert!((load.linear - carried).norm() < 1e-6, "{load:?}");
        }
    }
}
