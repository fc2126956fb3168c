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
use crate::physics::collision::manifold::Overlap;
use crate::physics::{Body, ContactModel, ContactPoint, FeatureId, Geometry, SolverSettings};

/// Adds the contact points of two bodies in world axes, if they overlap.
pub(crate) fn touch(
    a: &Body,
    b: &Body,
    settings: &SolverSettings,
    buffers: &mut AxisBuffers,
    points: &mut Vec<ContactPoint>,
) -> Option<Overlap> {
    let origin = a.position;
    let (shape_a, shape_b) = (Placed::new(a, &origin)?, Placed::new(b, &origin)?);
    let overlap = sat::overlap(&shape_a, &shape_b, &settings.sweeps, buffers)?;
    let first = points.len();
    if settings.contact_model() == ContactModel::SinglePoint {
        points.extend(single_point(&shape_a, &shape_b, &overlap));
    } else {
        contact_points(&shape_a, &shape_b, &overlap, points);
    }
    for point in &mut points[first..] {
        point.point += origin;
    }
    Some(overlap)
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
