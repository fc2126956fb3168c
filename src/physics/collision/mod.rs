//! Collision detection: which bodies may touch, where, along which normal and how deep.
//!
//! 1. [`broad`] keeps the pairs whose boxes in a tree overlap, and [`slots`] what each pair has between steps.
//! 2. A pair's contact points come from [`narrow`], with a routine for each kind of pair. Impulse methods have them in
//!    the slot until the pair moves; for all others the [`narrow_phase`] lists [`Contacts`] anew in each step.
//! 3. [`continuous`] finds where fast bodies first touch, and holds back what got through.
//! 4. Force-level sweeps may have the 2009 way of [`classic`] instead of 1 and 2: sweep and sort, one separating axis
//!    test over a set of axes, and extreme vertices.
//!
//! Everything is `f64` and computed relative to body A of each pair, so that it does not depend
//! on the distance from the origin. What contacts do to bodies is the constraints' business, and
//! who is told of them that of the events. Outside a step, [`probe`] tells whether two overlap.

mod box_around;
mod broad;
mod classic;
mod constants;
mod continuous;
mod gap;
mod lag;
mod manifold;
mod narrow;
mod narrow_phase;
mod parts;
mod pose;
mod probe;
mod slots;

#[cfg(test)]
mod tests;

pub(crate) use broad::bounding_tree::BoundingBox;
pub(crate) use broad::in_step::may_collide;
pub(crate) use broad::near_pairs::NearPairs;
pub(crate) use classic::vector_set::VectorSet;
pub(crate) use continuous::mechanisms::Mechanisms;
pub(crate) use continuous::thrown::hold_thrown_back;
pub(crate) use continuous::time_of_impact::{Course, course, overlapping_way, pass_by};
pub(crate) use gap::{closing_distance, fastest_approach, own_reach, turning_speed};
pub(crate) use lag::LaggedContacts;
pub(crate) use manifold::{ContactPoint, Contacts, FeatureId, Manifold, Overlap, Pair, PairKey, PartPair};
pub(crate) use narrow::contact_pair::{PairSearch, touch};
pub(crate) use narrow::place_at_any::{place_at_part, place_up_to};
pub(crate) use parts::{has_parts, parts_within};
pub use probe::PlacedCollider;
pub(crate) use slots::graph::{ContactGraph, GONE};
pub(crate) use slots::record::{ContactGeometry, ContactState, GEOMETRY, IMPACT, POINTS};
pub(crate) use slots::slot::Slot;

use bevy::prelude::*;

use super::body::ReportCollisions;
use super::readings::{ContactForces, Diagnostics};
use super::rewind::Keep;
use super::schedule::PhysicsSystems;
use super::settings::{contacts_are_of_2009, contacts_last};
use broad::near_pairs;
use classic::sweep_and_sort;
use continuous::hold_back;

pub(super) fn plugin(app: &mut App) {
    app.keep_resource::<sweep_and_sort::SweptPairs>()
        .keep_resource::<Contacts>()
        .keep_resource::<ContactGraph>()
        .keep_resource::<NearPairs>()
        .keep_resource::<LaggedContacts>()
        .keep_resource::<Mechanisms>();
    app.init_resource::<sweep_and_sort::SweptPairs>()
        .init_resource::<Contacts>()
        .init_resource::<ContactGraph>()
        .init_resource::<NearPairs>()
        .init_resource::<LaggedContacts>()
        .init_resource::<Mechanisms>()
        .add_systems(
            crate::physics::schedule::PhysicsSchedule,
            (
                sweep_and_sort::sweep.in_set(PhysicsSystems::BroadPhase).run_if(contacts_are_of_2009),
                near_pairs::update_pairs.in_set(PhysicsSystems::BroadPhase).run_if(not(contacts_are_of_2009)),
                narrow_phase::find_contacts.in_set(PhysicsSystems::NarrowPhase).run_if(not(contacts_last)),
                slots::graph::update_graph.in_set(PhysicsSystems::NarrowPhase).run_if(contacts_last),
                hold_back::hold_back
                    .after(PhysicsSystems::Solve)
                    .before(PhysicsSystems::WriteBack)
                    .run_if(contacts_last),
                hold_thrown_back.after(hold_back::hold_back).before(PhysicsSystems::WriteBack).run_if(contacts_last),
                lag::swap_contacts.after(PhysicsSystems::NarrowPhase).before(PhysicsSystems::Islands),
                slots::export::export_contacts
                    .after(PhysicsSystems::NarrowPhase)
                    .before(PhysicsSystems::Islands)
                    .run_if(contacts_last)
                    .run_if(contacts_are_read),
            ),
        );
}

/// Whether somebody reads [`Contacts`] of contacts that last.
fn contacts_are_read(
    diagnostics: Option<Res<Diagnostics>>,
    forces: Option<Res<ContactForces>>,
    reporters: Query<(), With<ReportCollisions>>,
) -> bool {
    diagnostics.is_some() || forces.is_some() || !reporters.is_empty()
}
