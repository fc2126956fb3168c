//! One mechanism through one step, by the integrator that the settings ask for.
//!
//! Where the sweeps of a step do not converge, because it is too long for what the forces make of the mechanism, it is
//! cut in two, and its parts again, and later ones begin with parts of that length; after some that converged longer
//! ones are tried. So is one in which a body by itself would turn by more than [`LONGEST_TURN`]. How often is counted.
//! What does not converge in the shortest part goes by a plain Euler step, and is reported, as when a mechanism at speed
//! comes to the end of its reach; so does all that is left of a step that has taken [`MOST_WORK`]. Whatever becomes of
//! a mechanism, a step ends.

use nalgebra::Vector3;

use super::gauss::{Gauss, Sweeps};
use super::lockstep::Lockstep;
use super::mechanism::{Mechanism, stretch};
use super::projection::Projection;
use super::rattle::{Rattle, kick};
use super::rows::Screw;
use crate::physics::settings::ExactIntegrator;

/// A step is cut into 2 to this power parts at most.
const MOST_CUTS: u32 = 12;

/// Work that a step may take: evaluations of all rows, and of links in all of these. Hard steps take some hundred
/// evaluations; few links may take more.
const MOST_WORK: (u32, u64) = (500, 200_000);

/// A step is cut into 2 to this power parts where they go by Euler's.
const COARSE_CUTS: u32 = 6;

/// Turn of a part, rad: of twice that, a box that flips over its middle axis keeps no digit for a second.
const LONGEST_TURN: f64 = 0.8;

/// Parts that must converge before longer ones are tried.
const CALM: u32 = 8;

