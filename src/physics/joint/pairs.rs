//! Which bodies a joint keeps from colliding.

use bevy::prelude::*;

/// Pairs of body indices that are joined and must not collide.
#[derive(Resource, Default)]
pub(crate) struct JoinedPairs {
    /// Sorted, the lower index first.
    pairs: Vec<(u32, u32)>,
}

impl JoinedPairs {
    /// Replaces all pairs.
    pub fn rebuild(&mut self, pairs: impl Iterator<Item = (u32, u32)>) {
        self.pairs.clear();
        self.pairs.extend(pairs.map(|(a, b)| (a.min(b), a.max(b))));
        self.pairs.sort_unstable();
    }

    /// Whether the two are joined, in either order.
    pub fn contains(&self, a: u32, b: u32) -> bool {
        self.pairs.binary_search(&(a.min(b), a.max(b))).is_ok()
    }
}
