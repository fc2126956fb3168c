//! Shapes as the tests of questions know them, by other ways than the engine's.
//!
//! A solid is all that is within a radius of a core: the hull of some points, or a convex polygon turned about y. Three
//! functions tell all of it. Its *height* over a point is convex and negative inside, so that where a ray comes nearest is
//! found by golden section. Its *distance* is the least over triangles of its corners, or over sides of the polygon. Its
//! *reach* along a direction proves that two solids are apart, whoever proposed that direction: here parry's GJK,
//! and where that fails a search. What one point of both proves is that they touch.

use std::cell::Cell;
use std::f64::consts::FRAC_PI_2;

use bevy::math::{DQuat, DVec2, DVec3};
use parry3d_f64::math::{Pose, Vector};
use parry3d_f64::query::gjk::{self, CsoPoint, GJKResult, VoronoiSimplex};
use parry3d_f64::shape::SupportMap;
use plumb::physics::Shape;
use plumb::prelude::*;

/// Sides of a polygon that are shorter than this share of an edge tell nothing of a plane.
const SLIVER: f64 = 1e-9;

/// Golden sections after which what is left of 100 m is less than rounding.
const SECTIONS: usize = 75;

enum Core {
    /// y ≤ 0.
    HalfSpace,
    /// The hull of these, with the planes of its faces where it has a volume.
    Points { points: Vec<DVec3>, planes: Vec<(DVec3, f64)> },
    /// The polygon of these corners, (distance from the axis, y), counter-clockwise from the axis to the axis.
    Turned(Vec<DVec2>),
}

/// A convex solid, or a triangle, where it is.
pub struct Solid {
    core: Core,
    radius: f64,
    position: DVec3,
    rotation: DQuat,
}

/// What a collider is made of, where it is.
pub fn solids_of(collider: &Collider, position: DVec3, rotation: DQuat) -> Vec<Solid> {
    let solid = |core: Core, radius: f64| vec![Solid { core, radius, position, rotation }];
    match collider.shape() {
        Shape::HalfSpace => solid(Core::HalfSpace, 0.0),
        Shape::Sphere { radius } => solid(Core::hull(vec![DVec3::ZERO]), *radius),
        Shape::Capsule { radius, length } => {
            solid(Core::hull([-0.5, 0.5].map(|end| DVec3::Y * (end * length)).into()), *radius)
        }
        Shape::Cuboid { size } => {
            let corner = |index: usize| DVec3::from_array([0, 1, 2].map(|axis| [-0.5, 0.5][index >> axis & 1])) * *size;
            solid(Core::hull((0..8).map(corner).collect()), 0.0)
        }
        Shape::Hull(hull) => solid(Core::hull(hull.vertices().collect()), 0.0),
        &Shape::Cylinder { radius, height } => {
            let corners = [[0.0, -0.5], [1.0, -0.5], [1.0, 0.5], [0.0, 0.5]];
            solid(Core::Turned(corners.map(|[r, y]| DVec2::new(r * radius, y * height)).into()), 0.0)
        }
        &Shape::Cone { radius, height } => {
            let corners = [[0.0, -0.25], [1.0, -0.25], [0.0, 0.75]];
            solid(Core::Turned(corners.map(|[r, y]| DVec2::new(r * radius, y * height)).into()), 0.0)
        }
        Shape::Compound(compound) => {
            let children = compound.children().iter();
            let of_child = |child: &plumb::physics::CompoundChild| {
                solids_of(&child.collider, position + rotation * child.position, rotation * child.rotation)
            };
            children.flat_map(of_child).collect()
        }
        Shape::Mesh(mesh) => {
            let vertices: Vec<DVec3> = mesh.vertices().collect();
            let triangles = mesh.triangles().iter();
            let core = |corners: &[u32; 3]| Core::hull(corners.map(|corner| vertices[corner as usize]).into());
            triangles.map(|corners| Solid { core: core(corners), radius: 0.0, position, rotation }).collect()
        }
    }
}

