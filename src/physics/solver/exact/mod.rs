//! The exact method: joints held by their exact forces, motion by integrators that converge, in `f64` throughout.
//!
//! Each step, [`solve_exactly`] takes the islands' groups one by one, on as many threads as there may be:
//! 1. what is in a group is planned where it changed ([`island`]): pieces held together by joints, bodies by themselves;
//! 2. where anything touches, all goes through the force-level sweeps of `island_solver`, in `f64` and shorter parts;
//! 3. bodies by themselves move in closed form ([`free`]) if no torque turns them;
//! 4. pieces ([`mechanism`]) go through the integrator ([`stepper`]; [`lockstep`] and [`gauss`], [`runge_kutta`], [`rattle`]), whose stages solve J M⁻¹ Jᵀ λ = b
//!    ([`rows`], [`factor`]), and are brought back onto their joints ([`projection`]).

mod evaluation;
mod factor;
mod free;
mod gauss;
mod group;
mod island;
mod lockstep;
mod mechanism;
mod projection;
mod rattle;
mod rows;
mod runge_kutta;
mod stepper;
mod tableau;

use bevy::prelude::*;

use self::island::ExactGroup;
use super::{ContactCache, IslandSolver, IslandSolvers, LaggedContacts, StepTerms};
use crate::physics::bodies::{Bodies, Joints};
use crate::physics::collision::Contacts;
use crate::physics::diagnostics::{ContactForces, StepStats};
use crate::physics::island::Islands;
use crate::physics::settings::{Gravity, Method, SolverSettings};
use crate::physics::{PhysicsSchedule, PhysicsSystems, threads};

/// Parts of a step in which sweeps take what touches something. Joints under load blow up in sweeps of 1/60 s.
const PARTS_IN_CONTACT: u32 = 4;

pub(super) fn plugin(app: &mut App) {
    app.init_resource::<ExactGroups>().add_systems(
        PhysicsSchedule,
        solve_exactly.in_set(PhysicsSystems::Solve).run_if(|settings: Res<SolverSettings>| is_exact(&settings)),
    );
}

/// Whether the settings ask for this method.
pub(super) fn is_exact(settings: &SolverSettings) -> bool {
    settings.method == Method::Exact
}

/// The groups, kept with their plans and buffers from step to step.
#[derive(Resource, Default)]
pub(crate) struct ExactGroups {
    list: Vec<ExactGroup>,
    used: usize,
    /// Bodies that sweeps have, ascending.
    touching: Vec<u32>,
}

impl ExactGroups {
    /// All that the next step depends on beside bodies and joints.
    pub fn memory(&self) -> impl Iterator<Item = f64> + '_ {
        self.list[..self.used].iter().flat_map(ExactGroup::memory)
    }
}

fn solve_exactly(
    mut bodies: ResMut<Bodies>,
    mut joints: ResMut<Joints>,
    contacts: Res<Contacts>,
    lagged: Res<LaggedContacts>,
    islands: Res<Islands>,
    mut cache: ResMut<ContactCache>,
    mut solvers: ResMut<IslandSolvers>,
    mut groups: ResMut<ExactGroups>,
    settings: Res<SolverSettings>,
    gravity: Res<Gravity>,
    forces: Option<Res<ContactForces>>,
    mut stats: ResMut<StepStats>,
) {
    let contacts = lagged.active(&settings, &contacts);
    let ExactGroups { list, used, touching } = &mut *groups;
    touching.clear();
    // Sweeps leave gaps in joints that a mechanism cannot go on from: they have all bodies until nothing touches.
    if !contacts.manifolds.is_empty() {
        touching.extend(0..bodies.list.len() as u32);
    }
    *used = islands.count();
    if list.len() < *used {
        list.resize_with(*used, ExactGroup::default);
    }
    let list = &mut list[..*used];
    list.iter_mut().enumerate().for_each(|(index, group)| group.begin(index));
    let (h, parts) = (settings.step() / f64::from(settings.substeps), settings.substeps);
    {
        let (bodies, joints) = (&*bodies, &*joints);
        threads::for_each_block(settings.threads, list, |group| {
            group.gather(&islands, bodies, joints, touching);
            group.step(bodies, settings.integrator, h, parts);
        });
    }
    // What touches something: whole groups, of which the rest is overwritten.
    let touched: Vec<usize> = (0..list.len()).filter(|&group| list[group].touches).collect();
    if solvers.list.len() < touched.len() {
        solvers.list.resize_with(touched.len(), IslandSolver::default);
    }
    solvers.used = touched.len();
    let solvers = &mut solvers.list[..touched.len()];
    let swept = SolverSettings { substeps: PARTS_IN_CONTACT * settings.substeps, ..*settings };
    let terms = StepTerms::new(&swept, gravity.length(), forces.is_some());
    for (solver, &group) in solvers.iter_mut().zip(&touched) {
        solver.begin(group);
    }
    {
        let (bodies, joints, cache) = (&*bodies, &*joints, &*cache);
        threads::for_each_block(settings.threads, solvers, |solver| {
            solver.gather(&islands, bodies, joints, contacts, cache);
            solver.step(&terms);
        });
    }
    (stats.resting, stats.rows, stats.row_updates, stats.cuts, stats.unsettled) = (0, 0, 0, 0, 0);
    for solver in &*solvers {
        stats.rows += solver.row_count();
        stats.row_updates += solver.row_updates();
        solver.scatter(&mut bodies.list, &mut joints.list);
    }
    for group in &*list {
        group.scatter(&mut bodies.list, &mut joints.list);
        for (rows, effort) in group.efforts() {
            stats.rows += rows;
            stats.row_updates += u64::from(rows) * u64::from(effort.solves);
            stats.cuts += effort.cuts;
            stats.unsettled += effort.unsettled;
        }
    }
    cache.clear();
    if settings.warm_starting {
        solvers.iter().for_each(|solver| solver.store_forces(contacts, &mut cache));
    }
}
