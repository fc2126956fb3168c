//! The broad phase: keeps the [`PersistentPairs`] of the bodies, and tells them what a change of a body or joint means.

use bevy::prelude::*;

use super::bounding_tree::BoundingBox;
use super::in_step::InStep;
use super::pair_slots::PairSlot;
use super::part_pairs::PartPairs;
use super::persistent_pairs::{PairChanges, PersistentPairs};
use crate::physics::body::Bodies;
use crate::physics::collision::manifold::{Pair, PartPair};
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
    parted: PartPairs,
}

impl NearPairs {
    /// Follows bodies to their new indices.
    pub fn remap(&mut self, new_index: &[Option<u32>]) {
        let first = self.dropped.len();
        self.pairs.remap(new_index, &mut self.dropped);
        self.parted.forget(&mut self.dropped, first);
        self.joined.remap(new_index);
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
    let NearPairs { pairs, changes, dropped, known, joined: joined_before, joints_version, parted } =
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
    let is_awake = |body| !bodies.asleep.contains(body) && !bodies.fixed.contains(body);
    parted.update(pairs, &in_step, is_awake, changes);
    if !dropped.is_empty() {
        dropped.append(&mut changes.removed);
        std::mem::swap(dropped, &mut changes.removed);
    }
}

impl NearPairs {
    /// Replaces what is in `found` by the bodies that may come into a box, ascending; half-spaces are everywhere.
    pub fn in_box(&self, bounds: &BoundingBox, stack: &mut Vec<u32>, found: &mut Vec<u32>) {
        found.clear();
        self.pairs.in_box(bounds, stack, found);
        found.sort_unstable();
    }

    /// The pair of a slot.
    pub fn pair(&self, slot: PairSlot) -> Option<Pair> {
        self.pairs.pairs().get(slot)
    }

    /// The pairs of a body: slots, and who is at the other end.
    pub fn of_body(&self, body: u32) -> impl Iterator<Item = (PairSlot, u32)> {
        self.pairs.pairs().of_body(body).filter(|(slot, _)| !self.parted.is_whole(*slot))
    }

    /// Which parts of the two shapes a slot is of.
    pub fn parts(&self, slot: PairSlot) -> PartPair {
        self.pairs.pairs().parts(slot)
    }

    /// How many slots there are, free ones included.
    pub fn slot_count(&self) -> usize {
        self.pairs.pairs().slot_count()
    }
}
