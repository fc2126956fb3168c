//! Where a ray meets a shape, in closed form.
//!
//! A ray is o + t d, d a unit vector, t ≥ 0. A convex shape has an interval of it: where the ray enters the last of the
//! planes, or the quadric, that bound it, before it leaves the first.
//!
//! *Ball* of radius r: with b = o·d and the foot c = o − b d of the centre, t = −b − √(r² − |c|²); the foot instead of o·o
//! keeps the digits of a small ball far away (Haines et al. 2019).
//!
//! *Cone* with the apex a: below it, the double cone is x² + z² = k² s², s the distance below the apex and k the radius over
//! the height. With p = o − a and s = −p_y − t d_y, A t² + 2 B t + C = 0, A = d_x² + d_z² − k² d_y², B = p_x d_x + p_z d_z −
//! k² p_y d_y, C = p_x² + p_z² − k² p_y². Of its roots counts that which enters where 0 ≤ s ≤ h; the base is a disc.

use nalgebra::Vector3;

use crate::physics::box_tree::Way;
use crate::physics::shape::{PartList, Parts, Solid};
use crate::physics::{BoundingBox, Geometry, Hull};

/// Where a ray enters a shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Entry {
    /// Along the ray, m; 0 where it begins inside.
    pub distance: f64,
    /// Unit, out of the shape; against the ray where it begins inside.
    pub normal: Vector3<f64>,
}

/// Where a ray from `origin` along the unit `direction`, both in the shape's axes, enters it.
pub(super) fn enter(geometry: &Geometry, origin: &Vector3<f64>, direction: &Vector3<f64>) -> Option<Entry> {
    match geometry {
        Geometry::HalfSpace => enter_planes([(Vector3::y(), 0.0)].into_iter(), origin, direction),
        Geometry::Sphere { radius } => enter_ball(*radius, origin, direction),
        Geometry::Cuboid { half } => enter_cuboid(half, origin, direction),
        Geometry::Capsule { radius, half, .. } => enter_capsule(*radius, *half, origin, direction),
        Geometry::Cylinder { radius, half, .. } => enter_cylinder(*radius, *half, origin, direction),
        Geometry::Cone { radius, height, .. } => enter_cone(*radius, *height, origin, direction),
        Geometry::Hull(hull) => enter_hull(hull, origin, direction),
        Geometry::Parts(parts) => enter_parts(parts, origin, direction),
    }
}

/// Into the first of the parts; through a triangle from its front.
fn enter_parts(parts: &Parts, origin: &Vector3<f64>, direction: &Vector3<f64>) -> Option<Entry> {
    let way = Way::new(origin, direction);
    let begins = |bounds: &BoundingBox| way.enters(&bounds.low, &bounds.high);
    let mut first: Option<Entry> = None;
    let mut take = |entry: Option<Entry>, most: f64| match entry {
        Some(entry) if first.is_none_or(|first| entry.distance < first.distance) => {
            first = Some(entry);
            entry.distance
        }
        _ => most,
    };
    parts.tree().search(f64::INFINITY, begins, |part, most| match &parts.list {
        PartList::Triangles(mesh) => {
            let mut most = most;
            mesh.search(part, most, begins, |triangle, so_far| {
                most = take(enter_triangle(&mesh.corners_of(triangle), origin, direction), so_far);
                most
            });
            most
        }
        PartList::Solids(solids) => {
            let Solid { geometry, position, rotation, .. } = &solids[part as usize];
            let into_part = |v: &Vector3<f64>| rotation.inverse_transform_vector(v);
            let entry = enter(geometry, &into_part(&(origin - position)), &into_part(direction));
            take(entry.map(|entry| Entry { normal: rotation * entry.normal, ..entry }), most)
        }
    });
    first
}

/// Where a + u (b − a) + v (c − a) = o + t d with u, v ≥ 0 and u + v ≤ 1, by Cramer's rule (Möller and Trumbore 1997).
fn enter_triangle([a, b, c]: &[Vector3<f64>; 3], origin: &Vector3<f64>, direction: &Vector3<f64>) -> Option<Entry> {
    let (ab, ac) = (b - a, c - a);
    let across = direction.cross(&ac);
    let determinant = ab.dot(&across);
    if determinant <= 0.0 {
        return None;
    }
    let from = origin - a;
    let u = from.dot(&across);
    let beside = from.cross(&ab);
    let v = direction.dot(&beside);
    let distance = ac.dot(&beside) / determinant;
    let is_met = u >= 0.0 && v >= 0.0 && u + v <= determinant && distance >= 0.0;
    is_met.then(|| Entry { distance, normal: ab.cross(&ac).normalize() })
}

fn inside(direction: &Vector3<f64>) -> Entry {
    Entry { distance: 0.0, normal: -direction }
}

/// Into a ball about the origin.
pub(super) fn enter_ball(radius: f64, origin: &Vector3<f64>, direction: &Vector3<f64>) -> Option<Entry> {
    if origin.norm_squared() <= radius * radius {
        return Some(inside(direction));
    }
    let along = origin.dot(direction);
    let foot = origin - direction * along;
    let half_squared = radius * radius - foot.norm_squared();
    if along > 0.0 || half_squared < 0.0 {
        return None;
    }
    let distance = (-along - half_squared.sqrt()).max(0.0);
    Some(Entry { distance, normal: (origin + direction * distance) / radius })
}

