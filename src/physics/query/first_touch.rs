//! Where a convex solid M that moves on along a unit direction d first touches another, O.
//!
//! The Minkowski difference O − M holds the vectors from the points of M to those of O. Moved on by t, M touches O exactly
//! where t d is in it: a ray is cast at a convex set of which the support function is known (van den Bergen 2004). Two bounds
//! of that t close in on it from either side:
//!
//! - For any n with n·d > 0 the solids are apart along n by s(n) = min n·w over w in O − M, and no touch comes before
//!   s(n)/(n·d). The greatest of these bounds is the first touch (duality of linear programs), and its n the normal there.
//! - Where the ray passes through a triangle of three points of O − M, that place is in O − M, so that a touch comes no
//!   later. With the weights of the triangle's corners there, the points of O that they were made of add up to a point of O,
//!   and those of M to one of M, which is the same: the point that is touched.
//!
//! With n the normal of that triangle, w(n), the point in which n·w is least, yields the lower bound, and then replaces the
//! corner without which the ray still passes through: a step of the simplex method, as of portals (Snethen 2008), by which
//! the upper bound falls. Of two polyhedra the bounds meet after a handful of steps, where one is curved after some tens.
//! Neither bound depends on how it was found.
//!
//! The first triangle is infinitely far ahead, and none of its corners is in O − M. As long as one of them is left, its
//! normal is across the ray: where the solids are apart along that they never touch.

use nalgebra::Vector3;

use super::solid::Solid;
use crate::physics::contact::tangents;

/// Steps at most: of two polyhedra it takes 7 to rounding, where one is curved 10 to 50.
const STEPS: u32 = 100;

/// Progress of a step that may be rounding, as a share of the sizes.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// Corrections of weights: each leaves of what is wrong as small a share as the first left of the whole.
const CORRECTIONS: u32 = 2;

/// Where a solid touches another.
#[derive(Clone, Copy, Debug)]
pub(super) struct Touch {
    /// How far the mover comes, m; less than 0 where they overlap from the start.
    pub distance: f64,
    /// A point of the other, from where its position is measured.
    pub point: Vector3<f64>,
    /// Unit, out of the other: a plane across it is between the two.
    pub normal: Vector3<f64>,
}

/// A corner of the triangle that the ray passes through.
#[derive(Clone, Copy)]
struct Corner {
    /// Where it is; of one that is infinitely far ahead, what of that is across the ray.
    place: Vector3<f64>,
    /// Across the ray.
    across: [f64; 2],
    /// The point of O that it is made of; none of one that is far ahead.
    on_other: Option<Vector3<f64>>,
}

/// Three corners, counter-clockwise seen against the ray.
type Triangle = [Corner; 3];

/// Where a mover on its way along a unit direction first touches another, if within `most`, m.
pub(super) fn first_touch(mover: &Solid, other: &Solid, direction: &Vector3<f64>, most: f64) -> Option<Touch> {
    let axes = tangents(direction);
    let rounding = ROUNDING * ((other.position - mover.position).norm() + mover.radius + other.radius);
    let mut triangle = far_ahead(&axes);
    let (mut latest, mut normal) = (f64::NEG_INFINITY, *direction);
    for _ in 0..STEPS {
        let Some(across) = normal_of(&triangle, direction).try_normalize(0.0) else { break };
        let (on_mover, on_other) = (mover.support(&across)?, other.support(&-across)?);
        let place = on_other - on_mover;
        let apart = across.dot(&place);
        let near = triangle.iter().filter(|corner| corner.on_other.is_some()).count();
        if near == 3 {
            let bound = apart / across.dot(direction);
            if bound > latest {
                (latest, normal) = (bound, across);
            }
            if latest > most {
                return None;
            }
        } else if near > 0 && apart > 0.0 {
            return None;
        }
        let known = triangle.iter().find(|corner| corner.on_other.is_some());
        if known.is_some_and(|known| across.dot(&known.place) - apart <= rounding) {
            break;
        }
        let next = Corner { place, across: axes.map(|axis| axis.dot(&place)), on_other: Some(on_other) };
        let Some(nearer) = around_the_ray(&triangle, next) else { break };
        triangle = nearer;
    }
    let weights = weights(&triangle)?;
    let mut point = Vector3::zeros();
    for (corner, weight) in triangle.iter().zip(weights) {
        point += corner.on_other? * weight;
    }
    (latest.is_finite() && latest <= most).then_some(Touch { distance: latest, point, normal: -normal })
}

