//! Clipped contacts: takes a pair of shapes to the routine for their kinds, in the body axes of
//! one of them, and the points back to the world.
//!
//! | | |
//! | --- | --- |
//! | [`plane`] | a half-space and anything |
//! | [`ball`] | a ball and anything |
//! | [`capsule`] | a capsule and anything but a ball |
//! | [`boxes`] | two boxes |
//! | [`feature_sat`] | boxes and hulls |
//! | [`cone_polyhedron`] | a cone and a box or hull |
//! | [`cone_cone`] | two cones |
//! | [`facet`] | a facet of a mesh and anything |
//!
//! All take a *gap*: shapes apart by no more than that get points as well, and shapes that touch
//! get those of their facing features that stand off by no more, with negative depths
//! ([speculative contacts](ContactPoint::depth)). The separation of the manifold is at most the
//! distance of the shapes, and equal to it wherever a face, a ball or a crossing of edges is
//! nearest; where corners and edges pass beside each other see [`apart`](super::apart).

use nalgebra::{Matrix3, Vector3};

use super::clipping::keep_touching_spread;
pub(crate) use super::feature_sat::PairSearch;
use super::{
    Cone, Cuboid, Frame, Overlap, Scale, ShapePair, ball, boxes, capsule, cone_cone, cone_polyhedron, facet,
    feature_sat, plane,
};
use crate::physics::collision::manifold::PartPair;
use crate::physics::collision::parts::{PartShape, Placed};
use crate::physics::{Body, ContactPoint, Geometry};

/// Adds the contact points of two bodies in world axes, of those parts if they have any, if they touch or are apart by no
/// more than the gap, m. With a gap of zero no depth is negative. Of what is farther apart, leaves in `search.apart` by how
/// much at least.
pub(crate) fn touch(
    [a, b]: [&Body; 2],
    parts: PartPair,
    gap: f64,
    search: &mut PairSearch,
    points: &mut Vec<ContactPoint>,
) -> Option<Overlap> {
    let rank = |placed: &Placed| match placed.shape {
        PartShape::Solid(Geometry::HalfSpace) => 0,
        PartShape::Facet(..) => 1,
        PartShape::Solid(Geometry::Cone { .. }) => 2,
        PartShape::Solid(Geometry::Cuboid { .. } | Geometry::Hull(_) | Geometry::Parts(_)) => 3,
        PartShape::Solid(Geometry::Capsule { .. }) => 4,
        PartShape::Solid(Geometry::Sphere { .. }) => 5,
    };
    search.apart = gap;
    let [a, b] = [Placed::of(a, parts.a)?, Placed::of(b, parts.b)?];
    // Half-spaces come first, then facets and cones, and what is round about a point or a segment last.
    if rank(&a) <= rank(&b) {
        touch_ranked(&a, &b, gap, search, points)
    } else {
        let overlap = touch_ranked(&b, &a, gap, search, points)?;
        Some(Overlap { normal: -overlap.normal, ..overlap })
    }
}

fn touch_ranked(
    a: &Placed,
    b: &Placed,
    gap: f64,
    search: &mut PairSearch,
    points: &mut Vec<ContactPoint>,
) -> Option<Overlap> {
    let PartShape::Solid(shape_b) = b.shape else { return None };
    let first = points.len();
    if let (PartShape::Solid(shape_a @ Geometry::Sphere { .. }), Geometry::Sphere { radius }) = (&a.shape, shape_b) {
        // Balls are the same in all axes: in those of the world nothing need be turned.
        let b_in_a = &Frame { rotation: Matrix3::identity(), center: b.position - a.position };
        let overlap = ball::touch(shape_a, a.radius, *radius, b_in_a, gap, &mut search.apart, points)?;
        points[first..].iter_mut().for_each(|found| found.point += a.position);
        return Some(overlap);
    }
    let [axes_a, axes_b] = [a, b].map(|placed| placed.rotation.to_rotation_matrix().into_inner());
    let b_in_a = &Frame { rotation: axes_a.tr_mul(&axes_b), center: axes_a.tr_mul(&(b.position - a.position)) };
    let overlap = match &a.shape {
        PartShape::Facet(mesh, facet) => facet::touch((mesh, *facet), shape_b, b.radius, b_in_a, gap, search, points)?,
        PartShape::Solid(shape_a) => {
            touch_solids([shape_a, shape_b], [a.radius, b.radius], b_in_a, gap, search, points)?
        }
    };
    for found in &mut points[first..] {
        found.point = axes_a * found.point + a.position;
    }
    Some(Overlap { normal: axes_a * overlap.normal, ..overlap })
}

/// Two solids, B placed in A's axes; leaves points in these.
fn touch_solids(
    [shape_a, shape_b]: [&Geometry; 2],
    [radius_a, radius_b]: [f64; 2],
    b_in_a: &Frame,
    gap: f64,
    search: &mut PairSearch,
    points: &mut Vec<ContactPoint>,
) -> Option<Overlap> {
    match (shape_a, shape_b) {
        (_, Geometry::Capsule { radius, half, .. }) => {
            capsule::touch(shape_a, radius_a, [*radius, *half], b_in_a, gap, &mut search.apart, points)
        }
        (Geometry::HalfSpace, _) => {
            plane::touch(shape_b, radius_b, b_in_a, gap, &mut search.clip, &mut search.apart, points)
        }
        (_, Geometry::Sphere { radius }) => {
            ball::touch(shape_a, radius_a, *radius, b_in_a, gap, &mut search.apart, points)
        }
        _ => {
            let scale = &Scale::new(radius_a, radius_b, gap);
            macro_rules! tested {
                ($touch:path, $a:expr, $b:expr) => {
                    $touch(&ShapePair { a: $a, b: $b, b_in_a, scale }, search)?
                };
            }
            let cuboid = |half: &Vector3<f64>| Cuboid { half: *half };
            let overlap = match (shape_a, shape_b) {
                (Geometry::Cone { radius, height, .. }, _) => {
                    let cone = Cone::new(*radius, *height);
                    match shape_b {
                        Geometry::Cone { radius, height, .. } => {
                            tested!(cone_cone::touch, &cone, &Cone::new(*radius, *height))
                        }
                        Geometry::Cuboid { half } => tested!(cone_polyhedron::touch, &cone, &cuboid(half)),
                        Geometry::Hull(b) => tested!(cone_polyhedron::touch, &cone, &**b),
                        _ => unreachable!("ranked"),
                    }
                }
                (Geometry::Cuboid { half: a }, Geometry::Cuboid { half: b }) => {
                    tested!(boxes::touch, &cuboid(a), &cuboid(b))
                }
                (Geometry::Cuboid { half }, Geometry::Hull(b)) => tested!(feature_sat::touch, &cuboid(half), &**b),
                (Geometry::Hull(a), Geometry::Cuboid { half }) => tested!(feature_sat::touch, &**a, &cuboid(half)),
                (Geometry::Hull(a), Geometry::Hull(b)) => tested!(feature_sat::touch, &**a, &**b),
                _ => unreachable!("ranked"),
            };
            keep_touching_spread(&mut search.clip.found, &overlap.normal, scale.size, points);
            Some(overlap)
        }
    }
}
