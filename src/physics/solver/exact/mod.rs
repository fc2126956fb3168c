//! The exact method: joints held by their exact forces, motion by integrators that converge, in `f64` throughout.
//!
//! Each step, [`solve_exactly`] plans the groups of islands whose contents have changed ([`exact_group`]): mechanisms that
//! joints hold together, free bodies, and bodies in reach of each other; what is the same as before goes on, whichever group
//! it is in. Then it takes the groups one by one, on as many threads as there may be:
//! 1. their state is taken in;
//! 2. what is in reach of something has a step of their own ([`contact`]), with joints and contacts by the cone solver;
//! 3. free bodies move in closed form ([`free`]) if no torque turns them;
//! 4. mechanisms ([`mechanism`]) go through the integrator ([`stepper`]; [`lockstep`] and [`gauss`], [`rattle`]), whose
//!    stages solve J M⁻¹ Jᵀ λ = b ([`rows`]), and are brought back onto their joints ([`projection`]);
//! 5. those some of whose rows have a bounded λ ([`row_mode`]: limits, dry friction, motors with a largest force) go from
//!    event to event ([`event_stepper`], [`event_search`]); at each, impacts pass ([`bounded_rows`]), and an
//!    [`active_set`] tells which rows hold from there.
//!
//! Groups of which something was thrown into what was out of reach go through the step again ([`unforeseen`]).

mod active_set;
mod bodies;
mod bounded_rows;
mod constants;
mod contact;
mod event_search;
mod event_stepper;
mod exact_group;
mod free;
mod gauss;
mod held_links;
mod held_mechanisms;
mod lockstep;
mod mechanism;
mod projection;
mod rattle;
mod redundancy;
mod rotation;
mod row_mode;
mod rows;
mod stepper;
mod tableau;
#[cfg(test)]
mod tests;
mod unforeseen;

use bevy::prelude::*;

use self::constants::MOST_UNFORESEEN;
pub(crate) use self::contact::PointForce;
use self::contact::{ContactGroup, ContactTerms};
use self::exact_group::{ExactGroup, LeftParts};
pub(super) use self::mechanism::{Coupling, Couplings, MemberState, links_at};
use self::unforeseen::UnforeseenPairs;
use super::cone::Deadline;
use crate::physics::HardProblems;
use crate::physics::body::Bodies;
use crate::physics::collision::{ContactGraph, Contacts, hold_thrown_back};
use crate::physics::contact::restitution_threshold;
use crate::physics::island::Islands;
use crate::physics::joint::{Breakable, JoinedPairs, JointLoad, Joints};
use crate::physics::rewind::Keep;
use crate::physics::schedule::{PhysicsSchedule, PhysicsSystems};
use crate::physics::settings::{Method, SolverSettings};
use crate::physics::solve_trace::SolveTrace;
use crate::physics::stats::StepStats;
use crate::physics::threads;

pub(super) fn plugin(app: &mut App) {
    app.init_resource::<ExactGroups>().keep_resource::<ExactGroups>().add_systems(
        PhysicsSchedule,
        (
            solve_exactly.run_if(|settings: Res<SolverSettings>| is_exact(&settings)),
            forget.run_if(|settings: Res<SolverSettings>| !is_exact(&settings)),
        )
            .in_set(PhysicsSystems::Solve),
    );
    app.add_systems(
        PhysicsSchedule,
        held_mechanisms::put_together
            .after(hold_thrown_back)
            .before(PhysicsSystems::WriteBack)
            .run_if(|settings: Res<SolverSettings>| settings.method.keeps_contacts()),
    );
}

/// Whether the settings ask for this method.
pub(super) fn is_exact(settings: &SolverSettings) -> bool {
    settings.method == Method::Exact
}

/// The groups, kept with their plans and buffers from step to step.
#[derive(Resource, Default, Clone)]
pub(crate) struct ExactGroups {
    list: Vec<ExactGroup>,
    used: usize,
}

impl ExactGroups {
    /// What each contact point carried.
    pub fn point_forces(&self) -> impl Iterator<Item = PointForce> + '_ {
        self.list[..self.used].iter().flat_map(ExactGroup::contact_groups).flat_map(ContactGroup::point_forces)
    }

    /// Deepest overlap at the end of the step, m; 0 if there is none.
    pub fn overlap(&self) -> f64 {
        let groups = self.list[..self.used].iter().flat_map(ExactGroup::contact_groups);
        groups.map(ContactGroup::overlap).fold(0.0, f64::max)
    }

    /// Bodies that move, with how often their rows were solved.
    pub fn solves(&self) -> impl Iterator<Item = (u32, u32)> + '_ {
        self.list[..self.used].iter().flat_map(ExactGroup::solves)
    }

    /// All that the next step depends on beside bodies, joints and what contacts carried.
    pub fn memory(&self) -> impl Iterator<Item = f64> + '_ {
        self.list[..self.used].iter().flat_map(ExactGroup::memory)
    }
}