/// What is left between the ends of a joint from which on that is reported, m. Near poses where ways to move branch a
/// millionth may be left: no linear step tells which to take.
const PARTED: f64 = 1e-5;

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
    rattle: Rattle,
    projection: Projection,
    /// Steps are cut into 2 to this power parts.
    level: u32,
    calm: u32,
    /// Mean of each link's force on B over the step, N.
    pub forces: Vec<Vector3<f64>>,
    screws: Vec<Screw>,
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
    pub fn advance(&mut self, mechanism: &mut Mechanism, integrator: ExactIntegrator, h: f64, parts: u32) -> Effort {
        self.forces.clear();
        self.forces.resize(mechanism.links.len(), Vector3::zeros());
        let mut effort = Effort::default();
        for _ in 0..parts {
            self.advance_part(mechanism, integrator, h, 1.0 / f64::from(parts), &mut effort);
        }
        effort
    }

    fn step(&mut self, mechanism: &mut Mechanism, integrator: ExactIntegrator, h: f64) -> Sweeps {
        match integrator {
            ExactIntegrator::Rattle => self.rattle.step(mechanism, h),
            ExactIntegrator::Gauss => {
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

    fn force(&self, integrator: ExactIntegrator, link: usize) -> Vector3<f64> {
        match integrator {
            ExactIntegrator::Rattle => self.rattle.forces[link],
            ExactIntegrator::Gauss if self.in_lockstep => self.lockstep.mean_force(link),
            ExactIntegrator::Gauss => self.gauss.mean_force(link),
        }
    }

    fn advance_part(
        &mut self,
        mechanism: &mut Mechanism,
        integrator: ExactIntegrator,
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
            let mut size = left.min(whole >> self.level);
            let part_of = |size: u32| f64::from(size) / f64::from(whole);
            let work = u64::from(effort.solves) * mechanism.links.len() as u64;
            let is_spent = effort.solves >= MOST_WORK.0 && work >= MOST_WORK.1;
            let sweeps = if is_spent { Sweeps::NONE } else { self.step(mechanism, integrator, h * part_of(size)) };
            effort.solves += sweeps.count;
            if sweeps.converged {
                for link in 0..self.forces.len() {
                    let force = self.force(integrator, link);
                    self.forces[link] += force * (part_of(size) * share);
                }
            } else if !is_spent && self.level < MOST_CUTS {
                self.level += 1;
                self.calm = 0;
                continue;
            } else {
                size = left.min(whole >> COARSE_CUTS);
                self.fall_back(mechanism, h * part_of(size), h / share);
                effort.unsettled += 1;
                (self.level, self.calm) = (COARSE_CUTS, 0);
            }
            effort.unsettled += u32::from(self.projection.project(mechanism) > PARTED);
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

    /// v += h a of forces, springs and drag without the other joints, which the projection brings back, then x += h v;
    /// in a step of so long, s.
    fn fall_back(&mut self, mechanism: &mut Mechanism, h: f64, step: f64) {
        let Self { projection, screws, forces, .. } = self;
        projection.assemble(mechanism);
        screws.clear();
        screws.resize(mechanism.members.len(), Screw::ZERO);
        let rows = &projection.rows;
        let mut pulls = vec![Vector3::zeros(); mechanism.links.len()];
        for (index, link) in mechanism.links.iter().enumerate() {
            if let Some(spring) = &link.spring {
                let [apart, speed] = stretch(link, &rows.arms[index], &mechanism.motion);
                pulls[index] = spring.give(&spring.ask_in_kick(&apart, &speed, h), &rows.mobility[index]) * h;
            }
        }
        rows.add_wrenches(mechanism, &pulls, screws);
        for (((motion, member), impulse), weight) in
            mechanism.motion.iter_mut().zip(&mechanism.members).zip(&*screws).zip(&rows.weights)
        {
            kick(member, motion, impulse, weight, h);
        }
        projection.project_velocities(mechanism);
        for ((force, pull), impulse) in forces.iter_mut().zip(&pulls).zip(projection.impulses()) {
            *force += (pull + impulse) / step;
        }
        for motion in &mut mechanism.motion {
            motion.drift(h);
        }
        self.gauss.forget();
        self.lockstep.forget();
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::solver::exact::mechanism::{Link, Member, Motion, Spring};

    /// A ball of 2 kg under a fixed point, on a spring and a rod of 1 m that hangs from it, all by Euler's steps: at rest
    /// the spring carries both, and its stretch is what the weight makes of it for the masses of its two bodies alone.
    #[test]
    fn what_falls_back_hangs_on_its_springs() {
        let (frequency, weight) = (std::f64::consts::TAU, Vector3::y() * -9.81);
        let body = |mass: f64| Member {
            mass,
            inverse_mass: Vector3::repeat(1.0 / mass),
            inertia: Vector3::repeat(0.1 * mass),
            force: weight * mass,
            ..Member::FIXED
        };
        let (order, mut mechanism) = Mechanism::plan(2, false, true, &[[2, 0], [0, 1]]);
        mechanism.members = vec![body(2.0), body(1.0), Member::FIXED];
        mechanism.motion = vec![Motion::REST; 3];
        mechanism.motion[1].position = Vector3::y() * -1.0;
        let spring = Spring { frequency, damping_ratio: 0.5, most: 1e9 };
        let links = [(2, 0, Vector3::zeros(), Some(spring)), (0, 1, Vector3::y(), None)]
            .map(|(a, b, anchor_b, spring)| Link { a, b, anchor_a: Vector3::zeros(), anchor_b, spring });
        mechanism.links = order.iter().map(|&link| links[link as usize].clone()).collect();
        let mut stepper = Stepper::default();
        let h = 1.0 / 240.0;
        for _ in 0..4800 {
            stepper.forces = vec![Vector3::zeros(); 2];
            stepper.fall_back(&mut mechanism, h, h);
            stepper.projection.project(&mut mechanism);
        }
        let rest = -9.81 * 3.0 / (2.0 * frequency * frequency);
        assert!((mechanism.motion[0].position.y - rest).abs() < 1e-6, "{}", mechanism.motion[0].position.y);
        assert!((mechanism.motion[1].position.y - (rest - 1.0)).abs() < 1e-6);
        for (&link, force) in order.iter().zip(&stepper.forces) {
            let carried = -weight * [3.0, 1.0][link as usize];
            assert!((force - carried).norm() < 1e-6, "{force}");
        }
    }
}
