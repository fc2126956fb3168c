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

impl<L: Lanes> Group<L> {
    /// Takes the islands that rest through a step of `substeps` of length `h`, s. Whether others rest now than did.
    /// No other group may share a body that moves, a joint or a contact.
    pub fn rest(&mut self, world: WorldParts, h: f64, substeps: u32) -> bool {
        let step = h * f64::from(substeps);
        let mut changed = false;
        for island in &mut self.islands {
            let rested = island.rests;
            let outcome = island.solve(&Resting(world), step, substeps, world.totals.len() == 0);
            changed |= island.rests != rested;
            if outcome != Outcome::Rests {
                continue;
            }
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
        changed
    }
}