/// The first triangle, about the ray.
fn far_ahead(axes: &[Vector3<f64>; 2]) -> Triangle {
    let height = 0.75_f64.sqrt();
    [[1.0, 0.0], [-0.5, height], [-0.5, -height]].map(|across| Corner {
        place: axes[0] * across[0] + axes[1] * across[1],
        across,
        on_other: None,
    })
}

/// The normal of a triangle, of any length, along the ray or across it: the limit where some corners go ahead for ever.
fn normal_of(triangle: &Triangle, direction: &Vector3<f64>) -> Vector3<f64> {
    let [a, b, c] = triangle.map(|corner| corner.place);
    match triangle.map(|corner| corner.on_other.is_none()) {
        [true, true, true] => *direction,
        [false, true, true] => (b - c).cross(direction),
        [true, false, true] => (c - a).cross(direction),
        [true, true, false] => (a - b).cross(direction),
        [true, false, false] => direction.cross(&(b - c)),
        [false, true, false] => direction.cross(&(c - a)),
        [false, false, true] => direction.cross(&(a - b)),
        [false, false, false] => (b - a).cross(&(c - a)),
    }
}

/// The triangle with a corner replaced by the next so that the ray passes through it; by rounding it may pass through none
/// of them, and then that of which the least weight is greatest.
fn around_the_ray(triangle: &Triangle, next: Corner) -> Option<Triangle> {
    let candidates = [0, 1, 2].map(|replaced| {
        let mut candidate = *triangle;
        candidate[replaced] = next;
        candidate
    });
    let least = |candidate: &Triangle| {
        weights(candidate).map_or(f64::NEG_INFINITY, |weights| weights.into_iter().fold(f64::INFINITY, f64::min))
    };
    let mut best = (f64::NEG_INFINITY, None);
    for candidate in candidates {
        let least = least(&candidate);
        if least > best.0 {
            best = (least, Some(candidate));
        }
    }
    best.1
}

/// The weights with which corners add up to a point of the ray; none if they are in line, seen along it.
///
/// By Cramer's rule they may be off where the triangle is thin, as it is at last about a curved surface. What they add up to
/// then beside the ray is taken away by the same rule.
fn weights(triangle: &Triangle) -> Option<[f64; 3]> {
    let cross = |[a, b]: [f64; 2], [c, d]: [f64; 2]| a * d - b * c;
    let minus = |[a, b]: [f64; 2], [c, d]: [f64; 2]| [a - c, b - d];
    let corners = triangle.map(|corner| corner.across);
    let [a, b, c] = corners;
    let sides = [minus(c, b), minus(a, c), minus(b, a)];
    let area = cross(sides[2], minus(c, a));
    if area <= 0.0 {
        return None;
    }
    let [one, other] = [cross(b, sides[0]) / area, cross(c, sides[1]) / area];
    let mut weights = [one, other, 1.0 - one - other];
    for _ in 0..CORRECTIONS {
        let beside = [0, 1].map(|axis| (0..3).map(|at| corners[at][axis] * weights[at]).sum::<f64>());
        let [one, other] = [cross(sides[0], beside) / area, cross(sides[1], beside) / area];
        weights = [weights[0] - one, weights[1] - other, weights[2] + one + other];
    }
    Some(weights)
}
