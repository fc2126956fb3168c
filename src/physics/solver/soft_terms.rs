//! How errors are mended, in the terms of one substep: by springs, or by moving bodies out of them.

use crate::physics::lanes::Lanes;

/// A speed beyond all, m/s, whose square is still finite in `f32`.
pub(crate) const UNLIMITED: f64 = 1e18;

/// How far contacts give and how they come back, in the terms of one substep.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SoftTerms<L> {
    /// ω/(2ζ + hω), 1/s.
    pub rate: L,
    /// σ.
    pub mass: L,
    /// ι.
    pub impulse: L,
    /// Fastest way out of an error, m/s, positive.
    pub push: L,
    /// 1/h.
    pub per_step: L,
    /// Depth left alone, m.
    pub slop: L,
}

impl<L: Lanes> SoftTerms<L> {
    /// A spring of `frequency` Hz and `damping` ratio over substeps of `h`.
    pub fn new(frequency: f64, damping: f64, push: f64, slop: f64, h: f64) -> Self {
        let omega = std::f64::consts::TAU * frequency;
        let a = h * omega * (2.0 * damping + h * omega);
        Self {
            rate: L::of(omega / (2.0 * damping + h * omega)),
            mass: L::of(a / (1.0 + a)),
            impulse: L::of(1.0 / (1.0 + a)),
            push: L::of(push),
            per_step: L::of(1.0 / h),
            slop: L::of(slop),
        }
    }

    /// No spring: a share of every error, given as a `rate` in 1/s, is taken back whatever the force.
    pub fn rigid(rate: f64, push: f64, slop: f64, h: f64) -> Self {
        Self {
            rate: L::of(rate),
            mass: L::one(),
            impulse: L::zero(),
            push: L::of(push),
            per_step: L::of(1.0 / h),
            slop: L::of(slop),
        }
    }
}

/// How one sweep over positions moves bodies out of their errors, the velocities left as they are.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Projection<L> {
    /// Share of a contact's error.
    pub contact: L,
    /// Share of a joint's error.
    pub joint: L,
    /// Most that one update mends, m.
    pub most: L,
    /// Depth left alone, m.
    pub slop: L,
}
