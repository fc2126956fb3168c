//! Islands of a group that rest, taken through the step directly.
#![allow(unsafe_code)]

use std::sync::atomic::Ordering;

use super::group::Group;
use super::stage::WorldParts;
use crate::physics::bodies::{Body, Joint};
use crate::physics::collision::{ContactState, Slot};
use crate::physics::lanes::Lanes;
use crate::physics::solver::direct::{Outcome, World};

/// Of bodies, contacts and joints that nobody is writing.
struct Resting<'a>(WorldParts<'a>);

impl World for Resting<'_> {
    fn body(&self, index: u32) -> &Body {
        // SAFETY: the group's own, or what nobody writes.
        unsafe { self.0.bodies.get(index as usize) }
    }

    fn slot(&self, index: u32) -> &Slot {
        &self.0.slots[index as usize]
    }

    fn state(&self, slot: u32) -> &ContactState {
        // SAFETY: the group's own, or what nobody writes.
        unsafe { self.0.states.get(slot as usize) }
    }

    fn joint(&self, index: u32) -> &Joint {
        // SAFETY: the group's own, or what nobody writes.
        unsafe { self.0.joints.get(index as usize) }
    }
}

/// How much of a group rests.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct AtRest {
    pub bodies: u32,
    pub rows: u32,
    /// Rows of which something was solved.
    pub rows_solved: u32,
    /// Whether others rest than in the step before.
    pub changed: bool,
}

impl<L: Lanes> Group<L> {
    /// Takes the islands that rest through a step of `substeps` of length `h`, s.
    /// No other group may share a body that moves, a joint or a contact.
    pub fn rest(&mut self, world: WorldParts, h: f64, substeps: u32) -> AtRest {
        let step = h * f64::from(substeps);
        let mut at_rest = AtRest::default();
        for island in &mut self.islands {
            let rested = island.rests;
            let outcome = island.solve(&Resting(world), step, substeps, world.totals.len() == 0);
            at_rest.changed |= island.rests != rested;
            if island.rests {
                at_rest.bodies += island.members().len() as u32;
                at_rest.rows += island.rows();
            }
            if outcome != Outcome::Rests {
                continue;
            }
            at_rest.rows_solved += island.rows();
            // SAFETY: these are the island's alone, and what was read of them is not held any more.
            unsafe {
                for (local, &member) in island.members().iter().enumerate() {
                    island.scatter(local, world.bodies.element(member as usize), step);
                }
                for (index, &slot) in island.contacts().iter().enumerate() {
                    let state = world.states.element(slot as usize);
                    state.impulses = island.impulses(index, f64::from(substeps));
                    if state.pushes() != world.slots[slot as usize].is_pressed {
                        world.presses_changed.store(true, Ordering::Relaxed);
                    }
                    if world.totals.len() > 0 {
                        *world.totals.element(slot as usize) = island.impulses(index, 1.0);
                    }
                }
                for (index, &joint) in island.joints().iter().enumerate() {
                    world.joints.element(joint as usize).force = island.joint_impulse(index) / step;
                }
            }
            island.remember(&Resting(world));
        }
        at_rest
    }
}