/// Into a capsule about a segment of twice `half` along y: the cylinder between its ends, or one of the balls there.
pub(super) fn enter_capsule(radius: f64, half: f64, origin: &Vector3<f64>, direction: &Vector3<f64>) -> Option<Entry> {
    let beside = origin - Vector3::y() * origin.y.clamp(-half, half);
    if beside.norm_squared() <= radius * radius {
        return Some(inside(direction));
    }
    let across = |vector: &Vector3<f64>| Vector3::new(vector.x, 0.0, vector.z);
    let (from, rate) = (across(origin), across(direction));
    let side = rate.try_normalize(0.0).and_then(|unit| {
        let entry = enter_ball(radius, &from, &unit)?;
        let distance = entry.distance / rate.norm();
        let is_between = (origin.y + direction.y * distance).abs() <= half;
        (is_between && entry.distance > 0.0).then_some(Entry { distance, normal: entry.normal })
    });
    let ends = [-half, half].map(|end| enter_ball(radius, &(origin - Vector3::y() * end), direction));
    let all = ends.into_iter().flatten().chain(side);
    all.min_by(|one, other| one.distance.total_cmp(&other.distance))
}

/// What of the ray is within the round side and between the ends.
fn enter_cylinder(radius: f64, half: f64, origin: &Vector3<f64>, direction: &Vector3<f64>) -> Option<Entry> {
    let ends = [(Vector3::y(), half), (-Vector3::y(), half)];
    let between = interval_of_planes(ends.into_iter(), origin, direction)?;
    let rate = direction.xz().norm();
    let from = Vector3::new(origin.x, 0.0, origin.z);
    if rate == 0.0 {
        return (from.norm_squared() <= radius * radius).then_some(between.0);
    }
    let along = Vector3::new(direction.x, 0.0, direction.z) / rate;
    let foot = from - along * from.dot(&along);
    let half_chord = radius * radius - foot.norm_squared();
    if half_chord < 0.0 {
        return None;
    }
    let [enters, leaves] = [-1.0, 1.0].map(|sign| (sign * half_chord.sqrt() - from.dot(&along)) / rate);
    let (entry, exit) = between;
    let entry = if enters > entry.distance {
        Entry { distance: enters, normal: (foot - along * half_chord.sqrt()) / radius }
    } else {
        entry
    };
    (entry.distance <= exit.min(leaves)).then_some(entry)
}

fn enter_cuboid(half: &Vector3<f64>, origin: &Vector3<f64>, direction: &Vector3<f64>) -> Option<Entry> {
    let sides = (0..3).flat_map(|axis| {
        [1.0, -1.0].map(|sign| {
            let mut normal = Vector3::zeros();
            normal[axis] = sign;
            (normal, half[axis])
        })
    });
    enter_planes(sides, origin, direction)
}

fn enter_hull(hull: &Hull, origin: &Vector3<f64>, direction: &Vector3<f64>) -> Option<Entry> {
    enter_planes(hull.faces.iter().map(|face| (face.normal, face.offset)), origin, direction)
}

/// Into what is below all planes, each a unit normal and its distance from the origin.
fn enter_planes(
    planes: impl Iterator<Item = (Vector3<f64>, f64)>,
    origin: &Vector3<f64>,
    direction: &Vector3<f64>,
) -> Option<Entry> {
    let (entry, exit) = interval_of_planes(planes, origin, direction)?;
    (entry.distance <= exit).then_some(entry)
}

/// Where a ray enters the last of the planes and where it leaves the first; none if it stays above one.
fn interval_of_planes(
    planes: impl Iterator<Item = (Vector3<f64>, f64)>,
    origin: &Vector3<f64>,
    direction: &Vector3<f64>,
) -> Option<(Entry, f64)> {
    let (mut entry, mut exit) = (inside(direction), f64::INFINITY);
    for (normal, offset) in planes {
        let (height, rate) = (normal.dot(origin) - offset, normal.dot(direction));
        if height > 0.0 {
            if rate >= 0.0 {
                return None;
            }
            let distance = -height / rate;
            if distance > entry.distance {
                entry = Entry { distance, normal };
            }
        } else if rate > 0.0 {
            exit = exit.min(-height / rate);
        }
    }
    Some((entry, exit))
}

fn enter_cone(radius: f64, height: f64, origin: &Vector3<f64>, direction: &Vector3<f64>) -> Option<Entry> {
    let slope = radius / height;
    // From the apex, y down.
    let (from, rate) = (Vector3::new(origin.x, 0.75 * height - origin.y, origin.z), -direction.y);
    let below_flank = from.x.hypot(from.z) <= slope * from.y;
    if below_flank && from.y <= height {
        return Some(inside(direction));
    }
    if from.y > height {
        // Through the base, or beside it through the flank from below.
        if rate >= 0.0 {
            return None;
        }
        let distance = (height - from.y) / rate;
        let at = origin + direction * distance;
        if at.x.hypot(at.z) <= radius {
            return Some(Entry { distance, normal: -Vector3::y() });
        }
    }
    let k = slope * slope;
    let a = direction.x * direction.x + direction.z * direction.z - k * rate * rate;
    let b = from.x * direction.x + from.z * direction.z - k * from.y * rate;
    let c = from.x * from.x + from.z * from.z - k * from.y * from.y;
    let discriminant = b * b - a * c;
    if discriminant < 0.0 {
        return None;
    }
    // Both roots without a difference of numbers that are nearly the same.
    let q = -(b + discriminant.sqrt().copysign(b));
    let entry = |distance: f64| {
        let at = origin + direction * distance;
        let depth = from.y + rate * distance;
        let outward = Vector3::new(at.x, k * depth, at.z);
        let enters = distance >= 0.0 && (0.0..=height).contains(&depth) && outward.dot(direction) < 0.0;
        (enters && outward != Vector3::zeros()).then(|| Entry { distance, normal: outward.normalize() })
    };
    let roots = [q / a, c / q].map(|distance| if distance.is_finite() { entry(distance) } else { None });
    roots.into_iter().flatten().min_by(|one, other| one.distance.total_cmp(&other.distance))
}
