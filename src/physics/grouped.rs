//! Items sorted by the group that each is in, by counting.

use super::Refill;

/// Items, group after group; those of one group in the order in which they came.
#[derive(Clone, Default)]
pub(crate) struct Grouped {
    items: Vec<u32>,
    /// Group g has `items[starts[g]..starts[g + 1]]`.
    starts: Vec<u32>,
}

impl Grouped {
    /// The group of what is in none.
    pub const NONE: u32 = u32::MAX;

    /// From items with their groups, each below `groups`, or [`Self::NONE`] for those that are left out.
    pub fn rebuild(&mut self, groups: u32, items: impl Iterator<Item = (u32, u32)> + Clone) {
        self.starts.reset(groups as usize + 1, 0);
        let items = items.filter(|&(_, group)| group != Self::NONE);
        for (_, group) in items.clone() {
            self.starts[group as usize + 1] += 1;
        }
        for group in 0..groups as usize {
            self.starts[group + 1] += self.starts[group];
        }
        self.items.reset(self.starts[groups as usize] as usize, 0);
        // Filling moves each start to its end; walking backwards would put it back, but a shift
        // afterwards is simpler.
        for (item, group) in items {
            let slot = &mut self.starts[group as usize];
            self.items[*slot as usize] = item;
            *slot += 1;
        }
        self.starts.rotate_right(1);
        self.starts[0] = 0;
    }

    /// How many groups there are.
    pub fn count(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }

    /// The items of a group.
    pub fn of(&self, group: usize) -> &[u32] {
        &self.items[self.starts[group] as usize..self.starts[group + 1] as usize]
    }

    /// The items of all groups.
    pub fn all(&self) -> &[u32] {
        &self.items
    }
}
