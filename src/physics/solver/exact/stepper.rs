//! One mechanism through one step, by the integrator that the settings ask for.
//!
//! Where the sweeps of a step do not converge, because it is too long for what the forces make of the mechanism, it is
//! cut in two, and its parts again, and later ones begin with parts of that length; after some that converged longer
//! ones are tried. So is one in which a body by itself would turn by more than [`LONGEST_TURN`]. How often is counted.
//! At the shortest a part goes by a plain Euler step, and is reported.

use nalgebra::Vector3;

use super::gauss::{Gauss, Sweeps};
use super::lockstep::Lockstep;
use super::mechanism::{Mechanism, Motion};
use super::projection::Projection;
use super::rattle::Rattle;
use super::rows::Screw;
use super::runge_kutta::RungeKutta;
use crate::physics::settings::Integrator;

/// A step is cut into 2 to this power parts at most.
const MOST_CUTS: u32 = 12;

/// Turn of a part, rad: of twice that, a box that flips over its middle axis keeps no digit for a second.
const LONGEST_TURN: f64 = 0.8;

/// Parts that must converge before longer ones are tried.
const CALM: u32 = 8;

/// Kinetic energy after a projection over that before it, at most.
const MOST_GAINED: f64 = 2.0;

/// Kinetic energy that is none, J/kg.
pub(crate) const STILL: f64 = 1e-12;

/// Stages.
const STAGES: usize = 3;

/// What a step took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Effort {
    /// Evaluations of all rows.
    pub solves: u32,
    /// Parts beyond those asked for.
    pub cuts: u32,
    /// Parts that did not converge however short.
    pub unsettled: u32,
    /// Sliding points without a rigid motion.
    pub jammed: u32,
}

/// Integrators with what they keep from step to step.
#[derive(Clone, Debug, Default)]
pub(crate) struct Stepper {
    gauss: Gauss<STAGES>,
    lockstep: Lockstep,
    /// Which of the two had the last step.
    in_lockstep: bool,
    runge_kutta: RungeKutta,
    rattle: Rattle,
    projection: Projection,
    /// Steps are cut into 2 to this power parts.
    level: u32,
    calm: u32,
    /// Mean of each link's force on B over the step, N.
    pub forces: Vec<Vector3<f64>>,
    screws: Vec<Screw>,
    /// The mechanism before it was projected.
    before: Vec<Motion>,
}

impl Stepper {
    /// Forgets the steps before: the mechanism was moved by somebody else.
    pub fn forget(&mut self) {
        self.gauss.forget();
        self.lockstep.forget();
        self.in_lockstep = false;
        self.level = 0;
        self.calm = 0;
    }

