//! The world outside of a group, shared with the threads that work on other groups.
#![allow(unsafe_code)]

use std::sync::atomic::{AtomicBool, Ordering};

use super::contact::ContactImpulses;
use crate::physics::bit_set::BitSet;
use crate::physics::body::{Bodies, Body};
use crate::physics::collision::{ContactGraph, ContactState, Slot};
use crate::physics::joint::{Joint, Joints};
use crate::physics::threads::{Claims, Shared};

/// What debug builds know of who touches the world.
#[derive(Clone, Debug, Default)]
pub(super) struct WorldClaims([Claims; 4]);

/// Bodies, joints and contacts; see [`super`] for who touches which.
#[derive(Clone, Copy)]
pub(super) struct SharedWorld<'a> {
    pub bodies: Shared<'a, Body>,
    pub joints: Shared<'a, Joint>,
    pub states: Shared<'a, ContactState>,
    pub slots: &'a [Slot],
    /// Impulses of each contact over a step; none unless somebody reads them.
    pub totals: Option<Shared<'a, ContactImpulses>>,
    /// Slots whose bodies pushed each other in the last step.
    started: &'a BitSet,
    starts_changed: &'a AtomicBool,
}

impl SharedWorld<'_> {
    /// Shares it for as long as `work` takes.
    pub fn share(
        bodies: &mut Bodies,
        joints: &mut Joints,
        graph: &mut ContactGraph,
        WorldClaims([of_bodies, of_joints, of_states, of_totals]): &mut WorldClaims,
        work: impl FnOnce(SharedWorld),
    ) {
        let starts_changed = AtomicBool::new(false);
        work(SharedWorld {
            bodies: Shared::new(&mut bodies.list, of_bodies),
            joints: Shared::new(&mut joints.list, of_joints),
            states: Shared::new(&mut graph.states, of_states),
            slots: &graph.slots,
            totals: graph.recording.as_mut().map(|recording| Shared::new(&mut recording.totals, of_totals)),
            started: &graph.started,
            starts_changed: &starts_changed,
        });
        graph.starts_changed |= starts_changed.into_inner();
    }

    /// Keeps the impulses of a contact.
    ///
    /// # Safety
    /// Nobody else may be using its state.
    pub unsafe fn store(&self, slot: u32, impulses: ContactImpulses) {
        // SAFETY: as the caller promises.
        let state = unsafe { self.states.element(slot as usize) };
        state.impulses = impulses;
        if state.pushes() != self.started.contains(slot) {
            self.starts_changed.store(true, Ordering::Relaxed);
        }
    }
}
