//! Which file has which of the methods on the impulse engine. Those on force-level rows never come here.

use super::coloring::Color;
use super::constants::POSITION_SWEEPS;
use super::stage::{GroupTerms, Plan, Stage};
use super::{sequential_impulses, soft_step, xpbd};
use crate::physics::lanes::Lanes;
use crate::physics::settings::{Method, SolverSettings};

/// What groups need of the settings, at a simulation time, s.
pub(crate) fn terms<L: Lanes>(settings: &SolverSettings, time: f64) -> GroupTerms<L> {
    match settings.method {
        Method::SequentialImpulses => sequential_impulses::terms(settings, time),
        Method::Xpbd => xpbd::terms(settings, time),
        _ => soft_step::terms(settings, time),
    }
}

/// All stages of a step, for a group of these colours.
pub(crate) fn stages(
    method: Method,
    plan: &Plan,
    colors: impl Iterator<Item = Color> + Clone,
    stages: &mut Vec<Stage>,
) {
    stages.clear();
    stages.extend([Stage::FreeMotion, Stage::Trees]);
    if colors.clone().next().is_none() {
        return;
    }
    match method {
        Method::SequentialImpulses => sequential_impulses::stages(plan, colors, stages),
        Method::Xpbd => xpbd::stages(plan, colors, stages),
        _ => soft_step::stages(plan, colors, stages),
    }
}

/// Whether trees of joints that nothing touches are solved exactly. A method that is compared by how its sweeps carry
/// joints sweeps them all.
pub(crate) fn solves_trees(method: Method) -> bool {
    method == Method::SoftStep
}

/// Sweeps over all rows in a substep.
pub(crate) fn sweeps(settings: &SolverSettings) -> u32 {
    match settings.method {
        Method::SequentialImpulses => settings.iterations + POSITION_SWEEPS,
        Method::Xpbd => settings.iterations + 1,
        _ => 2 * settings.iterations,
    }
}
