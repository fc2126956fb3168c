//! Whether two convex solids have a point in common, without asking how deep.
//!
//! They have where the Minkowski difference O − M of their cores comes as near to the origin as what is all around the two is
//! thick. A simplex of points of O − M goes after the origin (Gilbert, Johnson and Keerthi 1988): its nearest point v to the
//! origin tells along which n = v/|v| the next is the farthest towards it. What is told holds whatever led there: with the
//! w of the least n·w apart by more than they are thick, they are apart along n; with v, a mean of points of O − M, nearer than
//! that, or the origin within four of them, they meet. What is nearer to touching than rounding tells is left open.

use nalgebra::Vector3;

use super::solid::Solid;

/// Steps at most: of polyhedra it takes some 3 to 8.
const STEPS: u32 = 24;

/// A share of the sizes that is more than rounding.
const SLACK: f64 = 1e-9;

/// Whether they meet; none where that is not told for certain.
pub(super) fn meet(one: &Solid, other: &Solid) -> Option<bool> {
    let between = other.position - one.position;
    let distance = between.norm();
    let size = one.radius + other.radius;
    let slack = SLACK * (size + distance);
    if distance > size + slack {
        return Some(false);
    }
    // Where one is in the midst of the other any direction will do.
    let mut normal = between.try_normalize(slack).unwrap_or_else(Vector3::x);
    let mut simplex = Simplex::default();
    for _ in 0..STEPS {
        let ((from, around), (to, around_other)) = (one.farthest(&normal)?, other.farthest(&-normal)?);
        let (next, thick) = (to - from, around + around_other);
        if normal.dot(&next) > thick + slack {
            return Some(false);
        }
        match simplex.take_in(next) {
            Nearest::Within => return Some(true),
            Nearest::At(place) => {
                let length = place.norm();
                if length + slack < thick {
                    return Some(true);
                }
                // Near to touching, or no nearer than before.
                if length <= slack || simplex.is_stuck(length) {
                    return None;
                }
                normal = place / length;
            }
        }
    }
    None
}

/// Up to three points, of which none is dispensable for the one nearest to the origin.
#[derive(Default)]
struct Simplex {
    points: [Vector3<f64>; 3],
    count: usize,
    /// The least distance so far, m.
    least: Option<f64>,
}

/// Where the origin is.
enum Nearest {
    /// Within four points.
    Within,
    /// Outside; the nearest point to it.
    At(Vector3<f64>),
}

impl Simplex {
    /// Takes in another point, and keeps those that the nearest to the origin is a mean of.
    fn take_in(&mut self, d: Vector3<f64>) -> Nearest {
        let [a, b, c] = self.points;
        let (place, kept) = match self.count {
            0 => (d, [true, false, false]),
            1 => of_segment(&[d, a]),
            2 => of_triangle(&[d, a, b]),
            _ => {
                if is_within(&[a, b, c, d]) {
                    return Nearest::Within;
                }
                // One of those that the new point is of: from the old one the origin is seen through it.
                let faces = [[d, a, b], [d, b, c], [d, c, a]];
                let (mut best, mut least) = (0, f64::INFINITY);
                let mut found = [(Vector3::zeros(), [false; 3]); 3];
                for (face, points) in faces.iter().enumerate() {
                    found[face] = of_triangle(points);
                    let distance = found[face].0.norm_squared();
                    if distance < least {
                        (best, least) = (face, distance);
                    }
                }
                self.keep(&faces[best], found[best].1);
                return Nearest::At(found[best].0);
            }
        };
        self.keep(&[d, a, b], kept);
        Nearest::At(place)
    }

    fn keep(&mut self, points: &[Vector3<f64>; 3], kept: [bool; 3]) {
        self.count = 0;
        for (point, _) in points.iter().zip(kept).filter(|(_, kept)| *kept) {
            self.points[self.count] = *point;
            self.count += 1;
        }
    }

    /// Whether a distance, m, is not less than before; it is noted.
    fn is_stuck(&mut self, length: f64) -> bool {
        let least = self.least.replace(length);
        least.is_some_and(|least| length >= least)
    }
}

