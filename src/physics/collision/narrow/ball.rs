//! A ball against any other shape but a half-space: one point, in closed form.
//!
//! With the ball's centre outside the other shape, the normal is from the nearest point of that
//! to the centre. With it inside, the shortest way out is through the nearest face.

use nalgebra::Vector3;

use super::revolved::Revolved;
use super::{Cone, Cylinder, Frame, Overlap, Scale, first_max, nearest_on_hull, unit_across};
use crate::physics::collision::constants::ON_SURFACE;
use crate::physics::{ContactPoint, FeatureId, Geometry, Hull};

/// Where a point is with respect to a shape.
pub(crate) struct Place {
    /// Unit, out of the shape, along the shortest way between the point and the surface.
    pub normal: Vector3<f64>,
    /// Distance from the surface, negative inside.
    pub height: f64,
}

impl Place {
    /// Of a point outside, given the nearest point of the shape; none if they are nearly one.
    pub fn outside(point: &Vector3<f64>, nearest: &Vector3<f64>, radius: f64) -> Option<Self> {
        let away = point - nearest;
        let distance = away.norm();
        (distance > ON_SURFACE * radius).then(|| Self { normal: away / distance, height: distance })
    }
}

/// Tests a shape and a ball whose centre is given in the shape's axes, and adds the point where
/// they touch, or are nearest if they are apart by no more than the gap, in these axes. Normal and
/// distance are the true ones; of two that are farther apart it is left in `apart`, or less.
pub(crate) fn touch(
    shape: &Geometry,
    shape_radius: f64,
    radius: f64,
    ball_in_shape: &Frame,
    gap: f64,
    apart: &mut f64,
    points: &mut Vec<ContactPoint>,
) -> Option<Overlap> {
    let center = ball_in_shape.center;
    let Place { normal, height } = match shape {
        Geometry::Sphere { radius: other } => place_at_ball(*other, &center),
        Geometry::Capsule { radius: other, half, .. } => place_at_capsule(*other, *half, &center),
        Geometry::Cuboid { half } => place_at_cuboid(half, &center, radius),
        Geometry::Cylinder { radius: side, half, .. } => {
            place_at_cylinder(&Cylinder { radius: *side, half: *half }, &center, radius)
        }
        Geometry::Cone { radius: base, height, .. } => place_at_cone(&Cone::new(*base, *height), &center, radius),
        Geometry::Hull(hull) => place_at_hull(hull, &center, radius, gap),
        Geometry::HalfSpace | Geometry::Parts(_) => unreachable!("the plane comes first, and parts one by one"),
    };
    let scale = Scale::new(shape_radius, radius, gap);
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
    let Place { normal, height } = match shape {
        Geometry::HalfSpace => Place { normal: Vector3::y(), height: point.y },
        Geometry::Sphere { radius } => place_at_ball(*radius, point),
        Geometry::Capsule { radius, half, .. } => place_at_capsule(*radius, *half, point),
        Geometry::Cuboid { half } => place_at_cuboid(half, point, radius),
        Geometry::Cylinder { radius: side, half, .. } => {
            place_at_cylinder(&Cylinder { radius: *side, half: *half }, point, radius)
        }
        Geometry::Cone { radius: base, height, .. } => place_at_cone(&Cone::new(*base, *height), point, radius),
        Geometry::Hull(hull) => place_at_hull(hull, point, radius, f64::INFINITY),
        Geometry::Parts(_) => unreachable!("parts come one by one"),
    };
    (normal, height)
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

/// All in the half-plane of the axis and the point.
pub(super) fn place_at_cylinder(cylinder: &Cylinder, point: &Vector3<f64>, radius: f64) -> Place {
    let [x, z] = unit_across(point);
    let beside = point.x.hypot(point.z) - cylinder.radius;
    let above = point.y.abs() - cylinder.half;
    let over_flank = Place { normal: Vector3::new(x, 0.0, z), height: beside };
    let over_end = Place { normal: Vector3::y() * 1_f64.copysign(point.y), height: above };
    if beside > 0.0 && above > 0.0 {
        let rim = Vector3::new(cylinder.radius * x, cylinder.half.copysign(point.y), cylinder.radius * z);
        return Place::outside(point, &rim, radius).unwrap_or(over_flank);
    }
    if beside > above { over_flank } else { over_end }
}

/// Likewise.
pub(super) fn place_at_cone(cone: &Cone, point: &Vector3<f64>, radius: f64) -> Place {
    let [x, z] = unit_across(point);
    let across = point.x.hypot(point.z);
    let over_base = Place { normal: Cone::base_normal(), height: cone.base - point.y };
    let flank = cone.flank_normal([x, z]);
    let over_flank = Place { normal: flank, height: flank.dot(point) - cone.flank_offset() };
    if over_base.height <= 0.0 && over_flank.height <= 0.0 {
        return if over_base.height > over_flank.height { over_base } else { over_flank };
    }
    if over_base.height > 0.0 && across <= cone.radius {
        return over_base;
    }
    // Else the nearest point of the generator line: the apex and the rim are its ends.
    let apex = cone.apex_point();
    let line = cone.rim_point([x, z]) - apex;
    let share = ((point - apex).dot(&line) / line.norm_squared()).clamp(0.0, 1.0);
    Place::outside(point, &(apex + line * share), radius).unwrap_or(over_flank)
}
