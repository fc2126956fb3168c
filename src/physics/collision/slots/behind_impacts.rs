//! Contacts of what comes behind something that is stopped.
//!
//! Contacts are found once a step. Bodies that move along with each other do not approach, so that across a gap they have
//! none; but if the first of them is stopped within the step, the next runs into it by a step's way. What is much heavier
//! than what it runs into pushes that into whatever stopped it, and a column of light and heavy in turns that lands would
//! be pushed into itself at each of its gaps. What bounces is thrown back at what comes behind it, and overlaps that by
//! both their ways before anybody looks: a block of balls that lands lost a fifth of its energy in the rows that then pushed
//! it apart. So from the bodies that touch something on, unequal ones and those that bounce, that may come up to them with
//! what they move in the step, get their contacts, too, and those behind them in turn; and so do those of a row ([`is_row`]),
//! as all of it pushes the first.

use super::graph::{ContactGraph, Finder, is_row};
use crate::physics::bit_set::BitSet;
use crate::physics::body::Body;
use crate::physics::collision::gap::gap_if_stopped;
use crate::physics::collision::manifold::Pair;
use crate::physics::collision::pose::Pose;
use crate::physics::settings::SolverSettings;

impl ContactGraph {
    /// Finds the contacts of pairs that move along with each other, from those on of which one touches something. Whether
    /// there are any.
    pub(super) fn find_behind_impacts(
        &mut self,
        bodies: &[Body],
        joined: &BitSet,
        settings: &SolverSettings,
        finders: &mut [Finder],
    ) -> bool {
        if finders.iter().all(|finder| finder.together.is_empty()) {
            return false;
        }
        let (mut left, mut touched) = (std::mem::take(&mut self.together), std::mem::take(&mut self.touched));
        touched.clear();
        left.clear();
        left.extend(finders.iter_mut().flat_map(|finder| finder.together.drain(..)));
        for (_, (a, b)) in self.touching() {
            touched.set(a, true);
            touched.set(b, true);
        }
        loop {
            let before = left.len();
            left.retain(|&index| {
                let Pair { a, b } = self.slots[index as usize].pair;
                if !touched.contains(a) && !touched.contains(b) {
                    return true;
                }
                let ends = [&bodies[a as usize], &bodies[b as usize]];
                let is_row = is_row(&self.pair_counts, [a, b]);
                if let Some(gap) = gap_if_stopped(ends[0], ends[1], is_row, settings) {
                    let place = (self.slots[index as usize].pose(ends[0], ends[1]), gap);
                    self.find_with(&mut finders[0], index, place, ends, joined, settings);
                    if self.slots[index as usize].touching {
                        touched.set(a, true);
                        touched.set(b, true);
                    }
                }
                false
            });
            if left.is_empty() || left.len() == before {
                break;
            }
        }
        (self.together, self.touched) = (left, touched);
        true
    }

    /// Finds the contact of a slot at a relative pose, within a gap, m.
    fn find_with(
        &mut self,
        finder: &mut Finder,
        index: u32,
        place: (Pose, f64),
        ends: [&Body; 2],
        joined: &BitSet,
        settings: &SolverSettings,
    ) {
        let (slot, state) = (&mut self.slots[index as usize], &mut self.states[index as usize]);
        finder.find(ends, place, (index, slot, state), self.updates, joined, settings);
        if slot.touching {
            self.watches[index as usize].end();
        }
    }
}
