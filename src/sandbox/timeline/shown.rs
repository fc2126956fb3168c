//! The moment that is drawn while the world is elsewhere.

use bevy::prelude::*;

/// The step whose poses are drawn while the world is at another, as the way there is long.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ShownStep {
    /// As [`StepStats::steps`](crate::physics::StepStats::steps) counts them; none: the world is drawn as it is.
    pub step: Option<u64>,
    /// Whether somebody held the head there in this frame.
    pub(super) is_held: bool,
}
