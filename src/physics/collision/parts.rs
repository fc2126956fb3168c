//! Bodies whose shape has parts: each part where it is, and which parts of two bodies are near each other.

use nalgebra::{UnitQuaternion, Vector3};

use super::broad::bounding_tree::BoundingBox;
use super::manifold::PartPair;
use crate::physics::shape::{PartList, Parts, Triangles, placed_box};
use crate::physics::{Body, Geometry};

/// The shape of a body, or of one of its parts.
#[derive(Clone, Copy, Debug)]
pub(super) enum PartShape<'t> {
    Solid(&'t Geometry),
    /// A facet of a mesh.
    Facet(&'t Triangles, u32),
}

/// A shape where it is.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placed<'t> {
    pub shape: PartShape<'t>,
    /// Bounding radius about its own centre, m.
    pub radius: f64,
    pub position: Vector3<f64>,
    pub rotation: UnitQuaternion<f64>,
}

impl<'t> Placed<'t> {
    /// A body's shape, or that part of it; none if it has no shape.
    pub fn of(body: &'t Body, part: u32) -> Option<Self> {
        let geometry = body.geometry.as_ref()?;
        let (position, rotation) = (body.position, body.rotation);
        let Some(parts) = geometry.parts() else {
            return Some(Self { shape: PartShape::Solid(geometry), radius: body.radius, position, rotation });
        };
        Some(match &parts.list {
            PartList::Solids(solids) => {
                let solid = solids.get(part as usize)?;
                let (shape, radius) = (PartShape::Solid(&solid.geometry), solid.radius);
                Self {
                    shape,
                    radius,
                    position: position + rotation * solid.position,
                    rotation: rotation * solid.rotation,
                }
            }
            PartList::Triangles(triangles) => {
                let shape = PartShape::Facet(triangles, part);
                Self { shape, radius: body.radius, position, rotation }
            }
        })
    }
}

/// Whether pairs of a body are looked at part by part.
pub(super) fn has_parts(body: &Body) -> bool {
    parts_of(body).is_some()
}

fn parts_of(body: &Body) -> Option<&Parts> {
    body.geometry.as_ref().and_then(Geometry::parts)
}

/// Adds those parts of two bodies whose boxes overlap where B is in a box of the world and A in another, both wide enough for
/// what the bodies may move; none of a half-space, which is everywhere. Boxes of parts are grown by as much as `growth` tells
/// of what a body has within a radius of a place, m.
pub(super) fn near_parts(
    [a, b]: [&Body; 2],
    within: [Option<BoundingBox>; 2],
    growth: impl Fn(&Body, &Vector3<f64>, f64) -> f64 + Copy,
    list: &mut Vec<PartPair>,
) {
    let about = |body: &Body| (body.position, body.radius);
    match (parts_of(a), parts_of(b)) {
        (None, None) => list.push(PartPair::default()),
        (Some(of_a), None) => {
            parts_in(a, of_a, about(b), within[1], growth, |part| list.push(PartPair { a: part, b: 0 }))
        }
        (None, Some(of_b)) => {
            parts_in(b, of_b, about(a), within[0], growth, |part| list.push(PartPair { a: 0, b: part }))
        }
        // Two meshes never touch.
        (Some(of_a), Some(of_b)) if of_a.is_mesh() && of_b.is_mesh() => {}
        (Some(_), Some(of_b)) if of_b.is_mesh() => {
            let first = list.len();
            near_parts([b, a], [within[1], within[0]], growth, list);
            list[first..].iter_mut().for_each(|pair| *pair = pair.swapped());
        }
        // The solids of B, each against the parts of A.
        (Some(of_a), Some(of_b)) => {
            let axes = b.rotation.to_rotation_matrix().into_inner();
            parts_in(b, of_b, about(a), within[0], growth, |part_of_b| {
                let solid = &of_b.solids()[part_of_b as usize];
                let bounds = placed_box(&solid.bounds(), &axes, &b.position);
                let middle = b.position + axes * solid.position;
                let within = Some(bounds.grown(growth(b, &middle, solid.radius)));
                parts_in(a, of_a, (middle, solid.radius), within, growth, |part| {
                    list.push(PartPair { a: part, b: part_of_b })
                });
            });
        }
    }
}

/// Hands on the parts of a body whose boxes overlap one of the world, of something within a radius of a middle: a mesh's are
/// grown by what moves there, of solids each by its own way.
fn parts_in(
    body: &Body,
    parts: &Parts,
    (middle, radius): (Vector3<f64>, f64),
    within: Option<BoundingBox>,
    growth: impl Fn(&Body, &Vector3<f64>, f64) -> f64,
    mut take: impl FnMut(u32),
) {
    let Some(bounds) = within else {
        (0..parts.solids().len() as u32).for_each(take);
        return;
    };
    let axes = body.rotation.to_rotation_matrix().into_inner();
    let into_body = axes.transpose();
    let bounds = placed_box(&bounds, &into_body, &-(into_body * body.position));
    let PartList::Solids(solids) = &parts.list else {
        return parts.tree().overlapping(&bounds.grown(growth(body, &middle, radius)), &mut take);
    };
    // No part reaches as far from the body's middle.
    let most = growth(body, &body.position, 2.0 * body.radius);
    parts.tree().overlapping(&bounds.grown(most), |part| {
        let solid = &solids[part as usize];
        let own = growth(body, &(body.position + axes * solid.position), solid.radius);
        if solid.bounds().overlaps(&bounds.grown(own)) {
            take(part);
        }
    });
}

/// A box that holds a body's shape where it is; none of a half-space, and of what has no shape.
pub(crate) fn box_of(body: &Body) -> Option<BoundingBox> {
    let [low, high] = body.geometry.as_ref()?.reach(&body.rotation.to_rotation_matrix().into_inner())?;
    Some(BoundingBox { low: body.position + low, high: body.position + high })
}

/// The parts of two bodies that may be apart by no more than a distance where they are, m.
pub(crate) fn parts_within(a: &Body, b: &Body, distance: f64, list: &mut Vec<PartPair>) {
    list.clear();
    if has_parts(a) || has_parts(b) {
        near_parts([a, b], [box_of(a), box_of(b)], |_, _, _| distance, list);
    } else {
        list.push(PartPair::default());
    }
}