impl Core {
    /// Of few points: planes are tried through each three of them.
    fn hull(points: Vec<DVec3>) -> Self {
        let mut planes: Vec<(DVec3, f64)> = Vec::new();
        if points.len() > 3 {
            let size = points.iter().map(|point| point.length()).fold(0.0, f64::max);
            for [a, b, c] in triples(&points) {
                let across = (b - a).cross(c - a);
                if across.length() <= SLIVER * size * size {
                    continue;
                }
                let unit = across.normalize();
                for normal in [unit, -unit] {
                    let offset = normal.dot(a);
                    let is_face = points.iter().all(|point| normal.dot(*point) <= offset + 1e-12 * size);
                    if is_face && planes.iter().all(|(known, _)| known.dot(normal) < 1.0 - 1e-12) {
                        planes.push((normal, offset));
                    }
                }
            }
        }
        Self::Points { points, planes }
    }
}

fn triples(points: &[DVec3]) -> impl Iterator<Item = [DVec3; 3]> {
    let count = points.len();
    let pairs = (0..count).flat_map(move |a| (a + 1..count).map(move |b| [a, b]));
    pairs.flat_map(move |[a, b]| (b + 1..count).map(move |c| [points[a], points[b], points[c]]))
}

fn distance_of_segment(a: DVec3, b: DVec3, point: DVec3) -> f64 {
    let (along, from) = (b - a, point - a);
    let share = if a == b { 0.0 } else { (from.dot(along) / along.length_squared()).clamp(0.0, 1.0) };
    (from - along * share).length()
}

/// The least that a function has between two places, which falls up to some place and rises from there (golden section).
fn least_between([mut low, mut high]: [f64; 2], height: impl Fn(f64) -> f64) -> f64 {
    let golden = 0.5 * (5_f64.sqrt() - 1.0);
    let [mut one, mut other] = [high - golden * (high - low), low + golden * (high - low)];
    let [mut at_one, mut at_other] = [height(one), height(other)];
    let mut least = height(low).min(height(high)).min(at_one).min(at_other);
    for _ in 0..SECTIONS {
        if at_one <= at_other {
            (high, other, at_other) = (other, one, at_one);
            one = high - golden * (high - low);
            at_one = height(one);
        } else {
            (low, one, at_one) = (one, other, at_other);
            other = low + golden * (high - low);
            at_other = height(other);
        }
        least = least.min(at_one).min(at_other);
    }
    least
}

/// How far a point is inside all sides of a triangle, seen along its normal, m.
fn inside_of_sides(corners: &[DVec3; 3], point: DVec3) -> f64 {
    let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
    let side = |from: usize| {
        let along = corners[(from + 1) % 3] - corners[from];
        normal.cross(along).normalize().dot(point - corners[from])
    };
    side(0).min(side(1)).min(side(2))
}

fn distance_of_triangle(corners: &[DVec3; 3], point: DVec3) -> f64 {
    let [a, b, c] = *corners;
    let normal = (b - a).cross(c - a);
    if normal.length() > SLIVER * (b - a).length_squared() && inside_of_sides(corners, point) >= 0.0 {
        return normal.normalize().dot(point - a).abs();
    }
    [(a, b), (b, c), (c, a)]
        .map(|(from, to)| distance_of_segment(from, to, point))
        .into_iter()
        .fold(f64::INFINITY, f64::min)
}

impl Solid {
    fn local(&self, point: DVec3) -> DVec3 {
        self.rotation.inverse() * (point - self.position)
    }

    /// A point inside.
    fn middle(&self) -> DVec3 {
        let local = match &self.core {
            Core::Points { points, .. } => points.iter().sum::<DVec3>() / points.len() as f64,
            Core::HalfSpace | Core::Turned(_) => DVec3::ZERO,
        };
        self.position + self.rotation * local
    }

    /// The corners of a triangle of a mesh.
    fn triangle(&self) -> Option<[DVec3; 3]> {
        match &self.core {
            Core::Points { points, .. } => points[..].try_into().ok(),
            _ => None,
        }
    }

    /// Convex, and negative inside; beyond a face of it how far, m. None has that of a triangle.
    pub fn height(&self, point: DVec3) -> f64 {
        let at = self.local(point);
        match &self.core {
            Core::HalfSpace => at.y,
            Core::Points { planes, .. } if !planes.is_empty() => {
                planes.iter().map(|(normal, offset)| normal.dot(at) - offset).fold(f64::NEG_INFINITY, f64::max)
            }
            Core::Points { points, .. } => distance_of_segment(points[0], points[points.len() - 1], at) - self.radius,
            Core::Turned(corners) => {
                let at = DVec2::new(at.x.hypot(at.z), at.y);
                let over = |side: &[DVec2]| -(side[1] - side[0]).perp().normalize().dot(at - side[0]);
                corners.windows(2).map(over).fold(f64::NEG_INFINITY, f64::max)
            }
        }
    }

