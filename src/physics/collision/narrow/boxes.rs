//! Two boxes, the commonest pair: the separating axis test in closed form (Gottschalk 1996;
//! Ericson 2005, 4.4.1) and faces clipped as rectangles.
//!
//! All in A's axes. With R the axes of B, d its centre and h the half extents, the reach of B
//! along axis i of A is Σ |R_ij| h_j, so that all fifteen depths come from R, |R| and d alone:
//! less work than finding last step's axis.

use nalgebra::{Matrix3, Vector3};

use super::apart;
use super::clipping::{Clip, ClipBuffers, Faced};
use super::edge_contact::{Segment, closest};
use super::polyhedron::{Cuboid, Frame, Polyhedron};
use super::scale::Scale;
use crate::physics::collision::constants::PARALLEL_SQUARED_SINE;
use crate::physics::collision::manifold::{FeatureId, Overlap};

/// What the axis of least depth is made of, by axes of the boxes.
#[derive(Clone, Copy)]
enum Axis {
    OfA(usize),
    OfB(usize),
    Edges(usize, usize),
}

/// Two boxes in A's axes.
struct Boxes<'t> {
    a: Cuboid,
    b: Cuboid,
    b_in_a: &'t Frame,
    /// |R|.
    magnitudes: Matrix3<f64>,
    /// d in B's axes.
    center_in_b: Vector3<f64>,
}

/// Tests two boxes of those half extents and adds their contact points, in A's axes.
pub(crate) fn touch(
    half_a: &Vector3<f64>,
    half_b: &Vector3<f64>,
    b_in_a: &Frame,
    scale: &Scale,
    buffers: &mut ClipBuffers,
    axes: &mut u32,
) -> Option<Overlap> {
    let boxes = Boxes {
        a: Cuboid { half: *half_a },
        b: Cuboid { half: *half_b },
        b_in_a,
        magnitudes: b_in_a.rotation.abs(),
        center_in_b: b_in_a.enter(&b_in_a.center),
    };
    let (depth, axis) = boxes.least_overlap(scale, axes)?;
    let depth = scale.rounded(depth);
    let normal = boxes.normal(axis);
    let overlap = Overlap { normal, depth };
    let (a, b) = (&boxes.a, &boxes.b);
    let (axis, reference_is_b) = match axis {
        Axis::OfA(axis) => (axis, false),
        Axis::OfB(axis) => (axis, true),
        Axis::Edges(along_a, along_b) => return boxes.cross_edges(along_a, along_b, &overlap, scale, buffers),
    };
    let out = if reference_is_b { -b_in_a.enter(&normal) } else { normal };
    let is_any = if reference_is_b {
        let is_any = clip(b, a, &b_in_a.inverse(), true, axis, &out, depth, scale, buffers);
        for found in &mut buffers.found {
            found.point = b_in_a.place(&found.point);
        }
        is_any
    } else {
        clip(a, b, b_in_a, false, axis, &out, depth, scale, buffers)
    };
    if !is_any && depth < 0.0 {
        let base = if reference_is_b { b } else { a };
        base.corners(face_of(axis, &out), &mut buffers.reference);
        return apart::beside(a, b, b_in_a, reference_is_b, &overlap, scale, buffers);
    }
    Some(overlap)
}

