//! The engine under the impulse methods: bodies and constraints of a group of islands packed for wide kernels, and the
//! system that takes all groups through a step. A method is a list of stages.
//!
//! From the bottom: [`coloring`] which constraints may be solved side by side; [`bodies`] whitened velocities, and
//! [`pair`] those of a block; [`contact`], [`joint`] the kernels, [`impact`] what bounces; [`tree`] trees of joints, solved exactly; [`stage`]
//! what a step is made of; [`soft_step`], [`sequential_impulses`], [`xpbd`] the methods, and [`method`] which is which;
//! [`group`] what belongs together; [`world`] what groups share; [`walk`] what each stage does to a group;
//! [`direct_islands`] what needs no sweeps; [`details`] what was made of whom.
//!
//! # Who touches what
//! Threads work on the records of bodies, joints and contacts at once, through [`Shared`](crate::physics::threads::Shared).
//! No two of them touch one record of which either writes:
//! - *Groups.* Each moving body, each joint and each contact between awake bodies is in one group, and a group writes
//!   no others. Of bodies that do not move (static and kinematic ones, which may touch several groups) it only reads;
//!   they are moved when all groups are done.
//! - *Within a group* each moving body has one [`Place`](group): it moves freely, with its tree, with its directly
//!   solved island, or as a member that is swept. Constraints go where their bodies do; one with a body in a directly
//!   solved island is that island's.
//! - *Stages* follow one another ([`Stages`](crate::physics::threads::Stages)), and each chunk of one is given out
//!   once. A chunk of a stage of bodies is a range of their indices. One of a stage of constraints is some blocks of a
//!   colour, whose constraints share no body that moves ([`coloring`]); what does not move is flagged
//!   [`READ_ONLY`](crate::physics::lanes::READ_ONLY), and kernels do not write it.
//!
//! Debug builds assert all of it ([`Claims`](crate::physics::threads::Claims)).

#![allow(unsafe_code)]

mod bodies;
mod coloring;
mod constants;
mod contact;
mod details;
mod direct_islands;
mod group;
mod impact;
mod joint;
mod method;
mod pair;
mod sequential_impulses;
mod soft_step;
mod stage;
#[cfg(test)]
mod tests;
mod tree;
mod walk;
mod world;
mod xpbd;

use bevy::prelude::*;
use simba::simd::WideF32x8;

use super::direct::{LoadAccount, MotionTerms};
use crate::physics::body::{Bodies, RigidBody};
use crate::physics::collision::ContactGraph;
use crate::physics::island::Islands;
use crate::physics::joint::Joints;
use crate::physics::lanes::Lanes;
use crate::physics::rewind::Keep;
use crate::physics::schedule::{PhysicsSchedule, PhysicsSystems};
use crate::physics::settings::{Precision, SolverSettings, contacts_last};
use crate::physics::solve_trace::{Residuals, SolveTrace};
use crate::physics::stats::StepStats;
use crate::physics::threads::for_each_block;
pub(crate) use details::ImpulseDetails;
use group::{DirectCounts, DirectScope, Group, PlanInput};
use stage::Plan;
use world::{SharedWorld, WorldClaims};

pub(super) fn plugin(app: &mut App) {
    app.init_resource::<ImpulseGroups>()
        .keep_resource::<ImpulseGroups>()
        .add_systems(PhysicsSchedule, solve_groups.in_set(PhysicsSystems::Solve).run_if(contacts_last));
}

/// All groups, kept with their buffers from step to step.
#[derive(Resource, Default, Clone)]
pub(crate) struct ImpulseGroups {
    single: GroupsOf<WideF32x8>,
    double: GroupsOf<f64>,
}

/// Groups that are solved in the same lanes.
#[derive(Default, Clone)]
struct GroupsOf<L: Lanes> {
    list: Vec<Group<L>>,
    /// Version of the islands that the groups were planned for, and what was to be solved without sweeps.
    planned: Option<(u64, DirectScope)>,
    claims: WorldClaims,
    loads: LoadAccount,
}

