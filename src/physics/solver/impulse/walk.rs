//! What each [`Stage`] does to the bodies and constraints of a group.
#![allow(unsafe_code)]

use std::sync::atomic::{AtomicU32, Ordering};

use nalgebra::Vector3;

use super::bodies::{Ends, SharedBodies};
use super::coloring::{Color, Coloring};
use super::constants::{CHUNK_BLOCKS, CHUNK_BODIES, IMPACT_SWEEPS, WARM_START_TURN};
use super::contact::{ContactBlock, ContactImpulses, ContactInput};
use super::group::{Group, GroupContact, GroupJoint};
use super::impact::Restitution;
use super::joint::{Directions, JointBlock, JointInput, LinearParts, RowSoftness, RowsInput};
use super::stage::{GroupTerms, Stage, Sweep};
use super::tree::TreeStep;
use super::world::SharedWorld;
use crate::physics::body::{RigidBody, free_flight};
use crate::physics::joint::{BodyState, Joint, JointRow};
use crate::physics::lanes::{Lanes, READ_ONLY, WIDTH};
use crate::physics::scalar::Scalar;
use crate::physics::threads::{Division, Shared};

impl<L: Lanes> Group<L> {
    /// The colours of a group, joints first.
    pub fn colors(&self) -> impl Iterator<Item = Color> + Clone + use<L> {
        let (joints, contacts) = (self.joint_colors.stages.len() as u32, self.contact_colors.stages.len() as u32);
        (0..joints).map(Color::Joints).chain((0..contacts).map(Color::Contacts))
    }

    /// Goes through the stages.
    ///
    /// # Safety
    /// Nobody else may be writing the group's bodies, joints or contacts, nor bodies that these refer to.
    pub unsafe fn run(&mut self, terms: &GroupTerms<L>, world: SharedWorld, threads: u32) {
        self.totals.clear();
        if world.totals.is_some() {
            self.totals.resize(self.contact_blocks.len(), [ContactImpulses::default(); WIDTH]);
        }
        let traces = self.stages.iter().filter(|stage| matches!(stage, Stage::Trace { .. })).count();
        let changes: Vec<AtomicU32> = (0..traces).map(|_| AtomicU32::new(0)).collect();
        let [of_trees, of_joints, of_rows, of_contacts] = &mut self.claims;
        of_contacts.cover(self.contact_blocks.len());
        let walk = Walk {
            members: &self.members,
            own: self.own,
            joints: &self.joints,
            contacts: &self.contacts,
            joint_colors: &self.joint_colors,
            contact_colors: &self.contact_colors,
            free: &self.free,
            trees: Shared::new(&mut self.trees, of_trees),
            bodies: self.bodies.share(traces > 0),
            joint_blocks: Shared::new(&mut self.joint_blocks, of_joints),
            row_blocks: Shared::new(&mut self.row_blocks, of_rows),
            contact_blocks: Shared::with(&mut self.contact_blocks, of_contacts),
            restitutions: Shared::with(&mut self.restitutions, of_contacts),
            totals: Shared::with(&mut self.totals, of_contacts),
            struck: AtomicU32::new(0),
            changes: &changes,
            terms,
            world,
        };
        let stages = &self.stages;
        let chunks = stages.iter().map(|&stage| walk.count(stage).div_ceil(walk.chunk(stage)));
        let division = Division::of_stages(stages.len());
        self.progress.walk(threads, chunks, |stage, chunk| {
            // SAFETY: each chunk is given out once, and no stage before the last is done; what is the group's nobody
            // else touches, as the caller promises.
            division.stage(stage).work_as(chunk, || unsafe { walk.work(stages[stage], chunk) });
        });
        for stage in &self.stages {
            match stage {
                Stage::Trace { begins: true, .. } => self.residuals.begin_solve(),
                Stage::Trace { sweep, .. } => {
                    let change = changes[*sweep as usize].load(Ordering::Relaxed);
                    self.residuals.note(f64::from(f32::from_bits(change)));
                }
                _ => {}
            }
        }
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
    free: &'a [u32],
    trees: Shared<'a, TreeStep>,
    bodies: SharedBodies<'a, L::Scalar>,
    joint_blocks: Shared<'a, JointBlock<L>>,
    row_blocks: Shared<'a, JointBlock<L, Directions<L>>>,
    contact_blocks: Shared<'a, ContactBlock<L>>,
    restitutions: Shared<'a, Option<Restitution<L>>>,
    totals: Shared<'a, [ContactImpulses; WIDTH]>,
    /// The last sweep over impacts in which there was one, counted from 1.
    struck: AtomicU32,
    /// Of each sweep that is traced: the largest change of the velocity of a point of a body, m/s, the bits of an `f32`,
    /// whose order is that of such numbers.
    changes: &'a [AtomicU32],
    terms: &'a GroupTerms<L>,
    world: SharedWorld<'a>,
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
        if let Some(color) = stage.color() {
            let (start, end) = self.blocks(color);
            return (end - start) as usize;
        }
        match stage {
            Stage::FreeMotion => self.free.len(),
            Stage::Trees => self.trees.len(),
            Stage::Scatter | Stage::Trace { .. } => self.own,
            _ => self.members.len(),
        }
    }

