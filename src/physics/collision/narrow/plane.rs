//! A half-space against any other shape: what lies below its plane, or so little above that it may
//! get there within the step.

use nalgebra::Vector3;

use super::clipping::keep_touching_spread;
use super::revolved::Revolved;
use super::{ClipBuffers, Cone, Cuboid, Cylinder, Frame, Overlap, Polyhedron, Scale};
use crate::physics::collision::constants::RIM_POINTS;
use crate::physics::{ContactPoint, FeatureId, Geometry};

/// Tests the half-space y ≤ 0 and a shape in its axes, and adds the points up to a gap above the
/// plane, half-way to it: of a polyhedron its vertices, of a cone its apex and four points of the rim,
/// the lowest among them, of a cylinder those of both rims. Of a shape that is higher, leaves in `apart` by how much.
pub(crate) fn touch(
    shape: &Geometry,
    in_plane: &Frame,
    scale: &Scale,
    buffers: &mut ClipBuffers,
    apart: &mut f64,
    points: &mut Vec<ContactPoint>,
) -> Option<Overlap> {
    let ClipBuffers { incident: corners, found, .. } = buffers;
    found.clear();
    let mut lowest = f64::INFINITY;
    let mut add = |place: Vector3<f64>, feature| {
        lowest = lowest.min(place.y);
        let depth = scale.rounded(-place.y);
        if !scale.separates(depth) {
            let point = place + Vector3::y() * (depth / 2.0);
            found.push(ContactPoint { point, depth, feature });
        }
    };
    match shape {
        Geometry::Sphere { radius } => add(in_plane.center - Vector3::y() * *radius, FeatureId::default()),
        Geometry::Cuboid { half } => each_vertex(&Cuboid { half: *half }, in_plane, add),
        Geometry::Hull(hull) => each_vertex(&**hull, in_plane, add),
        Geometry::Cone { radius, height, .. } => {
            let cone = Cone::new(*radius, *height);
            corners.clear();
            cone.bottom().corners(&-in_plane.enter(&Vector3::y()), RIM_POINTS, corners);
            corners.push(cone.apex_point());
            for (corner, place) in (0..).zip(&*corners) {
                add(in_plane.place(place), FeatureId::of_vertex(true, corner));
            }
        }
        Geometry::Cylinder { radius, half, .. } => {
            let cylinder = Cylinder { radius: *radius, half: *half };
            corners.clear();
            for end in cylinder.ends().into_iter().flatten() {
                end.corners(&-in_plane.enter(&Vector3::y()), RIM_POINTS, corners);
            }
            for (corner, place) in (0..).zip(&*corners) {
                add(in_plane.place(place), FeatureId::of_vertex(true, corner));
            }
        }
        Geometry::Capsule { .. } => unreachable!("it has a routine for all shapes"),
        Geometry::HalfSpace => unreachable!("two half-spaces make no pair"),
        Geometry::Parts(_) => unreachable!("parts come one by one"),
    }
    let Some(depth) = found.iter().map(|point| point.depth).reduce(f64::max) else {
        *apart = lowest;
        return None;
    };
    keep_touching_spread(found, &Vector3::y(), scale.size, points);
    Some(Overlap { normal: Vector3::y(), depth })
}

fn each_vertex(shape: &impl Polyhedron, in_plane: &Frame, mut add: impl FnMut(Vector3<f64>, FeatureId)) {
    for index in 0..shape.vertex_count() {
        add(in_plane.place(&shape.vertex(index)), FeatureId::of_vertex(true, index as u32));
    }
}
