//! The convex hull of points as a shape of a scene.

use std::fmt;
use std::sync::{Arc, OnceLock};

use bevy::math::DVec3;

use crate::physics::{ConvexHull, HullError};

/// Points whose convex hull is a shape. Cheap to clone; the hull is built once, when first needed.
#[derive(Clone)]
pub struct HullSpec(Arc<Inner>);

struct Inner {
    points: Box<[DVec3]>,
    hull: OnceLock<Result<ConvexHull, HullError>>,
}

impl HullSpec {
    /// The hull of points, m.
    pub fn new(points: impl Into<Box<[DVec3]>>) -> Self {
        Self(Arc::new(Inner { points: points.into(), hull: OnceLock::new() }))
    }

    /// As given.
    pub fn points(&self) -> &[DVec3] {
        &self.0.points
    }

    /// Their hull, or why they have none: never of a valid scene.
    pub fn hull(&self) -> &Result<ConvexHull, HullError> {
        self.0.hull.get_or_init(|| ConvexHull::new(&self.0.points))
    }
}

impl From<ConvexHull> for HullSpec {
    /// That very hull.
    fn from(hull: ConvexHull) -> Self {
        let points = hull.vertices().map(|vertex| hull.center() + hull.axes() * vertex).collect();
        Self(Arc::new(Inner { points, hull: OnceLock::from(Ok(hull)) }))
    }
}

impl PartialEq for HullSpec {
    fn eq(&self, other: &Self) -> bool {
        self.points() == other.points()
    }
}

impl fmt::Debug for HullSpec {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.debug_tuple("HullSpec").field(&self.points()).finish()
    }
}
