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
mod gap;
mod hold_back;
mod lag;
mod manifold;
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

#[cfg(test)]
mod tests;

pub(crate) use contact_graph::{ContactGeometry, ContactGraph, ContactState, GEOMETRY, GONE, POINTS, Slot};
pub(crate) use contact_pair::{PairSearch, touch};
pub(crate) use gap::fastest_approach;
pub(crate) use lag::LaggedContacts;
pub(crate) use manifold::{ContactPoint, Contacts, FeatureId, Manifold, Pair};
pub(crate) use near_pairs::{CandidateTree, NearPairs};
pub use probe::PlacedCollider;

use bevy::prelude::*;

use super::body::ReportCollisions;
use super::readings::{ContactForces, Diagnostics};
use super::schedule::PhysicsSystems;
use super::settings::{BroadPhase, Method, SolverSettings, contacts_last};
use manifold::CandidatePairs;

pub(super) fn plugin(app: &mut App) {
    app.init_resource::<CandidatePairs>()
        .init_resource::<Contacts>()
        .init_resource::<ContactGraph>()
        .init_resource::<NearPairs>()
        .init_resource::<LaggedContacts>()
        .init_resource::<CandidateTree>()
        .add_systems(
            crate::physics::schedule::PhysicsSchedule,
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
                lag::swap_contacts.after(PhysicsSystems::NarrowPhase).before(PhysicsSystems::Islands),
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
