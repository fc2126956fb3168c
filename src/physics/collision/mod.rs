//! Collision detection: which bodies may touch, where, along which normal and how deep.
//!
//! 1. [`near_pairs`] keeps the pairs whose boxes in a tree overlap ([`persistent_pairs`]). Force-level methods may have
//!    [`sweep_and_sort`] instead, and the exact method has it, which finds the pairs whose bounding spheres overlap.
//!    Where contacts do not last, either lists [`CandidatePairs`].
//! 2. [`narrow_phase`] takes each pair to one of two ways to [`Contacts`]:
//!    - [`contact_pair`], with a routine for each kind of pair: [`plane`], [`ball`], [`boxes`],
//!      [`polyhedra`], [`cone_polyhedron`], [`cone_cone`], which share [`feature_sat`],
//!      [`clipping`], [`edge_contact`] and [`apart`];
//!    - the 2009 engine's: one separating axis test ([`sat`], whose axes a [`vector_set`] thins) of
//!      [`placed`] shapes, and [`extreme_vertices`].
//!
//! Everything is `f64` and computed relative to body A of each pair, so that it does not depend
//! on the distance from the origin. What contacts do to bodies is the constraints' business, and
//! who is told of them that of the events. Outside a step, [`probe`] tells whether two overlap.

mod apart;
mod ball;
mod bounding_tree;
mod boxes;
mod clipping;
mod cone;
mod cone_cone;
mod cone_polyhedron;
mod contact_graph;
mod contact_pair;
mod edge_contact;
mod ellipse;
mod extreme_vertices;
mod fat_box;
mod feature_sat;
mod hold_back;
mod narrow_phase;
mod near_pairs;
mod pair_slots;
mod persistent_pairs;
mod placed;
mod plane;
mod polyhedra;
mod polyhedron;
mod probe;
mod sat;
mod sweep_and_sort;
mod time_of_impact;
pub(crate) mod vector_set;

#[cfg(all(test, feature = "lab"))]
mod tests;

pub(crate) use contact_graph::{
    ContactGeometry, ContactGraph, ContactState, GEOMETRY, GONE, POINTS, Slot, fastest_approach,
};
pub(crate) use contact_pair::{PairSearch, touch};
pub(crate) use near_pairs::{CandidateTree, NearPairs};
pub use probe::PlacedCollider;

use bevy::prelude::*;
use nalgebra::Vector3;

use super::PhysicsSystems;
use super::bodies::Body;
use super::body::ReportCollisions;
use super::diagnostics::{ContactForces, Diagnostics};
use super::settings::{BroadPhase, ContactModel, Method, SolverSettings, contacts_last};

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

/// How far apart two bodies of the exact method may be that get contact points, m: as far as they can come together in
/// a step at their velocities and under the forces on them.
fn reachable_gap(a: &Body, b: &Body, settings: &SolverSettings) -> f64 {
    own_reach(a, settings) + own_reach(b, settings)
}

/// A body's own part of that.
fn own_reach(body: &Body, settings: &SolverSettings) -> f64 {
    let h = settings.step();
    contact_graph::own_reachable_gap(body, settings) + body.inverse_mass.component_mul(&body.force).norm() * h * h
}

/// Two bodies that may touch, as indices into [`super::bodies::Bodies`]. A is the half-space if
/// one is, else the one of lower index: the same from step to step, as normals and feature ids
/// are told from A.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) struct Pair {
    pub a: u32,
    pub b: u32,
}

/// Identifies a contact point of a pair from one step to the next: which features of A and B
/// (faces, edges, vertices) made it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) struct FeatureId(pub u64);

impl FeatureId {
    /// A vertex of A, or of B.
    fn of_vertex(of_b: bool, vertex: u32) -> Self {
        Self(u64::from(of_b) << 32 | u64::from(vertex))
    }

    /// One end, 0 or 1, of a stretch along which two edges touch.
    fn end(self, end: u64) -> Self {
        Self(self.0 | end << 33)
    }

    /// Of the faces of a clipped corner, other sides.
    fn with_sides(self, before: u16, after: u16) -> Self {
        Self(self.0 & !0xffff_ffff | u64::from(before) << 16 | u64::from(after))
    }

    /// The crossing of two edges.
    fn of_edges(edge_a: u32, edge_b: u32) -> Self {
        Self(1 << 62 | u64::from(edge_a & 0x7fff_ffff) << 31 | u64::from(edge_b & 0x7fff_ffff))
    }

    /// A corner of the incident face clipped to the reference face: the faces, 15 bits each, and
    /// the two sides that meet there.
    fn of_clipping(reference_is_b: bool, reference: u32, incident: u32, before: u16, after: u16) -> Self {
        let faces = u64::from(reference & 0x7fff) << 15 | u64::from(incident & 0x7fff);
        let sides = u64::from(before) << 16 | u64::from(after);
        Self((2 | u64::from(reference_is_b)) << 62 | faces << 32 | sides)
    }
}

/// How two shapes overlap.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Overlap {
    /// Unit, from A to B.
    pub normal: Vector3<f64>,
    /// How far B must move along the normal to be clear of A, m; negative only where they are apart
    /// by less than the gap that was asked for.
    depth: f64,
}

/// One point of a contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ContactPoint {
    /// World position. Clipped points lie half-way between the two surfaces.
    pub point: Vector3<f64>,
    /// Overlap along the manifold's normal, m; negative for a speculative point, that only may touch
    /// within the step: down to the gap that was asked for (see [`speculative_gap`]).
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
    app.init_resource::<CandidatePairs>()
        .init_resource::<Contacts>()
        .init_resource::<ContactGraph>()
        .init_resource::<NearPairs>()
        .init_resource::<CandidateTree>()
        .add_systems(
            super::PhysicsSchedule,
            (
                sweep_and_sort::find_candidate_pairs.in_set(PhysicsSystems::BroadPhase).run_if(pairs_are_swept),
                near_pairs::find_candidate_pairs
                    .in_set(PhysicsSystems::BroadPhase)
                    .run_if(not(contacts_last))
                    .run_if(not(pairs_are_swept)),
                near_pairs::update_pairs.in_set(PhysicsSystems::BroadPhase).run_if(contacts_last),
                narrow_phase::find_contacts.in_set(PhysicsSystems::NarrowPhase).run_if(not(contacts_last)),
                contact_graph::update_graph.in_set(PhysicsSystems::NarrowPhase).run_if(contacts_last),
                hold_back::hold_back
                    .after(PhysicsSystems::Solve)
                    .before(PhysicsSystems::WriteBack)
                    .run_if(contacts_last),
                contact_graph::export_contacts
                    .after(PhysicsSystems::NarrowPhase)
                    .before(PhysicsSystems::Islands)
                    .run_if(contacts_last)
                    .run_if(contacts_are_read),
            ),
        );
}

/// Whether pairs are found by sweep and sort. The exact method's contacts reach as far as forces take a body in a step,
/// which boxes of the tree do not.
fn pairs_are_swept(settings: Res<SolverSettings>) -> bool {
    match settings.method {
        Method::Exact => true,
        method => !method.keeps_contacts() && settings.broad_phase == BroadPhase::SweepAndSort,
    }
}

/// Whether somebody reads [`Contacts`] of contacts that last.
fn contacts_are_read(
    diagnostics: Option<Res<Diagnostics>>,
    forces: Option<Res<ContactForces>>,
    reporters: Query<(), With<ReportCollisions>>,
) -> bool {
    diagnostics.is_some() || forces.is_some() || !reporters.is_empty()
}
