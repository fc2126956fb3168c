//! Collision detection: which bodies may touch, where, along which normal and how deep.
//!
//! 1. [`broad`] keeps the pairs whose boxes in a tree overlap. Force-level methods may have the sweep and sort of
//!    [`classic`] instead, and the exact method has it, which finds the pairs whose bounding spheres overlap.
//!    Where contacts do not last, either lists [`CandidatePairs`].
//! 2. A pair's contact points come from [`narrow`], with a routine for each kind of pair, or from [`classic`]: one
//!    separating axis test over a set of axes, and extreme vertices.
//! 3. Contacts that last stay in [`slots`]; others are found anew in each step by the [`narrow_phase`].
//! 4. [`continuous`] finds where fast bodies first touch, and holds back what got through.
//!
//! Everything is `f64` and computed relative to body A of each pair, so that it does not depend
//! on the distance from the origin. What contacts do to bodies is the constraints' business, and
//! who is told of them that of the events. Outside a step, [`probe`] tells whether two overlap.

mod broad;
mod classic;
mod constants;
mod continuous;
mod gap;
mod lag;
mod manifold;
mod narrow;
mod narrow_phase;
mod probe;
mod slots;

#[cfg(test)]
mod tests;

pub(crate) use broad::near_pairs::{CandidateTree, NearPairs};
pub(crate) use classic::vector_set::VectorSet;
pub(crate) use gap::{closing_distance, fastest_approach};
pub(crate) use lag::LaggedContacts;
pub(crate) use manifold::{ContactPoint, Contacts, FeatureId, Manifold, Pair};
pub(crate) use narrow::contact_pair::{PairSearch, touch};
pub use probe::PlacedCollider;
pub(crate) use slots::graph::{ContactGraph, GONE};
pub(crate) use slots::record::{ContactGeometry, ContactState, GEOMETRY, POINTS};
pub(crate) use slots::slot::Slot;

use bevy::prelude::*;

use super::body::ReportCollisions;
use super::readings::{ContactForces, Diagnostics};
use super::schedule::PhysicsSystems;
use super::settings::{BroadPhase, Method, SolverSettings, contacts_last};
use broad::near_pairs;
use classic::sweep_and_sort;
use continuous::hold_back;
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
                slots::graph::update_graph.in_set(PhysicsSystems::NarrowPhase).run_if(contacts_last),
                hold_back::hold_back
                    .after(PhysicsSystems::Solve)
                    .before(PhysicsSystems::WriteBack)
                    .run_if(contacts_last),
                lag::swap_contacts.after(PhysicsSystems::NarrowPhase).before(PhysicsSystems::Islands),
                slots::export::export_contacts
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
        method => !method.keeps_contacts() && settings.sweeps.broad_phase == BroadPhase::SweepAndSort,
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
