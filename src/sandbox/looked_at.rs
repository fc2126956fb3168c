//! Loads of joints that are there because somebody looks at them.

use bevy::prelude::*;

use crate::physics::StepStats;

/// Marks a load that is there to be looked at, and goes when nobody does.
#[derive(Component)]
pub(super) struct LookedAt {
    /// Steps that the world had made then: none of them told the load.
    since: u64,
}

impl LookedAt {
    /// After the last step.
    pub fn from_now(stats: &StepStats) -> Self {
        Self { since: stats.steps }
    }

    /// Whether a step has told the load since.
    pub fn is_told(&self, stats: &StepStats) -> bool {
        stats.steps != self.since
    }
}