    /// Items that one thread takes at a time.
    fn chunk(&self, stage: Stage) -> usize {
        match stage {
            Stage::Trees => 1,
            _ if stage.color().is_some() => CHUNK_BLOCKS,
            _ => CHUNK_BODIES,
        }
    }

    /// # Safety
    /// Each chunk of a stage by one thread, and no stage before the last is done. Nobody else may be writing what is
    /// the group's, nor bodies that it refers to. Every method below relies on it.
    unsafe fn work(&self, stage: Stage, chunk: usize) {
        let size = self.chunk(stage);
        let items = chunk * size..((chunk + 1) * size).min(self.count(stage));
        // SAFETY: as the caller promises; why no two chunks share an item's bodies is told in `super`.
        unsafe {
            match stage.color() {
                Some(color) => {
                    let first = self.blocks(color).0 as usize;
                    for block in items {
                        match color {
                            Color::Joints(_) if first + block < self.joint_blocks.len() => {
                                self.joint_stage(stage, first + block);
                            }
                            Color::Joints(_) => self.row_stage(stage, first + block),
                            Color::Contacts(_) => self.contact_stage(stage, first + block),
                        }
                    }
                }
                None => items.for_each(|index| self.body_stage(stage, index)),
            }
        }
    }

    /// # Safety
    /// As of [`Self::work`].
    unsafe fn body_stage(&self, stage: Stage, index: usize) {
        let GroupTerms { h, substeps, .. } = self.terms;
        // SAFETY: as the caller promises.
        unsafe {
            match stage {
                Stage::FreeMotion => {
                    let body = self.world.bodies.element(self.free[index] as usize);
                    free_flight::fly(body, *h, substeps.most);
                }
                Stage::Trees => self.tree(index),
                Stage::Gather { substeps, done } => self.gather(index, substeps, done),
                Stage::BeginSubstep { is_first } => self.bodies.claim(index).begin_substep(is_first),
                Stage::Drift { freely: false } => self.bodies.claim(index).drift(<L::Scalar as Scalar>::of(*h)),
                Stage::Drift { freely: true } => self.bodies.claim(index).drift_freely(<L::Scalar as Scalar>::of(*h)),
                Stage::EndSubstep => self.bodies.claim(index).end_substep(),
                Stage::Trace { begins, sweep } => {
                    let radius = self.world.bodies.get(self.members[index] as usize).radius;
                    let change = self.bodies.claim(index).change(radius) as f32;
                    if !begins && change > 0.0 {
                        self.changes[sweep as usize].fetch_max(change.to_bits(), Ordering::Relaxed);
                    }
                }
                Stage::Scatter => {
                    let body = self.world.bodies.element(self.members[index] as usize);
                    if body.kind == RigidBody::Dynamic {
                        self.bodies.claim(index).scatter(body);
                    }
                }
                _ => {}
            }
        }
    }

