//! What is done to a group in a step, as stages: within one, everything may be done in any order
//! and on any thread, since colours share no body that moves.
#![allow(unsafe_code)]

use std::sync::atomic::{AtomicBool, Ordering};

use nalgebra::Vector3;

use super::bodies::SharedBodies;
use super::coloring::Coloring;
use super::contact::{ContactBlock, ContactImpulses, ContactSite};
use super::group::{Bounce, Group, GroupContact, GroupJoint};
use super::joint::{JointBlock, JointSite};
use super::tree::TreeStep;
use crate::physics::body::RigidBody;
use crate::physics::body::free_flight;
use crate::physics::body::{Bodies, Body};
use crate::physics::collision::{ContactGraph, ContactState, POINTS, Slot};
use crate::physics::contact::rebound;
use crate::physics::joint::{Joint, Joints};
use crate::physics::lanes::{Lanes, READ_ONLY};
use crate::physics::scalar::Scalar;
use crate::physics::solver::soft_terms::{Projection, SoftTerms};
use crate::physics::solver::substeps::Substeps;
use crate::physics::threads::Shared;

/// Bodies that one thread takes at a time.
const BODIES: usize = 64;
/// Blocks that one thread takes at a time.
const BLOCKS: usize = 8;

/// What an update does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Sweep {
    /// Contacts push by their springs and rub only where surfaces come together in the step; joints pull by theirs.
    Springs,
    /// As with springs, and contacts rub.
    Whole,
    /// Rigid and without bias; contacts rub.
    Relax,
}

/// A colour of joints or contacts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Color {
    Joints(u32),
    Contacts(u32),
}

/// One thing done to all of a group.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Stage {
    /// Bodies that nothing holds or touches, and trees of joints that nothing touches, go their way.
    Fly,
    Swing,
    /// Bodies are taken in, for so many substeps after those that are done.
    Gather {
        substeps: u32,
        done: u32,
    },
    /// Rows for the present poses.
    Prepare(Color),
    /// Forces act; but for the first substep, every constraint pushes as in the substep before.
    Begin {
        is_first: bool,
    },
    /// Constraints push as in the step before.
    WarmStart(Color),
    /// One update.
    Solve {
        color: Color,
        sweep: Sweep,
    },
    /// One update with springs, of contacts without friction; the first of a substep begins with nothing.
    Press {
        color: Color,
        is_first: bool,
    },
    /// One update of friction alone, from none.
    Rub(Color),
    /// One update of contacts that push, until they neither part nor approach.
    Settle(Color),
    /// What constraints pushed in this substep is taken in, for bounces and for whoever reads forces.
    Note(Color),
    /// Positions follow velocities.
    Drift,
    /// Positions are moved out of their errors.
    Project(Color),
    /// What constraints added to the velocities is remembered; drag acts.
    End,
    /// Points that came fast part again.
    Bounce(Color),
    /// Bodies and impulses are written back.
    Scatter,
    /// Impulses are written back.
    Store(Color),
}

/// Numbers of a step that all groups share.
#[derive(Clone, Copy, Debug)]
pub(crate) struct GroupTerms<L> {
    /// Length of a substep, s.
    pub h: f64,
    pub substeps: Substeps,
    pub joint: SoftTerms<L>,
    pub contact: SoftTerms<L>,
    /// Of methods with [`Stage::Project`].
    pub projection: Option<Projection<L>>,
    /// Approach from which a contact bounces, m/s.
    pub restitution_speed: f64,
}

/// The world outside of a group, shared with those that work on other groups.
#[derive(Clone, Copy)]
pub(crate) struct WorldParts<'a> {
    pub bodies: Shared<'a, Body>,
    pub joints: Shared<'a, Joint>,
    pub states: Shared<'a, ContactState>,
    pub slots: &'a [Slot],
    /// Set where a contact begins or ceases to push.
    pub presses_changed: &'a AtomicBool,
    /// Empty unless somebody reads contact forces.
    pub totals: Shared<'a, ContactImpulses>,
}

impl<'a> WorldParts<'a> {
    /// Handles on all of it; `none` is an empty list.
    pub fn new(
        bodies: &'a mut Bodies,
        joints: &'a mut Joints,
        graph: &'a mut ContactGraph,
        presses_changed: &'a AtomicBool,
        none: &'a mut [ContactImpulses],
    ) -> Self {
        Self {
            bodies: Shared::new(&mut bodies.list),
            joints: Shared::new(&mut joints.list),
            states: Shared::new(&mut graph.states),
            slots: &graph.slots,
            presses_changed,
            totals: Shared::new(graph.recording.as_mut().map_or(none, |recording| recording.totals.as_mut_slice())),
        }
    }
}

