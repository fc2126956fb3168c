//! The soft step: substeps with soft constraints (Catto 2024, *Solver2D*; Macklin et al. 2019 for
//! substeps instead of sweeps).
//!
//! Each substep: forces and the last impulses → a sweep with soft terms → positions → a sweep without. The springs
//! correct position errors with no more stiffness than a sweep can follow; the second sweep, *relax*, takes the
//! velocity that they add out again, so that it adds no energy. Impacts come first, before forces act ([`super::impact`]).
//!
//! Contacts solve friction in the second sweep only, except where surfaces come together in the step: the motion that
//! springs cause is no slip. Nor may softness make what is high lean: the springs of an interface resist tilting with
//! k_θ = Σ k z², and a column of unit cubes buckles under its weight from n³ m g/k_θ ≈ 7.84 on (Greenhill 1881), at 4
//! substeps from n = 20, though rigid cubes would stand. So rows are made for an earlier rotation of the bodies until
//! they have turned a little from it ([`super::constants::FRAME_TURN`]): a smaller lean adds nothing to the torque that
//! topples.

use super::coloring::Color;
use super::constants::{CONTACT_DAMPING, CONTACT_FREQUENCY, JOINT_DAMPING, JOINT_FREQUENCY, SOFT_STEP_TURN};
use super::stage::{GroupTerms, Plan, Stage, Sweep};
use crate::physics::lanes::Lanes;
use crate::physics::settings::SolverSettings;
use crate::physics::solver::soft_terms::{SoftTerms, UNLIMITED};

/// What groups need of the settings.
pub(crate) fn terms<L: Lanes>(settings: &SolverSettings, time: f64) -> GroupTerms<L> {
    let rigid = GroupTerms::new(settings, time);
    let h = rigid.h;
    let max_speed = settings.correction_speed.unwrap_or(UNLIMITED);
    let soft = |share: f64, damping, slop| SoftTerms::new(share / h, damping, max_speed, slop, h);
    GroupTerms {
        joint: soft(JOINT_FREQUENCY, JOINT_DAMPING, 0.0),
        contact: soft(CONTACT_FREQUENCY, CONTACT_DAMPING, settings.slop),
        ..rigid
    }
}

/// The stages of a step, for a group of these colours.
pub(crate) fn stages(plan: &Plan, colors: impl Iterator<Item = Color> + Clone, stages: &mut Vec<Stage>) {
    for interval in plan.intervals(plan.turns_over(SOFT_STEP_TURN)) {
        plan.interval(interval, colors.clone(), stages, |is_first, stages| {
            plan.begin(is_first, colors.clone(), stages);
            plan.sweeps(Sweep::Soft, colors.clone(), stages);
            plan.drift(stages);
            plan.sweeps(Sweep::Relax, colors.clone(), stages);
        });
    }
}