    /// # Safety
    /// As of [`Self::work`].
    unsafe fn gather(&self, index: usize, substeps: u32, done: u32) {
        let h = self.terms.h;
        // SAFETY: as the caller promises.
        let (body, mut claimed) =
            unsafe { (self.world.bodies.get(self.members[index] as usize), self.bodies.claim(index)) };
        let moved = (done > 0 && body.kind == RigidBody::Kinematic).then(|| {
            // Its own pose follows at the end of the step.
            let mut moved = body.clone();
            moved.coast(h * f64::from(done));
            moved
        });
        claimed.gather(moved.as_ref().unwrap_or(body), h * f64::from(substeps), h);
    }

    /// # Safety
    /// As of [`Self::work`].
    unsafe fn tree(&self, index: usize) {
        // SAFETY: as the caller promises; what was read of bodies is not held when they are written.
        unsafe {
            let tree = self.trees.element(index);
            let h = tree.step(|member| self.world.bodies.get(member as usize), &self.terms.substeps);
            for index in 0..tree.moving().len() {
                let member = tree.moving()[index] as usize;
                tree.scatter(index, self.world.bodies.element(member));
            }
            for (joint, force) in tree.joints().zip(tree.forces(h)) {
                self.world.joints.element(joint as usize).set_force(force);
            }
        }
    }

    /// # Safety
    /// As of [`Self::work`].
    #[inline(always)]
    unsafe fn joint_stage(&self, stage: Stage, index: usize) {
        let joints = self.joint_colors.lanes(index).iter().map(|&joint| self.joints[joint as usize]);
        // SAFETY: as the caller promises.
        unsafe {
            let block = self.joint_blocks.element(index);
            if let Stage::Prepare { .. } = stage {
                let mut inputs = [JointInput::default(); WIDTH];
                let lanes = inputs.iter_mut().zip(joints.clone());
                lanes.for_each(|(input, joint)| *input = self.joint_input(joint));
                block.ends = block_ends(joints.clone().map(|joint| [joint.a, joint.b]));
                block.take_in(&inputs[..joints.len()], &self.bodies.claim_pairs(block.ends), self.terms.h);
            } else if let Stage::Store(_) = stage {
                for (lane, joint) in joints.enumerate() {
                    self.world.joints.element(joint.global as usize).set_force(block.impulse(lane) / self.terms.h);
                }
            } else {
                self.sweep_joints(stage, block);
            }
        }
    }

    /// As [`Self::joint_stage`], of joints that hold no point at a point.
    ///
    /// # Safety
    /// As of [`Self::work`].
    #[inline(never)]
    unsafe fn row_stage(&self, stage: Stage, index: usize) {
        let joints = self.joint_colors.lanes(index).iter().map(|&joint| self.joints[joint as usize]);
        // SAFETY: as the caller promises.
        unsafe {
            let block = self.row_blocks.element(index - self.joint_blocks.len());
            if let Stage::Prepare { done, .. } = stage {
                let mut inputs = [RowsInput::default(); WIDTH];
                let lanes = inputs.iter_mut().zip(joints.clone());
                lanes.for_each(|(input, joint)| *input = self.rows_input(joint, done, block.scratch()));
                block.ends = block_ends(joints.clone().map(|joint| [joint.a, joint.b]));
                block.take_in_rows(&inputs[..joints.len()], &self.bodies.claim_pairs(block.ends), self.terms.h);
            } else if let Stage::Store(_) = stage {
                for (lane, GroupJoint { global, part, .. }) in joints.enumerate() {
                    let joint = self.world.joints.element(global as usize);
                    joint.store(part.half(), &block.wrench(lane), &block.impulse(lane), self.terms.h);
                }
            } else {
                self.sweep_joints(stage, block);
            }
        }
    }

    /// # Safety
    /// As of [`Self::work`].
    #[inline(always)]
    unsafe fn sweep_joints<P: LinearParts<L>>(&self, stage: Stage, block: &mut JointBlock<L, P>) {
        // SAFETY: as the caller promises.
        unsafe {
            let mut pairs = self.bodies.claim_pairs(block.ends);
            match stage {
                Stage::WarmStart(_) => block.warm_start(&mut pairs),
                Stage::Solve { sweep, .. } => {
                    let soft = (sweep != Sweep::Relax).then_some(&self.terms.joint);
                    block.solve(&mut pairs, soft);
                }
                Stage::SolvePositions { is_first, .. } => {
                    if is_first {
                        block.forget();
                    }
                    block.solve(&mut pairs, Some(&self.terms.joint));
                }
                Stage::Project(_) => {
                    if let Some(projection) = &self.terms.projection {
                        block.project(&mut pairs, projection);
                    }
                }
                _ => {}
            }
        }
    }

