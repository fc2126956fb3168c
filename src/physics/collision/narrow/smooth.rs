//! A triangle of a mesh that is smooth about it against a polyhedron.
//!
//! Whatever touches there is pushed nearly along the triangle's own normal, and that is taken. So no other axis need be
//! measured: the overlap is how far the polyhedron reaches below the triangle's plane, and the contact points are what of its
//! lowest face is over the triangle. A polyhedron that hangs over a side has the points of that side from both triangles, each
//! with its own normal, where the exact test finds one normal between them.

use nalgebra::Vector3;

use super::clipping::Faced;
use super::{Convex, Feature, Overlap, PairSearch, Plane, Polyhedron, ShapePair};
use crate::physics::shape::Triangle;

/// Gap, as a share of the size, from which on all points within it count. *speed*, `trees`.
const WIDE_GAP: f64 = 0.25;

/// A triangle about its middle.
pub(super) struct Front<'t>(pub Triangle<'t>);

impl Convex for Front<'_> {
    fn reach(&self, direction: &Vector3<f64>) -> f64 {
        self.0.corners.iter().map(|corner| corner.dot(direction)).fold(f64::NEG_INFINITY, f64::max)
    }

    fn inner_radius(&self) -> f64 {
        0.0
    }
}

impl Faced for Front<'_> {
    fn reference(&self, _: u32, corners: &mut Vec<Vector3<f64>>) -> Plane {
        corners.clear();
        corners.extend(self.0.corners);
        Plane { normal: self.0.normal, offset: 0.0 }
    }

    fn incident(&self, _: &Vector3<f64>, corners: &mut Vec<Vector3<f64>>) -> u32 {
        corners.clear();
        corners.extend(self.0.corners);
        0
    }
}

/// Tests a smooth triangle and a polyhedron, placed in the triangle's axes about its middle, whose overlap along the normal is
/// known; leaves the points where they touch in the clip buffers.
pub(super) fn touch<B: Polyhedron>(pair: &ShapePair<Front, B>, depth: f64, search: &mut PairSearch) -> Option<Overlap> {
    let Triangle { corners, normal, .. } = pair.a.0;
    for from in 0..3 {
        let outward = (corners[(from + 1) % 3] - corners[from]).cross(&normal).normalize();
        let beside = outward.dot(&(pair.b_in_a.center - corners[from])) - pair.b.reach(&-pair.b_in_a.enter(&outward));
        if pair.scale.separates(-beside) {
            search.apart = beside;
            return None;
        }
    }
    search.last = Some(Feature::FaceOfA(0));
    if search.any_normal {
        return Some(Overlap { normal, depth: pair.scale.rounded(depth) });
    }
    // Of what is below the plane over other triangles, what hovers over this one does not count, unless it comes so fast that
    // it may be stopped there and strike here in the same step.
    let is_wide = pair.scale.gap > WIDE_GAP * pair.scale.size;
    let depth = if is_wide { -pair.scale.gap } else { pair.scale.rounded(depth) };
    let is_any = pair.clip_to_face(false, 0, depth, &mut search.clip);
    let deepest = search.clip.found.iter().map(|point| point.depth).fold(f64::NEG_INFINITY, f64::max);
    is_any.then_some(Overlap { normal, depth: deepest })
}
