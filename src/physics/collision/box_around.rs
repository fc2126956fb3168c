//! Which facets of a mesh a solid may meet: an early test that leaves out most of those whose boxes overlap its own.
//!
//! Around the solid is a box in its own axes, rounded where the solid is round. It and a facet are apart if they are along the
//! facet's normal, or along an axis of the box (Gottschalk, Lin and Manocha 1996, less the crossings of edges). A hull and a
//! facet are if they are along the normal of one of the hull's faces, too.

use nalgebra::{Matrix3, Vector3};

use super::narrow::Frame;
use crate::physics::Geometry;
use crate::physics::shape::{Face, Triangles};

/// A rounded box around a solid, and a distance within which what is near it matters.
#[derive(Clone, Copy, Debug)]
pub(super) struct BoxAround<'s> {
    /// Its axes, and its middle.
    frame: Frame,
    half: Vector3<f64>,
    /// The radius of its rounding, and the distance, m.
    wide: f64,
    /// The faces of a hull, and the middle of the box in its axes.
    faces: &'s [Face],
    middle: Vector3<f64>,
    distance: f64,
}

impl<'s> BoxAround<'s> {
    /// Of a solid placed in a mesh's axes.
    pub fn new(shape: &'s Geometry, mut frame: Frame, distance: f64) -> Self {
        let mut middle = Vector3::zeros();
        let (half, radius) = match shape {
            Geometry::Sphere { radius } => (Vector3::zeros(), *radius),
            Geometry::Capsule { radius, half, .. } => (Vector3::y() * *half, *radius),
            _ => {
                let whole = [Vector3::repeat(f64::NEG_INFINITY), Vector3::repeat(f64::INFINITY)];
                let [low, high] = shape.reach(&Matrix3::identity()).unwrap_or(whole);
                middle = (low + high) / 2.0;
                frame.center += frame.rotation * middle;
                ((high - low) / 2.0, 0.0)
            }
        };
        let faces = if let Geometry::Hull(hull) = shape { &hull.faces[..] } else { &[] };
        Self { frame, half, wide: radius + distance, faces, middle, distance }
    }

    /// Whether the facet may be within the distance.
    pub fn may_meet(&self, mesh: &Triangles, facet: u32) -> bool {
        let Frame { rotation, center } = &self.frame;
        let triangles = mesh.triangles_of(facet);
        let (corners, normal) = (mesh.corners_of(triangles[0]), mesh.normal(triangles[0]));
        let height = normal.dot(&(center - corners[0])).abs();
        if height > rotation.tr_mul(&normal).abs().dot(&self.half) + self.wide {
            return false;
        }
        if triangles.len() > 1 {
            return true;
        }
        let [a, b, c] = corners.map(|corner| rotation.tr_mul(&(corner - center)));
        let (low, high) = (a.inf(&b).inf(&c), a.sup(&b).sup(&c));
        if (0..3).any(|axis| low[axis].max(-high[axis]) > self.half[axis] + self.wide) {
            return false;
        }
        let corners = [a, b, c].map(|corner| corner + self.middle);
        self.faces.iter().all(|face| {
            let nearest = corners.iter().map(|corner| face.normal.dot(corner)).fold(f64::INFINITY, f64::min);
            nearest - face.offset <= self.distance
        })
    }
}
