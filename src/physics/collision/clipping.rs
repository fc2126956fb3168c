//! Contact points by face clipping (Sutherland–Hodgman; Ericson 2005, 8.3; Catto, GDC 2007).
//!
//! The face that gave the normal is the *reference*, the face of the other shape most against it
//! the *incident* one. The incident face is cut by the sides of the reference face, and what is
//! left below the reference plane are the contact points, each with its own depth, half-way
//! between the two surfaces. Two edges touch in one point, a ball in one, and what lies on a
//! half-space in the vertices below its plane. Of more than [`MAX_POINTS`] the deepest and those
//! that span the most area are kept.

use nalgebra::Vector3;

use super::placed::{Placed, PlacedEdge};
use super::sat::{AxisSource, Overlap, plane_depth};
use super::{CONTACT_TOLERANCE, ContactPoint, FeatureId};
use crate::physics::collider::Geometry;

/// Most points of a clipped manifold.
pub(super) const MAX_POINTS: usize = 4;

/// Sides of the reference face are moved outward by this share of the smaller bounding radius, so
/// that corners of aligned boxes stay corners when rounding moves them across a side.
const SIDE_MARGIN: f64 = 1e-5;

/// Depths that are less than the greatest by up to this share of the smaller bounding radius
/// count as deepest: the first of them is taken, so that the choice does not flicker.
const NEARLY_DEEPEST: f64 = 1e-4;

/// Likewise squared distances and areas from this share of the greatest.
const NEARLY_WIDEST: f64 = 0.99;

/// Buffers of the clipping, kept from pair to pair.
#[derive(Default)]
pub(super) struct ClipBuffers {
    reference: Vec<Vector3<f64>>,
    incident: Vec<Vector3<f64>>,
    polygon: Vec<Corner>,
    clipped: Vec<Corner>,
    found: Vec<ContactPoint>,
}

/// A corner of the polygon being clipped, named by the lines that meet in it: sides of the
/// incident face, or sides of the reference face.
#[derive(Clone, Copy)]
struct Corner {
    point: Vector3<f64>,
    before: u8,
    after: u8,
}

/// Names the side of a reference face; sides of the incident face have names below this.
const REFERENCE_SIDE: u8 = 0x80;

/// Adds the contact points of an overlap, relative to body A.
pub(super) fn contact_points(
    a: &Placed,
    b: &Placed,
    overlap: &Overlap,
    plane_gap: f64,
    buffers: &mut ClipBuffers,
    points: &mut Vec<ContactPoint>,
) {
    let Overlap { normal, depth, source } = *overlap;
    buffers.found.clear();
    match (a.geometry, b.geometry) {
        (_, Geometry::Sphere { radius }) => points.push(ContactPoint {
            point: b.center - normal * (radius - depth / 2.0),
            depth,
            feature: FeatureId::default(),
        }),
        (Geometry::Sphere { radius }, _) => points.push(ContactPoint {
            point: a.center + normal * (radius - depth / 2.0),
            depth,
            feature: FeatureId::default(),
        }),
        (Geometry::HalfSpace, _) => {
            vertices_below(a, b, &normal, plane_gap, &mut buffers.found);
            keep_spread(&mut buffers.found, &normal, b.radius, points);
        }
        (_, Geometry::HalfSpace) => {
            vertices_below(b, a, &-normal, plane_gap, &mut buffers.found);
            keep_spread(&mut buffers.found, &normal, a.radius, points);
        }
        _ if source == AxisSource::Edges => {
            let (on_a, on_b) = (a.edge_toward(&normal), b.edge_toward(&-normal));
            let point = middle_of_closest(&on_a, &on_b);
            points.push(ContactPoint { point, depth, feature: FeatureId::of_edges(on_a.index, on_b.index) });
        }
        _ => {
            if source == AxisSource::A {
                clip_faces(a, b, false, overlap, buffers);
            } else {
                let turned = Overlap { normal: -normal, ..*overlap };
                clip_faces(b, a, true, &turned, buffers);
            }
            keep_spread(&mut buffers.found, &normal, a.radius.min(b.radius), points);
        }
    }
}

/// The vertices of a body up to a gap over a plane, moved half-way to it.
fn vertices_below(plane: &Placed, body: &Placed, normal: &Vector3<f64>, gap: f64, found: &mut Vec<ContactPoint>) {
    let level = plane.center.dot(normal);
    body.for_each_vertex(|index, vertex| {
        if let Some(depth) = plane_depth(level - vertex.dot(normal), gap, body.radius) {
            let point = vertex + normal * (depth / 2.0);
            found.push(ContactPoint { point, depth, feature: FeatureId::of_vertex(true, index) });
        }
    });
}

