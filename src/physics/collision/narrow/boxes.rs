//! Two boxes, the commonest pair: the separating axis test in closed form (Gottschalk 1996;
//! Ericson 2005, 4.4.1) and faces clipped as rectangles.
//!
//! All in A's axes. With R the axes of B, d its centre and h the half extents, the reach of B
//! along axis i of A is Σ |R_ij| h_j, so that all fifteen depths come from R, |R| and d alone:
//! less work than finding last step's axis.

use nalgebra::{Matrix3, Vector3};

use super::{ClipBuffers, Cuboid, Overlap, PairSearch, Plane, Polyhedron, ShapePair};
use crate::physics::collision::constants::PARALLEL_SQUARED_SINE;

/// What the axis of least depth is made of, by axes of the boxes.
#[derive(Clone, Copy)]
enum Axis {
    OfA(usize),
    OfB(usize),
    Edges(usize, usize),
}

/// Two boxes in A's axes.
struct Boxes<'t> {
    pair: &'t ShapePair<'t, Cuboid, Cuboid>,
    /// |R|.
    magnitudes: Matrix3<f64>,
    /// d in B's axes.
    center_in_b: Vector3<f64>,
}

/// Tests two boxes and leaves their contact points in the clip buffers, in A's axes.
pub(crate) fn touch(pair: &ShapePair<Cuboid, Cuboid>, search: &mut PairSearch) -> Option<Overlap> {
    let PairSearch { clip: buffers, axes, apart, .. } = search;
    let b_in_a = pair.b_in_a;
    let center_in_b = b_in_a.enter(&b_in_a.center);
    let boxes = Boxes { pair, magnitudes: b_in_a.rotation.abs(), center_in_b };
    let (depth, axis) = boxes.least_overlap(axes).map_err(|depth| *apart = -depth).ok()?;
    let depth = pair.scale.rounded(depth);
    let normal = boxes.normal(axis);
    let overlap = Overlap { normal, depth };
    let (axis, reference_is_b) = match axis {
        Axis::OfA(axis) => (axis, false),
        Axis::OfB(axis) => (axis, true),
        Axis::Edges(along_a, along_b) => {
            let foremost = [foremost_edge(along_a, &normal), foremost_edge(along_b, &-b_in_a.enter(&normal))];
            return pair.crossing(foremost, &overlap, buffers);
        }
    };
    let out = if reference_is_b { -b_in_a.enter(&normal) } else { normal };
    let is_any = if reference_is_b {
        let is_any = pair.swapped(&b_in_a.inverse()).clip(true, axis, out, depth, buffers);
        buffers.place(b_in_a);
        is_any
    } else {
        pair.clip(false, axis, out, depth, buffers)
    };
    if !is_any && depth < 0.0 {
        let base = if reference_is_b { pair.b } else { pair.a };
        base.corners(face_of(axis, &out), &mut buffers.reference);
        return pair.beside(reference_is_b, &overlap, buffers);
    }
    Some(overlap)
}

impl Boxes<'_> {
    /// The least depth, faces of A before those of B before edges; an error if an axis separates by
    /// more than the gap, with its depth.
    fn least_overlap(&self, axes: &mut u32) -> Result<(f64, Axis), f64> {
        let &ShapePair { a, b, b_in_a, scale } = self.pair;
        let (a, b) = (&a.half, &b.half);
        let of_a = a + self.magnitudes * b - b_in_a.center.abs();
        let face_a = of_a.imin();
        *axes += 3;
        let of_b = b + self.magnitudes.tr_mul(a) - self.center_in_b.abs();
        let face_b = of_b.imin();
        *axes += 3;
        // The farther they are found to be, the longer nobody need look again.
        let of_faces = of_a[face_a].min(of_b[face_b]);
        if scale.separates(of_faces) {
            return Err(of_faces);
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
                let [u, v] = others(along_a).map(|side| b_in_a.rotation[(side, along_b)]);
                let squared_sine = u * u + v * v;
                if squared_sine < PARALLEL_SQUARED_SINE {
                    continue;
                }
                let depth = depth / squared_sine.sqrt();
                if scale.separates(depth) {
                    return Err(depth);
                }
                if depth < limit {
                    limit = depth;
                    least = (depth, Axis::Edges(along_a, along_b));
                }
            }
        }
        Ok(least)
    }

    /// The depth across an edge of each, times the sine of the angle between them.
    fn edge_overlap(&self, along_a: usize, along_b: usize) -> f64 {
        let &ShapePair { a, b, b_in_a, .. } = self.pair;
        let (a, b) = (&a.half, &b.half);
        let (r, m, d) = (&b_in_a.rotation, &self.magnitudes, &b_in_a.center);
        let [u, v] = others(along_a);
        let [p, q] = others(along_b);
        let reach_a = a[u] * m[(v, along_b)] + a[v] * m[(u, along_b)];
        let reach_b = b[p] * m[(along_a, q)] + b[q] * m[(along_a, p)];
        let apart = d[v] * r[(u, along_b)] - d[u] * r[(v, along_b)];
        reach_a + reach_b - apart.abs()
    }

    /// From A to B.
    fn normal(&self, axis: Axis) -> Vector3<f64> {
        let b_in_a = self.pair.b_in_a;
        let toward = |axis: Vector3<f64>| if axis.dot(&b_in_a.center) < 0.0 { -axis } else { axis };
        let unit = |axis: usize| Vector3::from_fn(|row, _| f64::from(u8::from(row == axis)));
        match axis {
            Axis::OfA(axis) => toward(unit(axis)),
            Axis::OfB(axis) => toward(b_in_a.rotation.column(axis).into_owned()),
            Axis::Edges(along_a, along_b) => toward(unit(along_a).cross(&b_in_a.rotation.column(along_b)).normalize()),
        }
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

impl ShapePair<'_, Cuboid, Cuboid> {
    /// Clips the face of B that is most against the face of A across `axis`, which looks along `normal`, in a pair that
    /// may have been swapped. False if nothing is over that.
    fn clip(&self, of_b: bool, axis: usize, normal: Vector3<f64>, depth: f64, buffers: &mut ClipBuffers) -> bool {
        let (half, face) = (&self.a.half, face_of(axis, &normal) as u32);
        let clip = self.clip_of(of_b, face, Plane { normal, offset: half[axis] }, depth, buffers);
        clip.clip_to_rectangle(axis, half, buffers)
    }
}
