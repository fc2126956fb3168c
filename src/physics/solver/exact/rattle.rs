//! RATTLE (Andersen 1983): Strang's splitting into kicks by forces and free flight, with joints held exactly in place
//! and velocity; symmetric, of order 2.
//!
//! v½ = v₀ + ½h W₀(F + J₀ᵀλ) with λ such that joints hold after the flight: C(q₁) = 0; then
//! v₁ = v½ + ½h W₁(F + J₁ᵀμ) with μ such that J₁ v₁ = 0. λ is found by Newton's method with J₀ W₀ J₀ᵀ in place of
//! J₁ W₁ J₀ᵀ. Bodies turn freely by the midpoint rule of `integrator::gyroscopic`; drag takes e^{−ch/2} with each kick.

use nalgebra::Vector3;

use super::evaluation::Evaluation;
use super::gauss::Sweeps;
use super::mechanism::{Mechanism, Member, Motion};
use super::projection::{Gaps, Projection};
use super::rows::{Screw, Weight};
use crate::physics::integrator::gyroscopic::free_rotation;

/// Turns of Newton's method at most.
const MOST_TURNS: usize = 40;

/// Buffers.
#[derive(Clone, Debug, Default)]
pub(crate) struct Rattle {
    evaluation: Evaluation,
    projection: Projection,
    kicked: Vec<Motion>,
    impulses: Vec<Vector3<f64>>,
    errors: Vec<Vector3<f64>>,
    screws: Vec<Screw>,
    /// Mean force of each link over the step, N.
    pub forces: Vec<Vector3<f64>>,
}

impl Rattle {
    /// A step of order 2, of h, s. Where joints cannot be held the mechanism stays where it was.
    pub fn step(&mut self, mechanism: &mut Mechanism, h: f64) -> Sweeps {
        // λ of the start is the guess: it carries what is given, too.
        self.evaluation.evaluate(mechanism, &mechanism.motion, h);
        let Some(count) = self.hold_places(mechanism, h) else {
            return Sweeps { count: MOST_TURNS as u32, converged: false };
        };
        self.hold_velocities(mechanism, h);
        self.forces.clear();
        self.forces.extend(self.impulses.iter().map(|impulse| impulse * (1.0 / (0.5 * h))));
        Sweeps { count: count + 2, converged: true }
    }

    /// The first kick and the flight.
    fn hold_places(&mut self, mechanism: &mut Mechanism, h: f64) -> Option<u32> {
        let Self { evaluation, impulses, errors, screws, kicked, projection, .. } = self;
        kicked.clone_from(&mechanism.motion);
        let start = std::mem::take(kicked);
        impulses.clear();
        impulses.extend(evaluation.forces.iter().map(|force| force * (0.5 * h)));
        let mut before = f64::INFINITY;
        for turn in 1..=MOST_TURNS {
            screws.clear();
            screws.resize(start.len(), Screw::ZERO);
            evaluation.rows.add_wrenches(mechanism, impulses, screws);
            for (index, (motion, start)) in mechanism.motion.iter_mut().zip(&start).enumerate() {
                let member = &mechanism.members[index];
                *motion = *start;
                kick(member, motion, &screws[index], &evaluation.rows.weights[index], 0.5 * h);
                fly(member, motion, h);
            }
            let Gaps { largest, rounding, .. } = projection.errors_of(mechanism, errors);
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
        mechanism.motion.clone_from(&start);
        *kicked = start;
        None
    }

    /// The second kick.
    fn hold_velocities(&mut self, mechanism: &mut Mechanism, h: f64) {
        self.screws.clear();
        self.screws.resize(mechanism.members.len(), Screw::ZERO);
        if mechanism.gives {
            self.evaluation.evaluate(mechanism, &mechanism.motion, h);
            let forces = mechanism.links.iter().zip(&self.evaluation.forces);
            self.errors.clear();
            self.errors.extend(
                forces.map(|(link, force)| if link.spring.is_some() { force * (0.5 * h) } else { force * 0.0 }),
            );
            self.evaluation.rows.add_wrenches(mechanism, &self.errors, &mut self.screws);
        } else {
            self.evaluation.assemble(mechanism, &mechanism.motion, h);
        }
        for (index, motion) in mechanism.motion.iter_mut().enumerate() {
            let member = &mechanism.members[index];
            kick(member, motion, &self.screws[index], &self.evaluation.rows.weights[index], 0.5 * h);
        }
        self.projection.assemble(mechanism);
        self.projection.project_velocities(mechanism);
    }
}

/// Force and drag over h, with what joints give.
pub(super) fn kick(member: &Member, motion: &mut Motion, impulse: &Screw, weight: &Weight, h: f64) {
    if !member.moves() {
        return;
    }
    let given = Screw { linear: member.force * h + impulse.linear, angular: member.torque * h + impulse.angular };
    let gain = weight.of(&given);
    let kept = ((-member.drag.0 * h).exp(), (-member.drag.1 * h).exp());
    motion.linear = motion.linear * kept.0 + gain.linear;
    motion.angular = motion.angular * kept.1 + gain.angular;
}

/// Free flight over h.
pub(super) fn fly(member: &Member, motion: &mut Motion, h: f64) {
    let inverse = member.inertia.map(|inertia| if inertia > 0.0 { inertia.recip() } else { 0.0 });
    let free = free_rotation(&motion.rotation, &motion.angular, &inverse, &member.freedom, h);
    if let Some((angular, rotation)) = free {
        motion.position += motion.linear * h;
        (motion.angular, motion.rotation) = (angular, rotation);
    } else {
        motion.drift(h);
    }
}
