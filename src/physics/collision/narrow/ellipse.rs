//! The feet of a point on an ellipse: where the distance to it is least, seen from either side of
//! the long axis.

use crate::physics::collision::constants::FOOT_STEPS;

/// For the ellipse (a cos t, b sin t), a ≥ b ≥ 0, and a point, the sine and cosine of t where the
/// distance from the point has a minimum: the nearest foot, and the one beyond the long axis if
/// there is one, which is so for points near the middle of it.
///
/// By symmetry the point is taken to x, y ≥ 0. Feet are the zeros of
/// G(t) = (a² − b²) sin t cos t − a x sin t + b y cos t. In the first quadrant G/(sin t cos t)
/// falls from +∞ to −∞: there is one, the nearest (Eberly, *Distance from a point to an ellipse*,
/// 2013). In the fourth there are two if the point lies inside the evolute,
/// (a x)^⅔ + (b y)^⅔ < (a² − b²)^⅔, a minimum and a maximum, on either side of
/// tan³ t = −b y/(a x). Elsewhere there are only maxima.
pub(crate) fn feet([a, b]: [f64; 2], [x, y]: [f64; 2]) -> [Option<[f64; 2]>; 2] {
    let (ax, by) = (a * x.abs(), b * y.abs());
    let focal = a * a - b * b;
    let foot = |low: [f64; 2], start: [f64; 2], by: f64| {
        falling_zero([low, [1.0, 0.0]], start, |sin, cos| {
            (focal * sin * cos - ax * sin + by * cos, focal * (cos * cos - sin * sin) - ax * cos - by * sin)
        })
    };
    let near = foot([0.0, 1.0], unit([a * y.abs(), b * x.abs()]), by);
    // Inside the evolute, (a x)^⅔ + (b y)^⅔ < focal^⅔, only if both are less than that.
    let far = (ax < focal && by < focal)
        .then(|| [ax.cbrt(), by.cbrt()])
        .filter(|[cbrt_x, cbrt_y]| (cbrt_x * cbrt_x + cbrt_y * cbrt_y).powi(3) < focal * focal);
    let far = far.map(|[cbrt_x, cbrt_y]| {
        // Mirrored into the first quadrant: −y for y.
        let turning = unit([cbrt_y, cbrt_x]);
        foot(turning, unit([turning[0] + 1.0, turning[1]]), -by)
    });
    let signed = |[sin, cos]: [f64; 2], side: f64| [side * sin.copysign(y), cos.copysign(x)];
    [Some(signed(near, 1.0)), far.map(|far| signed(far, -1.0))]
}

/// Of none, along the long axis.
fn unit([sin, cos]: [f64; 2]) -> [f64; 2] {
    let length = (sin * sin + cos * cos).sqrt();
    if length > 0.0 { [sin / length, cos / length] } else { [0.0, 1.0] }
}

/// Sine and cosine of the angle, between two that are less than a right angle apart, where a function falls through
/// zero. It comes with its slope, of sine and cosine.
fn falling_zero(
    [mut low, mut high]: [[f64; 2]; 2],
    start: [f64; 2],
    function: impl Fn(f64, f64) -> (f64, f64),
) -> [f64; 2] {
    let middle = |low: [f64; 2], high: [f64; 2]| unit([low[0] + high[0], low[1] + high[1]]);
    // By the sine of the angle between.
    let is_after = |one: [f64; 2], other: [f64; 2]| one[0] * other[1] - one[1] * other[0] > 0.0;
    // At the ends the function may be zero without falling through it.
    let [inner_low, inner_high] = [[low, high], [high, low]]
        .map(|[end, other]| unit([end[0] + END_MARGIN * other[0], end[1] + END_MARGIN * other[1]]));
    let mut angle = start;
    if is_after(inner_low, angle) {
        angle = inner_low;
    } else if is_after(angle, inner_high) {
        angle = inner_high;
    }
    for _ in 0..FOOT_STEPS {
        let [sin, cos] = angle;
        let (value, slope) = function(sin, cos);
        if value > 0.0 {
            low = angle;
        } else {
            high = angle;
        }
        // The angle whose half has that tangent: the same to third order.
        let half = -0.5 * value / slope;
        let scale = 1.0 / (1.0 + half * half);
        let [c, s] = [(1.0 - half * half) * scale, 2.0 * half * scale];
        let newton = [sin * c + cos * s, cos * c - sin * s];
        let is_between = half.abs() < 1.0 && is_after(newton, low) && is_after(high, newton);
        if value == 0.0 || half.abs() <= 0.5 * f64::EPSILON {
            break;
        }
        angle = if is_between { newton } else { middle(low, high) };
    }
    unit(angle)
}

