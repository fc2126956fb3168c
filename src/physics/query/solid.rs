//! Convex solids, and triangles, where they are: what two shapes are compared by without contact points.

use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use crate::physics::shape::PartList;
use crate::physics::{Body, Geometry};

/// Where something is, and its axes.
pub(super) type At = (Vector3<f64>, Matrix3<f64>);

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

/// The axes, as columns, of a shape that is turned so. To a ball any will do: there they are not worked out.
#[inline]
pub(super) fn axes_of(geometry: &Geometry, rotation: &UnitQuaternion<f64>) -> Matrix3<f64> {
    match geometry {
        Geometry::Sphere { .. } => Matrix3::identity(),
        _ => rotation.to_rotation_matrix().into_inner(),
    }
}

/// A body's shape, or that part of it, from a place; none of a half-space and of a facet of many triangles.
pub(super) fn solid_of<'b>(body: &'b Body, part: u32, from: &Vector3<f64>) -> Option<Solid<'b>> {
    let geometry = body.geometry.as_ref()?;
    solid_at(geometry, (body.position - from, axes_of(geometry, &body.rotation)), body.radius, part)
}

/// The same of a shape where it is, its axes as columns, of that bounding radius.
pub(super) fn solid_at(geometry: &Geometry, (position, axes): At, radius: f64, part: u32) -> Option<Solid<'_>> {
    match geometry.parts().map(|parts| &parts.list) {
        None => {
            let shape = Outline::Solid(geometry);
            radius.is_finite().then_some(Solid { shape, position, axes, radius })
        }
        Some(PartList::Solids(solids)) => {
            let solid = &solids[part as usize];
            let position = position + axes * solid.position;
            let axes = axes * solid.rotation.to_rotation_matrix().into_inner();
            Some(Solid { shape: Outline::Solid(&solid.geometry), position, axes, radius: solid.radius })
        }
        Some(PartList::Triangles(mesh)) => {
            let corners = mesh.corners_of(mesh.only_triangle(part)?);
            let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
            let corners = corners.map(|corner| corner - middle);
            let radius = corners.iter().map(Vector3::norm).fold(0.0, f64::max);
            Some(Solid { shape: Outline::Corners(corners), position: position + axes * middle, axes, radius })
        }
    }
}
