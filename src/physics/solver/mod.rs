//! The `Solve` phase: each island is taken through all its substeps on its own.
//!
//! A substep, whatever the method: rows from the present poses ([`rows`]) → the method's solve
//! (one file each: [`pgs`], [`cg_pgs`], [`nncg`], [`joint_space`]) → integration (`super::integrator`). Islands share
//! no body that moves, so threads take whole islands and the result does not depend on their number.

mod cg_pgs;
mod cone;
mod conjugate_residuals;
mod direct;
mod exact;
mod impulse;
mod island_solver;
mod joint_space;
mod joint_tree;
mod lag;
mod method;
mod nncg;
mod pgs;
mod rows;
mod sequential_impulses;
mod soft_step;
mod soft_terms;
mod substeps;
mod warm_start;
mod xpbd;

#[cfg(test)]
mod tests;

pub(crate) use exact::ExactGroups;
pub(crate) use island_solver::{IslandSolver, LocalBody, StepTerms};
pub(crate) use lag::LaggedContacts;
pub(crate) use rows::Scalar;
pub(crate) use warm_start::ContactCache;

use bevy::prelude::*;

use super::bodies::{Bodies, Joints};
use super::collision::Contacts;
use super::diagnostics::{ContactForces, StepStats};
use super::island::Islands;
use super::settings::{Gravity, SolverSettings};
use super::{PhysicsSchedule, PhysicsSystems, threads};

pub(super) fn plugin(app: &mut App) {
    app.init_resource::<LaggedContacts>()
        .init_resource::<ContactCache>()
        .init_resource::<IslandSolvers>()
        .add_systems(
            PhysicsSchedule,
            lag::swap_contacts.after(PhysicsSystems::NarrowPhase).before(PhysicsSystems::Islands),
        )
        .add_plugins((impulse::plugin, exact::plugin))
        .add_systems(PhysicsSchedule, solve_islands.in_set(PhysicsSystems::Solve).run_if(sweeps_force_rows));
}

fn sweeps_force_rows(settings: Res<SolverSettings>) -> bool {
    settings.method.is_force_level()
}

/// One solver per island, kept with its buffers from step to step.
#[derive(Resource, Default)]
pub(crate) struct IslandSolvers {
    pub list: Vec<IslandSolver>,
    /// How many of them the last step used.
    pub used: usize,
}

fn solve_islands(
    mut bodies: ResMut<Bodies>,
    mut joints: ResMut<Joints>,
    contacts: Res<Contacts>,
    lagged: Res<LaggedContacts>,
    islands: Res<Islands>,
    mut cache: ResMut<ContactCache>,
    mut solvers: ResMut<IslandSolvers>,
    settings: Res<SolverSettings>,
    gravity: Res<Gravity>,
    forces: Option<Res<ContactForces>>,
    mut stats: ResMut<StepStats>,
) {
    let contacts = lagged.active(&settings, &contacts);
    let terms = StepTerms::new(&settings, gravity.length(), forces.is_some());
    let count = islands.count();
    if solvers.list.len() < count {
        solvers.list.resize_with(count, IslandSolver::default);
    }
    solvers.used = count;
    for (island, solver) in solvers.list[..count].iter_mut().enumerate() {
        solver.begin(island);
    }
    {
        let (bodies, joints, cache) = (&*bodies, &*joints, &*cache);
        threads::for_each_block(settings.threads, &mut solvers.list[..count], |solver| {
            solver.gather(&islands, bodies, joints, contacts, cache);
            solver.step(&terms);
        });
    }
    stats.resting = 0;
    stats.rows = 0;
    stats.row_updates = 0;
    for solver in &solvers.list[..count] {
        stats.rows += solver.row_count();
        stats.row_updates += solver.row_updates();
        solver.scatter(&mut bodies.list, &mut joints.list);
    }
    cache.clear();
    if settings.warm_starting {
        for solver in &solvers.list[..count] {
            solver.store_forces(contacts, &mut cache);
        }
    }
}