/// Share of the quarter at its ends in which no search begins.
const END_MARGIN: f64 = 1e-3;

#[cfg(test)]
mod tests {
    use super::feet;
    use crate::physics::testing::Random;

    /// Minima of the distance among many points of the ellipse, by the angle's sine and cosine.
    fn minima_by_search([a, b]: [f64; 2], [x, y]: [f64; 2]) -> Vec<[f64; 2]> {
        let count = 20_000;
        let at = |step: usize| std::f64::consts::TAU * (step % count) as f64 / count as f64;
        let square = |step: usize| {
            let (sin, cos) = at(step).sin_cos();
            (a * cos - x).powi(2) + (b * sin - y).powi(2)
        };
        (count..2 * count)
            .filter(|&step| square(step) <= square(step - 1) && square(step) < square(step + 1))
            .map(|step| at(step).sin_cos().into())
            .collect()
    }

    #[test]
    fn feet_are_all_the_nearest_points_on_either_side() {
        let mut random = Random::new(5);
        let (mut one, mut two) = (0, 0);
        for _ in 0..300 {
            let a = random.within(0.3, 2.0);
            let b = a * random.within(0.0, 1.0);
            let point = [random.within(-2.0, 2.0), random.within(-1.5, 1.5)];
            let found: Vec<_> = feet([a, b], point).into_iter().flatten().collect();
            let searched = minima_by_search([a, b], point);
            assert_eq!(found.len(), searched.len(), "of ({a}, {b}) from {point:?}");
            for minimum in searched {
                let near = |foot: &&[f64; 2]| (foot[0] - minimum[0]).hypot(foot[1] - minimum[1]) < 1e-3;
                assert!(found.iter().any(|foot| near(&foot)), "{minimum:?} is not in {found:?}");
            }
            one += u32::from(found.len() == 1);
            two += u32::from(found.len() == 2);
        }
        assert!(one > 50 && two > 50, "{one} {two}");
    }

    #[test]
    fn feet_of_points_on_the_axes() {
        let close = |foot: Option<[f64; 2]>, [sin, cos]: [f64; 2]| {
            let foot = foot.expect("a foot");
            assert!((foot[0] - sin).abs() < 1e-9 && (foot[1] - cos).abs() < 1e-9, "{foot:?} is not ({sin}, {cos})");
        };
        // From the middle both ends of the short axis.
        let [near, far] = feet([2.0, 1.0], [0.0, 0.0]);
        close(near, [1.0, 0.0]);
        close(far, [-1.0, 0.0]);
        // From within the evolute on the long axis: cos t = a x/(a² − b²).
        let [near, far] = feet([2.0, 1.0], [0.75, 0.0]);
        close(near, [0.75_f64.sqrt(), 0.5]);
        close(far, [-(0.75_f64.sqrt()), 0.5]);
        // From outside the tip.
        let [near, far] = feet([2.0, 1.0], [-5.0, 0.0]);
        close(near, [0.0, -1.0]);
        assert!(far.is_none());
        // Of a circle, and of a segment.
        close(feet([1.0, 1.0], [3.0, 4.0])[0], [0.8, 0.6]);
        close(feet([1.0, 0.0], [0.6, 4.0])[0], [0.8, 0.6]);
    }
}