fn solve_groups(
    mut bodies: ResMut<Bodies>,
    mut joints: ResMut<Joints>,
    mut graph: ResMut<ContactGraph>,
    islands: Res<Islands>,
    mut groups: ResMut<ImpulseGroups>,
    settings: Res<SolverSettings>,
    mut trace: Option<ResMut<SolveTrace>>,
    mut stats: ResMut<StepStats>,
) {
    if let Some(trace) = &mut trace {
        trace.begin_step(stats.steps + 1);
    }
    let residuals = trace.as_mut().map(|trace| &mut trace.residuals);
    let ImpulseGroups { single, double } = &mut *groups;
    let counts = match settings.precision {
        Precision::F32 => {
            double.planned = None;
            single.solve(&mut bodies, &mut joints, &mut graph, &islands, &settings, stats.time, residuals)
        }
        Precision::F64 => {
            single.planned = None;
            double.solve(&mut bodies, &mut joints, &mut graph, &islands, &settings, stats.time, residuals)
        }
    };
    let Bodies { list, asleep, fixed, .. } = &mut *bodies;
    for index in asleep.in_neither(fixed, 0..list.len() as u32) {
        let body = &mut list[index as usize];
        if body.kind != RigidBody::Kinematic {
            continue;
        }
        body.coast(settings.step());
    }
    // Three rows a joint, and three of friction a contact.
    let (manifolds, joints) = islands.constraint_count();
    stats.rows = graph.active_points() + 3 * (manifolds + joints) as u32;
    let sweeps = u64::from(settings.substeps) * u64::from(method::sweeps(&settings));
    stats.row_updates = u64::from(stats.rows.saturating_sub(counts.rows)) * sweeps + u64::from(counts.row_updates);
    stats.resting = counts.resting;
}

impl ImpulseGroups {
    /// What the last step made of bodies and constraints.
    pub fn details(&self, islands: &Islands, settings: &SolverSettings) -> ImpulseDetails {
        let mut details = ImpulseDetails::default();
        match settings.precision {
            Precision::F32 => {
                self.single.in_use(islands).iter().for_each(|group| details.add(group, islands, settings))
            }
            Precision::F64 => {
                self.double.in_use(islands).iter().for_each(|group| details.add(group, islands, settings))
            }
        }
        details
    }
}

impl<L: Lanes> GroupsOf<L> {
    fn in_use<'a>(&'a self, islands: &Islands) -> &'a [Group<L>] {
        &self.list[..islands.count().min(self.list.len())]
    }

    fn solve(
        &mut self,
        bodies: &mut Bodies,
        joints: &mut Joints,
        graph: &mut ContactGraph,
        islands: &Islands,
        settings: &SolverSettings,
        time: f64,
        mut residuals: Option<&mut Residuals>,
    ) -> DirectCounts {
        let count = islands.count();
        if self.list.len() < count {
            self.list.resize_with(count, Group::default);
        }
        let (groups, threads) = (&mut self.list[..count], settings.threads);
        let scope = DirectScope::of(settings);
        let planned = Some((islands.version(), scope));
        if self.planned != planned {
            self.planned = planned;
            groups.iter_mut().enumerate().for_each(|(index, group)| group.index = index);
            let input = PlanInput { islands, bodies, joints, graph };
            for_each_block(threads, groups, |group| group.plan(&input, scope));
        }
        let may_spend = self.loads.begin_step((0..count).map(|group| islands.bodies(group).len()).sum());
        if !groups.iter().all(|group| group.islands.is_empty()) {
            let terms = MotionTerms::of(settings, time, may_spend);
            SharedWorld::share(bodies, joints, graph, &mut self.claims, |world| {
                for_each_block(threads, groups, |group| {
                    // SAFETY: no two groups share what either writes, see above.
                    group.counts = unsafe { group.solve_directly(world, &terms, scope) };
                });
            });
        }
        let mut total = DirectCounts::default();
        let records = graph.recording.is_some();
        for group in groups.iter_mut() {
            let counts = std::mem::take(&mut group.counts);
            if counts.changed {
                group.arrange(&PlanInput { islands, bodies, joints, graph });
            }
            group.residuals.clear();
            total.resting += counts.resting;
            total.rows += counts.rows;
            total.row_updates += counts.row_updates;
            self.loads.spend(counts.spent);
            let plan = Plan {
                substeps: settings.substeps,
                iterations: settings.iterations,
                bounces: group.may_bounce && settings.restitution_speed.is_some(),
                records,
                traces: residuals.is_some(),
                turn: group.turn(&bodies.list, settings.step()),
            };
            let colors = group.colors();
            method::stages(settings.method, &plan, colors, &mut group.stages);
        }
        let terms = method::terms(settings, time);
        SharedWorld::share(bodies, joints, graph, &mut self.claims, |world| {
            // SAFETY: no two groups share what either writes, see above.
            let step = |group: &mut Group<L>, threads: u32| unsafe { group.run(&terms, world, threads) };
            // Large groups get all threads, one after the other; of the others each thread takes some.
            if threads > 1 {
                groups.iter_mut().filter(|group| group.is_large()).for_each(|group| step(group, threads));
                let is_small = |group: &Group<L>| !group.is_large() && group.has_work();
                if groups.iter().any(is_small) {
                    for_each_block(threads, groups, |group| {
                        if is_small(group) {
                            step(group, 1);
                        }
                    });
                }
            } else {
                groups.iter_mut().for_each(|group| step(group, 1));
            }
        });
        if let Some(residuals) = &mut residuals {
            groups.iter().for_each(|group| residuals.take_in(&group.residuals));
        }
        total
    }
}
