//! Two convex polyhedra of any kind: [`feature_sat`], then the faces clipped, or the point where
//! two edges cross.

use super::apart;
use super::clipping::{Clip, ClipBuffers};
use super::edge_contact::{Segment, closest, middle};
use super::feature_sat::{self, EdgeBuffers, Feature, Least, Verdict};
use super::polyhedron::{Frame, Polyhedron};
use super::scale::Scale;
use crate::physics::collision::manifold::{ContactPoint, FeatureId, Overlap};

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
    match feature {
        Feature::FaceOfA(face) => {
            let is_any = clip_faces(a, b, b_in_a, false, face, depth, scale, clip);
            if !is_any && depth < 0.0 {
                return apart::beside(a, b, b_in_a, false, &overlap, scale, clip);
            }
        }
        Feature::FaceOfB(face) => {
            let is_any = clip_faces(b, a, &b_in_a.inverse(), true, face, depth, scale, clip);
            for found in &mut clip.found {
                found.point = b_in_a.place(&found.point);
            }
            if !is_any && depth < 0.0 {
                return apart::beside(a, b, b_in_a, true, &overlap, scale, clip);
            }
        }
        Feature::Edges(edge_a, edge_b) => {
            let (on_a, on_b) = (a.edge(edge_a as usize), b.edge(edge_b as usize).placed(b_in_a, false));
            let ends = closest(&Segment([on_a.start, on_a.end()]), &Segment([on_b.start, on_b.end()]));
            let overlap = apart::along(a, b, b_in_a, ends, &overlap, scale)?;
            let feature = FeatureId::of_edges(edge_a, edge_b);
            clip.found.clear();
            clip.found.push(ContactPoint { point: middle(ends), depth: overlap.depth, feature });
            return Some(overlap);
        }
        Feature::Smooth(_) => unreachable!("of cones only"),
    }
    Some(overlap)
}

/// Clips the face of `other` that is most against a face of `base`, in the axes of `base`. False
/// if nothing is over that.
fn clip_faces(
    base: &impl Polyhedron,
    other: &impl Polyhedron,
    other_in_base: &Frame,
    base_is_b: bool,
    face: u32,
    depth: f64,
    scale: &Scale,
    buffers: &mut ClipBuffers,
) -> bool {
    let plane = base.face(face as usize);
    base.corners(face as usize, &mut buffers.reference);
    let incident = other.face_toward(&-other_in_base.enter(&plane.normal));
    other.corners(incident, &mut buffers.incident);
    for corner in &mut buffers.incident {
        *corner = other_in_base.place(corner);
    }
    let clip = Clip {
        reference_is_b: base_is_b,
        reference_face: face,
        incident_face: incident as u32,
        normal: plane.normal,
        level: plane.offset,
        depth,
        scale,
    };
    clip.clip(buffers)
}
