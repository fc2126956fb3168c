//! Islands of a group that are solved directly, at rest or in motion.
#![allow(unsafe_code)]

use super::group::{DirectCounts, DirectScope, Group};
use super::world::SharedWorld;
use crate::physics::body::{Body, RigidBody};
use crate::physics::collision::{ContactState, Slot};
use crate::physics::joint::Joint;
use crate::physics::lanes::{Lanes, Record};
use crate::physics::solver::direct::{DirectIsland, MotionTerms, Outcome, World};
use crate::physics::solver::substeps::Intervals;

/// An island's view of the world.
struct IslandView<'a> {
    world: SharedWorld<'a>,
    /// Kinematic bodies where they are by now: their own poses follow at the end of the step.
    moved: Vec<(u32, Body)>,
}

impl<'a> IslandView<'a> {
    /// # Safety
    /// Nobody may write a body, contact or joint that it is asked for while the answer is held.
    unsafe fn new(world: SharedWorld<'a>) -> Self {
        Self { world, moved: Vec::new() }
    }
}

impl World for IslandView<'_> {
    fn body(&self, index: u32) -> &Body {
        let moved = self.moved.iter().find(|(body, _)| *body == index).map(|(_, body)| body);
        // SAFETY: not being written, as whoever made the view promised.
        moved.unwrap_or_else(|| unsafe { self.world.bodies.get(index as usize) })
    }

    fn slot(&self, index: u32) -> &Slot {
        &self.world.slots[index as usize]
    }

    fn state(&self, slot: u32) -> &ContactState {
        // SAFETY: not being written, as whoever made the view promised.
        unsafe { self.world.states.get(slot as usize) }
    }

    fn joint(&self, index: u32) -> &Joint {
        // SAFETY: not being written, as whoever made the view promised.
        unsafe { self.world.joints.get(index as usize) }
    }
}

impl<L: Lanes> Group<L> {
    /// Takes the islands that can be solved directly through a step.
    ///
    /// # Safety
    /// Nobody else may be writing the group's bodies, joints or contacts, nor bodies that these refer to.
    pub unsafe fn solve_directly(
        &mut self,
        world: SharedWorld,
        terms: &MotionTerms,
        scope: DirectScope,
    ) -> DirectCounts {
        let mut counts = DirectCounts::default();
        // SAFETY: as the caller promises, nobody else writes; this thread only while it holds no answer.
        let mut view = unsafe { IslandView::new(world) };
        for island in &mut self.islands {
            // SAFETY: an island's bodies, joints and contacts are its group's.
            let is_solved = unsafe {
                scope.rest && solve_at_rest(island, &view, terms, &mut counts)
                    || scope.trees && solve_in_motion(island, &mut view, terms, &mut counts)
            };
            if !is_solved && island.is_doubtful(&view) {
                for &slot in island.contacts() {
                    // SAFETY: the island's alone, and nothing that was read of it is held.
                    unsafe { world.store(slot, Record::default()) };
                }
            }
            counts.spent += island.take_spent();
            counts.changed |= island.is_solved != is_solved;
            island.is_solved = is_solved;
        }
        counts
    }
}

/// Takes an island that rests through a step. Whether it does.
///
/// # Safety
/// As of [`Group::solve_directly`].
unsafe fn solve_at_rest(
    island: &mut DirectIsland,
    view: &IslandView,
    terms: &MotionTerms,
    counts: &mut DirectCounts,
) -> bool {
    let (world, step, substeps) = (view.world, terms.substeps.step, terms.substeps.most);
    let outcome = island.solve(view, step, substeps, world.totals.is_none());
    if outcome == Outcome::Moves {
        return false;
    }
    counts.resting += island.members().len() as u32;
    island.solves = 0;
    counts.rows += island.rows();
    if outcome == Outcome::Rests {
        counts.row_updates += island.rows();
        island.solves = 1;
        // SAFETY: these are the island's alone, and what was read of them is not held any more.
        unsafe {
            for (local, &member) in island.members().iter().enumerate() {
                island.scatter(local, world.bodies.element(member as usize), step);
            }
            store(island, world, [step, f64::from(substeps)], true);
        }
        island.remember(view);
    }
    true
}

/// Takes an island with joints in motion through a step. Whether it can be.
///
/// # Safety
/// As of [`Group::solve_directly`].
unsafe fn solve_in_motion(
    island: &mut DirectIsland,
    view: &mut IslandView,
    terms: &MotionTerms,
    counts: &mut DirectCounts,
) -> bool {
    if !island.set_off(view, terms) {
        return false;
    }
    let (world, Intervals { count, h, replaces, .. }) = (view.world, island.intervals());
    let may_go_back = island.joints().is_empty();
    if may_go_back {
        island.keep(view);
    }
    for substep in 0..count {
        view.moved.clear();
        for &partner in island.partners() {
            let body = view.body(partner);
            if substep > 0 && body.kind == RigidBody::Kinematic {
                let mut body = body.clone();
                body.coast(h * f64::from(substep));
                view.moved.push((partner, body));
            }
        }
        if !island.substep(view, terms, substep) {
            view.moved.clear();
            // SAFETY: these are the island's alone, and what was read of them is not held any more.
            unsafe { go_back(island, world) };
            return false;
        }
        // SAFETY: these are the island's alone, and what was read of them is not held any more.
        unsafe {
            for (local, &member) in island.members().iter().enumerate() {
                island.move_on(local, world.bodies.element(member as usize), h);
            }
            if substep + 1 == count || !island.is_without_contacts() {
                store(island, world, [h, replaces], substep == 0);
            }
        }
        island.carry_on(h);
    }
    counts.row_updates += island.rows() * count;
    island.solves = count;
    counts.rows += island.rows();
    view.moved.clear();
    if may_go_back {
        island.expect_next(view, h);
        for (index, &slot) in island.contacts().iter().enumerate() {
            // SAFETY: the island's alone, and what was read of it is not held any more.
            unsafe { world.store(slot, island.impulses(index, replaces)) };
        }
    }
    island.remember_motion(view);
    true
}

/// Has the bodies and contacts of an island be as its step found them.
///
/// # Safety
/// Nobody else may be using the island's bodies and contacts.
unsafe fn go_back(island: &DirectIsland, world: SharedWorld) {
    // SAFETY: as the caller promises.
    unsafe {
        for (&member, body) in island.members().iter().zip(&island.kept.bodies) {
            world.bodies.element(member as usize).clone_from(body);
        }
        for (&slot, impulses) in island.contacts().iter().zip(&island.kept.impulses) {
            world.store(slot, *impulses);
        }
    }
}

/// Keeps the impulses of contacts and joints over a time h, s, of so many substeps.
///
/// # Safety
/// Nobody else may be using the island's contacts and joints.
unsafe fn store(island: &DirectIsland, world: SharedWorld, [h, substeps]: [f64; 2], is_first: bool) {
    // SAFETY: as the caller promises.
    unsafe {
        for (index, &slot) in island.contacts().iter().enumerate() {
            world.store(slot, island.impulses(index, substeps));
            if let Some(totals) = world.totals {
                let total = totals.element(slot as usize);
                if is_first {
                    *total = Record::default();
                }
                total.0.iter_mut().zip(island.impulses(index, 1.0).0).for_each(|(total, now)| *total += now);
            }
        }
        for (index, &joint) in island.joints().iter().enumerate() {
            island.store_joint(index, world.joints.element(joint as usize), h);
        }
    }
}
