//! Which bodies a joint keeps from colliding.

use bevy::prelude::*;

/// Pairs of body indices that are joined and must not collide.
#[derive(Resource, Default, Clone)]
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

    /// Calls `differs` with each pair that only one of the two has.
    pub fn differences(&self, other: &Self, mut differs: impl FnMut(u32, u32)) {
        let (mut one, mut two) = (self.pairs.iter().peekable(), other.pairs.iter().peekable());
        loop {
            let next = match (one.peek(), two.peek()) {
                (Some(a), Some(b)) if a == b => {
                    one.next();
                    two.next();
                    continue;
                }
                (Some(a), Some(b)) if a < b => one.next(),
                (Some(_), None) => one.next(),
                (_, Some(_)) => two.next(),
                (None, None) => return,
            };
            next.into_iter().for_each(|&(a, b)| differs(a, b));
        }
    }

    /// Follows bodies to their new indices; pairs of the gone go.
    pub fn remap(&mut self, new_index: &[Option<u32>]) {
        let of = |body: u32| new_index.get(body as usize).copied().flatten();
        self.pairs = self.pairs.iter().filter_map(|&(a, b)| Some((of(a)?, of(b)?))).collect();
    }
}
