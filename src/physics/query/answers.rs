//! What is asked for, and what comes back.

use bevy::math::DVec3;
use bevy::prelude::*;

/// A ray to be followed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where it begins, m.
    pub origin: DVec3,
    /// Where it goes, of any length but zero.
    pub direction: DVec3,
    /// How far it is followed, m; may be infinite.
    pub length: f64,
}

impl Ray {
    /// From a point along a direction, without an end.
    pub fn new(origin: DVec3, direction: DVec3) -> Self {
        Self { origin, direction, length: f64::INFINITY }
    }
}

/// Where a ray meets a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayHit {
    /// The body.
    pub entity: Entity,
    /// From the ray's origin, m; 0 where that is inside.
    pub distance: f64,
    /// World position, m.
    pub point: DVec3,
    /// Unit, out of the body; against the ray where that begins inside.
    pub normal: DVec3,
}

/// The point of a body that is nearest to a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointHit {
    /// The body.
    pub entity: Entity,
    /// Between the two points, m; 0 where the one asked about is inside.
    pub distance: f64,
    /// World position, m.
    pub point: DVec3,
}

/// Where a shape on its way touches a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CastHit {
    /// The body.
    pub entity: Entity,
    /// How far the shape came, m; 0 where it overlaps the body from the start.
    pub distance: f64,
    /// A point of the body that is touched, world position, m.
    pub point: DVec3,
    /// Unit, out of the body.
    pub normal: DVec3,
}

/// What is found, and how far it is.
pub(super) trait Hit: Copy {
    /// Its distance, and its body, by which hits at one distance are told apart.
    fn key(&self) -> (f64, Entity);
}

macro_rules! hits {
    ($($Hit:ty),*) => {$(
        impl Hit for $Hit {
            fn key(&self) -> (f64, Entity) {
                (self.distance, self.entity)
            }
        }
    )*};
}

hits!(RayHit, PointHit, CastHit);
