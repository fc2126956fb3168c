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
//! | [`revolved_polyhedron`] | a cone or cylinder and a box or hull |
//! | [`cone_cone`] | two cones |
//! | [`cylinder_revolved`] | a cylinder and a cylinder or cone |
//! | [`facet`] | a facet of a mesh and anything |
//!
//! All take a *gap*: shapes apart by no more than that get points as well, and shapes that touch
//! get those of their facing features that stand off by no more, with negative depths
//! ([speculative contacts](ContactPoint::depth)). The separation of the manifold is at most the
//! distance of the shapes, and equal to it wherever a face, a ball or a crossing of edges is
//! nearest; where corners and edges pass beside each other see [`apart`](super::apart).

use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use super::clipping::keep_touching_spread;
pub(crate) use super::feature_sat::PairSearch;
use super::{
    Cone, Cuboid, Cylinder, Frame, Overlap, Scale, ShapePair, ball, boxes, capsule, cone_cone, cylinder_revolved,
    facet, feature_sat, plane, revolved_polyhedron,
};
use crate::physics::collision::manifold::PartPair;
use crate::physics::collision::parts::{PartShape, Placed};
use crate::physics::shape::Triangles;
use crate::physics::{Body, ContactPoint, Geometry};

/// A solid where it is.
#[derive(Clone, Copy)]
struct Solid<'t> {
    shape: &'t Geometry,
    radius: f64,
    position: &'t Vector3<f64>,
    rotation: &'t UnitQuaternion<f64>,
}

/// Adds the contact points of two bodies in world axes, of those parts if they have any, if they touch or are apart by no
/// more than the gap, m. With a gap of zero no depth is negative. Of what is farther apart, leaves in `search.apart` by how
/// much at least.
pub(crate) fn touch(
    bodies: [&Body; 2],
    parts: PartPair,
    gap: f64,
    search: &mut PairSearch,
    points: &mut Vec<ContactPoint>,
) -> Option<Overlap> {
    search.apart = gap;
    let [a, b] = bodies;
    let (shape_a, shape_b) = (a.geometry.as_ref()?, b.geometry.as_ref()?);
    if matches!(shape_a, Geometry::Parts(_)) || matches!(shape_b, Geometry::Parts(_)) {
        return touch_parts(bodies, parts, gap, search, points);
    }
    fn solid<'t>(body: &'t Body, shape: &'t Geometry) -> Solid<'t> {
        Solid { shape, radius: body.radius, position: &body.position, rotation: &body.rotation }
    }
    touch_solids(solid(a, shape_a), solid(b, shape_b), gap, search, points)
}

/// Where one of the bodies has parts. Kept apart, so that others have the registers to themselves.
#[inline(never)]
fn touch_parts(
    [a, b]: [&Body; 2],
    parts: PartPair,
    gap: f64,
    search: &mut PairSearch,
    points: &mut Vec<ContactPoint>,
) -> Option<Overlap> {
    let (a, b) = (&Placed::of(a, parts.a)?, &Placed::of(b, parts.b)?);
    fn solid<'t>(placed: &'t Placed, shape: &'t Geometry) -> Solid<'t> {
        Solid { shape, radius: placed.radius, position: &placed.position, rotation: &placed.rotation }
    }
    match (&a.shape, &b.shape) {
        (PartShape::Solid(of_a), PartShape::Solid(of_b)) => {
            touch_solids(solid(a, of_a), solid(b, of_b), gap, search, points)
        }
        (PartShape::Facet(mesh, facet), PartShape::Solid(of_b)) => {
            touch_facet((mesh, *facet, a), &solid(b, of_b), gap, search, points)
        }
        (PartShape::Solid(of_a), PartShape::Facet(mesh, facet)) => {
            let overlap = touch_facet((mesh, *facet, b), &solid(a, of_a), gap, search, points)?;
            Some(Overlap { normal: -overlap.normal, ..overlap })
        }
        (PartShape::Facet(..), PartShape::Facet(..)) => None,
    }
}

/// A facet of a mesh that is placed there, and a solid; the normal points out of the facet.
fn touch_facet(
    (mesh, facet, placed): (&Triangles, u32, &Placed),
    solid: &Solid,
    gap: f64,
    search: &mut PairSearch,
    points: &mut Vec<ContactPoint>,
) -> Option<Overlap> {
    if matches!(solid.shape, Geometry::HalfSpace) {
        return None;
    }
    let first = points.len();
    let [axes, axes_of_solid] = [&placed.rotation, solid.rotation].map(|turn| turn.to_rotation_matrix().into_inner());
    let solid_in_mesh =
        &Frame { rotation: axes.tr_mul(&axes_of_solid), center: axes.tr_mul(&(solid.position - placed.position)) };
    let overlap = facet::touch((mesh, facet), solid.shape, solid.radius, solid_in_mesh, gap, search, points)?;
    for found in &mut points[first..] {
        found.point = axes * found.point + placed.position;
    }
    Some(Overlap { normal: axes * overlap.normal, ..overlap })
}

