//! How position errors are corrected, in the terms of one substep: by springs, or by moving bodies out of them.

use crate::physics::lanes::Lanes;

/// A speed beyond all, m/s, whose square is still finite in `f32`.
pub(crate) const UNLIMITED: f64 = 1e18;

/// How a soft constraint acts, in the terms of one substep.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SoftTerms<L> {
    /// Velocity bias over error, ω/(2ζ + hω), 1/s.
    pub rate: L,
    /// σ, the factor on the effective mass.
    pub mass: L,
    /// ι, the share of the accumulated impulse that is taken back.
    pub impulse: L,
    /// Largest speed out of an error, m/s, positive.
    pub max_speed: L,
    /// 1/h.
    pub per_step: L,
    /// Depth that is not corrected, m.
    pub slop: L,
}

impl<L: Lanes> SoftTerms<L> {
    /// A spring of `frequency` Hz and `damping` ratio over substeps of `h`.
    pub fn new(frequency: f64, damping: f64, max_speed: f64, slop: f64, h: f64) -> Self {
        let omega = std::f64::consts::TAU * frequency;
        let a = h * omega * (2.0 * damping + h * omega);
        Self {
            mass: L::of(a / (1.0 + a)),
            impulse: L::of(1.0 / (1.0 + a)),
            ..Self::rigid(omega / (2.0 * damping + h * omega), max_speed, slop, h)
        }
    }

    /// A spring of stiffness and damping for each unit of the effective mass, 1/s² and 1/s, over substeps of `h`.
    pub fn of_spring([stiffness, damping]: [f64; 2], h: f64) -> Self {
        let per_speed = damping + h * stiffness;
        let a = h * per_speed;
        let rate = if per_speed > 0.0 { stiffness / per_speed } else { 0.0 };
        Self { mass: L::of(a / (1.0 + a)), impulse: L::of(1.0 / (1.0 + a)), ..Self::rigid(rate, UNLIMITED, 0.0, h) }
    }

    /// No spring: the bias is `rate`, 1/s, times the error, whatever the force.
    pub fn rigid(rate: f64, max_speed: f64, slop: f64, h: f64) -> Self {
        Self {
            rate: L::of(rate),
            mass: L::one(),
            impulse: L::zero(),
            max_speed: L::of(max_speed),
            per_step: L::of(1.0 / h),
            slop: L::of(slop),
        }
    }
}

/// How one sweep over positions moves bodies out of their errors, the velocities left as they are.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Projection<L> {
    /// Share of a contact's error that an update corrects.
    pub contact_share: L,
    /// Share of a joint's error that an update corrects.
    pub joint_share: L,
    /// Largest correction of one update, m.
    pub max_correction: L,
    /// Depth that is not corrected, m.
    pub slop: L,
}