    /// # Safety
    /// As of [`Self::work`].
    unsafe fn rows_input(
        &self,
        GroupJoint { global, part, .. }: GroupJoint,
        done: u32,
        rows: &mut Vec<JointRow<f64>>,
    ) -> RowsInput {
        let h = self.terms.h;
        let passed = h * f64::from(done);
        // SAFETY: as the caller promises.
        let joint = unsafe { self.world.joints.get(global as usize) };
        let states = [joint.a, joint.b].map(|body| {
            // SAFETY: as the caller promises.
            let body = unsafe { self.world.bodies.get(body as usize) };
            let state = BodyState::of(body);
            // The own pose of a kinematic body follows at the end of the step.
            if body.kind == RigidBody::Kinematic { state.later(passed) } else { state }
        });
        rows.clear();
        joint.definition.rows_at(&states, self.terms.time + passed, rows);
        let first = if part.half() == 0 { 0 } else { joint.definition.halves()[0] };
        let count = joint.definition.halves()[part.half()];
        // SAFETY: as the caller promises.
        let trusted = unsafe { self.trusted_time(joint) };
        let of_half = |row: usize| rows.get(first + row).filter(|_| row < count).copied();
        let softness = of_half(0).and_then(|row| {
            // SAFETY: as the caller promises.
            let ends = [joint.a, joint.b].map(|body| unsafe { self.world.bodies.get(body as usize) });
            RowSoftness::of(&row, ends, h)
        });
        RowsInput {
            rows: std::array::from_fn(of_half),
            arm_b: states[1].rotation.mul_vec3(joint.definition.frames[1].anchor.into()).into(),
            impulse: Vector3::from_fn(
                |row, _| if row < count { joint.multipliers[first + row] * trusted } else { 0.0 },
            ),
            softness,
            least_bounce: self.terms.restitution_speed,
        }
    }

    /// # Safety
    /// As of [`Self::work`].
    unsafe fn joint_input(&self, GroupJoint { global, a, b, .. }: GroupJoint) -> JointInput {
        // SAFETY: as the caller promises.
        let (joint, offset) = unsafe { (self.world.joints.get(global as usize), self.bodies.offset(a, b)) };
        let (anchors, softness) =
            (joint.anchors(), joint.softness().map(|softness| RowSoftness::new(softness, self.terms.h)));
        // SAFETY: as the caller promises.
        let trusted = unsafe { self.trusted_time(joint) };
        JointInput { anchors, offset, impulse: joint.force * trusted, softness }
    }

    /// For how much of a substep, s, sweeps start from what a joint carried: none where that is doubtful, or where one of its
    /// bodies turns so far in a substep that the force on it points elsewhere.
    ///
    /// # Safety
    /// As of [`Self::work`].
    unsafe fn trusted_time(&self, joint: &Joint) -> f64 {
        let h = self.terms.h;
        let turns = [joint.a, joint.b].map(|body| {
            // SAFETY: as the caller promises.
            unsafe { self.world.bodies.get(body as usize) }.angular.norm_squared() * h * h
        });
        let is_stale = turns[0].max(turns[1]) > WARM_START_TURN * WARM_START_TURN;
        if is_stale { 0.0 } else { joint.trusted_time(h) }
    }