    /// All that the next step depends on beside the mechanism.
    pub fn memory(&self) -> impl Iterator<Item = f64> + '_ {
        let kept = self.gauss.memory().chain(self.lockstep.memory());
        kept.chain([f64::from(self.level), f64::from(self.calm), f64::from(u8::from(self.in_lockstep))])
    }

    /// Takes the mechanism through so many equal parts of h, s, each.
    pub fn advance(&mut self, mechanism: &mut Mechanism, integrator: Integrator, h: f64, parts: u32) -> Effort {
        self.forces.clear();
        self.forces.resize(mechanism.links.len(), Vector3::zeros());
        let mut effort = Effort::default();
        for _ in 0..parts {
            self.advance_part(mechanism, integrator, h, 1.0 / f64::from(parts), &mut effort);
        }
        effort
    }

    fn step(&mut self, mechanism: &mut Mechanism, integrator: Integrator, h: f64) -> Sweeps {
        match integrator {
            Integrator::RungeKutta4 => self.runge_kutta.step(mechanism, h),
            Integrator::Rattle => self.rattle.step(mechanism, h),
            Integrator::ComposedRattle => self.rattle.composed_step(mechanism, h),
            _ => {
                if let Some(sweeps) = self.lockstep.step(mechanism, h) {
                    self.in_lockstep = true;
                    return sweeps;
                }
                if std::mem::replace(&mut self.in_lockstep, false) {
                    self.gauss.forget();
                }
                let sweeps = self.gauss.step(mechanism, h);
                Sweeps { count: sweeps.count * STAGES as u32, ..sweeps }
            }
        }
    }

    fn force(&self, integrator: Integrator, link: usize) -> Vector3<f64> {
        match integrator {
            Integrator::RungeKutta4 => self.runge_kutta.forces[link],
            Integrator::Rattle | Integrator::ComposedRattle => self.rattle.forces[link],
            _ if self.in_lockstep => self.lockstep.mean_force(link),
            _ => self.gauss.mean_force(link),
        }
    }

    fn advance_part(
        &mut self,
        mechanism: &mut Mechanism,
        integrator: Integrator,
        h: f64,
        share: f64,
        effort: &mut Effort,
    ) {
        let whole = 1_u32 << MOST_CUTS;
        let (mut left, mut parts) = (whole, 0);
        while left > 0 {
            while self.level < MOST_CUTS && turn_of(mechanism, h, self.level) > LONGEST_TURN {
                self.level += 1;
                self.calm = 0;
            }
            let size = whole >> self.level;
            let length = f64::from(size) / f64::from(whole);
            let sweeps = self.step(mechanism, integrator, h * length);
            effort.solves += sweeps.count;
            if !sweeps.converged && self.level < MOST_CUTS {
                self.level += 1;
                self.calm = 0;
                continue;
            }
            if sweeps.converged {
                for link in 0..self.forces.len() {
                    let force = self.force(integrator, link);
                    self.forces[link] += force * (length * share);
                }
            } else {
                self.fall_back(mechanism, h * length);
                effort.unsettled += 1;
            }
            let is_projected = self.project(mechanism);
            effort.unsettled += u32::from(!is_projected);
            left -= size;
            parts += 1;
            self.calm += 1;
            if self.calm >= CALM
                && self.level > 0
                && left.is_multiple_of(2 * size)
                && turn_of(mechanism, h, self.level - 1) <= LONGEST_TURN
            {
                self.level -= 1;
                self.calm = 0;
            }
        }
        effort.cuts += parts - 1;
    }

    /// Brings joints back, unless that makes kinetic energy where no support moves: then their rows are too nearly
    /// dependent, and the mechanism stays as it was. Whether it did.
    fn project(&mut self, mechanism: &mut Mechanism) -> bool {
        self.before.clone_from(&mechanism.motion);
        self.projection.project(mechanism);
        let mass: f64 = mechanism.members.iter().map(|member| member.mass).sum();
        let most = MOST_GAINED * kinetic_energy(mechanism, &self.before) + STILL * mass;
        let gains = mechanism.motion[mechanism.moving..].iter().all(Motion::is_still)
            && kinetic_energy(mechanism, &mechanism.motion) > most;
        if gains {
            mechanism.motion.clone_from(&self.before);
        }
        !gains
    }

    /// v += h a without the joints, which the projection brings back, then x += h v.
    fn fall_back(&mut self, mechanism: &mut Mechanism, h: f64) {
        self.projection.assemble(mechanism);
        self.screws.clear();
        self.screws
            .extend(mechanism.members.iter().map(|member| Screw { linear: member.force, angular: member.torque }));
        for ((motion, wrench), weight) in
            mechanism.motion.iter_mut().zip(&self.screws).zip(&self.projection.rows.weights)
        {
            let gain = weight.of(wrench);
            motion.linear += gain.linear * h;
            motion.angular += gain.angular * h;
        }
        self.projection.project_velocities(mechanism);
        for motion in &mut mechanism.motion {
            motion.drift(h);
        }
    }
}

/// How far a body by itself turns in a part of a step of h, s, cut so often, rad. Of what is joined, sweeps that do not
/// converge tell.
fn turn_of(mechanism: &Mechanism, h: f64, level: u32) -> f64 {
    if !mechanism.links.is_empty() {
        return 0.0;
    }
    let squares = mechanism.motion.iter().map(|motion| motion.angular.norm_squared());
    squares.fold(0.0, f64::max).sqrt() * h / f64::from(1_u32 << level)
}

fn kinetic_energy(mechanism: &Mechanism, motion: &[Motion]) -> f64 {
    mechanism.members.iter().zip(motion).map(|(member, motion)| member.kinetic_energy(motion)).sum()
}