/// Whether the origin is within a tetrahedron, or on it.
fn is_within([a, b, c, d]: &[Vector3<f64>; 4]) -> bool {
    let volume = |a: &Vector3<f64>, b: &Vector3<f64>, c: &Vector3<f64>| a.dot(&b.cross(c));
    // Six times the volumes between the origin and each side, of the same sign where it is within.
    let parts = [volume(b, d, c), volume(a, c, d), volume(a, d, b), volume(a, b, c)];
    parts.iter().all(|part| *part > 0.0) || parts.iter().all(|part| *part < 0.0)
}

/// The point of a segment that is nearest to the origin, and which ends it is a mean of.
fn of_segment([a, b]: &[Vector3<f64>; 2]) -> (Vector3<f64>, [bool; 3]) {
    let way = b - a;
    let share = -a.dot(&way) / way.norm_squared();
    if share > 0.0 && share < 1.0 {
        (a + way * share, [true, true, false])
    } else if share >= 1.0 {
        (*b, [false, true, false])
    } else {
        (*a, [true, false, false])
    }
}

/// The same of a triangle (Ericson 2005, 5.1.5).
fn of_triangle([a, b, c]: &[Vector3<f64>; 3]) -> (Vector3<f64>, [bool; 3]) {
    let (ab, ac) = (b - a, c - a);
    let (d1, d2) = (-ab.dot(a), -ac.dot(a));
    if d1 <= 0.0 && d2 <= 0.0 {
        return (*a, [true, false, false]);
    }
    let (d3, d4) = (-ab.dot(b), -ac.dot(b));
    if d3 >= 0.0 && d4 <= d3 {
        return (*b, [false, true, false]);
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return (a + ab * (d1 / (d1 - d3)), [true, true, false]);
    }
    let (d5, d6) = (-ab.dot(c), -ac.dot(c));
    if d6 >= 0.0 && d5 <= d6 {
        return (*c, [false, false, true]);
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return (a + ac * (d2 / (d2 - d6)), [true, false, true]);
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        let share = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return (b + (c - b) * share, [false, true, true]);
    }
    let whole = va + vb + vc;
    (a + ab * (vb / whole) + ac * (vc / whole), [true, true, true])
}

#[cfg(test)]
mod tests {
    use nalgebra::UnitQuaternion;

    use super::*;
    use crate::physics::query::solid::Outline;
    use crate::physics::testing::Random;
    use crate::physics::{Collider, Geometry};

    fn solid<'g>(geometry: &'g Geometry, radius: f64, position: Vector3<f64>, turn: UnitQuaternion<f64>) -> Solid<'g> {
        Solid { shape: Outline::Solid(geometry), position, axes: turn.to_rotation_matrix().into_inner(), radius }
    }

    /// Along the line between two middles shapes meet up to one distance, and are apart from there on.
    #[test]
    fn what_meets_is_told_to_rounding() {
        let colliders = [
            Collider::sphere(0.4),
            Collider::cuboid(0.6, 0.9, 0.4),
            Collider::capsule(0.2, 0.7),
            Collider::cylinder(0.4, 0.5),
            Collider::cone(0.5, 0.8),
        ];
        let mut random = Random::new(11);
        let mut open = 0;
        for case in 0..2000 {
            let [one, other] = [case % 5, case / 5 % 5].map(|kind| &colliders[kind]);
            let shapes = [one, other].map(|collider| (collider.geometry(), collider.bounding_radius()));
            let turns = [random.rotation(), random.rotation()];
            let way = random.direction();
            let mut meets = |distance: f64| {
                let [a, b] =
                    [0, 1].map(|end| solid(&shapes[end].0, shapes[end].1, way * (distance * end as f64), turns[end]));
                let found = meet(&a, &b);
                open += u32::from(found.is_none());
                found
            };
            let (mut low, mut high) = (0.0, shapes[0].1 + shapes[1].1 + 1e-6);
            assert_eq!(meets(high), Some(false), "{one:?} {other:?}");
            while high - low > 1e-6 {
                let middle = 0.5 * (low + high);
                match meets(middle) {
                    Some(true) => low = middle,
                    Some(false) => high = middle,
                    None => break,
                }
            }
            // Convex shapes that meet there do so nearer, too, and none farther.
            for share in [0.1, 0.5, 0.9, 0.999] {
                assert_ne!(meets(low * share), Some(false), "{one:?} {other:?} at {low} * {share}");
                assert_ne!(meets(high + (1.0 - share)), Some(true), "{one:?} {other:?} at {high}");
            }
        }
        assert!(open < 1000, "{open} left open");
    }
}
