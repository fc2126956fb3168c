//! The `Solve` phase: an engine a folder, each of which takes islands through all substeps of a step.
//!
//! [`sweeps`] over force-level rows, [`impulse`] on velocities, [`direct`] and [`joint_tree`] for what it solves without
//! sweeps, [`exact`] with the contact solver [`cone`]. Islands share no body that moves, so threads take whole islands
//! and the result does not depend on their number.

mod cone;
mod direct;
mod exact;
mod impulse;
mod joint_tree;
mod linear;
mod soft_terms;
mod substeps;
mod sweeps;

pub(crate) use exact::ExactGroups;
pub(crate) use impulse::ImpulseGroups;
pub(crate) use sweeps::IslandSolvers;

use bevy::prelude::*;

use super::HardProblems;
use super::rewind::Keep;
use super::solve_trace::SolveTrace;

pub(super) fn plugin(app: &mut App) {
    app.keep_resource::<SolveTrace>().keep_resource::<HardProblems>();
    app.add_plugins((sweeps::plugin, impulse::plugin, exact::plugin));
}
