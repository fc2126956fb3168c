//! Bodies whose shape has parts: each part where it is, and which parts of two bodies are near each other.

use std::ops::ControlFlow;

use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use super::box_around::BoxAround;
use super::broad::bounding_tree::BoundingBox;
use super::constants::CONTACT_TOLERANCE;
use super::manifold::PartPair;
use super::narrow::Frame;
use crate::physics::shape::{PartList, Parts, Triangles, placed_box};
use crate::physics::{Body, Geometry};

/// The shape of a body, or of one of its parts.
#[derive(Clone, Copy, Debug)]
pub(super) enum PartShape<'t> {
    Solid(&'t Geometry),
    /// A facet or cluster of a mesh.
    Facet(&'t Triangles, u32),
}

impl PartShape<'_> {
    /// Whether it is a cluster of a mesh.
    pub fn is_cluster(&self) -> bool {
        matches!(self, Self::Facet(mesh, part) if mesh.is_cluster(*part))
    }
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
pub(crate) fn has_parts(body: &Body) -> bool {
    parts_of(body).is_some()
}

/// Whether a body is a mesh.
pub(super) fn is_mesh(body: &Body) -> bool {
    body.geometry.as_ref().is_some_and(Geometry::is_mesh)
}

/// The smallest bounding radius among the solids of a body, of a mesh its own, m.
pub(super) fn least_radius(body: &Body) -> f64 {
    let solids = parts_of(body).map_or(&[][..], Parts::solids);
    solids.iter().map(|solid| solid.radius).fold(body.radius, f64::min)
}

fn parts_of(body: &Body) -> Option<&Parts> {
    body.geometry.as_ref().and_then(Geometry::parts)
}

/// How far what a body has within a radius of a place moves in a step at most, m.
pub(super) type Way<'t> = dyn Fn(&Body, &Vector3<f64>, f64) -> f64 + 't;

/// Adds those parts of two bodies that may meet where either moves: boxes of parts, grown by as much as `growth` tells of what a
/// body has within a radius of a place, m, overlap. A half-space is everywhere. Two meshes never touch. Where it is told
/// how far bodies move, polyhedra that are slower than thick meet the clusters of a mesh.
pub(super) fn near_parts(
    [a, b]: [&Body; 2],
    by_cluster: Option<&Way>,
    growth: impl Fn(&Body, &Vector3<f64>, f64) -> f64 + Copy,
    list: &mut Vec<PartPair>,
) {
    let whole = |body| Mover::of(body, 0, growth);
    match (parts_of(a), parts_of(b)) {
        (None, None) => list.push(PartPair::default()),
        (Some(of_a), None) => {
            parts_near(a, of_a, whole(b), by_cluster, growth, |part| list.push(PartPair { a: part, b: 0 }));
        }
        (None, Some(of_b)) => {
            parts_near(b, of_b, whole(a), by_cluster, growth, |part| list.push(PartPair { a: 0, b: part }));
        }
        (Some(of_a), Some(of_b)) if of_a.is_mesh() && of_b.is_mesh() => {}
        (Some(_), Some(of_b)) if of_b.is_mesh() => {
            let first = list.len();
            near_parts([b, a], by_cluster, growth, list);
            list[first..].iter_mut().for_each(|pair| *pair = pair.swapped());
        }
        // The solids of B, each against the parts of A.
        (Some(of_a), Some(of_b)) => {
            let axes = b.rotation.to_rotation_matrix().into_inner();
            let into_b = axes.transpose();
            let around_a = box_of(a).map(|bounds| bounds.grown(growth(a, &a.position, a.radius)));
            let Some(around_a) = around_a else { return };
            let around_a = placed_box(&around_a, &into_b, &-(into_b * b.position));
            let most = growth(b, &b.position, 2.0 * b.radius);
            solids_in(b, of_b, &axes, &around_a, most, growth, |part_of_b| {
                let mover = Mover::of(b, part_of_b, growth);
                parts_near(a, of_a, mover, by_cluster, growth, |part| list.push(PartPair { a: part, b: part_of_b }));
            });
        }
    }
}

/// A solid where it is, and by how much it may come nearer to something, m.
struct Mover<'t> {
    body: &'t Body,
    placed: Placed<'t>,
    shape: &'t Geometry,
    way: f64,
}

