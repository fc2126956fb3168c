//! What is usual and therefore not written.

use bevy::math::{DQuat, DVec3};

/// Of a soft joint that does not say: critical.
pub(super) const USUAL_DAMPING_RATIO: f64 = 1.0;

/// A value, unless it is the usual one in every bit: −0 is not 0.
pub(super) fn unless_same<T: Bits>(value: T, usual: T) -> Option<T> {
    (!value.same_bits(&usual)).then_some(value)
}

pub(super) trait Bits {
    fn same_bits(&self, other: &Self) -> bool;
}

impl Bits for f64 {
    fn same_bits(&self, other: &Self) -> bool {
        self.to_bits() == other.to_bits()
    }
}

impl Bits for DVec3 {
    fn same_bits(&self, other: &Self) -> bool {
        self.to_array().map(f64::to_bits) == other.to_array().map(f64::to_bits)
    }
}

impl Bits for DQuat {
    fn same_bits(&self, other: &Self) -> bool {
        self.to_array().map(f64::to_bits) == other.to_array().map(f64::to_bits)
    }
}