impl<L: Lanes> Group<L> {
    /// The colours of a group, joints first.
    pub fn colors(&self) -> impl Iterator<Item = Color> + Clone + use<L> {
        let (joints, contacts) = (self.joint_colors.stages.len() as u32, self.contact_colors.stages.len() as u32);
        (0..joints).map(Color::Joints).chain((0..contacts).map(Color::Contacts))
    }

    /// Goes through the stages. No other group may share a body that moves, a joint or a contact.
    pub fn run(&mut self, stages: &[Stage], terms: &GroupTerms<L>, world: WorldParts, records: bool, threads: u32) {
        let walk = Walk {
            members: &self.members,
            own: self.own,
            joints: &self.joints,
            contacts: &self.contacts,
            joint_colors: &self.joint_colors,
            contact_colors: &self.contact_colors,
            flying: &self.flying,
            trees: Shared::new(&mut self.trees),
            bodies: self.bodies.share(),
            joint_blocks: Shared::new(&mut self.joint_blocks),
            contact_blocks: Shared::new(&mut self.contact_blocks),
            bounces: Shared::new(&mut self.bounces),
            totals: {
                self.totals.clear();
                if records {
                    self.totals.resize(self.contact_colors.blocks.len() * L::COUNT, ContactImpulses::default());
                }
                Shared::new(&mut self.totals)
            },
            records,
            terms,
            world,
        };
        let chunks = stages.iter().map(|&stage| walk.count(stage).div_ceil(walk.chunk(stage)));
        // SAFETY: a stage's items are worked on by one thread each; those of a colour share no body that moves,
        // and what does not move is not written. Stages follow one another.
        self.progress.walk(threads, chunks, |stage, chunk| unsafe { walk.work(stages[stage], chunk) });
    }
}

/// A group on its way through the stages.
struct Walk<'a, L: Lanes> {
    members: &'a [u32],
    own: usize,
    joints: &'a [GroupJoint],
    contacts: &'a [GroupContact],
    joint_colors: &'a Coloring,
    contact_colors: &'a Coloring,
    flying: &'a [u32],
    trees: Shared<'a, TreeStep>,
    bodies: SharedBodies<'a, L::Scalar>,
    joint_blocks: Shared<'a, JointBlock<L>>,
    contact_blocks: Shared<'a, ContactBlock<L>>,
    bounces: Shared<'a, Option<Bounce<L>>>,
    totals: Shared<'a, ContactImpulses>,
    records: bool,
    terms: &'a GroupTerms<L>,
    world: WorldParts<'a>,
}

