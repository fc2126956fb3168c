//! A ball against any other shape but a half-space: one point, in closed form.
//!
//! With the ball's centre outside the other shape, the normal is from the nearest point of that
//! to the centre. With it inside, the shortest way out is through the nearest face.

use nalgebra::Vector3;

use super::place::Place;
use super::revolved::Revolved;
use super::{Cone, Cylinder, Frame, Overlap, Scale, first_max, nearest_on_hull};
use crate::physics::collision::constants::ON_SURFACE;
use crate::physics::{ContactPoint, FeatureId, Geometry, Hull};

/// Tests a shape and a ball whose centre is given in the shape's axes, and adds the point where
/// they touch, or are nearest if they are apart by no more than the gap, in these axes. Normal and
/// distance are the true ones; of two that are farther apart it is left in `apart`, or less.
pub(crate) fn touch(
    shape: &Geometry,
    radius: f64,
    ball_in_shape: &Frame,
    scale: &Scale,
    apart: &mut f64,
    points: &mut Vec<ContactPoint>,
) -> Option<Overlap> {
    let center = ball_in_shape.center;
    let Place { normal, height } = place_within(shape, &center, radius, scale.gap);
    let depth = radius - height;
    if scale.separates(depth) {
        *apart = -depth;
        return None;
    }
    let depth = scale.rounded(depth);
    let point = center - normal * (radius - depth / 2.0);
    points.push(ContactPoint { point, depth, feature: FeatureId::default() });
    Some(Overlap { normal, depth })
}

/// The unit normal out of a solid of that bounding radius along the shortest way between its surface and a point in its
/// axes, and how far the point is out, m, negative inside.
pub(crate) fn place(shape: &Geometry, point: &Vector3<f64>, radius: f64) -> (Vector3<f64>, f64) {
    place_up_to(shape, point, radius, f64::INFINITY)
}

/// The same; of a shape that is farther out than `most`, m, only that it is.
pub(crate) fn place_up_to(shape: &Geometry, point: &Vector3<f64>, radius: f64, most: f64) -> (Vector3<f64>, f64) {
    let Place { normal, height } = place_within(shape, point, radius, most - 2.0 * radius);
    (normal, height)
}

/// Likewise; of a hull whose faces are farther from the point than a ball of that radius and a gap, one of these faces.
fn place_within(shape: &Geometry, point: &Vector3<f64>, radius: f64, gap: f64) -> Place {
    match shape {
        Geometry::HalfSpace => Place { normal: Vector3::y(), height: point.y },
        Geometry::Sphere { radius: other } => place_at_ball(*other, point),
        Geometry::Capsule { radius: other, half, .. } => place_at_capsule(*other, *half, point),
        Geometry::Cuboid { half } => place_at_cuboid(half, point, radius),
        Geometry::Cylinder { radius: side, half, .. } => Cylinder { radius: *side, half: *half }.place(point, radius),
        Geometry::Cone { radius: base, height, .. } => Cone::new(*base, *height).place(point, radius),
        Geometry::Hull(hull) => place_at_hull(hull, point, radius, gap),
        Geometry::Parts(_) => unreachable!("parts come one by one"),
    }
}

fn place_at_ball(radius: f64, point: &Vector3<f64>) -> Place {
    let distance = point.norm();
    let normal = if distance > ON_SURFACE * radius { point / distance } else { Vector3::y() };
    Place { normal, height: distance - radius }
}

fn place_at_capsule(radius: f64, half: f64, point: &Vector3<f64>) -> Place {
    let away = point - Vector3::y() * point.y.clamp(-half, half);
    let distance = away.norm();
    // Beside a point of the axis, any way across it is as short.
    let normal = if distance > ON_SURFACE * radius { away / distance } else { Vector3::x() };
    Place { normal, height: distance - radius }
}

fn place_at_cuboid(half: &Vector3<f64>, point: &Vector3<f64>, radius: f64) -> Place {
    let nearest = point.zip_map(half, |along, half| along.clamp(-half, half));
    Place::outside(point, &nearest, radius).unwrap_or_else(|| {
        let heights = point.abs() - half;
        let axis = heights.imax();
        let mut normal = Vector3::zeros();
        normal[axis] = 1_f64.copysign(point[axis]);
        Place { normal, height: heights[axis] }
    })
}

fn place_at_hull(hull: &Hull, point: &Vector3<f64>, radius: f64, gap: f64) -> Place {
    let height = |face: usize| hull.faces[face].normal.dot(point) - hull.faces[face].offset;
    let highest = first_max((0..hull.faces.len()).map(height));
    let over_face = Place { normal: hull.faces[highest].normal, height: height(highest) };
    if over_face.height <= 0.0 || over_face.height > 2.0 * radius + gap {
        // Inside, or certainly apart.
        return over_face;
    }
    Place::outside(point, &nearest_on_hull(hull, point), radius).unwrap_or(over_face)
}
