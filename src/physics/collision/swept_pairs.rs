//! Broad phase of contacts that last by *sweep and sort*: the candidates of each step, held against
//! those of the step before, so that a pair that stays keeps its slot.
//!
//! [`SweepAndSort`] finds the candidates anew in each step, on spheres that reach as far as their
//! bodies can get within it; sorted, they are merged with the sorted pairs that there are. Its cost
//! follows how many bodies there are, not how many move.

use std::cmp::Ordering;

use super::manifold::Pair;
use super::pair_slots::{PairSlot, PairSlots};
use super::persistent_pairs::PairChanges;
use super::sweep_and_sort::SweepAndSort;
use crate::physics::body::Body;
use crate::physics::joint::JoinedPairs;
use crate::physics::settings::SolverSettings;

/// The pairs, and what it takes to keep them.
#[derive(Default)]
pub(crate) struct SweptPairs {
    sweep: SweepAndSort,
    pairs: PairSlots,
    /// All pairs, sorted.
    known: Vec<(Pair, PairSlot)>,
    to_renew: Vec<u32>,
    // Scratch.
    candidates: Vec<Pair>,
    kept: Vec<(Pair, PairSlot)>,
}

impl SweptPairs {
    /// The pairs as they are.
    pub fn pairs(&self) -> &PairSlots {
        &self.pairs
    }

    /// To be called when what was known of a body's contacts is void: in the next update its pairs
    /// go, and are found again, in other slots.
    pub fn renew(&mut self, body: u32) {
        self.to_renew.push(body);
    }

    /// To be called when bodies were despawned and the others renumbered in the same order: their
    /// new indices, None for what is gone. Pairs of the gone are reported under the old indices.
    pub fn remap(&mut self, new_index: &[Option<u32>], removed: &mut Vec<(PairSlot, Pair)>) {
        let count = self.pairs.body_count().min(new_index.len());
        for gone in (0..count).filter(|&body| new_index[body].is_none()) {
            self.pairs.drop_all_of(gone as u32, removed);
        }
        self.pairs.remap(&new_index[..count]);
        let renamed = |&body: &u32| new_index.get(body as usize).copied().flatten();
        self.to_renew = self.to_renew.iter().filter_map(renamed).collect();
        self.know_all();
    }

    fn know_all(&mut self) {
        self.known.clear();
        self.known.extend(self.pairs.iter().map(|(slot, pair)| (pair, slot)));
        self.known.sort_unstable();
    }

    /// Brings the pairs up to date.
    pub fn update(
        &mut self,
        bodies: &[Body],
        joined: &JoinedPairs,
        settings: &SolverSettings,
        changes: &mut PairChanges,
    ) {
        changes.removed.clear();
        changes.added.clear();
        if bodies.len() > self.pairs.body_count() {
            self.pairs.set_body_count(bodies.len());
        }
        if !self.to_renew.is_empty() {
            for body in self.to_renew.drain(..) {
                self.pairs.drop_all_of(body, &mut changes.removed);
            }
            self.know_all();
        }
        self.candidates.clear();
        self.sweep.find_pairs(bodies, joined, settings, &mut self.candidates);
        self.candidates.sort_unstable();
        self.remove_parted(&mut changes.removed);
        self.add_new(&mut changes.added);
    }

    /// Removes the pairs that are candidates no more, and leaves the others in `kept`.
    fn remove_parted(&mut self, removed: &mut Vec<(PairSlot, Pair)>) {
        self.kept.clear();
        let mut candidates = self.candidates.iter().peekable();
        for &(pair, slot) in &self.known {
            while candidates.next_if(|&&candidate| candidate < pair).is_some() {}
            if candidates.peek() == Some(&&pair) {
                self.kept.push((pair, slot));
            } else {
                removed.push((slot, self.pairs.remove(slot)));
            }
        }
    }

    /// Adds the candidates that are not among the kept.
    fn add_new(&mut self, added: &mut Vec<PairSlot>) {
        self.known.clear();
        let mut kept = self.kept.iter().peekable();
        for &pair in &self.candidates {
            let slot = match kept.peek().map(|(known, _)| known.cmp(&pair)) {
                Some(Ordering::Equal) => kept.next().expect("peeked").1,
                _ => {
                    let slot = self.pairs.insert(pair);
                    added.push(slot);
                    slot
                }
            };
            self.known.push((pair, slot));
        }
    }
}