/// Cuts the incident face of `other` by the sides of the face of `base` along the normal, which
/// points from `base` to `other`.
fn clip_faces(base: &Placed, other: &Placed, base_is_b: bool, overlap: &Overlap, buffers: &mut ClipBuffers) {
    let ClipBuffers { reference, incident, polygon, clipped, found } = buffers;
    let normal = overlap.normal;
    let reference_face = base.face_toward(&normal, reference);
    let incident_face = other.face_toward(&-normal, incident);
    polygon.clear();
    let sides = incident.len();
    polygon.extend(incident.iter().enumerate().map(|(corner, &point)| Corner {
        point,
        before: incident_side(corner + sides - 1, sides),
        after: incident_side(corner, sides),
    }));
    let size = base.radius.min(other.radius);
    for (side, &from) in reference.iter().enumerate() {
        let to = reference[(side + 1) % reference.len()];
        let outward = (to - from).cross(&reference_face.normal).normalize();
        let limit = outward.dot(&from) + SIDE_MARGIN * size;
        clip(polygon, clipped, &outward, limit, REFERENCE_SIDE | side as u8);
        std::mem::swap(polygon, clipped);
    }
    let level = reference.iter().map(|corner| corner.dot(&normal)).fold(f64::NEG_INFINITY, f64::max);
    let tolerance = CONTACT_TOLERANCE * (base.radius + other.radius);
    let name =
        |before, after| FeatureId::of_clipping(base_is_b, reference_face.index, incident_face.index, before, after);
    for corner in &*polygon {
        let depth = level - corner.point.dot(&normal);
        if depth >= -tolerance {
            let depth = depth.max(0.0);
            let point = corner.point + normal * (depth / 2.0);
            found.push(ContactPoint { point, depth, feature: name(corner.before, corner.after) });
        }
    }
    if found.is_empty() {
        // Only a depth that is not the least (an axis left out) ends here: the deepest corner
        // stands for the face.
        let deepest = super::placed::first_max(incident.iter().map(|corner| -corner.dot(&normal)));
        let point = incident[deepest] + normal * (overlap.depth / 2.0);
        let feature = name(incident_side(deepest + sides - 1, sides), incident_side(deepest, sides));
        found.push(ContactPoint { point, depth: overlap.depth, feature });
    }
}

fn incident_side(side: usize, sides: usize) -> u8 {
    (side % sides) as u8 & !REFERENCE_SIDE
}

/// Keeps what of a polygon lies within `limit` along `outward`.
fn clip(polygon: &[Corner], clipped: &mut Vec<Corner>, outward: &Vector3<f64>, limit: f64, side: u8) {
    clipped.clear();
    for (index, &corner) in polygon.iter().enumerate() {
        let next = polygon[(index + 1) % polygon.len()];
        let beyond = outward.dot(&corner.point) - limit;
        let next_beyond = outward.dot(&next.point) - limit;
        if beyond <= 0.0 {
            clipped.push(corner);
        }
        if (beyond <= 0.0) != (next_beyond <= 0.0) {
            let share = beyond / (beyond - next_beyond);
            let point = corner.point + (next.point - corner.point) * share;
            let (before, after) = if beyond <= 0.0 { (corner.after, side) } else { (side, corner.after) };
            clipped.push(Corner { point, before, after });
        }
    }
}

/// Half-way between the closest points of two edges (Ericson 2005, 5.1.9).
fn middle_of_closest(one: &PlacedEdge, other: &PlacedEdge) -> Vector3<f64> {
    let [p, q] = [one.ends[0], other.ends[0]];
    let [u, v] = [one.ends[1] - p, other.ends[1] - q];
    let w = p - q;
    let (uu, uv, vv, uw, vw) = (u.dot(&u), u.dot(&v), v.dot(&v), u.dot(&w), v.dot(&w));
    // Not zero: the cross product of the edges is the normal.
    let along = ((uv * vw - uw * vv) / (uu * vv - uv * uv)).clamp(0.0, 1.0);
    let other_along = ((uv * along + vw) / vv).clamp(0.0, 1.0);
    let along = ((uv * other_along - uw) / uu).clamp(0.0, 1.0);
    (p + u * along + q + v * other_along) / 2.0
}

/// Moves at most [`MAX_POINTS`] of the points found to `points`, in the order they were found.
fn keep_spread(found: &mut Vec<ContactPoint>, normal: &Vector3<f64>, size: f64, points: &mut Vec<ContactPoint>) {
    if found.len() > MAX_POINTS {
        let kept = spread(found, normal, size);
        points.extend(found.iter().enumerate().filter(|(index, _)| kept.contains(index)).map(|(_, point)| point));
    } else {
        points.append(found);
    }
}

/// The deepest, the farthest from it, the farthest from the line of those two, and the one that
/// adds most area to the triangle of these. Some may be the same.
fn spread(found: &[ContactPoint], normal: &Vector3<f64>, size: f64) -> [usize; MAX_POINTS] {
    let point = |index: usize| found[index].point;
    let widest = |value: &dyn Fn(&Vector3<f64>) -> f64| {
        first_from(found.iter().map(|found| value(&found.point)), |greatest| greatest * NEARLY_WIDEST)
    };
    let deepest = first_from(found.iter().map(|found| found.depth), |greatest| greatest - NEARLY_DEEPEST * size);
    let farthest = widest(&|at| (at - point(deepest)).norm_squared());
    let across = normal.cross(&(point(farthest) - point(deepest)));
    let beside = widest(&|at| across.dot(&(at - point(deepest))).abs());
    let mut triangle = [deepest, farthest, beside].map(point);
    if across.dot(&(triangle[2] - triangle[0])) < 0.0 {
        triangle.swap(1, 2);
    }
    let fourth = widest(&|at| {
        let beyond = |side: usize| {
            let (from, to) = (triangle[side], triangle[(side + 1) % 3]);
            (to - from).cross(normal).dot(&(at - from))
        };
        beyond(0).max(beyond(1)).max(beyond(2))
    });
    [deepest, farthest, beside, fourth]
}

/// Index of the first value that is at least `limit` of the greatest.
fn first_from(values: impl Iterator<Item = f64> + Clone, limit: impl Fn(f64) -> f64) -> usize {
    let limit = limit(values.clone().fold(f64::NEG_INFINITY, f64::max));
    values.into_iter().position(|value| value >= limit).unwrap_or(0)
}
