//! Pairs of entities of which it is told when they come and go.

use bevy::prelude::*;

/// The pairs of the last step, sorted.
#[derive(Clone, Default)]
pub(crate) struct ToldPairs {
    told: Vec<(Entity, Entity)>,
    present: Vec<(Entity, Entity)>,
}

impl ToldPairs {
    /// Whether there was none.
    pub fn is_empty(&self) -> bool {
        self.told.is_empty()
    }

    /// Takes in the pairs of this step. Calls `tell` with those that came, then with those that went, and whether they came.
    pub fn update(
        &mut self,
        present: impl Iterator<Item = (Entity, Entity)>,
        mut tell: impl FnMut(bool, (Entity, Entity)),
    ) {
        let Self { told, present: now } = self;
        now.clear();
        now.extend(present);
        now.sort_unstable();
        now.iter().filter(|pair| told.binary_search(pair).is_err()).for_each(|&pair| tell(true, pair));
        told.iter().filter(|pair| now.binary_search(pair).is_err()).for_each(|&pair| tell(false, pair));
        std::mem::swap(told, now);
    }
}
