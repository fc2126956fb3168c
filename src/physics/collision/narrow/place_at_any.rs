//! Where a point is with respect to any shape, of one part or many.

use nalgebra::Vector3;

use super::{ball, triangle};
use crate::physics::shape::{PartList, Parts, Solid};
use crate::physics::{BoundingBox, Geometry};

/// The unit normal out of a shape of that bounding radius along the shortest way between its surface and a point in its
/// axes, and how far the point is out, m, negative inside; where that is more than `most`, only that it is.
pub(crate) fn place_up_to(shape: &Geometry, point: &Vector3<f64>, radius: f64, most: f64) -> (Vector3<f64>, f64) {
    match shape {
        Geometry::Parts(parts) => place_at_parts(parts, point, most),
        _ => ball::place_up_to(shape, point, radius, most),
    }
}

/// The same of that part of a shape alone, where it has parts; of a facet of many triangles, of the whole mesh.
pub(crate) fn place_at_part(shape: &Geometry, part: u32, point: &Vector3<f64>, radius: f64) -> (Vector3<f64>, f64) {
    let Geometry::Parts(parts) = shape else { return ball::place(shape, point, radius) };
    match &parts.list {
        PartList::Triangles(mesh) => match mesh.only_triangle(part) {
            Some(triangle) => triangle::place(&mesh.get(triangle), point),
            None => place_at_parts(parts, point, f64::INFINITY),
        },
        PartList::Solids(solids) => place_at_solid(&solids[part as usize], point, f64::INFINITY),
    }
}

fn place_at_solid(solid: &Solid, point: &Vector3<f64>, most: f64) -> (Vector3<f64>, f64) {
    let local = solid.rotation.inverse_transform_vector(&(point - solid.position));
    let (normal, height) = ball::place_up_to(&solid.geometry, &local, solid.radius, most);
    (solid.rotation * normal, height)
}

/// At the nearest of the parts; from a mesh, which has no inside, every point is away.
fn place_at_parts(parts: &Parts, point: &Vector3<f64>, most: f64) -> (Vector3<f64>, f64) {
    let mut nearest = (Vector3::y(), f64::INFINITY);
    let distance = |bounds: &BoundingBox| bounds.distance(point);
    let mut take = |found: (Vector3<f64>, f64)| {
        if found.1 < nearest.1 {
            nearest = found;
        }
        nearest.1.max(0.0)
    };
    parts.tree().search(most.max(0.0), distance, |part, most| match &parts.list {
        PartList::Triangles(mesh) => {
            let mut most = most;
            mesh.search(part, most, distance, |triangle, _| {
                let corners = mesh.corners_of(triangle).map(|corner| corner - point);
                if triangle::nearest_on_triangle(&corners, &Vector3::zeros()).norm_squared() <= most * most {
                    most = take(triangle::place(&mesh.get(triangle), point));
                }
                most
            });
            most
        }
        PartList::Solids(solids) => take(place_at_solid(&solids[part as usize], point, most)),
    });
    nearest
}
