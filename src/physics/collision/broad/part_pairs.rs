//! Pairs of parts: what stands for a pair of bodies of which one has parts.
//!
//! The broad phase pairs bodies. Such a pair has a slot there that nobody else sees, and of its parts those pairs have slots
//! whose boxes overlap: the parts of one in the fat box of the other, by the tree of the parts. They are looked for anew
//! when either body has a new fat box, and in each step in which a body with parts may have moved; what is there already
//! keeps its slot.

use nalgebra::Vector3;

use super::in_step::InStep;
use super::pair_slots::PairSlot;
use super::persistent_pairs::{PairChanges, PersistentPairs};
use crate::physics::bit_set::BitSet;
use crate::physics::body::{Body, RigidBody};
use crate::physics::collision::constants::FAT_MARGIN;
use crate::physics::collision::gap::{own_reach, way_of};
use crate::physics::collision::manifold::{Pair, PartPair};
use crate::physics::collision::parts::{has_parts, near_parts};

/// The pairs of parts of each pair.
#[derive(Clone, Debug, Default)]
pub(super) struct PartPairs {
    /// The slots of pairs of bodies that are looked at part by part.
    whole: BitSet,
    /// By such a slot: its parts, sorted, and their slots.
    known: Vec<Vec<(PartPair, PairSlot)>>,
    // Scratch.
    found: Vec<PartPair>,
    to_find: Vec<u32>,
}

impl PartPairs {
    /// Whether a slot is that of a pair of bodies whose parts have slots instead.
    pub fn is_whole(&self, slot: PairSlot) -> bool {
        self.whole.contains(slot.0)
    }

    /// Takes those pairs of bodies out of a list of what was removed, from a place on, that nobody has seen.
    pub fn forget(&mut self, removed: &mut Vec<(PairSlot, Pair)>, first: usize) {
        let mut index = 0;
        removed.retain(|(slot, _)| {
            index += 1;
            let is_whole = index > first && self.is_whole(*slot);
            if is_whole {
                self.whole.set(slot.0, false);
                self.known[slot.0 as usize].clear();
            }
            !is_whole
        });
    }

    /// Follows what became of pairs of bodies.
    pub fn update(
        &mut self,
        pairs: &mut PersistentPairs,
        in_step: &InStep,
        awake: impl Iterator<Item = u32>,
        changes: &mut PairChanges,
    ) {
        self.forget(&mut changes.removed, 0);
        let pair_of = |pairs: &PersistentPairs, slot: PairSlot| pairs.pairs().get(slot).expect("a pair of this step");
        let ends = |pair: Pair| [pair.a, pair.b].map(|body| &in_step.bodies[body as usize]);
        changes.added.retain(|&slot| {
            let is_whole = ends(pair_of(pairs, slot)).into_iter().any(has_parts);
            if is_whole {
                self.whole.set(slot.0, true);
                self.to_find.push(slot.0);
            }
            !is_whole
        });
        if self.whole.is_empty() {
            return;
        }
        for &body in pairs.moved() {
            self.to_find.extend(wholes_of(&self.whole, pairs, body));
        }
        for body in awake {
            if has_parts(&in_step.bodies[body as usize]) {
                self.to_find.extend(wholes_of(&self.whole, pairs, body));
            }
        }
        let mut to_find = std::mem::take(&mut self.to_find);
        to_find.sort_unstable();
        to_find.dedup();
        for slot in to_find.drain(..) {
            let pair = pair_of(pairs, PairSlot(slot));
            self.find(slot, pair, ends(pair), pairs, in_step, changes);
        }
        self.to_find = to_find;
    }

    /// Looks for the pairs of parts of two bodies that are a pair in that slot.
    fn find(
        &mut self,
        slot: u32,
        pair: Pair,
        ends: [&Body; 2],
        pairs: &mut PersistentPairs,
        in_step: &InStep,
        changes: &mut PairChanges,
    ) {
        self.found.clear();
        let growth = |body: &Body, place: &Vector3<f64>, radius: f64| growth(body, place, radius, in_step);
        near_parts(ends, [pair.a, pair.b].map(|body| pairs.paired_within(body)), growth, &mut self.found);
        self.found.sort_unstable();
        if self.known.len() <= slot as usize {
            self.known.resize(slot as usize + 1, Vec::new());
        }
        let known = &mut self.known[slot as usize];
        known.retain(|&(parts, slot)| {
            let stays = self.found.binary_search(&parts).is_ok();
            if !stays {
                changes.removed.push((slot, pairs.remove_parts(slot)));
            }
            stays
        });
        let first_new = known.len();
        for &parts in &self.found {
            if known[..first_new].binary_search_by_key(&parts, |(known, _)| *known).is_err() {
                let slot = pairs.insert_parts(pair, parts);
                known.push((parts, slot));
                changes.added.push(slot);
            }
        }
        known.sort_unstable_by_key(|(parts, _)| *parts);
    }
}

/// The slots of a body that are looked at part by part.
fn wholes_of(whole: &BitSet, pairs: &PersistentPairs, body: u32) -> impl Iterator<Item = u32> {
    pairs.pairs().of_body(body).map(|(slot, _)| slot.0).filter(|&slot| whole.contains(slot))
}

/// By how much what a body has within a radius of a place may come nearer to what is in a fat box in this step, m, and a margin
/// in which it gets contacts ahead.
fn growth(body: &Body, place: &Vector3<f64>, radius: f64, in_step: &InStep) -> f64 {
    let h = in_step.h;
    let reach = in_step.reach.map_or_else(|| way_of(body, place, radius, h), |settings| own_reach(body, settings));
    if body.kind == RigidBody::Static { reach } else { reach + FAT_MARGIN * radius }
}