    /// Between a point and the solid, m; 0 inside.
    pub fn distance(&self, point: DVec3) -> f64 {
        let at = self.local(point);
        match &self.core {
            Core::Points { points, planes } => match points[..] {
                [a, b, c] => distance_of_triangle(&[a, b, c], at),
                [first, .., last] | [first @ last] if planes.is_empty() => {
                    (distance_of_segment(first, last, at) - self.radius).max(0.0)
                }
                _ if self.height(point) <= 0.0 => 0.0,
                _ => triples(points).map(|corners| distance_of_triangle(&corners, at)).fold(f64::INFINITY, f64::min),
            },
            Core::Turned(corners) if self.height(point) > 0.0 => {
                let at = DVec3::new(at.x.hypot(at.z), at.y, 0.0);
                let sides =
                    corners.windows(2).map(|side| distance_of_segment(side[0].extend(0.0), side[1].extend(0.0), at));
                sides.fold(f64::INFINITY, f64::min)
            }
            _ => self.height(point).max(0.0),
        }
    }

    /// The point of it that is farthest along a direction. There is none of a half-space.
    fn farthest(&self, direction: DVec3) -> DVec3 {
        let along = self.rotation.inverse() * direction;
        let local = match &self.core {
            Core::HalfSpace => unreachable!("it has no end"),
            Core::Points { points, .. } => {
                let first = points.iter().max_by(|one, other| one.dot(along).total_cmp(&other.dot(along)));
                *first.expect("a core has points") + along.normalize_or_zero() * self.radius
            }
            Core::Turned(corners) => {
                let across = DVec2::new(along.x, along.z);
                let (unit, seen) = (across.normalize_or_zero(), DVec2::new(across.length(), along.y));
                let first = corners.iter().max_by(|one, other| one.dot(seen).total_cmp(&other.dot(seen)));
                let corner = first.expect("a polygon has corners");
                DVec3::new(unit.x * corner.x, corner.y, unit.y * corner.x)
            }
        };
        self.position + self.rotation * local
    }

    /// By how much it is beyond a plane there at most, along the plane's unit normal, m.
    pub fn beyond(&self, point: DVec3, normal: DVec3) -> f64 {
        match &self.core {
            Core::HalfSpace if normal.dot(self.rotation * DVec3::Y) > 1.0 - 1e-12 => -self.height(point),
            Core::HalfSpace => f64::INFINITY,
            _ => (self.farthest(normal) - point).dot(normal),
        }
    }

    /// Whether a ray does not come deeper into it than a slack before it has gone so far, m. A triangle is entered from its
    /// front.
    pub fn is_not_entered(&self, ray: &Ray, length: f64, slack: f64) -> bool {
        let unit = ray.direction.normalize();
        if let Some(corners) = self.triangle() {
            let corners = corners.map(|corner| self.position + self.rotation * corner);
            let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize();
            let (height, rate) = (normal.dot(ray.origin - corners[0]), normal.dot(unit));
            let distance = -height / rate;
            return rate >= 0.0
                || height < slack
                || (length - distance) * -rate <= slack
                || inside_of_sides(&corners, ray.origin + unit * distance) <= slack;
        }
        let least = least_between([0.0, length], |gone| self.height(ray.origin + unit * gone));
        least >= -slack
    }

    /// How far it reaches from its middle, m; 0 of a half-space.
    pub fn size(&self) -> f64 {
        match &self.core {
            Core::HalfSpace => 0.0,
            Core::Points { points, .. } => points.iter().map(|at| at.length()).fold(0.0, f64::max) + self.radius,
            Core::Turned(corners) => corners.iter().map(|at| at.length()).fold(0.0, f64::max),
        }
    }

    /// Of a triangle, which has only a front, the part of a way in which a point is before it; of a solid, all. None: nowhere,
    /// or the point begins behind.
    fn way_before(&self, point: DVec3, way: DVec3) -> Option<DVec3> {
        let Some([a, b, c]) = self.triangle() else { return Some(way) };
        let normal = self.rotation * (b - a).cross(c - a).normalize();
        let (height, rise) = (normal.dot(point - self.position - self.rotation * a), normal.dot(way));
        if height <= 0.0 {
            return None;
        }
        Some(if height + rise < 0.0 { way * (height / -rise) } else { way })
    }

