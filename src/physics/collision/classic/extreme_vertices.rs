//! Contact points of the 2009 engine: the extreme vertices of each shape toward the other, moved
//! onto the plane where they should end up, by the depth along the normal.
//!
//! Each point is a contact of its own with the depth of the separating axis test. A vertex of a
//! coarse shape may lie far from where a fine one touches it, and a tilted shape's vertices all
//! get the depth of the deepest: the method's documented weakness, kept as it was.

use nalgebra::Vector3;

use super::placed::Placed;
use super::sat::{self, AxisBuffers};
use crate::physics::collision::constants::{CONTACT_TOLERANCE, EXTREME_SHARE};
use crate::physics::collision::manifold::{Overlap, PartPair};
use crate::physics::collision::parts::{self, PartShape};
use crate::physics::shape::{Triangle, Triangles};
use crate::physics::{Body, BoundingBox, ContactModel, ContactPoint, FeatureId, Geometry, SolverSettings};

/// Adds the contact points of those parts of two bodies in world axes, if they overlap.
pub(crate) fn touch(
    [a, b]: [&Body; 2],
    parts: PartPair,
    settings: &SolverSettings,
    buffers: &mut AxisBuffers,
    points: &mut Vec<ContactPoint>,
) -> Option<Overlap> {
    let origin = a.position;
    let (one, other) = (parts::Placed::of(a, parts.a)?, parts::Placed::of(b, parts.b)?);
    let first = points.len();
    let overlap = match (&one.shape, &other.shape) {
        (PartShape::Solid(of_a), PartShape::Solid(of_b)) => {
            let (shape_a, shape_b) = (Placed::new(&one, of_a, &origin), Placed::new(&other, of_b, &origin));
            let overlap = sat::overlap(&shape_a, &shape_b, &settings.sweeps, buffers)?;
            if settings.contact_model() == ContactModel::SinglePoint {
                points.extend(single_point(&shape_a, &shape_b, &overlap));
            } else {
                contact_points(&shape_a, &shape_b, &overlap, points);
            }
            overlap
        }
        (PartShape::Facet(mesh, facet), PartShape::Solid(of_b)) => {
            touch_facet((mesh, *facet, &one), &Placed::new(&other, of_b, &origin), &origin, true, points)?
        }
        (PartShape::Solid(of_a), PartShape::Facet(mesh, facet)) => {
            let shape = Placed::new(&one, of_a, &origin);
            let overlap = touch_facet((mesh, *facet, &other), &shape, &origin, false, points)?;
            Overlap { normal: -overlap.normal, ..overlap }
        }
        (PartShape::Facet(..), PartShape::Facet(..)) => return None,
    };
    for point in &mut points[first..] {
        point.point += origin;
    }
    Some(overlap)
}

/// A facet of a mesh, triangle by triangle; a vertex over the side between two of them counts once.
fn touch_facet(
    (mesh, facet, placed): (&Triangles, u32, &parts::Placed),
    shape: &Placed,
    origin: &Vector3<f64>,
    shape_is_b: bool,
    points: &mut Vec<ContactPoint>,
) -> Option<Overlap> {
    let into_mesh = placed.rotation.inverse();
    let local = into_mesh * (shape.center + origin - placed.position);
    let reach = Vector3::repeat(shape.radius * (1.0 + CONTACT_TOLERANCE));
    let (first, mut overlap) = (points.len(), None);
    mesh.in_facet(facet, &BoundingBox { low: local - reach, high: local + reach }, |index| {
        let from = points.len();
        let found = touch_triangle((&mesh.get(index), placed), shape, origin, shape_is_b, points);
        overlap = found.or(overlap);
        for at in (from..points.len()).rev() {
            if points[first..from].iter().any(|known| known.feature == points[at].feature) {
                points.remove(at);
            }
        }
    });
    overlap
}

/// A triangle of a mesh, which the 2009 engine did not have: the plane of it, under those extreme vertices of the other shape
/// that are over the triangle. The normal points out of it.
fn touch_triangle(
    (triangle, placed): (&Triangle, &parts::Placed),
    shape: &Placed,
    origin: &Vector3<f64>,
    shape_is_b: bool,
    points: &mut Vec<ContactPoint>,
) -> Option<Overlap> {
    let normal = placed.rotation * triangle.normal;
    let middle = placed.position + placed.rotation * triangle.middle - origin;
    let level = middle.dot(&normal);
    if shape.center.dot(&normal) <= level {
        return None;
    }
    let depth = level - shape.project(&normal)[0];
    let tolerance = CONTACT_TOLERANCE * shape.radius;
    if depth < -tolerance {
        return None;
    }
    let depth = depth.max(0.0);
    let corners = triangle.corners.map(|corner| middle + placed.rotation * corner);
    let is_over = |point: &Vector3<f64>| {
        (0..3).all(|from| {
            let outward = (corners[(from + 1) % 3] - corners[from]).cross(&normal);
            outward.dot(&(point - corners[from])) <= tolerance * outward.norm()
        })
    };
    let first = points.len();
    shape.for_each_extreme(&-normal, EXTREME_SHARE * shape.radius, |index, vertex| {
        if is_over(&vertex) {
            let feature = FeatureId::of_vertex(shape_is_b, index);
            points.push(ContactPoint { point: vertex + normal * depth, depth, feature });
        }
    });
    (points.len() > first).then_some(Overlap { normal, depth })
}

/// Adds the contact points of an overlap, relative to body A: A's first, then B's.
fn contact_points(a: &Placed, b: &Placed, overlap: &Overlap, points: &mut Vec<ContactPoint>) {
    let Overlap { normal, depth } = *overlap;
    let mut add = |point: Vector3<f64>, feature| points.push(ContactPoint { point, depth, feature });
    // Two balls have no vertices and touch in one point, not in one of each.
    let two_balls = [a, b].iter().all(|shape| matches!(shape.geometry, Geometry::Sphere { .. }));
    if !two_balls {
        a.for_each_extreme(&normal, EXTREME_SHARE * a.radius, |index, vertex| {
            add(vertex - normal * depth, FeatureId::of_vertex(false, index));
        });
    }
    b.for_each_extreme(&-normal, EXTREME_SHARE * b.radius, |index, vertex| {
        add(vertex + normal * depth, FeatureId::of_vertex(true, index));
    });
}

/// The one point of an overlap, relative to body A: the foremost vertex that lies in the other shape, or if none does,
/// where edges cross, the foremost of all. Of vertices as far the first, A's before B's.
fn single_point(a: &Placed, b: &Placed, overlap: &Overlap) -> Option<ContactPoint> {
    let Overlap { normal, depth } = *overlap;
    let mut best: Option<(bool, f64, ContactPoint)> = None;
    for (of_b, shape, other, direction) in [(false, a, b, normal), (true, b, a, -normal)] {
        let reach = shape.project(&direction)[1];
        shape.for_each_extreme(&direction, EXTREME_SHARE * shape.radius, |index, vertex| {
            let is_outside = !other.holds(&vertex, CONTACT_TOLERANCE * shape.radius);
            let behind = reach - vertex.dot(&direction);
            if best.as_ref().is_none_or(|&(outside, least, _)| (is_outside, behind) < (outside, least)) {
                let (point, feature) = (vertex - direction * depth, FeatureId::of_vertex(of_b, index));
                best = Some((is_outside, behind, ContactPoint { point, depth, feature }));
            }
        });
    }
    best.map(|(.., point)| point)
}
