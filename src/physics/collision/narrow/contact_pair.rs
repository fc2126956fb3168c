//! Clipped contacts: takes a pair of shapes to the routine for their kinds, in the body axes of
//! one of them, and the points back to the world.
//!
//! | | |
//! | --- | --- |
//! | [`plane`] | a half-space and anything |
//! | [`ball`] | a ball and anything |
//! | [`boxes`] | two boxes |
//! | [`polyhedra`] | boxes and hulls |
//! | [`cone_polyhedron`] | a cone and a box or hull |
//! | [`cone_cone`] | two cones |
//!
//! All take a *gap*: shapes apart by no more than that get points as well, and shapes that touch
//! get those of their facing features that stand off by no more, with negative depths
//! ([speculative contacts](ContactPoint::depth)). The separation of the manifold is at most the
//! distance of the shapes, and equal to it wherever a face, a ball or a crossing of edges is
//! nearest; where corners and edges pass beside each other see [`apart`](super::apart).

use nalgebra::Vector3;

use super::clipping::{ClipBuffers, keep_touching_spread};
use super::cone::Cone;
use super::feature_sat::{EdgeBuffers, Feature};
use super::polyhedron::{Cuboid, Frame};
use super::scale::Scale;
use super::{ball, boxes, cone_cone, cone_polyhedron, plane, polyhedra};
use crate::physics::body::Body;
use crate::physics::collision::manifold::{ContactPoint, Overlap};
use crate::physics::shape::Geometry;

/// What one pair's test needs and leaves: buffers, and the axis that next step's test begins with.
#[derive(Default)]
pub(crate) struct PairSearch {
    edges: EdgeBuffers,
    clip: ClipBuffers,
    /// The axis of the last step, then that of this one.
    pub(crate) last: Option<Feature>,
    /// Axes measured so far.
    pub axes: u32,
}

/// Adds the contact points of two bodies in world axes, if they touch or are apart by no more than
/// the gap, m. With a gap of zero no depth is negative.
pub(crate) fn touch(
    a: &Body,
    b: &Body,
    gap: f64,
    search: &mut PairSearch,
    points: &mut Vec<ContactPoint>,
) -> Option<Overlap> {
    let rank = |geometry: &Geometry| match geometry {
        Geometry::HalfSpace => 0,
        Geometry::Cone { .. } => 1,
        Geometry::Cuboid { .. } | Geometry::Hull(_) => 2,
        Geometry::Sphere { .. } => 3,
    };
    // Half-spaces come first, then cones, and balls last.
    if rank(a.geometry.as_ref()?) <= rank(b.geometry.as_ref()?) {
        touch_ranked(a, b, gap, search, points)
    } else {
        let overlap = touch_ranked(b, a, gap, search, points)?;
        Some(Overlap { normal: -overlap.normal, ..overlap })
    }
}

fn touch_ranked(
    a: &Body,
    b: &Body,
    gap: f64,
    search: &mut PairSearch,
    points: &mut Vec<ContactPoint>,
) -> Option<Overlap> {
    let (shape_a, shape_b) = (a.geometry.as_ref()?, b.geometry.as_ref()?);
    let [axes_a, axes_b] = [a, b].map(|body| body.rotation.to_rotation_matrix().into_inner());
    let b_in_a = Frame { rotation: axes_a.tr_mul(&axes_b), center: axes_a.tr_mul(&(b.position - a.position)) };
    let first = points.len();
    let PairSearch { edges, clip, last, axes } = search;
    let overlap = match (shape_a, shape_b) {
        (Geometry::HalfSpace, _) => plane::touch(shape_b, b.radius, &b_in_a, gap, clip, points)?,
        (_, Geometry::Sphere { radius }) => ball::touch(shape_a, a.radius, *radius, &b_in_a, gap, points)?,
        _ => {
            let scale = &Scale::new(a.radius, b.radius, gap);
            let overlap = match (shape_a, shape_b) {
                (Geometry::Cone { radius, height, .. }, Geometry::Cone { radius: radius_b, height: height_b, .. }) => {
                    let (cone, other) = (Cone::new(*radius, *height), Cone::new(*radius_b, *height_b));
                    cone_cone::touch(&cone, &other, &b_in_a, scale, last, clip, axes)?
                }
                (Geometry::Cone { radius, height, .. }, Geometry::Cuboid { half }) => {
                    let (cone, cuboid) = (Cone::new(*radius, *height), Cuboid { half: *half });
                    cone_polyhedron::touch(&cone, &cuboid, &b_in_a, scale, last, &mut edges.a, clip, axes)?
                }
                (Geometry::Cone { radius, height, .. }, Geometry::Hull(hull)) => {
                    let cone = Cone::new(*radius, *height);
                    cone_polyhedron::touch(&cone, &**hull, &b_in_a, scale, last, &mut edges.a, clip, axes)?
                }
                (Geometry::Cuboid { half }, Geometry::Cuboid { half: half_b }) => {
                    boxes::touch(half, half_b, &b_in_a, scale, clip, axes)?
                }
                (Geometry::Cuboid { half }, Geometry::Hull(hull)) => {
                    polyhedra::touch(&Cuboid { half: *half }, &**hull, &b_in_a, scale, last, edges, clip, axes)?
                }
                (Geometry::Hull(hull), Geometry::Cuboid { half }) => {
                    polyhedra::touch(&**hull, &Cuboid { half: *half }, &b_in_a, scale, last, edges, clip, axes)?
                }
                (Geometry::Hull(hull), Geometry::Hull(other)) => {
                    polyhedra::touch(&**hull, &**other, &b_in_a, scale, last, edges, clip, axes)?
                }
                _ => unreachable!("ranked"),
            };
            keep_touching_spread(&mut clip.found, &overlap.normal, scale.size, points);
            overlap
        }
    };
    let to_world = |point: &Vector3<f64>| axes_a * point + a.position;
    for found in &mut points[first..] {
        found.point = to_world(&found.point);
    }
    Some(Overlap { normal: axes_a * overlap.normal, ..overlap })
}
