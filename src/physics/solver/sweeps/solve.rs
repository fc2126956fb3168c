//! The system: every island by its own solver.

use bevy::prelude::*;

use super::island_solver::IslandSolver;
use super::step_terms::StepTerms;
use crate::physics::body::Bodies;
use crate::physics::collision::{ContactGraph, Contacts, LaggedContacts};
use crate::physics::island::Islands;
use crate::physics::joint::Joints;
use crate::physics::readings::ContactForces;
use crate::physics::rewind::Keep;
use crate::physics::schedule::{PhysicsSchedule, PhysicsSystems};
use crate::physics::settings::{Gravity, SolverSettings};
use crate::physics::solve_trace::SolveTrace;
use crate::physics::stats::StepStats;
use crate::physics::threads;

pub(in crate::physics::solver) fn plugin(app: &mut App) {
    app.init_resource::<IslandSolvers>()
        .keep_resource::<IslandSolvers>()
        .add_systems(PhysicsSchedule, solve_islands.in_set(PhysicsSystems::Solve).run_if(sweeps_force_rows));
}

fn sweeps_force_rows(settings: Res<SolverSettings>) -> bool {
    settings.method.is_force_level()
}

/// One solver per island, kept with its buffers from step to step.
#[derive(Resource, Default, Clone)]
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
    mut graph: ResMut<ContactGraph>,
    mut solvers: ResMut<IslandSolvers>,
    settings: Res<SolverSettings>,
    gravity: Res<Gravity>,
    forces: Option<Res<ContactForces>>,
    mut trace: Option<ResMut<SolveTrace>>,
    mut stats: ResMut<StepStats>,
) {
    let contacts = lagged.active(&settings, &contacts);
    let mut terms = StepTerms::new(&settings, gravity.length(), forces.is_some(), stats.time);
    terms.traces = trace.is_some();
    let count = islands.count();
    if solvers.list.len() < count {
        solvers.list.resize_with(count, IslandSolver::default);
    }
    solvers.used = count;
    for (island, solver) in solvers.list[..count].iter_mut().enumerate() {
        solver.begin(island);
    }
    {
        let (bodies, joints, graph) = (&*bodies, &*joints, &*graph);
        threads::for_each_block(settings.threads, &mut solvers.list[..count], |solver| {
            solver.gather(&islands, bodies, joints, contacts, graph);
            solver.step(&terms);
        });
    }
    stats.resting = 0;
    stats.rows = 0;
    stats.row_updates = 0;
    for solver in &solvers.list[..count] {
        stats.rows += solver.row_count;
        stats.row_updates += solver.row_updates;
        solver.scatter(&mut bodies.list, &mut joints.list);
    }
    if let Some(trace) = &mut trace {
        trace.begin_step(stats.steps + 1);
        solvers.list[..count].iter().for_each(|solver| trace.residuals.take_in(&solver.residuals));
    }
    let warm = if settings.sweeps.warm_starting { count } else { 0 };
    graph.keep_forces(solvers.list[..warm].iter().flat_map(|solver| solver.forces(contacts)));
}
