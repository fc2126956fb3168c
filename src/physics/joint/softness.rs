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

/// A spring along a row, as engines take it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum SpringConstants {
    /// For each unit of the row's effective mass: ω², 1/s², and 2ζω, 1/s.
    PerMass { stiffness: f64, damping: f64 },
    /// N/m and N·s/m, or N·m/rad and N·m·s/rad.
    Given { stiffness: f64, damping: f64 },
}

impl SpringConstants {
    /// Stiffness and damping for each unit of an effective mass, of a row that has that one, kg or kg·m².
    pub fn per_mass(&self, mass: f64) -> [f64; 2] {
        match *self {
            Self::PerMass { stiffness, damping } => [stiffness, damping],
            Self::Given { stiffness, damping } if mass > 0.0 => [stiffness / mass, damping / mass],
            Self::Given { .. } => [0.0; 2],
        }
    }
}

impl From<Softness> for SpringConstants {
    fn from(Softness { frequency, damping_ratio, .. }: Softness) -> Self {
        let omega = std::f64::consts::TAU * frequency;
        Self::PerMass { stiffness: omega * omega, damping: 2.0 * damping_ratio * omega }
    }
}
