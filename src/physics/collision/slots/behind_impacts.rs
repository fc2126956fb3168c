//! Contacts of what comes behind something that is stopped.
//!
//! Contacts are found once a step. Bodies that move along with each other do not approach, so that across a gap they have
//! none; but if the first of them is stopped within the step, the next runs into it, and a column that lands would be
//! pushed into itself by a step's way at each of its gaps. So from the bodies that touch something on, those that may
//! come up to them with what they move in the step get their contacts, too, and those behind them in turn.

use super::graph::{ContactGraph, Finder};
use super::slot::RelativePose;
use crate::physics::bit_set::BitSet;
use crate::physics::body::Body;
use crate::physics::collision::gap::gap_if_stopped;
use crate::physics::collision::manifold::Pair;
use crate::physics::settings::SolverSettings;

impl ContactGraph {
    /// Finds the contacts of pairs that move along with each other, from those on of which one touches something.
    pub(super) fn find_behind_impacts(
        &mut self,
        bodies: &[Body],
        joined: &BitSet,
        settings: &SolverSettings,
        finders: &mut [Finder],
    ) {
        let mut left: Vec<u32> = finders.iter_mut().flat_map(|finder| finder.together.drain(..)).collect();
        let Some(finder) = finders.first_mut().filter(|_| !left.is_empty()) else { return };
        let mut touched = BitSet::default();
        for (_, (a, b)) in self.touching() {
            touched.set(a, true);
            touched.set(b, true);
        }
        loop {
            let before = left.len();
            left.retain(|&index| {
                let (slot, state) = (&mut self.slots[index as usize], &mut self.states[index as usize]);
                let Pair { a, b } = slot.pair;
                if !touched.contains(a) && !touched.contains(b) {
                    return true;
                }
                let ends = [&bodies[a as usize], &bodies[b as usize]];
                if let Some(gap) = gap_if_stopped(ends[0], ends[1], settings) {
                    let place = (RelativePose::of(ends[0], ends[1]), gap);
                    finder.find(ends, place, (slot, state), self.updates, joined, settings);
                    if slot.touching {
                        touched.set(a, true);
                        touched.set(b, true);
                    }
                }
                false
            });
            if left.is_empty() || left.len() == before {
                return;
            }
        }
    }
}
