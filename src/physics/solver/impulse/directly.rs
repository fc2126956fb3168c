//! Islands of a group that are solved directly, at rest or in motion.
#![allow(unsafe_code)]

use std::sync::atomic::Ordering;

use super::group::{Exactly, Group};
use super::stage::WorldParts;
use crate::physics::body::Body;
use crate::physics::body::RigidBody;
use crate::physics::collision::{ContactState, Slot};
use crate::physics::joint::Joint;
use crate::physics::lanes::{Lanes, Record};
use crate::physics::solver::direct::{DirectIsland, MotionTerms, Outcome, World};
use crate::physics::solver::substeps::Parts;

/// Of bodies, contacts and joints that nobody is writing.
struct View<'a> {
    parts: WorldParts<'a>,
    /// What goes where it is told, where it is by now; its own pose follows at the end of the step.
    there: &'a [(u32, Body)],
}

impl World for View<'_> {
    fn body(&self, index: u32) -> &Body {
        let there = self.there.iter().find(|(body, _)| *body == index).map(|(_, body)| body);
        // SAFETY: the group's own, or what nobody writes.
        there.unwrap_or_else(|| unsafe { self.parts.bodies.get(index as usize) })
    }

    fn slot(&self, index: u32) -> &Slot {
        &self.parts.slots[index as usize]
    }

    fn state(&self, slot: u32) -> &ContactState {
        // SAFETY: the group's own, or what nobody writes.
        unsafe { self.parts.states.get(slot as usize) }
    }

    fn joint(&self, index: u32) -> &Joint {
        // SAFETY: the group's own, or what nobody writes.
        unsafe { self.parts.joints.get(index as usize) }
    }
}

/// How much of a group is solved directly.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Directly {
    /// Bodies at rest.
    pub resting: u32,
    pub rows: u32,
    /// Rows solved, over all substeps.
    pub row_updates: u32,
    /// Whether others are than in the step before.
    pub changed: bool,
}

impl<L: Lanes> Group<L> {
    /// Takes the islands that can be solved directly through a step.
    /// No other group may share a body that moves, a joint or a contact.
    pub fn solve_directly(&mut self, world: WorldParts, terms: &MotionTerms, exactly: Exactly) -> Directly {
        let mut directly = Directly::default();
        for island in &mut self.islands {
            let mut is_solved = exactly.rest && rest(island, world, terms, &mut directly);
            if !is_solved && exactly.trees && island.set_off(&View { parts: world, there: &[] }, terms) {
                directly.row_updates += island.rows() * island.parts().count;
                directly.rows += island.rows();
                travel(island, world, terms);
                is_solved = true;
            }
            directly.changed |= island.is_solved != is_solved;
            island.is_solved = is_solved;
        }
        directly
    }
}

/// Takes an island that rests through a step.
fn rest(island: &mut DirectIsland, world: WorldParts, terms: &MotionTerms, directly: &mut Directly) -> bool {
    let (step, substeps) = (terms.substeps.step, f64::from(terms.substeps.most));
    let seen = View { parts: world, there: &[] };
    let outcome = island.solve(&seen, step, terms.substeps.most, world.totals.len() == 0);
    if outcome == Outcome::Moves {
        return false;
    }
    directly.resting += island.members().len() as u32;
    directly.rows += island.rows();
    if outcome == Outcome::Rests {
        directly.row_updates += island.rows();
        // SAFETY: these are the island's alone, and what was read of them is not held any more.
        unsafe {
            for (local, &member) in island.members().iter().enumerate() {
                island.scatter(local, world.bodies.element(member as usize), step);
            }
            store(island, world, [step, substeps], true);
        }
        island.remember(&seen);
    }
    true
}

/// Takes an island in motion through a step.
fn travel(island: &mut DirectIsland, world: WorldParts, terms: &MotionTerms) {
    let mut there = Vec::new();
    let Parts { count, h, replaces, .. } = island.parts();
    for substep in 0..count {
        there.clear();
        for &partner in island.partners() {
            // SAFETY: nobody writes what does not move here.
            let body = unsafe { world.bodies.get(partner as usize) };
            if substep > 0 && body.kind == RigidBody::Kinematic {
                let mut body = body.clone();
                body.coast(h * f64::from(substep));
                there.push((partner, body));
            }
        }
        island.substep(&View { parts: world, there: &there }, terms, substep == 0);
        // SAFETY: these are the island's alone, and what was read of them is not held any more.
        unsafe {
            for (local, &member) in island.members().iter().enumerate() {
                island.move_on(local, world.bodies.element(member as usize), h);
            }
            store(island, world, [h, replaces], substep == 0);
        }
        island.carry_on(h);
    }
}

/// Keeps what contacts and joints pushed in a time h, s, of so many substeps.
///
/// # Safety
/// Nobody else may be using the island's contacts and joints.
unsafe fn store(island: &DirectIsland, world: WorldParts, [h, substeps]: [f64; 2], is_first: bool) {
    // SAFETY: as the caller promises.
    unsafe {
        for (index, &slot) in island.contacts().iter().enumerate() {
            let state = world.states.element(slot as usize);
            state.impulses = island.impulses(index, substeps);
            if state.pushes() != world.slots[slot as usize].is_pressed {
                world.presses_changed.store(true, Ordering::Relaxed);
            }
            if world.totals.len() > 0 {
                let total = world.totals.element(slot as usize);
                if is_first {
                    *total = Record::default();
                }
                total.0.iter_mut().zip(island.impulses(index, 1.0).0).for_each(|(total, now)| *total += now);
            }
        }
        for (index, &joint) in island.joints().iter().enumerate() {
            world.joints.element(joint as usize).force = island.joint_impulse(index) / h;
        }
    }
}
