//! The broad phase: keeps the [`PersistentPairs`] of the bodies, tells them what a change of a body or joint means, and
//! bounds each shape: for impulse methods by its own box, for others, whose gap is told for each body, by its sphere and
//! that gap.

use bevy::prelude::*;
use nalgebra::Vector3;

use super::bounding_tree::BoundingBox;
use super::fat_box::{Extent, Placement};
use super::pair_slots::PairSlot;
use super::persistent_pairs::{BoundedBodies, Bounds, PairChanges, PersistentPairs};
use crate::physics::body::{Bodies, Body, RigidBody};
use crate::physics::collision::constants::CONTACT_TOLERANCE;
use crate::physics::collision::gap::own_reach;
use crate::physics::collision::manifold::Pair;
use crate::physics::joint::{JoinedPairs, Joints};
use crate::physics::settings::SolverSettings;
use crate::physics::stats::StepStats;

/// Pairs near each other, and what changed about them in this step.
#[derive(Resource, Default, Clone)]
pub(crate) struct NearPairs {
    pairs: PersistentPairs,
    pub changes: PairChanges,
    /// Pairs of bodies that are gone, under the indices they had.
    dropped: Vec<(PairSlot, Pair)>,
    /// Steps up to which the pairs are known, and whether for contacts that last; bodies that changed in a step without
    /// are not, and what slots keep is of no use to the other.
    known: Option<(u64, bool)>,
    joined: JoinedPairs,
    joints_version: u64,
}

impl NearPairs {
    /// Follows bodies to their new indices.
    pub fn remap(&mut self, new_index: &[Option<u32>]) {
        self.pairs.remap(new_index, &mut self.dropped);
        self.joined.remap(new_index);
    }
}

/// The bodies as the broad phase asks for them.
pub(crate) struct InStep<'a> {
    pub bodies: &'a [Body],
    pub joined: &'a JoinedPairs,
    /// s.
    pub h: f64,
    /// Of methods that look for contacts up to a gap told for each body.
    pub reach: Option<&'a SolverSettings>,
}

impl BoundedBodies for InStep<'_> {
    fn placement(&self, body: u32) -> Placement {
        let Body { position, rotation, linear, angular, pulled, .. } = self.bodies[body as usize];
        if self.reach.is_some() {
            return Placement { position, rotation, travel: Vector3::zeros(), turn: f64::INFINITY };
        }
        let turn = if pulled > 0.0 { f64::INFINITY } else { angular.norm() * self.h };
        Placement { position, rotation, travel: linear * self.h, turn }
    }

    fn bounds(&self, body: u32) -> Bounds {
        let body = &self.bodies[body as usize];
        if body.touches_nothing() {
            return Bounds::None;
        }
        let axes = body.rotation.to_rotation_matrix().into_inner();
        let gap = self.reach.map_or(body.pulled * self.h * self.h, |settings| own_reach(body, settings));
        let Some(geometry) = &body.geometry else { return Bounds::None };
        let Some(reach) = geometry.reach(&axes) else {
            let normal = axes.column(1).into_owned();
            return Bounds::HalfSpace { normal, point: body.position + normal * gap };
        };
        let slack = Vector3::repeat(CONTACT_TOLERANCE * body.radius);
        let [low, high] = [body.position + reach[0] - slack, body.position + reach[1] + slack];
        let moves = body.kind != RigidBody::Static;
        Bounds::Within(Extent { bounds: BoundingBox { low, high }, radius: body.radius + gap, moves })
    }

    fn may_pair(&self, a: u32, b: u32) -> bool {
        let (one, other) = (&self.bodies[a as usize], &self.bodies[b as usize]);
        (one.is_dynamic() || other.is_dynamic()) && one.layers.interact(other.layers) && !self.joined.contains(a, b)
    }
}

/// Brings the pairs up to date with the bodies.
pub(crate) fn update_pairs(
    bodies: Res<Bodies>,
    joints: Res<Joints>,
    joined: Res<JoinedPairs>,
    settings: Res<SolverSettings>,
    mut near: ResMut<NearPairs>,
    stats: Res<StepStats>,
) {
    let NearPairs { pairs, changes, dropped, known, joined: joined_before, joints_version } =
        near.bypass_change_detection();
    let lasts = settings.method.keeps_contacts();
    if known.replace((stats.steps + 1, lasts)) == Some((stats.steps, lasts)) {
        bodies.renewed.iter().for_each(|&body| pairs.renew(body));
    } else {
        (0..bodies.list.len() as u32).for_each(|body| pairs.renew(body));
    }
    if *joints_version != joints.version {
        *joints_version = joints.version;
        joined.differences(joined_before, |a, b| pairs.reconsider(a, b));
        joined_before.clone_from(&joined);
    }
    let reach = (!lasts).then_some(&*settings);
    let in_step = InStep { bodies: &bodies.list, joined: &joined, h: settings.step(), reach };
    pairs.update(&in_step, bodies.awake(), settings.threads, changes);
    if !dropped.is_empty() {
        dropped.append(&mut changes.removed);
        std::mem::swap(dropped, &mut changes.removed);
    }
}

impl NearPairs {
    /// The pair of a slot.
    pub fn pair(&self, slot: PairSlot) -> Option<Pair> {
        self.pairs.pairs().get(slot)
    }

    /// The pairs of a body: slots, and who is at the other end.
    pub fn of_body(&self, body: u32) -> impl Iterator<Item = (PairSlot, u32)> {
        self.pairs.pairs().of_body(body)
    }

    /// How many slots there are, free ones included.
    pub fn slot_count(&self) -> usize {
        self.pairs.pairs().slot_count()
    }
}
