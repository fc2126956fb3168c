//! Rotations as a group: the exponential map and its differential.
//!
//! A rotation vector φ stands for the rotation exp φ by |φ| about φ. Where R(t) = exp φ(t) R₀ turns with the angular
//! velocity ω in world axes, ω = dexp_φ φ̇, of which the inverse is (Hairer, Lubich and Wanner 2006, Geometric
//! Numerical Integration, lemma III.4.2 and IV.7; Iserles et al. 2000, appendix B)
//!
//! φ̇ = dexp⁻¹_φ ω = ω − ½ φ × ω + c φ × (φ × ω),  c = (1 − (θ/2) cot(θ/2))/θ²,  θ = |φ|.

use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};

use crate::physics::solver::linear::Number;

/// θ² below which the series are exact to rounding.
const SMALL: f64 = 0.25;

/// (cos x − 1)/x², sin x/x and c, by x² and θ².
const COS: [f64; 6] = [-0.5, 1.0 / 24.0, -1.0 / 720.0, 1.0 / 40320.0, -1.0 / 3_628_800.0, 1.0 / 479_001_600.0];
const SINC: [f64; 7] =
    [1.0, -1.0 / 6.0, 1.0 / 120.0, -1.0 / 5040.0, 1.0 / 362_880.0, -1.0 / 39_916_800.0, 1.0 / 6_227_020_800.0];
/// Bernoulli numbers: Σ |B₂ₖ| θ²ᵏ⁻²/(2k)!.
const BERNOULLI: [f64; 6] =
    [1.0 / 12.0, 1.0 / 720.0, 1.0 / 30240.0, 1.0 / 1_209_600.0, 1.0 / 47_900_160.0, 5.284_190_138_7e-10];

/// A polynomial, its lowest coefficient first.
#[inline]
fn polynomial<N: Number, const K: usize>(coefficients: &[f64; K], x: N) -> N {
    let mut higher = coefficients.iter().rev().map(|&coefficient| nalgebra::convert::<f64, N>(coefficient));
    let highest = higher.next().unwrap_or_else(N::zero);
    higher.fold(highest, |sum, coefficient| sum * x + coefficient)
}

/// exp φ of small turns, scalar and vector.
#[inline]
pub(super) fn small_exponential<N: Number>(turn: &Vector3<N>) -> (N, Vector3<N>) {
    let (quarter, half) = (nalgebra::convert::<f64, N>(0.25), nalgebra::convert::<f64, N>(0.5));
    let s = turn.dot(turn) * quarter;
    (N::one() + s * polynomial(&COS, s), turn * (polynomial(&SINC, s) * half))
}

/// The rotation by a vector, rad.
#[inline]
pub(crate) fn exponential(turn: &Vector3<f64>) -> UnitQuaternion<f64> {
    let squared = 0.25 * turn.norm_squared();
    let (cos, vector) = if squared < 0.25 * SMALL {
        small_exponential(turn)
    } else {
        let half = squared.sqrt();
        (half.cos(), turn * (0.5 * (half.sin() / half)))
    };
    UnitQuaternion::new_unchecked(Quaternion::from_parts(cos, vector))
}

/// exp φ − 1 as a quaternion: what a small turn adds, without the rounding of the sum.
pub(crate) fn exponential_less_one(turn: &Vector3<f64>) -> Quaternion<f64> {
    let s = 0.25 * turn.norm_squared();
    let less = if s < 0.25 * SMALL {
        s * polynomial(&COS, s)
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
    if s < SMALL {
        return small_inverse_dexp(turn, angular);
    }
    let half = 0.5 * s.sqrt();
    with_factor(turn, angular, (1.0 - half / half.tan()) / s)
}

/// dexp⁻¹_φ ω of small turns.
#[inline]
pub(super) fn small_inverse_dexp<N: Number>(turn: &Vector3<N>, angular: &Vector3<N>) -> Vector3<N> {
    with_factor(turn, angular, polynomial(&BERNOULLI, turn.dot(turn)))
}

/// dexp⁻¹_φ ω for a c.
#[inline]
fn with_factor<N: Number>(turn: &Vector3<N>, angular: &Vector3<N>, c: N) -> Vector3<N> {
    let once = turn.cross(angular);
    angular - once * nalgebra::convert::<f64, N>(0.5) + turn.cross(&once) * c
}

/// R diag(p) Rᵀ.
#[inline]
pub(crate) fn in_world<N: Number>(principal: &Vector3<N>, rotation: &Matrix3<N>) -> Matrix3<N> {
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
