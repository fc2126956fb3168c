//! The point of a shape that is farthest along a direction.

use nalgebra::Vector3;

use super::Geometry;

impl Geometry {
    /// The farthest point along a direction of the shape's core, in the shape's axes, and by how much the shape is larger all
    /// around; none of a half-space, and of what has parts.
    pub fn farthest(&self, direction: &Vector3<f64>) -> Option<(Vector3<f64>, f64)> {
        let turned = |radius: f64, y: f64| {
            let across = across(direction);
            let scale = if across > 0.0 { radius / across } else { 0.0 };
            Vector3::new(direction.x * scale, y, direction.z * scale)
        };
        Some(match self {
            Self::HalfSpace | Self::Parts(_) => return None,
            Self::Sphere { radius } => (Vector3::zeros(), *radius),
            Self::Capsule { radius, half, .. } => (Vector3::new(0.0, half.copysign(direction.y), 0.0), *radius),
            Self::Cuboid { half } => (half.zip_map(direction, f64::copysign), 0.0),
            Self::Cylinder { radius, half, .. } => (turned(*radius, half.copysign(direction.y)), 0.0),
            Self::Cone { radius, height, .. } => {
                let is_apex = direction.y * height > radius * across(direction);
                let apex = Vector3::new(0.0, 0.75 * height, 0.0);
                (if is_apex { apex } else { turned(*radius, -0.25 * height) }, 0.0)
            }
            Self::Hull(hull) => (hull.farthest(direction), 0.0),
        })
    }
}

/// The length of a direction across y: of directions, which are no longer than numbers can be squared.
fn across(direction: &Vector3<f64>) -> f64 {
    (direction.x * direction.x + direction.z * direction.z).sqrt()
}