/// Another method takes over: what this one kept from step to step, and told of joints, is not of its steps.
fn forget(mut groups: ResMut<ExactGroups>, mut joints: ResMut<Joints>) {
    if groups.used > 0 {
        *groups = ExactGroups::default();
        joints.list.iter_mut().for_each(|joint| joint.load_at_end = None);
    }
}

fn solve_exactly(
    mut bodies: ResMut<Bodies>,
    mut joints: ResMut<Joints>,
    contacts: Res<Contacts>,
    islands: Res<Islands>,
    mut graph: ResMut<ContactGraph>,
    mut groups: ResMut<ExactGroups>,
    settings: Res<SolverSettings>,
    mut stats: ResMut<StepStats>,
    (mut trace, mut hard): (Option<ResMut<SolveTrace>>, Option<ResMut<HardProblems>>),
    (joined, mut unforeseen): (Res<JoinedPairs>, Local<UnforeseenPairs>),
    read: Query<(), Or<(With<JointLoad>, With<Breakable>)>>,
) {
    let ExactGroups { list, used } = &mut *groups;
    *used = islands.count();
    if list.len() < *used {
        list.resize_with(*used, ExactGroup::default);
    }
    let (list, unused) = list.split_at_mut(*used);
    let mut left = LeftParts::default();
    for (index, group) in list.iter_mut().enumerate() {
        group.begin(index);
        group.take_stock(&islands, &bodies, &joints, &contacts, &mut left);
    }
    unused.iter_mut().for_each(|group| group.hand_over(&mut left, (bodies.version, joints.version)));
    left.sort();
    list.iter_mut().for_each(|group| group.plan(&mut left, &bodies, &joints, stats.time));
    let terms = ContactTerms {
        time: stats.time,
        h: settings.step() / f64::from(settings.substeps),
        parts: settings.substeps,
        correction_speed: settings.correction_speed.unwrap_or(f64::INFINITY),
        restitution_speed: restitution_threshold(&settings),
        reads_loads: !read.is_empty(),
        traces: trace.is_some(),
        keeps_hardest: hard.is_some(),
        deadline: Deadline::after(settings.exact.time_budget),
    };
    {
        let (bodies, joints, graph) = (&*bodies, &*joints, &*graph);
        let take_through = |group: &mut ExactGroup| {
            group.gather(bodies, joints, settings.friction);
            group.step(bodies, settings.exact.integrator, &terms, graph);
        };
        threads::for_each_block(settings.threads, list, take_through);
        for _ in 0..MOST_UNFORESEEN {
            if terms.deadline.is_over() || !unforeseen.find(list, bodies, &joined, &settings) {
                break;
            }
            let mut left = LeftParts::default();
            unforeseen.join(list, &mut left);
            left.sort();
            for group in list.iter_mut().filter(|group| group.is_stale()) {
                group.plan(&mut left, bodies, joints, stats.time);
                take_through(group);
            }
        }
    }
    (stats.resting, stats.rows, stats.row_updates) = (0, 0, 0);
    (stats.cuts, stats.unsettled, stats.jammed) = (0, 0, 0);
    for group in &*list {
        group.scatter(&mut bodies.list, &mut joints.list);
        stats.resting += group.contact_groups().iter().map(ContactGroup::resting).sum::<usize>() as u32;
        for (rows, effort) in group.efforts() {
            stats.rows += rows;
            stats.row_updates += u64::from(rows) * u64::from(effort.solves);
            stats.cuts += effort.cuts;
            stats.unsettled += effort.unsettled;
            stats.jammed += effort.jammed;
        }
    }
    if let Some(trace) = &mut trace {
        trace.begin_step(stats.steps + 1);
        let groups = list.iter().flat_map(ExactGroup::contact_groups);
        groups.for_each(|group| trace.residuals.take_in(&group.residuals));
    }
    if let Some(hard) = &mut hard {
        let groups = list.iter().flat_map(ExactGroup::contact_groups);
        hard.take_in(stats.steps + 1, groups.flat_map(ContactGroup::hardest));
    }
    graph.keep_forces(list.iter().flat_map(ExactGroup::contact_groups).flat_map(ContactGroup::next_forces));
}
