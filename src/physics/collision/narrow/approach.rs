//! Whether two convex shapes are apart by more than a gap, in a few steps.
//!
//! With w(n) the vector from the foremost point of A along n to that of B along −n, n·w(n) is at most the
//! distance. From some direction on, v goes to the nearest point to the origin of the segment from v to w(v/|v|)
//! (Gilbert 1966): |v| is never less than the distance, and n = v/|v| turns to the direction in which it is.
//! What is found to be apart is so, whatever the start; what is not may be.

use nalgebra::Vector3;

use super::axis_code::AxisCode;
use super::{Feature, PairSearch};
use crate::physics::collision::constants::{APPROACH_STEPS, APPROACH_TRIALS};

/// That two shapes are apart by more than the gap, where that is found. Begins with the direction of the last step, or
/// else from centre to centre, leaves one for the next step, and in `search.apart` how far apart they are at least. The
/// first direction that tells is enough: a better one saves fewer tests than it costs.
pub(crate) fn are_apart(
    search: &mut PairSearch,
    center: &Vector3<f64>,
    gap: f64,
    between: impl Fn(&Vector3<f64>) -> Vector3<f64>,
) -> bool {
    let mut normal = match search.last {
        Some(Feature::Smooth(code)) => AxisCode(code).axis(),
        _ => match center.try_normalize(0.0) {
            Some(normal) => normal,
            None => return false,
        },
    };
    let mut nearest = between(&normal);
    let mut distance = normal.dot(&nearest);
    let mut farthest = distance;
    search.axes += 1;
    for step in 0..APPROACH_STEPS {
        let length = nearest.norm();
        let is_hopeless = step >= APPROACH_TRIALS && farthest <= 0.0;
        if distance > gap || length <= gap || is_hopeless {
            break;
        }
        normal = nearest / length;
        let next = between(&normal);
        distance = normal.dot(&next);
        farthest = farthest.max(distance);
        search.axes += 1;
        let way = next - nearest;
        let share = -nearest.dot(&way) / way.norm_squared();
        // Not a number where no step is left.
        if share.is_nan() {
            break;
        }
        nearest += way * share.clamp(0.0, 1.0);
    }
    if distance <= gap {
        return false;
    }
    search.last = Some(Feature::Smooth(AxisCode::of(&normal).0));
    search.apart = distance;
    true
}
