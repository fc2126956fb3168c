//! Where a point is with respect to a solid.

use nalgebra::Vector3;

use crate::physics::collision::constants::ON_SURFACE;

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
