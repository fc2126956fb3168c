//! Contacts one step late: the 2009 engine's threaded loop solved with the contacts of the pose
//! before (`contact_lag` = 1).

use bevy::prelude::*;

use super::manifold::Contacts;
use super::slots::graph::ContactGraph;
use crate::physics::settings::SolverSettings;

/// What the step before found, and what the solver is to use now, with a lag of one step.
#[derive(Resource, Default, Clone)]
pub(crate) struct LaggedContacts {
    active: Contacts,
    next: Contacts,
}

impl LaggedContacts {
    /// The contacts that the solver uses in this step.
    pub fn active<'a>(&'a self, settings: &SolverSettings, present: &'a Contacts) -> &'a Contacts {
        if settings.contact_lag() == 0 { present } else { &self.active }
    }

    /// Forgets the contacts of a body whose pose jumped.
    pub fn drop_body(&mut self, body: u32) {
        self.next.manifolds.retain(|manifold| manifold.pair.a != body && manifold.pair.b != body);
    }

    /// Follows bodies to their new indices; contacts of bodies that are gone are forgotten.
    pub fn remap(&mut self, new_index: &[Option<u32>]) {
        self.next.manifolds.retain_mut(|manifold| {
            let (Some(a), Some(b)) = (new_index[manifold.pair.a as usize], new_index[manifold.pair.b as usize]) else {
                return false;
            };
            manifold.pair.a = a;
            manifold.pair.b = b;
            true
        });
    }

    /// The contacts found last: part of the state while there is a lag.
    pub fn pending(&self) -> &Contacts {
        &self.next
    }
}

pub(super) fn swap_contacts(
    settings: Res<SolverSettings>,
    present: Res<Contacts>,
    graph: Res<ContactGraph>,
    mut lagged: ResMut<LaggedContacts>,
) {
    let LaggedContacts { active, next } = &mut *lagged;
    if settings.contact_lag() == 0 {
        if !next.manifolds.is_empty() {
            *next = Contacts::default();
        }
        return;
    }
    std::mem::swap(active, next);
    for manifold in &mut active.manifolds {
        // Another pair may have the slot by now.
        manifold.slot = manifold.slot.filter(|&slot| graph.slots[slot as usize].pair == manifold.pair);
    }
    next.manifolds.clone_from(&present.manifolds);
    next.points.clone_from(&present.points);
    next.time = present.time;
}