impl<'t> Mover<'t> {
    /// A body's shape, or that solid of it; none of a mesh and of what has no shape.
    fn of(body: &'t Body, part: u32, growth: impl Fn(&Body, &Vector3<f64>, f64) -> f64) -> Option<Self> {
        let placed = Placed::of(body, part)?;
        let PartShape::Solid(shape) = placed.shape else { return None };
        let way = growth(body, &placed.position, placed.radius);
        Some(Self { body, placed, shape, way })
    }
}

/// Hands on the parts of a body that a solid may meet: a mesh's are grown by what moves there, solids each by its own way.
fn parts_near(
    body: &Body,
    parts: &Parts,
    mover: Option<Mover>,
    by_cluster: Option<&Way>,
    growth: impl Fn(&Body, &Vector3<f64>, f64) -> f64,
    mut take: impl FnMut(u32),
) {
    let Some(Mover { placed, shape, way, body: moving }) = mover else { return };
    let axes = body.rotation.to_rotation_matrix().into_inner();
    let into_body = axes.transpose();
    let rotation = into_body * placed.rotation.to_rotation_matrix().into_inner();
    let center = into_body * (placed.position - body.position);
    let Some(bounds) = shape.bounds_at(&center, &rotation) else {
        (0..parts.solids().len() as u32).for_each(take);
        return;
    };
    let bounds = bounds.grown(way);
    let PartList::Triangles(mesh) = &parts.list else {
        // What a body may bring to where the solid comes is no farther from there than either goes, if that is not far.
        let near = growth(body, &placed.position, 2.0 * (placed.radius + way));
        let is_far = near > placed.radius + way;
        let most = if is_far { growth(body, &body.position, 2.0 * body.radius) } else { near };
        return solids_in(body, parts, &axes, &bounds, most, growth, take);
    };
    let own = growth(body, &placed.position, placed.radius);
    let around = BoxAround::new(shape, Frame { rotation, center }, way + own + CONTACT_TOLERANCE * placed.radius);
    let is_polyhedron = matches!(shape, Geometry::Cuboid { .. } | Geometry::Hull(_));
    let is_slow = |way: &Way| {
        let ways = [body, moving].map(|body| way(body, &placed.position, placed.radius));
        ways[0] + ways[1] <= shape.inner_radius()
    };
    let tree = if is_polyhedron && by_cluster.is_some_and(is_slow) { parts.clustered() } else { parts.tree() };
    tree.overlapping(&bounds.grown(own), |part| {
        if mesh.is_cluster(part) || around.may_meet(mesh, part) {
            take(part);
        }
        ControlFlow::Continue(())
    });
}

/// Hands on the solids of a body, whose axes are given as columns, that may come into a box in these axes where its points move
/// by no more than `most`, m.
fn solids_in(
    body: &Body,
    parts: &Parts,
    axes: &Matrix3<f64>,
    bounds: &BoundingBox,
    most: f64,
    growth: impl Fn(&Body, &Vector3<f64>, f64) -> f64,
    mut take: impl FnMut(u32),
) {
    parts.tree().overlapping(&bounds.grown(most), |part| {
        let solid = &parts.solids()[part as usize];
        let own = growth(body, &(body.position + axes * solid.position), solid.radius);
        if solid.bounds().overlaps(&bounds.grown(own)) {
            take(part);
        }
        ControlFlow::Continue(())
    });
}

/// A box that holds a body's shape where it is; none of a half-space, and of what has no shape.
fn box_of(body: &Body) -> Option<BoundingBox> {
    body.geometry.as_ref()?.bounds_at(&body.position, &body.rotation.to_rotation_matrix().into_inner())
}

/// The parts of two bodies that may be apart by no more than a distance where they are, m; of a mesh its facets.
pub(crate) fn parts_within(a: &Body, b: &Body, distance: f64, list: &mut Vec<PartPair>) {
    list.clear();
    if has_parts(a) || has_parts(b) {
        near_parts([a, b], None, |_, _, _| distance, list);
    } else {
        list.push(PartPair::default());
    }
}
