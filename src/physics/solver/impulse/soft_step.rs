//! The soft step: substeps with soft constraints (Catto 2024, *Solver2D*; Macklin et al. 2019 for
//! substeps instead of sweeps).
//!
//! Each substep: forces and last impulses → sweep with springs → positions → sweep without. The
//! springs mend position errors without stiffness a sweep cannot follow; the second sweep, *relax*,
//! takes their push out of the velocities again, so that it adds no energy. Bounces come last.
//!
//! Contacts rub in the second sweep only, but where surfaces come together in the step: what the springs move is no
//! slip. Nor may softness make what is high lean: the springs of an interface resist tilting with k_θ = Σ k z², and a
//! column of unit cubes buckles under its weight from n³ m g/k_θ ≈ 7.84 on (Greenhill 1881), at 4 substeps from n = 20,
//! though rigid cubes would stand. So rows are made for the rotations that bodies had until they turn a little
//! ([`crate::physics::solver::impulse`]): a lean of less adds nothing to what topples.

use super::{Color, GroupTerms, Plan, Stage, Sweep};
use crate::physics::lanes::Lanes;
use crate::physics::settings::SolverSettings;
use crate::physics::solver::soft_terms::{SoftTerms, UNLIMITED};
use crate::physics::solver::substeps::Substeps;

/// Natural frequency of contacts over substeps a second. What a sweep can follow is about a quarter (Catto 2024);
/// stiffer, large walls tremble, softer, columns sink deeper.
const CONTACT_FREQUENCY: f64 = 0.1875;
/// Damping ratio of contacts: they must not bounce. Less lets them ring, more lets columns creep.
const CONTACT_DAMPING: f64 = 5.0;
/// Natural frequency of joints over substeps a second.
const JOINT_FREQUENCY: f64 = 0.25;
/// Damping ratio of joints.
const JOINT_DAMPING: f64 = 2.0;

/// What groups need of the settings.
pub(crate) fn terms<L: Lanes>(settings: &SolverSettings) -> GroupTerms<L> {
    let h = settings.step() / f64::from(settings.substeps);
    let push = settings.correction_speed.unwrap_or(UNLIMITED);
    let soft = |share: f64, damping, slop| SoftTerms::new(share / h, damping, push, slop, h);
    GroupTerms {
        h,
        substeps: Substeps::of(settings),
        joint: soft(JOINT_FREQUENCY, JOINT_DAMPING, 0.0),
        contact: soft(CONTACT_FREQUENCY, CONTACT_DAMPING, settings.slop),
        projection: None,
        restitution_speed: settings.restitution_speed.unwrap_or(UNLIMITED),
    }
}

/// Turn in a step beyond which rows of joints that stay as they were are wrong by a tenth of a limb, rad.
const FAR: f64 = 0.1;

/// The stages of a step, for a group of these colours.
pub(crate) fn stages(plan: &Plan, colors: impl Iterator<Item = Color> + Clone, stages: &mut Vec<Stage>) {
    for part in plan.parts(plan.turns_over(FAR)) {
        plan.part(part, colors.clone(), stages, |is_first, stages| {
            stages.push(Stage::Begin { is_first });
            if is_first {
                stages.extend(colors.clone().map(Stage::WarmStart));
            }
            plan.sweeps(Sweep::Springs, colors.clone(), stages);
            stages.push(Stage::Drift);
            plan.sweeps(Sweep::Relax, colors.clone(), stages);
        });
    }
}
