//! Collision detection: which bodies may touch, where, along which normal and how deep.
//!
//! 1. [`sweep_and_sort`] finds the pairs whose bounding spheres overlap: [`CandidatePairs`].
//! 2. [`narrow_phase`] takes each pair through the separating axis test ([`sat`], whose axes a
//!    [`vector_set`] thins) and, where they touch, finds the points: by [`extreme_vertices`], as
//!    the 2009 engine did, or by [`clipping`]. The result is [`Contacts`].
//!
//! Everything is `f64` and computed relative to body A of each pair, so that it does not depend
//! on the distance from the origin. What contacts do to bodies is the constraints' business, and
//! who is told of them that of the events. Outside a step, [`probe`] tells whether two overlap.

mod clipping;
mod extreme_vertices;
mod narrow_phase;
mod placed;
mod probe;
mod sat;
mod sweep_and_sort;
pub(crate) mod vector_set;

#[cfg(all(test, feature = "lab"))]
mod tests;

pub use probe::PlacedCollider;

use bevy::prelude::*;
use nalgebra::Vector3;

use super::PhysicsSystems;
use super::bodies::Body;
use super::settings::{ContactModel, SolverSettings};

/// Gaps up to this share of the bounding radii count as touching: rounding could have made them
/// of a gap of zero.
const CONTACT_TOLERANCE: f64 = 1e-9;

/// The gap over a half-space up to which a body already gets contact points, m: as far as it can
/// fall in one step at its present velocity. The points' negative depth lets the solver stop it at
/// the plane instead of finding it a step's way below. Not where the 2009 contacts are asked for,
/// and not where the pair bounces: a speculative contact takes the approach away that a bounce needs.
fn speculative_gap(plane: &Body, body: &Body, normal: &Vector3<f64>, settings: &SolverSettings) -> f64 {
    let bounces = plane.material.pair(body.material).restitution > 0.0;
    if settings.contacts != ContactModel::Clipping || bounces {
        return 0.0;
    }
    let approach = (plane.linear - body.linear).dot(normal).max(0.0) + body.angular.norm() * body.radius;
    approach * settings.step()
}

/// Two bodies that may touch, as indices into [`super::bodies::Bodies`]. A is the half-space if
/// one is, else the one of lower index: the same from step to step, as normals and feature ids
/// are told from A.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Pair {
    pub a: u32,
    pub b: u32,
}

/// Identifies a contact point of a pair from one step to the next: which features of A and B
/// (faces, edges, vertices) made it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) struct FeatureId(pub u32);

impl FeatureId {
    /// A vertex of A, or of B.
    fn of_vertex(of_b: bool, vertex: u32) -> Self {
        Self(u32::from(of_b) << 29 | (vertex & 0x1fff_ffff))
    }

    /// The crossing of two edges.
    fn of_edges(edge_a: u32, edge_b: u32) -> Self {
        Self(1 << 30 | (edge_a & 0x7fff) << 15 | (edge_b & 0x7fff))
    }

    /// A corner of the incident face clipped to the reference face: the faces, seven bits each,
    /// and the two sides that meet there.
    fn of_clipping(reference_is_b: bool, reference: u32, incident: u32, before: u8, after: u8) -> Self {
        let sides = u32::from(before) << 8 | u32::from(after);
        Self((2 | u32::from(reference_is_b)) << 30 | (reference & 0x7f) << 23 | (incident & 0x7f) << 16 | sides)
    }
}

/// One point of a contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ContactPoint {
    /// World position. Clipped points lie half-way between the two surfaces.
    pub point: Vector3<f64>,
    /// Overlap along the manifold's normal, m; negative for a point that only may touch within
    /// the step (see [`speculative_gap`]).
    pub depth: f64,
    pub feature: FeatureId,
}

/// How two bodies touch: a normal and a run of points in [`Contacts::points`].
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Manifold {
    pub pair: Pair,
    /// Unit, from A to B, world axes.
    pub normal: Vector3<f64>,
    /// Range in [`Contacts::points`].
    pub first_point: u32,
    pub point_count: u32,
    /// μ of the pair.
    pub friction: f64,
    /// e of the pair.
    pub restitution: f64,
}

/// The contacts of one step, in the order in which the broad phase found the pairs (half-space
/// pairs first).
#[derive(Resource, Default, Clone)]
pub(crate) struct Contacts {
    pub manifolds: Vec<Manifold>,
    pub points: Vec<ContactPoint>,
    /// Simulation time of the poses they were found at, s.
    pub time: f64,
}

impl Contacts {
    pub fn points_of(&self, manifold: &Manifold) -> &[ContactPoint] {
        let first = manifold.first_point as usize;
        &self.points[first..first + manifold.point_count as usize]
    }
}

/// The pairs that the narrow phase looks at, half-space pairs first.
#[derive(Resource, Default)]
pub(crate) struct CandidatePairs {
    pub pairs: Vec<Pair>,
}

pub(super) fn plugin(app: &mut App) {
    app.init_resource::<CandidatePairs>().init_resource::<Contacts>().add_systems(
        super::PhysicsSchedule,
        (
            sweep_and_sort::find_candidate_pairs.in_set(PhysicsSystems::BroadPhase),
            narrow_phase::find_contacts.in_set(PhysicsSystems::NarrowPhase),
        ),
    );
}
