//! Where two straight edges touch.

use nalgebra::Vector3;

use super::{Overlap, Scale, Segment};
use crate::physics::collision::constants::STRETCH_SQUARED_SINE;
use crate::physics::{ContactPoint, FeatureId};

/// The closest points of two edges (Ericson 2005, 5.1.9); of parallel ones any two of them.
pub(crate) fn closest(one: &Segment, other: &Segment) -> [Vector3<f64>; 2] {
    let (u, v, w) = (one.along(), other.along(), one.0[0] - other.0[0]);
    let (uu, uv, vv, uw, vw) = (u.dot(&u), u.dot(&v), v.dot(&v), u.dot(&w), v.dot(&w));
    let along = ((uv * vw - uw * vv) / (uu * vv - uv * uv)).clamp(0.0, 1.0);
    // Zero by zero, between parallel edges.
    let along = if along.is_nan() { 0.0 } else { along };
    let other_along = ((uv * along + vw) / vv).clamp(0.0, 1.0);
    let along = ((uv * other_along - uw) / uu).clamp(0.0, 1.0);
    [one.at(along), other.at(other_along)]
}

/// Half-way between two points.
pub(crate) fn middle([one, other]: [Vector3<f64>; 2]) -> Vector3<f64> {
    (one + other) / 2.0
}

/// Adds the point where an edge of A crosses one of B, with the overlap across both; or the ends of the stretch that they share, if they are nearly parallel, each with its own depth,
/// and of these what is within the gap.
pub(crate) fn touch(
    one: &Segment,
    other: &Segment,
    &Overlap { normal, depth }: &Overlap,
    feature: FeatureId,
    scale: &Scale,
    found: &mut Vec<ContactPoint>,
) {
    let (u, v) = (one.along(), other.along());
    if u.cross(&v).norm_squared() > STRETCH_SQUARED_SINE * u.norm_squared() * v.norm_squared() {
        found.push(ContactPoint { point: middle(closest(one, other)), depth, feature });
        return;
    }
    let before = found.len();
    let [from, to] = [0, 1].map(|end| one.share_of(&other.0[end]));
    let shares = [from.min(to).clamp(0.0, 1.0), from.max(to).clamp(0.0, 1.0)];
    for (end, share) in (0..).zip(shares) {
        let on_one = one.at(share);
        let on_other = other.at(other.share_of(&on_one).clamp(0.0, 1.0));
        let at_end = normal.dot(&(on_one - on_other));
        let depth = if scale.is_speculative() { scale.rounded(at_end.min(depth)) } else { at_end.clamp(0.0, depth) };
        if scale.separates(depth) {
            continue;
        }
        found.push(ContactPoint { point: (on_one + on_other) / 2.0, depth, feature: feature.end(end) });
    }
    if found.len() == before {
        found.push(ContactPoint { point: middle(closest(one, other)), depth, feature });
    }
}