fn touch_solids(
    a: Solid,
    b: Solid,
    gap: f64,
    search: &mut PairSearch,
    points: &mut Vec<ContactPoint>,
) -> Option<Overlap> {
    let rank = |solid: &Solid| match solid.shape {
        Geometry::HalfSpace => 0,
        Geometry::Cylinder { .. } => 1,
        Geometry::Cone { .. } => 2,
        Geometry::Cuboid { .. } | Geometry::Hull(_) | Geometry::Parts(_) => 3,
        Geometry::Capsule { .. } => 4,
        Geometry::Sphere { .. } => 5,
    };
    // Half-spaces come first, then cylinders and cones, and what is round about a point or a segment last.
    if rank(&a) <= rank(&b) {
        touch_ranked(&a, &b, gap, search, points)
    } else {
        let overlap = touch_ranked(&b, &a, gap, search, points)?;
        Some(Overlap { normal: -overlap.normal, ..overlap })
    }
}

fn touch_ranked(
    a: &Solid,
    b: &Solid,
    gap: f64,
    search: &mut PairSearch,
    points: &mut Vec<ContactPoint>,
) -> Option<Overlap> {
    let (shape_a, shape_b) = (a.shape, b.shape);
    let first = points.len();
    let scale = &Scale::new(a.radius, b.radius, gap).exact(search.is_exact).keeping_faces(search.keeps_faces);
    if let (Geometry::Sphere { .. }, Geometry::Sphere { radius }) = (shape_a, shape_b) {
        // Balls are the same in all axes: in those of the world nothing need be turned.
        let b_in_a = &Frame { rotation: Matrix3::identity(), center: b.position - a.position };
        let overlap = ball::touch(shape_a, *radius, b_in_a, scale, &mut search.apart, points)?;
        points[first..].iter_mut().for_each(|found| found.point += a.position);
        return Some(overlap);
    }
    let [axes_a, axes_b] = [a, b].map(|solid| solid.rotation.to_rotation_matrix().into_inner());
    let b_in_a = &Frame { rotation: axes_a.tr_mul(&axes_b), center: axes_a.tr_mul(&(b.position - a.position)) };
    let overlap = match (shape_a, shape_b) {
        (_, Geometry::Capsule { radius, half, .. }) => {
            capsule::touch(shape_a, a.radius, [*radius, *half], b_in_a, scale, &mut search.apart, points)?
        }
        (Geometry::HalfSpace, _) => plane::touch(shape_b, b_in_a, scale, &mut search.clip, &mut search.apart, points)?,
        (_, Geometry::Sphere { radius }) => ball::touch(shape_a, *radius, b_in_a, scale, &mut search.apart, points)?,
        _ => {
            macro_rules! tested {
                ($touch:path, $a:expr, $b:expr) => {
                    $touch(&ShapePair { a: $a, b: $b, b_in_a, scale }, search)?
                };
            }
            let cuboid = |half: &Vector3<f64>| Cuboid { half: *half };
            let overlap = match (shape_a, shape_b) {
                (Geometry::Cylinder { radius, half, .. }, _) => {
                    let cylinder = Cylinder { radius: *radius, half: *half };
                    match shape_b {
                        Geometry::Cylinder { radius, half, .. } => {
                            let b = Cylinder { radius: *radius, half: *half };
                            tested!(cylinder_revolved::touch, &cylinder, &b)
                        }
                        Geometry::Cone { radius, height, .. } => {
                            tested!(cylinder_revolved::touch, &cylinder, &Cone::new(*radius, *height))
                        }
                        Geometry::Cuboid { half } => {
                            tested!(revolved_polyhedron::touch, &cylinder, &cuboid(half))
                        }
                        Geometry::Hull(b) => tested!(revolved_polyhedron::touch, &cylinder, &**b),
                        _ => unreachable!("ranked"),
                    }
                }
                (Geometry::Cone { radius, height, .. }, _) => {
                    let cone = Cone::new(*radius, *height);
                    match shape_b {
                        Geometry::Cone { radius, height, .. } => {
                            tested!(cone_cone::touch, &cone, &Cone::new(*radius, *height))
                        }
                        Geometry::Cuboid { half } => tested!(revolved_polyhedron::touch, &cone, &cuboid(half)),
                        Geometry::Hull(b) => tested!(revolved_polyhedron::touch, &cone, &**b),
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
            overlap
        }
    };
    for found in &mut points[first..] {
        found.point = axes_a * found.point + a.position;
    }
    Some(Overlap { normal: axes_a * overlap.normal, ..overlap })
}
