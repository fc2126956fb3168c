//! Motions that are prescribed in time.

use bevy::prelude::*;

/// A coordinate as a function of simulation time t, s: an angle, rad, or a distance, m. Integrators evaluate it, and
/// its derivatives, at their own times.
#[derive(Reflect, Clone, Copy, Debug, PartialEq)]
pub enum PrescribedMotion {
    /// q = from + rate t.
    Ramp {
        /// At t = 0.
        from: f64,
        /// 1/s.
        rate: f64,
    },
    /// q = mean + amplitude sin(ω t + phase).
    Sine {
        /// The middle of the motion.
        mean: f64,
        /// How far from the middle it goes.
        amplitude: f64,
        /// ω, rad/s.
        angular_frequency: f64,
        /// rad.
        phase: f64,
    },
    /// q = position + velocity (t − at) + ½ acceleration (t − at)²: what a system sets anew each step.
    Course {
        /// When it is at `position`, s.
        at: f64,
        /// At that time.
        position: f64,
        /// 1/s.
        velocity: f64,
        /// 1/s².
        acceleration: f64,
    },
}

impl PrescribedMotion {
    /// Stays at a place.
    pub(crate) fn rest(at: f64) -> Self {
        Self::Ramp { from: at, rate: 0.0 }
    }

    /// q, q̇ and q̈ at a time, s.
    pub fn at_time(&self, time: f64) -> [f64; 3] {
        match *self {
            Self::Ramp { from, rate } => [from + rate * time, rate, 0.0],
            Self::Sine { mean, amplitude, angular_frequency, phase } => {
                let (sin, cos) = (angular_frequency * time + phase).sin_cos();
                let rate = amplitude * angular_frequency;
                [mean + amplitude * sin, rate * cos, -rate * angular_frequency * sin]
            }
            Self::Course { at, position, velocity, acceleration } => {
                let t = time - at;
                [position + t * (velocity + 0.5 * t * acceleration), velocity + t * acceleration, acceleration]
            }
        }
    }

    /// Whether all its numbers are finite.
    pub(crate) fn is_finite(&self) -> bool {
        match *self {
            Self::Ramp { from, rate } => [from, rate, 0.0, 0.0],
            Self::Sine { mean, amplitude, angular_frequency, phase } => [mean, amplitude, angular_frequency, phase],
            Self::Course { at, position, velocity, acceleration } => [at, position, velocity, acceleration],
        }
        .iter()
        .all(|number| number.is_finite())
    }
}
