//! Where two straight edges touch.

use nalgebra::Vector3;

use super::{ContactPoint, FeatureId};

/// Squared sine of the angle under which two edges touch along a stretch, not in a point.
const NEARLY_PARALLEL: f64 = 1e-5;

/// The ends of an edge.
pub(super) struct Segment(pub [Vector3<f64>; 2]);

impl Segment {
    fn along(&self) -> Vector3<f64> {
        self.0[1] - self.0[0]
    }

    fn at(&self, share: f64) -> Vector3<f64> {
        self.0[0] + self.along() * share
    }

    /// Share of the way at which a point is nearest, beyond the ends too.
    fn share_of(&self, point: &Vector3<f64>) -> f64 {
        let along = self.along();
        (point - self.0[0]).dot(&along) / along.norm_squared()
    }
}

/// Half-way between the closest points of two edges that are not parallel (Ericson 2005, 5.1.9).
pub(super) fn middle_of_closest(one: &Segment, other: &Segment) -> Vector3<f64> {
    let (u, v, w) = (one.along(), other.along(), one.0[0] - other.0[0]);
    let (uu, uv, vv, uw, vw) = (u.dot(&u), u.dot(&v), v.dot(&v), u.dot(&w), v.dot(&w));
    let along = ((uv * vw - uw * vv) / (uu * vv - uv * uv)).clamp(0.0, 1.0);
    let other_along = ((uv * along + vw) / vv).clamp(0.0, 1.0);
    let along = ((uv * other_along - uw) / uu).clamp(0.0, 1.0);
    (one.at(along) + other.at(other_along)) / 2.0
}

/// Adds the point where an edge of A crosses one of B, whose overlap along `normal` is `depth`; or
/// the ends of the stretch that they share, if they are nearly parallel, each with its own depth.
pub(super) fn touch(
    one: &Segment,
    other: &Segment,
    normal: &Vector3<f64>,
    depth: f64,
    feature: FeatureId,
    found: &mut Vec<ContactPoint>,
) {
    let (u, v) = (one.along(), other.along());
    if u.cross(&v).norm_squared() > NEARLY_PARALLEL * u.norm_squared() * v.norm_squared() {
        found.push(ContactPoint { point: middle_of_closest(one, other), depth, feature });
        return;
    }
    let [from, to] = [0, 1].map(|end| one.share_of(&other.0[end]));
    let shares = [from.min(to).clamp(0.0, 1.0), from.max(to).clamp(0.0, 1.0)];
    for (end, share) in (0..).zip(shares) {
        let on_one = one.at(share);
        let on_other = other.at(other.share_of(&on_one).clamp(0.0, 1.0));
        let depth = normal.dot(&(on_one - on_other)).clamp(0.0, depth);
        found.push(ContactPoint { point: (on_one + on_other) / 2.0, depth, feature: feature.end(end) });
    }
}
