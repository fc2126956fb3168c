//! The engine under the impulse methods: bodies and constraints of a group packed for wide
//! kernels, one file a kind, and the system that takes all groups through a step.
//!
//! [`bodies`] whitened velocities; [`contact`], [`joint`] the kernels; [`tree`] exact trees of joints, [`free`] bodies
//! on their own, which need no sweeps; [`coloring`] which
//! constraints may be solved side by side; [`group`] who belongs together; [`stage`] what is done
//! to a group; [`plan`] the frame of a step. A method is a list of stages.

mod bodies;
mod coloring;
mod contact;
mod directly;
mod group;
mod joint;
mod method;
mod plan;
mod sequential_impulses;
mod soft_step;
mod stage;
#[cfg(test)]
mod tests;
mod tree;
mod xpbd;

pub(crate) use plan::Plan;
pub(crate) use stage::{Color, GroupTerms, Stage, Sweep};

use std::sync::atomic::AtomicBool;

use bevy::prelude::*;
use simba::simd::WideF32x8;

use super::direct::MotionTerms;
use crate::physics::body::Bodies;
use crate::physics::body::RigidBody;
use crate::physics::collision::ContactGraph;
use crate::physics::island::Islands;
use crate::physics::joint::Joints;
use crate::physics::lanes::Lanes;
use crate::physics::schedule::{PhysicsSchedule, PhysicsSystems};
use crate::physics::settings::{Precision, SolverSettings, contacts_last};
use crate::physics::stats::StepStats;
use crate::physics::threads::for_each_block;
use directly::Directly;
use group::{Exactly, Group};
use stage::WorldParts;

pub(super) fn plugin(app: &mut App) {
    app.init_resource::<Groups>()
        .add_systems(PhysicsSchedule, solve_groups.in_set(PhysicsSystems::Solve).run_if(contacts_last));
}

/// All groups, kept with their buffers from step to step.
#[derive(Resource, Default)]
struct Groups {
    single: GroupsOf<WideF32x8>,
    double: GroupsOf<f64>,
}

/// Groups that are solved in the same lanes.
struct GroupsOf<L: Lanes> {
    list: Vec<Numbered<L>>,
    /// Version of the islands that the groups were planned for, and what was to be solved exactly.
    planned: Option<(u64, Exactly)>,
}

impl<L: Lanes> Default for GroupsOf<L> {
    fn default() -> Self {
        Self { list: Vec::new(), planned: None }
    }
}

/// A group, which of the islands' it is, and its stages.
struct Numbered<L: Lanes> {
    index: usize,
    group: Group<L>,
    directly: Directly,
    stages: Vec<Stage>,
}

fn solve_groups(
    mut bodies: ResMut<Bodies>,
    mut joints: ResMut<Joints>,
    mut graph: ResMut<ContactGraph>,
    islands: Res<Islands>,
    mut groups: ResMut<Groups>,
    settings: Res<SolverSettings>,
    mut stats: ResMut<StepStats>,
) {
    let Groups { single, double } = &mut *groups;
    let directly = match settings.precision {
        Precision::F32 => {
            double.planned = None;
            single.solve(&mut bodies, &mut joints, &mut graph, &islands, &settings)
        }
        Precision::F64 => {
            single.planned = None;
            double.solve(&mut bodies, &mut joints, &mut graph, &islands, &settings)
        }
    };
    let Bodies { list, asleep, .. } = &mut *bodies;
    for index in asleep.absent(list.len() as u32) {
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
    stats.row_updates = u64::from(stats.rows.saturating_sub(directly.rows)) * sweeps + u64::from(directly.row_updates);
    stats.resting = directly.resting;
}

impl<L: Lanes> GroupsOf<L> {
    fn solve(
        &mut self,
        bodies: &mut Bodies,
        joints: &mut Joints,
        graph: &mut ContactGraph,
        islands: &Islands,
        settings: &SolverSettings,
    ) -> Directly {
        let count = islands.count();
        if self.list.len() < count {
            self.list.resize_with(count, || Numbered {
                index: 0,
                group: Group::default(),
                directly: Directly::default(),
                stages: Vec::new(),
            });
        }
        let groups = &mut self.list[..count];
        let exactly = Exactly::of(settings);
        let planned = Some((islands.version(), exactly));
        if self.planned != planned {
            self.planned = planned;
            groups.iter_mut().enumerate().for_each(|(index, group)| group.index = index);
            for_each_block(settings.threads, groups, |Numbered { index, group, .. }| {
                group.plan(*index, islands, bodies, joints, graph, exactly);
            });
        }
        let directly = self.solve_directly(bodies, joints, graph, islands, settings);
        let groups = &mut self.list[..count];
        for Numbered { group, stages, .. } in groups.iter_mut() {
            let plan = Plan {
                substeps: settings.substeps,
                iterations: settings.iterations,
                notes: graph.recording.is_some() || group.may_bounce(),
                turn: group.turn(&bodies.list, settings.step()),
            };
            method::stages(settings.method, &plan, group.colors(), stages);
        }
        let terms = method::terms(settings);
        let records = graph.recording.is_some();
        let presses_changed = AtomicBool::new(false);
        let mut none = [];
        let world = WorldParts::new(bodies, joints, graph, &presses_changed, &mut none);
        let step = |Numbered { group, stages, .. }: &mut Numbered<L>, threads: u32| {
            group.run(stages, &terms, world, records, threads);
        };
        // Large groups get all threads, one after the other; of the others each thread takes some.
        if settings.threads > 1 {
            groups.iter_mut().filter(|group| group.group.is_large()).for_each(|group| step(group, settings.threads));
            let is_small = |group: &Numbered<L>| !group.group.is_large() && group.group.has_work();
            if groups.iter().any(is_small) {
                for_each_block(settings.threads, groups, |group| {
                    if is_small(group) {
                        step(group, 1);
                    }
                });
            }
        } else {
            groups.iter_mut().for_each(|group| step(group, 1));
        }
        graph.presses_changed |= presses_changed.into_inner();
        directly
    }

    /// Takes islands that can be solved directly through the step, and packs the others.
    fn solve_directly(
        &mut self,
        bodies: &mut Bodies,
        joints: &mut Joints,
        graph: &mut ContactGraph,
        islands: &Islands,
        settings: &SolverSettings,
    ) -> Directly {
        let groups = &mut self.list[..islands.count()];
        let mut total = Directly::default();
        if groups.iter().all(|Numbered { group, .. }| group.islands.is_empty()) {
            return total;
        }
        let presses_changed = AtomicBool::new(false);
        let mut none = [];
        let world = WorldParts::new(bodies, joints, graph, &presses_changed, &mut none);
        let (terms, exactly) = (MotionTerms::of(settings), Exactly::of(settings));
        for_each_block(settings.threads, groups, |Numbered { group, directly, .. }| {
            *directly = group.solve_directly(world, &terms, exactly);
        });
        graph.presses_changed |= presses_changed.into_inner();
        for Numbered { index, group, directly, .. } in groups {
            if directly.changed {
                group.arrange(*index, islands, bodies, joints, graph);
            }
            total.resting += directly.resting;
            total.rows += directly.rows;
            total.row_updates += directly.row_updates;
        }
        total
    }
}
