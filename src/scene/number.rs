//! Numbers that are what they must be: read through these, a bad one is the parser's error, with
//! line and column.

use bevy::math::{DQuat, DVec3};
use serde::Deserialize;

/// A number that is not what it must be.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("must be {must_be}, is {value}")]
pub(super) struct NumberError {
    must_be: &'static str,
    value: f64,
}

macro_rules! number {
    ($name:ident, $must_be:literal, $holds:expr) => {
        #[doc = concat!("A number that is ", $must_be, ".")]
        #[derive(Deserialize, Clone, Copy, Debug, PartialEq)]
        #[serde(try_from = "f64")]
        pub(super) struct $name(f64);

        impl TryFrom<f64> for $name {
            type Error = NumberError;

            fn try_from(value: f64) -> Result<Self, NumberError> {
                let holds: fn(f64) -> bool = $holds;
                if !value.is_finite() {
                    Err(NumberError { must_be: "finite", value })
                } else if !holds(value) {
                    Err(NumberError { must_be: $must_be, value })
                } else {
                    Ok(Self(value))
                }
            }
        }

        impl From<$name> for f64 {
            fn from(number: $name) -> f64 {
                number.0
            }
        }
    };
}

number!(Finite, "finite", |_| true);
number!(Positive, "greater than 0", |value| value > 0.0);
number!(NonNegative, "at least 0", |value| value >= 0.0);
number!(Fraction, "0 to 1", |value| (0.0..=1.0).contains(&value));

/// Three finite numbers, written `(x, y, z)`.
#[derive(Deserialize, Clone, Copy, Debug)]
pub(super) struct Vector(Finite, Finite, Finite);

/// Three positive numbers, written `(x, y, z)`.
#[derive(Deserialize, Clone, Copy, Debug)]
pub(super) struct PositiveVector(Positive, Positive, Positive);

/// A colour, written `(red, green, blue)`, 0 to 1 each.
#[derive(Deserialize, Clone, Copy, Debug)]
pub(super) struct Color(Fraction, Fraction, Fraction);

/// A rotation, written as a quaternion `(x, y, z, w)` of any length but 0.
#[derive(Deserialize, Clone, Copy, Debug)]
#[serde(try_from = "(Finite, Finite, Finite, Finite)")]
pub(super) struct Quaternion(DQuat);

impl From<Vector> for DVec3 {
    fn from(Vector(x, y, z): Vector) -> Self {
        Self::new(x.0, y.0, z.0)
    }
}

impl From<PositiveVector> for DVec3 {
    fn from(PositiveVector(x, y, z): PositiveVector) -> Self {
        Self::new(x.0, y.0, z.0)
    }
}

impl From<Color> for [f32; 3] {
    fn from(Color(red, green, blue): Color) -> Self {
        [red.0 as f32, green.0 as f32, blue.0 as f32]
    }
}

impl TryFrom<(Finite, Finite, Finite, Finite)> for Quaternion {
    type Error = &'static str;

    fn try_from((x, y, z, w): (Finite, Finite, Finite, Finite)) -> Result<Self, Self::Error> {
        let largest = [x.0, y.0, z.0, w.0].into_iter().fold(0.0, |largest: f64, value| largest.max(value.abs()));
        if largest == 0.0 {
            return Err("a rotation must not be (0, 0, 0, 0); no rotation is (0, 0, 0, 1)");
        }
        // Divided by the largest first: squares of very large or small numbers leave f64's range.
        Ok(Self(DQuat::from_xyzw(x.0 / largest, y.0 / largest, z.0 / largest, w.0 / largest).normalize()))
    }
}

impl From<Quaternion> for DQuat {
    fn from(quaternion: Quaternion) -> Self {
        quaternion.0
    }
}
