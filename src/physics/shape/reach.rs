//! How far a shape reaches along the axes of the world.

use nalgebra::{Matrix3, Vector3};

use super::Geometry;
use crate::physics::BoundingBox;

impl Geometry {
    /// A box that holds it where it is, m, its axes as columns; none of a half-space.
    pub fn bounds_at(&self, position: &Vector3<f64>, axes: &Matrix3<f64>) -> Option<BoundingBox> {
        let [low, high] = self.reach(axes)?;
        Some(BoundingBox { low: position + low, high: position + high })
    }

    /// The least and the greatest coordinates of its points from its centre of mass, m, by the axes of its body as columns;
    /// none of a half-space.
    pub fn reach(&self, axes: &Matrix3<f64>) -> Option<[Vector3<f64>; 2]> {
        Some(match self {
            Self::HalfSpace => return None,
            Self::Sphere { radius } => [Vector3::repeat(-radius), Vector3::repeat(*radius)],
            Self::Cuboid { half } => {
                let reach = axes.abs() * half;
                [-reach, reach]
            }
            Self::Capsule { radius, half, .. } => {
                let reach = (axes.column(1) * *half).abs().add_scalar(*radius);
                [-reach, reach]
            }
            Self::Cylinder { radius, half, .. } => {
                let axis = axes.column(1);
                let reach = axis.map(|along| along.abs() * half + radius * (1.0 - along * along).max(0.0).sqrt());
                [-reach, reach]
            }
            Self::Cone { radius, height, .. } => {
                // The apex, and the disc of the base.
                let axis = axes.column(1);
                let disc = axis.map(|along| radius * (1.0 - along * along).max(0.0).sqrt());
                let (apex, base) = (axis * (0.75 * height), axis * (-0.25 * height));
                [apex.inf(&(base - disc)), apex.sup(&(base + disc))]
            }
            Self::Parts(parts) => parts.reach(axes),
            Self::Hull(hull) => {
                let start = [Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY)];
                hull.vertices
                    .iter()
                    .map(|vertex| axes * vertex)
                    .fold(start, |[low, high], v| [low.inf(&v), high.sup(&v)])
            }
        })
    }
}
