//! A tape of which one end is chosen.

use bevy::prelude::*;

use super::reader::WatchedPoint;

/// The end of a tape that is chosen, and the other once it is.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq)]
pub struct TapeStart {
    /// None: no tape is being drawn.
    pub from: Option<WatchedPoint>,
    /// Where the second click was.
    pub to: Option<WatchedPoint>,
}

impl TapeStart {
    /// Whether the next click is the other end of a tape.
    pub fn is_waiting(&self) -> bool {
        self.from.is_some()
    }
}