    /// # Safety
    /// As of [`Self::work`].
    unsafe fn contact_stage(&self, stage: Stage, index: usize) {
        let contacts = self.contact_colors.lanes(index).iter().map(|&contact| self.contacts[contact as usize]);
        // SAFETY: as the caller promises.
        unsafe {
            let block = self.contact_blocks.element(index);
            if let Stage::Prepare { .. } = stage {
                block.ends = block_ends(contacts.clone().map(|contact| [contact.a, contact.b]));
            }
            let mut pairs = self.bodies.claim_pairs(block.ends);
            match stage {
                Stage::Prepare { done, .. } => {
                    let first = contacts.clone().next().expect("a block has a contact");
                    let mut inputs = [self.contact_input(first); WIDTH];
                    let lanes = inputs.iter_mut().zip(contacts.clone()).skip(1);
                    lanes.for_each(|(input, contact)| *input = self.contact_input(contact));
                    block.take_in(&inputs[..contacts.len()], &pairs);
                    let restitution = |lane: usize| {
                        let slot = contacts.clone().nth(lane).map(|contact| contact.slot);
                        slot.map_or(0.0, |slot| f64::from(self.world.slots[slot as usize].restitution))
                    };
                    let before = self.restitutions.element(index);
                    let mut now = Restitution::new(restitution);
                    if let (Some(now), Some(before), 1..) = (&mut now, &before, done) {
                        now.resume(before);
                    }
                    *before = now;
                }
                Stage::WarmStart(_) => block.warm_start(&mut pairs),
                Stage::Solve { sweep, .. } => block.solve(&mut pairs, &self.terms.contact, sweep),
                Stage::SolvePositions { is_first, .. } => {
                    block.solve_positions(&mut pairs, &self.terms.contact, is_first);
                }
                Stage::SolveFriction(_) => block.solve_friction(&mut pairs),
                Stage::SolveVelocities(_) => block.solve_velocities(&mut pairs),
                Stage::Project(_) => {
                    if let Some(projection) = &self.terms.projection {
                        block.project(&mut pairs, projection);
                    }
                }
                Stage::Record(_) => {
                    let totals = self.totals.element(index);
                    let mut add = |impulses: [ContactImpulses; WIDTH]| {
                        for (total, now) in totals.iter_mut().zip(impulses) {
                            total.0.iter_mut().zip(now.0).for_each(|(total, now)| *total += now);
                        }
                    };
                    add(block.impulses(L::zero()));
                    if let Some(restitution) = self.restitutions.element(index) {
                        add(L::give(restitution.take_impacts()));
                    }
                }
                Stage::Impact { sweep, .. } => {
                    let is_due = sweep % IMPACT_SWEEPS == 0 || self.struck.load(Ordering::Relaxed) >= sweep;
                    if let Some(restitution) = self.restitutions.element(index).as_mut().filter(|_| is_due) {
                        let GroupTerms { h, restitution_speed, .. } = *self.terms;
                        if block.bounce(&mut pairs, restitution, [restitution_speed, h].map(L::of)) {
                            self.struck.fetch_max(sweep + 1, Ordering::Relaxed);
                        }
                    }
                }
                Stage::Store(_) => {
                    let of_impacts = self.restitutions.get(index).as_ref().map_or(L::zero(), Restitution::of_step);
                    for (lane, (contact, impulses)) in contacts.zip(block.impulses(of_impacts)).enumerate() {
                        self.world.store(contact.slot, impulses);
                        if let Some(totals) = self.world.totals {
                            *totals.element(contact.slot as usize) = self.totals.get(index)[lane];
                        }
                    }
                }
                _ => {}
            }
        }
    }

    /// # Safety
    /// As of [`Self::work`].
    unsafe fn contact_input(&self, GroupContact { slot, a, b }: GroupContact) -> ContactInput<'_> {
        // SAFETY: as the caller promises.
        let (state, mut offset) = unsafe { (self.world.states.get(slot as usize), self.bodies.offset(a, b)) };
        let slot = &self.world.slots[slot as usize];
        offset += slot.ahead;
        if a & READ_ONLY != 0 {
            // SAFETY: as the caller promises.
            offset -= slot.origin_in_world(unsafe { self.world.bodies.get(slot.pair.a as usize) });
        }
        ContactInput { geometry: &state.geometry, impulses: &state.impulses, offset }
    }
}

/// The bodies of a block's constraints. Lanes left over write none.
fn block_ends(bodies: impl ExactSizeIterator<Item = [u32; 2]> + Clone) -> Ends {
    let mut ends = [[0; WIDTH]; 2];
    let last = bodies.clone().last().unwrap_or_default().map(|body| body | READ_ONLY);
    for (lane, [a, b]) in bodies.chain(std::iter::repeat(last)).take(WIDTH).enumerate() {
        (ends[0][lane], ends[1][lane]) = (a, b);
    }
    ends
}
