//! The scalars in which one island can be solved at a time.

use nalgebra::SimdRealField;

/// A scalar in which one island can be solved at a time.
pub(crate) trait Scalar: SimdRealField + Copy + PartialOrd + Default {
    /// The gap between 1 and the next number.
    const EPSILON: f64;

    fn of(value: f64) -> Self;
    fn to_f64(self) -> f64;
}

impl Scalar for f32 {
    const EPSILON: f64 = f32::EPSILON as f64;

    fn of(value: f64) -> Self {
        value as Self
    }
    fn to_f64(self) -> f64 {
        f64::from(self)
    }
}

impl Scalar for f64 {
    const EPSILON: f64 = f64::EPSILON;

    fn of(value: f64) -> Self {
        value
    }
    fn to_f64(self) -> f64 {
        self
    }
}
