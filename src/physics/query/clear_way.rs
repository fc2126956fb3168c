//! How far a shape goes before it can touch another, in a few cheap steps: what passes by is mostly told at once.
//!
//! With w(n) the vector from the foremost point of the mover along n to that of the other along −n, n·w(n) is at most their
//! distance, and along d the way is clear for n·w/(n·d), for ever where n·d ≤ 0. From some direction on, v goes to the nearest
//! point to the origin of the segment from v to w(v/|v|) (Gilbert 1966): |v| is never less than the distance. While the
//! mover goes on, all of these vectors go along (van den Bergen 2004).

use nalgebra::{Matrix3, Vector3};

use crate::physics::Geometry;

/// Steps at most: more tell little that the exact look does not tell.
const STEPS: u32 = 12;

/// A share of the sizes that is more than rounding.
const SLACK: f64 = 1e-9;

/// Distance, as a share of the way there, from which on the exact look is better.
const CLOSE: f64 = 0.02;

/// A solid, or a triangle, where it is.
pub(super) struct Solid<'g> {
    pub shape: Outline<'g>,
    /// From a place near both.
    pub position: Vector3<f64>,
    pub axes: Matrix3<f64>,
    /// Bounding radius.
    pub radius: f64,
}

/// What a solid reaches with.
pub(super) enum Outline<'g> {
    Solid(&'g Geometry),
    Corners([Vector3<f64>; 3]),
}

impl Solid<'_> {
    /// The farthest point of its core along a direction, and what is all around that.
    pub fn farthest(&self, direction: &Vector3<f64>) -> Option<(Vector3<f64>, f64)> {
        let along = self.axes.tr_mul(direction);
        let (local, around) = match &self.shape {
            Outline::Solid(geometry) => geometry.farthest(&along)?,
            Outline::Corners(corners) => {
                let heights = Vector3::from(corners.map(|corner| corner.dot(&along)));
                (corners[heights.imax()], 0.0)
            }
        };
        Some((self.position + self.axes * local, around))
    }

    /// Whether it is bounded by flat faces alone.
    pub fn is_polyhedron(&self) -> bool {
        matches!(self.shape, Outline::Corners(_) | Outline::Solid(Geometry::Cuboid { .. } | Geometry::Hull(_)))
    }

    /// Whether it is all that is within a radius of a point or a segment.
    pub fn is_round(&self) -> bool {
        matches!(self.shape, Outline::Solid(Geometry::Sphere { .. } | Geometry::Capsule { .. }))
    }

    /// Whether a place is before it, if it has a front alone, as a triangle of a mesh has.
    pub fn faces(&self, place: &Vector3<f64>) -> bool {
        let Outline::Corners([a, b, c]) = &self.shape else { return true };
        let normal = self.axes * (b - a).cross(&(c - a));
        normal.dot(&(place - self.position)) > 0.0
    }

    /// The farthest point of it along a unit direction.
    pub fn support(&self, direction: &Vector3<f64>) -> Option<Vector3<f64>> {
        let (point, around) = self.farthest(direction)?;
        Some(point + direction * around)
    }
}

/// What is known before an exact look.
#[derive(Clone, Copy, Debug)]
pub(super) struct Clear {
    /// How far the way is clear, m.
    pub distance: f64,
    /// How far apart the shapes are there at most, m.
    pub within: f64,
}

/// How far a mover on its way along a unit direction certainly touches nothing of the other; none: not within `most`.
pub(super) fn clear_way(mover: &Solid, other: &Solid, direction: &Vector3<f64>, most: f64) -> Option<Clear> {
    let mut clear = Clear { distance: 0.0, within: f64::INFINITY };
    let between = other.position - mover.position;
    let size = mover.radius + other.radius;
    let slack = SLACK * (size + between.norm());
    let Some(mut normal) = between.try_normalize(slack) else { return Some(clear) };
    let look = |normal: &Vector3<f64>, distance: f64| {
        let ((from, around), (to, around_other)) = (mover.farthest(normal)?, other.farthest(&-normal)?);
        Some((to - from - direction * distance, around + around_other))
    };
    let mut nearest: Option<Vector3<f64>> = None;
    for _ in 0..STEPS {
        let Some((mut next, around)) = look(&normal, clear.distance) else { return Some(clear) };
        let gap = normal.dot(&next) - around - slack;
        if gap > 0.0 {
            let approach = normal.dot(direction);
            if approach <= 0.0 {
                return None;
            }
            let step = gap / approach;
            clear.distance += step;
            if clear.distance > most {
                return None;
            }
            next -= direction * step;
            nearest = nearest.map(|nearest| nearest - direction * step);
        }
        let toward = match nearest {
            None => next,
            Some(from) => {
                let way = next - from;
                let share = -from.dot(&way) / way.norm_squared();
                if share.is_nan() { from } else { from + way * share.clamp(0.0, 1.0) }
            }
        };
        nearest = Some(toward);
        let length = toward.norm();
        clear.within = (length - around).max(0.0) + slack;
        if length <= around + CLOSE * size {
            break;
        }
        normal = toward / length;
    }
    Some(clear)
}
