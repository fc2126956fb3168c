//! A joint that gives.

use bevy::prelude::*;

/// A joint as a damped spring with a bounded force.
#[derive(Reflect, Clone, Copy, Debug, PartialEq)]
pub struct Softness {
    /// Undamped frequency, Hz, positive.
    pub frequency: f64,
    /// Damping ratio ζ ≥ 0; 1 is critical.
    pub damping_ratio: f64,
    /// Largest force, N: of its Euclidean norm, whatever its direction.
    pub max_force: f64,
}

impl Softness {
    /// Whether it describes a spring.
    pub(super) fn is_valid(&self) -> bool {
        self.frequency > 0.0
            && self.frequency.is_finite()
            && self.damping_ratio >= 0.0
            && self.damping_ratio.is_finite()
            && self.max_force >= 0.0
    }
}
