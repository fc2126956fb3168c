//! Two convex polyhedra of any kind: [`feature_sat`], then the faces clipped, or the point where
//! two edges cross.

use super::apart;
use super::clipping::{ClipBuffers, clip_to_face};
use super::edge_contact::{Segment, closest};
use super::feature_sat::{self, EdgeBuffers, Feature, Least, Verdict};
use super::polyhedron::{Frame, Polyhedron};
use super::scale::Scale;
use crate::physics::collision::manifold::{FeatureId, Overlap};

/// Tests two polyhedra; what was the last step's axis is tried first and replaced. Contact points
/// are left in the clip buffers, in A's axes.
pub(crate) fn touch(
    a: &impl Polyhedron,
    b: &impl Polyhedron,
    b_in_a: &Frame,
    scale: &Scale,
    last: &mut Option<Feature>,
    edges: &mut EdgeBuffers,
    clip: &mut ClipBuffers,
    axes: &mut u32,
) -> Option<Overlap> {
    let least = match feature_sat::test(a, b, b_in_a, scale, *last, edges, axes) {
        Verdict::Apart(feature) => {
            *last = Some(feature);
            return None;
        }
        Verdict::Near(least) => least,
    };
    *last = Some(least.feature);
    let Least { normal, depth, feature } = least;
    let overlap = Overlap { normal, depth };
    if let Feature::Edges(edge_a, edge_b) = feature {
        let (on_a, on_b) = (a.edge(edge_a as usize), b.edge(edge_b as usize).placed(b_in_a, false));
        let ends = closest(&Segment([on_a.start, on_a.end()]), &Segment([on_b.start, on_b.end()]));
        return apart::crossing(a, b, b_in_a, ends, &overlap, FeatureId::of_edges(edge_a, edge_b), scale, clip);
    }
    let (reference_is_b, face) = feature.face().expect("a polyhedron has faces and edges alone");
    let is_any = clip_to_face(a, b, b_in_a, reference_is_b, face, depth, scale, clip);
    if !is_any && depth < 0.0 {
        return apart::beside(a, b, b_in_a, reference_is_b, &overlap, scale, clip);
    }
    Some(overlap)
}