impl Boxes<'_> {
    /// The least depth, faces of A before those of B before edges; none if an axis separates by
    /// more than the gap.
    fn least_overlap(&self, scale: &Scale, axes: &mut u32) -> Option<(f64, Axis)> {
        let (a, b) = (&self.a.half, &self.b.half);
        let of_a = a + self.magnitudes * b - self.b_in_a.center.abs();
        let face_a = of_a.imin();
        *axes += 3;
        if scale.separates(of_a[face_a]) {
            return None;
        }
        let of_b = b + self.magnitudes.tr_mul(a) - self.center_in_b.abs();
        let face_b = of_b.imin();
        *axes += 3;
        if scale.separates(of_b[face_b]) {
            return None;
        }
        let mut least = (of_a[face_a], Axis::OfA(face_a));
        if of_b[face_b] < scale.limit(least.0) {
            least = (of_b[face_b], Axis::OfB(face_b));
        }
        *axes += 9;
        let mut limit = scale.limit(least.0);
        for along_a in 0..3 {
            for along_b in 0..3 {
                let depth = self.edge_overlap(along_a, along_b);
                // So far times the sine of the angle between the edges, which is at most 1.
                if depth >= limit.max(0.0) {
                    continue;
                }
                let [u, v] = others(along_a).map(|side| self.b_in_a.rotation[(side, along_b)]);
                let squared_sine = u * u + v * v;
                if squared_sine < PARALLEL_SQUARED_SINE {
                    continue;
                }
                let depth = depth / squared_sine.sqrt();
                if scale.separates(depth) {
                    return None;
                }
                if depth < limit {
                    limit = depth;
                    least = (depth, Axis::Edges(along_a, along_b));
                }
            }
        }
        Some(least)
    }

    /// The depth across an edge of each, times the sine of the angle between them.
    fn edge_overlap(&self, along_a: usize, along_b: usize) -> f64 {
        let (a, b) = (&self.a.half, &self.b.half);
        let (r, m, d) = (&self.b_in_a.rotation, &self.magnitudes, &self.b_in_a.center);
        let [u, v] = others(along_a);
        let [p, q] = others(along_b);
        let reach_a = a[u] * m[(v, along_b)] + a[v] * m[(u, along_b)];
        let reach_b = b[p] * m[(along_a, q)] + b[q] * m[(along_a, p)];
        let apart = d[v] * r[(u, along_b)] - d[u] * r[(v, along_b)];
        reach_a + reach_b - apart.abs()
    }

    /// From A to B.
    fn normal(&self, axis: Axis) -> Vector3<f64> {
        let toward = |axis: Vector3<f64>| if axis.dot(&self.b_in_a.center) < 0.0 { -axis } else { axis };
        let unit = |axis: usize| Vector3::from_fn(|row, _| f64::from(u8::from(row == axis)));
        match axis {
            Axis::OfA(axis) => toward(unit(axis)),
            Axis::OfB(axis) => toward(self.b_in_a.rotation.column(axis).into_owned()),
            Axis::Edges(along_a, along_b) => {
                toward(unit(along_a).cross(&self.b_in_a.rotation.column(along_b)).normalize())
            }
        }
    }

    /// Leaves the point half-way between the foremost edges along the normal.
    fn cross_edges(
        &self,
        along_a: usize,
        along_b: usize,
        overlap: &Overlap,
        scale: &Scale,
        buffers: &mut ClipBuffers,
    ) -> Option<Overlap> {
        let normal = &overlap.normal;
        let on_a = self.a.edge(foremost_edge(along_a, normal));
        let on_b = self.b.edge(foremost_edge(along_b, &-self.b_in_a.enter(normal))).placed(self.b_in_a, false);
        let ends = closest(&Segment([on_a.start, on_a.end()]), &Segment([on_b.start, on_b.end()]));
        let feature = FeatureId::of_edges(on_a.index, on_b.index);
        apart::crossing(&self.a, &self.b, self.b_in_a, ends, overlap, feature, scale, buffers)
    }
}

fn others(axis: usize) -> [usize; 2] {
    [(axis + 1) % 3, (axis + 2) % 3]
}

/// Number of a box's edge along an axis that reaches farthest along a direction.
fn foremost_edge(along: usize, direction: &Vector3<f64>) -> usize {
    let [u, v] = others(along).map(|side| usize::from(direction[side] < 0.0));
    along << 2 | u << 1 | v
}

/// The face across an axis that looks along a normal.
fn face_of(axis: usize, normal: &Vector3<f64>) -> usize {
    2 * axis + usize::from(normal[axis] < 0.0)
}

/// Clips the face of `other` that is most against the face of `base` across `axis`, which looks
/// along `normal`. All in the axes of `base`. False if nothing is over that.
fn clip(
    base: &Cuboid,
    other: &Cuboid,
    other_in_base: &Frame,
    base_is_b: bool,
    axis: usize,
    normal: &Vector3<f64>,
    depth: f64,
    scale: &Scale,
    buffers: &mut ClipBuffers,
) -> bool {
    let incident_face = other.incident(&-other_in_base.enter(normal), &mut buffers.incident);
    for corner in &mut buffers.incident {
        *corner = other_in_base.place(corner);
    }
    let clip = Clip {
        reference_is_b: base_is_b,
        reference_face: face_of(axis, normal) as u32,
        incident_face,
        normal: *normal,
        level: base.half[axis],
        depth,
        scale,
    };
    clip.clip_to_rectangle(axis, &base.half, buffers)
}
