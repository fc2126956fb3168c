//! Numbers that are what they must be: read through these, a bad one is the parser's error, with
//! line and column.

use bevy::math::{DQuat, DVec3};
use serde::{Deserialize, Serialize};

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
        #[derive(Serialize, Deserialize, Clone, Copy, Debug, PartialEq)]
        #[serde(try_from = "f64", into = "f64")]
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

        impl $name {
            /// To be written; of a scene that is valid.
            pub fn of_valid(number: f64) -> Self {
                Self(number)
            }
        }
    };
}

number!(Finite, "finite", |_| true);
number!(Positive, "greater than 0", |value| value > 0.0);
number!(NonNegative, "at least 0", |value| value >= 0.0);
number!(Fraction, "0 to 1", |value| (0.0..=1.0).contains(&value));

/// Three finite numbers, written `(x, y, z)`.
#[derive(Serialize, Deserialize, Clone, Copy, Debug)]
pub(super) struct Vector(Finite, Finite, Finite);

/// Three positive numbers, written `(x, y, z)`.
#[derive(Serialize, Deserialize, Clone, Copy, Debug)]
pub(super) struct PositiveVector(Positive, Positive, Positive);

/// A colour, written `(red, green, blue)`, 0 to 1 each.
#[derive(Serialize, Deserialize, Clone, Copy, Debug)]
pub(super) struct Color(Fraction, Fraction, Fraction);

/// A rotation, written as a quaternion `(x, y, z, w)` of any length but 0.
#[derive(Serialize, Deserialize, Clone, Copy, Debug)]
#[serde(try_from = "(Finite, Finite, Finite, Finite)", into = "(f64, f64, f64, f64)")]
pub(super) struct Quaternion(DQuat);

impl From<Vector> for DVec3 {
    fn from(Vector(x, y, z): Vector) -> Self {
        Self::new(x.0, y.0, z.0)
    }
}

impl From<DVec3> for Vector {
    /// To be written; of a scene that is valid.
    fn from(DVec3 { x, y, z }: DVec3) -> Self {
        Self(Finite(x), Finite(y), Finite(z))
    }
}

impl From<PositiveVector> for DVec3 {
    fn from(PositiveVector(x, y, z): PositiveVector) -> Self {
        Self::new(x.0, y.0, z.0)
    }
}

impl From<DVec3> for PositiveVector {
    /// To be written; of a scene that is valid.
    fn from(DVec3 { x, y, z }: DVec3) -> Self {
        Self(Positive(x), Positive(y), Positive(z))
    }
}

impl From<Color> for [f32; 3] {
    fn from(Color(red, green, blue): Color) -> Self {
        [red.0 as f32, green.0 as f32, blue.0 as f32]
    }
}

impl From<[f32; 3]> for Color {
    /// To be written; of a scene that is valid. By the decimals that single precision takes: 0.1,
    /// not 0.10000000149011612.
    fn from(color: [f32; 3]) -> Self {
        let [red, green, blue] = color.map(|channel| Fraction(channel.to_string().parse().unwrap_or(channel.into())));
        Self(red, green, blue)
    }
}

/// A quaternion whose length is this near to 1 is taken as it is: scaling it again would change
/// bits that were written to be read back.
const UNIT_ROUNDING: f64 = 1e-12;

impl TryFrom<(Finite, Finite, Finite, Finite)> for Quaternion {
    type Error = &'static str;

    fn try_from((x, y, z, w): (Finite, Finite, Finite, Finite)) -> Result<Self, Self::Error> {
        let given = DQuat::from_xyzw(x.0, y.0, z.0, w.0);
        if (given.length_squared() - 1.0).abs() < UNIT_ROUNDING {
            return Ok(Self(given));
        }
        let largest = [x.0, y.0, z.0, w.0].into_iter().fold(0.0, |largest: f64, value| largest.max(value.abs()));
        if largest == 0.0 {
            return Err("a rotation must not be (0, 0, 0, 0); no rotation is (0, 0, 0, 1)");
        }
        // Divided by the largest first: squares of very large or small numbers leave f64's range.
        Ok(Self((given / largest).normalize()))
    }
}

impl From<DQuat> for Quaternion {
    /// To be written; of a scene that is valid.
    fn from(rotation: DQuat) -> Self {
        Self(rotation)
    }
}

impl From<Quaternion> for (f64, f64, f64, f64) {
    fn from(Quaternion(DQuat { x, y, z, w }): Quaternion) -> Self {
        (x, y, z, w)
    }
}

impl From<Quaternion> for DQuat {
    fn from(quaternion: Quaternion) -> Self {
        quaternion.0
    }
}
