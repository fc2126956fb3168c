//! Joints that break.

use bevy::prelude::*;

/// What a joint bears: it breaks at the end of a step where the mean of its force or of its torque about the anchor, over
/// a window of time, is larger, impacts, limits and motors included.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component, Debug, PartialEq)]
pub struct Breakable {
    /// Largest force, N; may be infinite.
    pub force: f64,
    /// Largest torque, N·m; may be infinite.
    pub torque: f64,
    /// Length of the window, s; at least a step.
    pub window: f64,
    /// Simulation time from which on it counts, s.
    pub from: f64,
}

impl Breakable {
    /// Breaks at that force, N, over a sixtieth of a second, from 1 s on.
    pub fn at_force(force: f64) -> Self {
        Self { force, torque: f64::INFINITY, window: 1.0 / 60.0, from: 1.0 }
    }

    /// Breaks at that torque about the anchor, N·m, too.
    pub fn with_torque(self, torque: f64) -> Self {
        Self { torque, ..self }
    }

    /// Counts from the start on.
    pub fn at_once(self) -> Self {
        Self { from: 0.0, ..self }
    }

    /// Whether its numbers make sense.
    pub(crate) fn is_valid(&self) -> bool {
        self.force > 0.0 && self.torque > 0.0 && self.window >= 0.0 && self.window.is_finite() && self.from.is_finite()
    }
}

/// Marks a joint that broke: it holds nothing any more. Its bodies do not collide until they are apart. To mend it, take
/// the marker off.
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Component, Debug, Default, PartialEq)]
pub struct BrokenJoint {
    /// Whether its bodies have been apart since.
    pub apart: bool,
}
