//! Which points of a manifold bear its friction.
//!
//! Where friction acts at one place for all points of a manifold, that is the middle of those which bear the load. Points that
//! are found only because they may get there within the step bear none: with them in it the middle of a wheel's contact would
//! lie above the ground as soon as its rolling is fast. With s_i the height of a point over the lowest and ρ² the mean square
//! of their distances from their middle, a point has the weight
//!
//!   w_i = (ρ²/(ρ² + (s_i/τ)²))²,  τ = [`TILT`]:
//!
//! smooth, so that no point jumps in or out, and near 1 for what stands on all of them.

use nalgebra::Vector3;

use crate::physics::collision::POINTS;
use crate::physics::lanes::{Lanes, dot, inverse};

/// Slope, of the surface over the other, at which the higher points have a quarter of the weight of the lower.
/// `cylinders::it_rolls_down_a_slope_or_slips_as_its_friction_says`.
const TILT: f64 = 0.1;

/// Each point's share in friction; of those alone that are there, which have a 1 in `present`, and the others a 0.
#[inline(always)]
pub(crate) fn shares<L: Lanes>(
    arms: &[Vector3<L>; POINTS],
    separations: &[L; POINTS],
    present: &[L; POINTS],
) -> [L; POINTS] {
    let each = inverse(present.iter().fold(L::zero(), |sum, &one| sum + one));
    let middle = arms.iter().zip(present).fold(Vector3::repeat(L::zero()), |sum, (arm, &one)| sum + arm * (one * each));
    let (mut square, mut lowest) = (L::zero(), L::of(f64::from(f32::MAX)));
    for ((arm, &separation), &one) in arms.iter().zip(separations).zip(present) {
        let off = arm - middle;
        square += dot(&off, &off) * (one * each);
        lowest = separation.select(one.simd_gt(L::zero()), lowest).simd_min(lowest);
    }
    // Of a single point, which is at no distance.
    let square = square + L::of(1e-20);
    let weights: [L; POINTS] = std::array::from_fn(|index| {
        let height = (separations[index] - lowest) * L::of(1.0 / TILT);
        let weight = square / (square + height * height);
        (weight * weight * present[index]).select(present[index].simd_gt(L::zero()), L::zero())
    });
    let all = inverse(weights.iter().fold(L::zero(), |sum, &weight| sum + weight));
    weights.map(|weight| weight * all)
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::shares;

    const ARMS: [Vector3<f64>; 4] = [
        Vector3::new(1.0, 0.0, 1.0),
        Vector3::new(1.0, 0.0, -1.0),
        Vector3::new(-1.0, 0.0, 1.0),
        Vector3::new(-1.0, 0.0, -1.0),
    ];

    #[test]
    fn those_that_touch_alike_share_alike_whatever_is_not_there() {
        for count in 1..=4 {
            let present = std::array::from_fn(|index| if index < count { 1.0 } else { 0.0 });
            for height in [-0.1, 0.0, 0.3] {
                let separations = std::array::from_fn(|index| if index < count { height } else { -5.0 });
                for (share, one) in shares(&ARMS, &separations, &present).into_iter().zip(present) {
                    assert!((share - one / count as f64).abs() < 1e-12, "{count} at {height}: {share}");
                }
            }
        }
    }

    #[test]
    fn what_is_high_bears_nothing_and_what_is_nearly_down_nearly_all_of_its_own() {
        let share = |height: f64| shares(&ARMS, &[0.0, 0.0, height, height], &[1.0; 4])[3];
        assert!(share(1e-3) > 0.2499 && share(2.0) < 1e-4, "{} {}", share(1e-3), share(2.0));
        // ρ is √2 m: at 0.1 √2 the weight is a quarter.
        assert!((share(0.1 * 2.0_f64.sqrt()) - 0.125 / 1.25).abs() < 1e-12);
    }
}