    /// Whether a point is on it and, where it has an inside, the plane there has all of it on one side; of a triangle,
    /// whether that is its front.
    pub fn has_on_its_surface(&self, point: DVec3, normal: DVec3, slack: f64) -> bool {
        self.distance(point) <= slack && self.beyond(point, normal) <= slack
    }
}

/// A solid and all places where it comes on its way.
struct Swept<'s> {
    solid: &'s Solid,
    way: DVec3,
}

impl SupportMap for Swept<'_> {
    fn local_support_point(&self, direction: Vector) -> Vector {
        let direction = DVec3::from_array(direction.to_array());
        let way = if self.way.dot(direction) > 0.0 { self.way } else { DVec3::ZERO };
        Vector::from_array((self.solid.farthest(direction) + way).to_array())
    }
}

/// How far a solid stays apart from another on a way, m, as proven by a plane between them, across the one direction that is
/// known or one that is sought; none if there is no such proof. A triangle knows only what has its middle before it.
pub fn apart_on_a_way(mover: &Solid, way: DVec3, other: &Solid, known: Option<DVec3>) -> Option<f64> {
    let Some(way) = other.way_before(mover.position, way) else { return Some(f64::INFINITY) };
    let between = |normal: DVec3| {
        let end = mover.farthest(normal) + if way.dot(normal) > 0.0 { way } else { DVec3::ZERO };
        -other.beyond(end, -normal)
    };
    if matches!(other.core, Core::HalfSpace) {
        return Some(between(other.rotation * DVec3::NEG_Y));
    }
    let of_known = known.map(between);
    if of_known.is_some_and(|gap| gap > -1e-12) {
        return of_known;
    }
    let (swept, rest) = (Swept { solid: mover, way }, Swept { solid: other, way: DVec3::ZERO });
    let (mut simplex, here) = (VoronoiSimplex::new(), Pose::IDENTITY);
    let first = (other.position - mover.position).normalize_or(DVec3::X);
    simplex.reset(CsoPoint::from_shapes(&here, &swept, &rest, Vector::from_array(first.to_array())));
    match gjk::closest_points(&here, &swept, &rest, f64::MAX, true, &mut simplex) {
        GJKResult::ClosestPoints(_, _, normal) | GJKResult::NoIntersection(normal) | GJKResult::Proximity(normal) => {
            let gap = between(DVec3::from_array(normal.to_array()).normalize());
            Some(of_known.map_or(gap, |known| known.max(gap)))
        }
        GJKResult::Intersection => of_known,
    }
}

/// Likewise, as proven by a plane that is sought among all that there are. Where they pass by each other closely, one of a
/// million times GJK ends with a direction that proves nothing, or with none.
///
/// A plane between the two has the middle of the other before it, and every place of the mover's middle behind: its normal n
/// has n·m > 0, m the vector from the nearest of these to the other's. The distance along n = m/|m| + u e + v f is a concave
/// function of u and v, whatever the length of n, so that it is greatest where golden sections end, one within the other.
pub fn apart_by_search(mover: &Solid, way: DVec3, other: &Solid) -> Option<f64> {
    let Some(way) = other.way_before(mover.position, way) else { return Some(f64::INFINITY) };
    let between = other.middle() - mover.middle();
    let share = (between.dot(way) / way.length_squared()).clamp(0.0, 1.0);
    let first = (between - way * share).try_normalize()?;
    let (e, f) = first.any_orthonormal_pair();
    let apart = Cell::new(f64::NEG_INFINITY);
    let height = |u: f64, v: f64| {
        let along = first + e * u.tan() + f * v.tan();
        let normal = along.normalize();
        let end = mover.farthest(normal) + if way.dot(normal) > 0.0 { way } else { DVec3::ZERO };
        let beyond = other.beyond(end, -normal);
        apart.set(apart.get().max(-beyond));
        beyond * along.length()
    };
    let range = [-FRAC_PI_2, FRAC_PI_2];
    least_between(range, |u| least_between(range, |v| height(u, v)));
    Some(apart.get())
}