impl<L: Lanes> Walk<'_, L> {
    /// The blocks of a colour.
    fn blocks(&self, color: Color) -> (u32, u32) {
        match color {
            Color::Joints(color) => self.joint_colors.stages[color as usize],
            Color::Contacts(color) => self.contact_colors.stages[color as usize],
        }
    }

    /// Items of a stage.
    fn count(&self, stage: Stage) -> usize {
        match stage {
            Stage::Gather { .. } | Stage::Begin { .. } | Stage::Drift | Stage::End => self.members.len(),
            Stage::Scatter => self.own,
            Stage::Fly => self.flying.len(),
            Stage::Swing => self.trees.len(),
            Stage::Prepare(color)
            | Stage::WarmStart(color)
            | Stage::Solve { color, .. }
            | Stage::Press { color, .. }
            | Stage::Rub(color)
            | Stage::Settle(color)
            | Stage::Project(color)
            | Stage::Note(color)
            | Stage::Bounce(color)
            | Stage::Store(color) => {
                let (start, end) = self.blocks(color);
                (end - start) as usize
            }
        }
    }

    fn chunk(&self, stage: Stage) -> usize {
        match stage {
            Stage::Gather { .. } | Stage::Begin { .. } | Stage::Drift | Stage::End | Stage::Scatter | Stage::Fly => {
                BODIES
            }
            Stage::Swing => 1,
            _ => BLOCKS,
        }
    }

    /// # Safety
    /// Each chunk of a stage by one thread, and no stage before the last is done.
    unsafe fn work(&self, stage: Stage, chunk: usize) {
        let size = self.chunk(stage);
        let items = chunk * size..((chunk + 1) * size).min(self.count(stage));
        let h = <L::Scalar as Scalar>::of(self.terms.h);
        // SAFETY: as the caller promises.
        unsafe {
            match stage {
                Stage::Fly => items.for_each(|index| {
                    let body = self.world.bodies.element(self.flying[index] as usize);
                    free_flight::fly(body, self.terms.h, self.terms.substeps.most);
                }),
                Stage::Swing => items.for_each(|index| self.swing(self.trees.element(index))),
                Stage::Gather { substeps, done } => items.for_each(|index| self.gather(index, substeps, done)),
                Stage::Begin { is_first } => items.for_each(|index| self.bodies.begin_substep(index, is_first)),
                Stage::Drift => items.for_each(|index| self.bodies.drift(index, h)),
                Stage::End => items.for_each(|index| self.bodies.end_substep(index)),
                Stage::Scatter => items.for_each(|index| {
                    let body = self.world.bodies.element(self.members[index] as usize);
                    if body.kind == RigidBody::Dynamic {
                        self.bodies.scatter(index, body);
                    }
                }),
                Stage::Prepare(color)
                | Stage::WarmStart(color)
                | Stage::Solve { color, .. }
                | Stage::Press { color, .. }
                | Stage::Rub(color)
                | Stage::Settle(color)
                | Stage::Project(color)
                | Stage::Note(color)
                | Stage::Bounce(color)
                | Stage::Store(color) => {
                    let first = self.blocks(color).0 as usize;
                    for block in items {
                        match color {
                            Color::Joints(_) => self.joint_stage(stage, first + block),
                            Color::Contacts(_) => self.contact_stage(stage, first + block),
                        }
                    }
                }
            }
        }
    }

    /// # Safety
    /// Nobody else may be using the body.
    unsafe fn gather(&self, index: usize, substeps: u32, done: u32) {
        let h = self.terms.h;
        // SAFETY: as the caller promises.
        let body = unsafe { self.world.bodies.get(self.members[index] as usize) };
        let there = (done > 0 && body.kind == RigidBody::Kinematic).then(|| {
            // Its own pose follows at the end of the step.
            let mut there = body.clone();
            there.coast(h * f64::from(done));
            there
        });
        // SAFETY: as the caller promises.
        unsafe { self.bodies.gather(index, there.as_ref().unwrap_or(body), h * f64::from(substeps), h) };
    }

    /// # Safety
    /// Nobody else may be using the tree's bodies and joints.
    unsafe fn swing(&self, tree: &mut TreeStep) {
        // SAFETY: as the caller promises.
        unsafe {
            let h = tree.step(|member| self.world.bodies.get(member as usize), &self.terms.substeps);
            for index in 0..tree.moving().len() {
                let member = tree.moving()[index] as usize;
                tree.scatter(index, self.world.bodies.element(member));
            }
            for (joint, force) in tree.joints().zip(tree.forces(h)) {
                self.world.joints.element(joint as usize).force = force;
            }
        }
    }

    /// # Safety
    /// Nobody else may be using the block and its bodies.
    unsafe fn joint_stage(&self, stage: Stage, index: usize) {
        let SharedBodies { velocity, moved, frames, .. } = self.bodies;
        let lanes = self.joint_colors.lanes(index);
        // SAFETY: as the caller promises.
        unsafe {
            let block = self.joint_blocks.element(index);
            match stage {
                Stage::Prepare(_) => {
                    let mut sites = [JointSite::default(); 8];
                    for (site, &joint) in sites.iter_mut().zip(lanes) {
                        *site = self.joint_site(joint);
                    }
                    *block = JointBlock::new(&sites[..lanes.len()], frames, self.terms.h);
                }
                Stage::WarmStart(_) => block.warm_start(velocity),
                Stage::Solve { sweep, .. } => {
                    let springs = (sweep != Sweep::Relax).then_some(&self.terms.joint);
                    block.solve(velocity, moved, springs);
                }
                Stage::Press { is_first, .. } => {
                    if is_first {
                        block.forget();
                    }
                    block.solve(velocity, moved, Some(&self.terms.joint));
                }
                Stage::Project(_) => {
                    if let Some(projection) = &self.terms.projection {
                        block.project(moved, projection);
                    }
                }
                Stage::Store(_) => {
                    for (lane, &joint) in lanes.iter().enumerate() {
                        let joint = self.world.joints.element(self.joints[joint as usize].global as usize);
                        joint.force = block.impulse(lane) / self.terms.h;
                    }
                }
                _ => {}
            }
        }
    }

    unsafe fn joint_site(&self, joint: u32) -> JointSite {
        let GroupJoint { global, a, b } = self.joints[joint as usize];
        // SAFETY: a joint is its group's own.
        let joint = unsafe { self.world.joints.get(global as usize) };
        let ([anchor_a, anchor_b], softness) = (joint.anchors(), joint.softness());
        JointSite { a, b, anchor_a, anchor_b, apart: self.apart(a, b), impulse: joint.force * self.terms.h, softness }
    }

    /// Centre of B less centre of A.
    fn apart(&self, a: u32, b: u32) -> Vector3<f64> {
        // SAFETY: written in the stage that gathers alone.
        let position = |body: u32| unsafe { self.bodies.positions.read((body & !READ_ONLY) as usize) };
        position(b) - position(a)
    }

    /// # Safety
    /// Nobody else may be using the block and its bodies.
    unsafe fn contact_stage(&self, stage: Stage, index: usize) {
        let SharedBodies { velocity, moved, frames, .. } = self.bodies;
        let lanes = self.contact_colors.lanes(index);
        // SAFETY: as the caller promises.
        unsafe {
            let block = self.contact_blocks.element(index);
            match stage {
                Stage::Prepare(_) => {
                    let first = self.contact_site(lanes[0]);
                    let mut sites = [first; 8];
                    for (site, &contact) in sites.iter_mut().zip(lanes).skip(1) {
                        *site = self.contact_site(contact);
                    }
                    *block = ContactBlock::new(&sites[..lanes.len()], frames);
                    *self.bounces.element(index) = self.bounce_of(block, lanes);
                }
                Stage::WarmStart(_) => block.warm_start(velocity),
                Stage::Solve { sweep, .. } => block.solve(velocity, moved, &self.terms.contact, sweep),
                Stage::Press { is_first, .. } => block.press(velocity, moved, &self.terms.contact, is_first),
                Stage::Rub(_) => block.rub(velocity),
                Stage::Settle(_) => block.settle(velocity),
                Stage::Project(_) => {
                    if let Some(projection) = &self.terms.projection {
                        block.project(moved, projection);
                    }
                }
                Stage::Note(_) => self.note(block, index),
                Stage::Bounce(_) => {
                    if let Some(Bounce { parting, peak }) = self.bounces.get(index) {
                        let pushed = |point: usize| peak[point].simd_gt(L::zero());
                        block.bounce(velocity, &std::array::from_fn(|p| parting[p].select(pushed(p), L::zero())));
                    }
                }
                Stage::Store(_) => {
                    for (lane, (&contact, impulses)) in lanes.iter().zip(block.impulses()).enumerate() {
                        let slot = self.contacts[contact as usize].slot as usize;
                        let state = self.world.states.element(slot);
                        state.impulses = impulses;
                        if state.pushes() != self.world.slots[slot].is_pressed {
                            self.world.presses_changed.store(true, Ordering::Relaxed);
                        }
                        if self.records {
                            *self.world.totals.element(slot) = self.totals.read(index * L::COUNT + lane);
                        }
                    }
                }
                _ => {}
            }
        }
    }

    unsafe fn contact_site(&self, contact: u32) -> ContactSite<'_> {
        let GroupContact { slot, a, b } = self.contacts[contact as usize];
        // SAFETY: a contact is its group's own.
        let state = unsafe { self.world.states.get(slot as usize) };
        let slot = &self.world.slots[slot as usize];
        let mut apart = self.apart(a, b) + slot.ahead;
        if a & READ_ONLY != 0 {
            // SAFETY: nobody writes bodies while rows are made from them.
            apart -= slot.origin_in_world(unsafe { self.world.bodies.get(slot.pair.a as usize) });
        }
        ContactSite { a, b, geometry: &state.geometry, impulses: &state.impulses, apart }
    }

    /// How fast the points that may bounce come together at the start of the step.
    unsafe fn bounce_of(&self, block: &ContactBlock<L>, lanes: &[u32]) -> Option<Bounce<L>> {
        let restitution = |lane: usize| {
            let slot = lanes.get(lane).map(|&contact| self.contacts[contact as usize].slot);
            slot.map_or(0.0, |slot| f64::from(self.world.slots[slot as usize].restitution))
        };
        if (0..L::COUNT).all(|lane| restitution(lane) == 0.0) {
            return None;
        }
        let share = L::each(|lane| <L::Scalar as Scalar>::of(restitution(lane)));
        let least = L::of(self.terms.restitution_speed);
        // SAFETY: velocities rest while rows are made.
        let approach = unsafe { block.approach(self.bodies.velocity) };
        let parting = approach.map(|speed| rebound(share, speed, least));
        Some(Bounce { parting, peak: [L::zero(); POINTS] })
    }

    /// Takes in what a block pushed in this substep.
    unsafe fn note(&self, block: &ContactBlock<L>, index: usize) {
        // SAFETY: the block is this thread's, and what goes with it.
        unsafe {
            if let Some(bounce) = self.bounces.element(index) {
                let pushes = block.pushes();
                bounce.peak = std::array::from_fn(|point| bounce.peak[point].simd_max(pushes[point]));
            }
            if self.records {
                for (lane, impulses) in block.impulses().into_iter().take(L::COUNT).enumerate() {
                    let total = self.totals.element(index * L::COUNT + lane);
                    total.0.iter_mut().zip(impulses.0).for_each(|(total, now)| *total += now);
                }
            }
        }
    }
}
