//! Rotations as a group: the exponential map and its differential.
//!
//! A rotation vector φ stands for the rotation exp φ by |φ| about φ. Where R(t) = exp φ(t) R₀ turns with the angular
//! velocity ω in world axes, ω = dexp_φ φ̇, of which the inverse is (Hairer, Lubich and Wanner 2006, Geometric
//! Numerical Integration, lemma III.4.2 and IV.7; Iserles et al. 2000, appendix B)
//!
//! φ̇ = dexp⁻¹_φ ω = ω − ½ φ × ω + c φ × (φ × ω),  c = (1 − (θ/2) cot(θ/2))/θ²,  θ = |φ|.

use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};

/// θ² below which the series are exact to rounding.
const SMALL: f64 = 0.25;

/// (−1)ᵏ/(2k + 1)! and (−1)ᵏ/(2k)! for k from 1.
const SINC: [f64; 6] =
    [-1.0 / 6.0, 1.0 / 120.0, -1.0 / 5040.0, 1.0 / 362_880.0, -1.0 / 39_916_800.0, 1.0 / 6_227_020_800.0];
const COS: [f64; 6] = [-0.5, 1.0 / 24.0, -1.0 / 720.0, 1.0 / 40320.0, -1.0 / 3_628_800.0, 1.0 / 479_001_600.0];

/// The rotation by a vector, rad.
#[inline]
pub(crate) fn exponential(turn: &Vector3<f64>) -> UnitQuaternion<f64> {
    let squared = 0.25 * turn.norm_squared();
    let (sinc, cos) = if squared < 0.25 * SMALL {
        let s = squared;
        let sinc = 1.0 + s * (SINC[0] + s * (SINC[1] + s * (SINC[2] + s * (SINC[3] + s * (SINC[4] + s * SINC[5])))));
        let cos = 1.0 + s * (COS[0] + s * (COS[1] + s * (COS[2] + s * (COS[3] + s * (COS[4] + s * COS[5])))));
        (sinc, cos)
    } else {
        let half = squared.sqrt();
        (half.sin() / half, half.cos())
    };
    UnitQuaternion::new_unchecked(Quaternion::from_parts(cos, turn * (0.5 * sinc)))
}

/// exp φ − 1 as a quaternion: what a small turn adds, without the rounding of the sum.
pub(crate) fn exponential_less_one(turn: &Vector3<f64>) -> Quaternion<f64> {
    let s = 0.25 * turn.norm_squared();
    let less = if s < 0.25 * SMALL {
        s * (COS[0] + s * (COS[1] + s * (COS[2] + s * (COS[3] + s * (COS[4] + s * COS[5])))))
    } else {
        let sin = (0.5 * s.sqrt()).sin();
        -2.0 * sin * sin
    };
    Quaternion::from_parts(less, exponential(turn).vector().into_owned())
}

/// dexp⁻¹_φ ω.
#[inline]
pub(crate) fn inverse_dexp(turn: &Vector3<f64>, angular: &Vector3<f64>) -> Vector3<f64> {
    let s = turn.norm_squared();
    let c = if s < SMALL {
        // Bernoulli numbers: Σ |B₂ₖ| θ²ᵏ⁻²/(2k)!.
        1.0 / 12.0
            + s * (1.0 / 720.0
                + s * (1.0 / 30240.0 + s * (1.0 / 1_209_600.0 + s * (1.0 / 47_900_160.0 + s * 5.284_190_138_7e-10))))
    } else {
        let half = 0.5 * s.sqrt();
        (1.0 - half / half.tan()) / s
    };
    let once = turn.cross(angular);
    angular - once * 0.5 + turn.cross(&once) * c
}

/// R diag(p) Rᵀ.
#[inline]
pub(crate) fn in_world(principal: &Vector3<f64>, rotation: &Matrix3<f64>) -> Matrix3<f64> {
    let r = rotation;
    let scaled =
        Matrix3::from_columns(&[r.column(0) * principal.x, r.column(1) * principal.y, r.column(2) * principal.z]);
    let mut world = Matrix3::zeros();
    for column in 0..3 {
        for row in column..3 {
            let sum = scaled[(row, 0)] * r[(column, 0)]
                + scaled[(row, 1)] * r[(column, 1)]
                + scaled[(row, 2)] * r[(column, 2)];
            world[(row, column)] = sum;
            world[(column, row)] = sum;
        }
    }
    world
}
