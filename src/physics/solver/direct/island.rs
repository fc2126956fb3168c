//! An island of contacts and joints, and the solve of all of it at once for given masses, momenta and rows.

use std::ops::RangeInclusive;

use nalgebra::{Matrix3, Vector3};

use super::any_joint::AnyJoint;
use super::constants::{
    DUAL_PRODUCTS, ENERGY_ROUNDING, EXPECTED_GAIN, IMPULSE_TOLERANCE, JOINT_PENALTY, LINE_SEARCH_POINTS,
    LINE_SEARCH_SLOPE, REST_PRODUCTS,
};
use super::contact::DirectContact;
use super::dual::DualSystem;
use super::joint::{DirectJoint, SoftLaw};
use super::loads::{Kept, Loads};
use super::posture::Posture;
use super::rows::{Correction, RowBlocks, RowKey, Rows, Side, body_vector, halves};
use super::snapshot::Snapshot;
use super::world::World;
use crate::physics::body::{Body, world_inverse_inertia};
use crate::physics::constraint::row::{Twist, Wrench};
use crate::physics::joint::{BodyState, Joint, JointRow, Softness};
use crate::physics::lanes::Record;
use crate::physics::solver::linear::{BlockLdl, BodyVector, Elimination, Inverse};
use crate::physics::solver::soft_terms::{SoftTerms, UNLIMITED};
use crate::physics::solver::substeps::Intervals;

/// Does the same to the rows of each constraint of an island: contacts, then points held at points, then other joints.
macro_rules! for_each_constraint {
    (($contacts:expr, $points:expr, $joints:expr), |$rows:ident| $work:block) => {
        for $rows in $contacts $work
        for $rows in $points $work
        for $rows in $joints $work
    };
}

/// What is known of how an island can be factored.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Analysis {
    /// It was not needed so far.
    #[default]
    Due,
    /// There is an elimination.
    Done,
    /// It is for the sweeps.
    Unsuitable,
}

/// An island and its factor.
#[derive(Clone, Default)]
pub(crate) struct DirectIsland {
    /// Bodies that move, contacts by slot and joints, global indices; of joints first those that hold a point at a point.
    pub(super) members: Vec<u32>,
    pub(super) contacts: Vec<u32>,
    pub(super) joints: Vec<u32>,
    /// How many joints hold a point at a point.
    pub(super) points: usize,
    /// Of contacts, then joints: both bodies' places among the members.
    ends: Vec<[Option<u32>; 2]>,
    /// The bodies of each contact, global indices, for which it was analysed: a slot may have come to be of others.
    pairs: Vec<[u32; 2]>,
    analysis: Analysis,
    pub(super) loads: Loads,
    pub kept: Kept,
    pub(super) elimination: Elimination,
    /// The pairs of members that the elimination is for.
    edges: Vec<[u32; 2]>,
    /// Whether it was solved here in the last step, at rest or in motion.
    pub is_solved: bool,
    /// How often it was in that step.
    pub solves: u32,
    /// Whether the iterations of the last substep in motion ended.
    pub(super) has_converged: bool,
    /// Whether those of all substeps of its last step in motion did.
    pub(super) is_trusted: bool,
    /// Whether its last solve was in motion.
    pub(super) moves: bool,
    /// Whether some contact may bounce in its step in motion.
    pub(super) bounces: bool,
    /// Whether it was still when its step in motion began.
    pub(super) was_still: bool,
    /// The substeps of its step in motion.
    pub(super) intervals: Intervals,
    /// Geometric stiffness of each member.
    pub(super) stiffnesses: Vec<Matrix3<f64>>,
    /// Steps for which none was tried at rest after the last that failed, and those left.
    pub(super) pause: u32,
    pub(super) pause_left: u32,
    pub(super) matrix: BlockLdl<f64, Inverse>,
    /// M v₀ + h f, by place in the elimination, like the next three.
    pub(super) momentum: Vec<BodyVector>,
    pub(super) velocity: Vec<BodyVector>,
    /// Velocity of the iteration before.
    pub(super) before: Vec<BodyVector>,
    /// Velocity that corrects position errors besides.
    pub(super) correction: Vec<BodyVector>,
    /// Of contacts, then joints: the relative motion of the iteration before, and of the one at hand.
    motions: [Vec<Twist<f64>>; 2],
    /// How far from one to the other; none where the rows have no impulse on the way.
    lines: Vec<Option<Twist<f64>>>,
    pub(super) contact_rows: Vec<DirectContact>,
    pub(super) joint_rows: Vec<DirectJoint>,
    pub(super) any_rows: Vec<AnyJoint>,
    /// Rows of one joint.
    scratch: Vec<JointRow<f64>>,
    /// Whether the rows of contacts are those of the step before.
    pub(super) has_rows: bool,
    /// The rows that the factor was made of, contacts first; empty: there is none.
    pub(super) factored: Vec<RowKey>,
    /// What each adds to the matrix.
    blocks: Vec<RowBlocks>,
    /// Mass and world inertia of each member that the factor was made of.
    pub(super) inertias: Vec<(f64, Matrix3<f64>)>,
    /// The impulses of its joints as unknowns, where it has no contacts and some joint holds more than a point.
    pub(super) dual: Option<Box<DualSystem>>,
    /// Where it has contacts besides: its joints, which are put together in the poses once all was solved for.
    pub(super) posture: Option<Box<Posture>>,
    /// Whether a spring pulls at some point, as the hand of a user does.
    pub(super) is_pulled: bool,
    /// Whether joints were put together so in the substep at hand.
    pub(super) is_put_together: bool,
    /// Bodies that do not move here but touch or hold it, global indices.
    pub(super) partners: Vec<u32>,
    /// Members, then partners, after a step that changed nothing; else empty.
    pub(super) snapshots: Vec<Snapshot>,
    /// Step, and the sum of when the manifolds were found, then.
    pub(super) snapshot_key: (f64, u64),
}

impl DirectIsland {
    /// Of bodies that move and contacts by slot, both ascending, and joints, first those that hold a point at a point.
    pub fn new(members: Vec<u32>, contacts: Vec<u32>, joints: Vec<u32>) -> Self {
        Self { members, contacts, joints, has_converged: true, is_trusted: true, ..Self::default() }
    }

    /// The island of the same members and joints with those contacts: a new one, but for its memory and for what does not
    /// depend on contacts.
    pub fn with_contacts(self, contacts: &[u32]) -> Self {
        let mut old = self;
        old.contacts.clear();
        old.contacts.extend_from_slice(contacts);
        for vectors in [&mut old.momentum, &mut old.velocity, &mut old.before, &mut old.correction] {
            vectors.clear();
        }
        old.inertias.clear();
        old.contact_rows.clear();
        old.blocks.clear();
        Self {
            elimination: old.elimination,
            edges: old.edges,
            posture: old.posture,
            matrix: old.matrix,
            momentum: old.momentum,
            velocity: old.velocity,
            before: old.before,
            correction: old.correction,
            inertias: old.inertias,
            contact_rows: old.contact_rows,
            blocks: old.blocks,
            scratch: old.scratch,
            ..Self::new(old.members, old.contacts, old.joints)
        }
    }

    /// Whether it can be factored, and then what that takes.
    pub(super) fn is_analysed(&mut self, world: &impl World, time: f64) -> bool {
        if self.analysis == Analysis::Due {
            self.analysis = self.analyse(world);
            let is_wanted = self.points < self.joints.len();
            let parts = [&self.members[..], &self.partners, &self.joints];
            let is_alone = self.contacts.is_empty();
            let dual = (is_wanted && is_alone).then(|| DualSystem::new(world, time, parts, DUAL_PRODUCTS)).flatten();
            self.dual = dual.map(Box::new);
            self.posture = match self.posture.take() {
                _ if !is_wanted || is_alone => None,
                Some(mut posture) => {
                    posture.place(world, [&self.members, &self.partners]);
                    Some(posture)
                }
                None => Posture::new(world, parts, DUAL_PRODUCTS).map(Box::new),
            };
        }
        self.analysis == Analysis::Done
    }

    fn analyse(&mut self, world: &impl World) -> Analysis {
        let local = |body: u32| self.members.binary_search(&body).ok().map(|local| local as u32);
        let of_contacts = self.contacts.iter().map(|&slot| world.slot(slot).pair).map(|pair| [pair.a, pair.b]);
        let of_joints = self.joints.iter().map(|&joint| world.joint(joint)).map(|joint| [joint.a, joint.b]);
        self.pairs = of_contacts.clone().collect();
        let pairs = of_contacts.chain(of_joints);
        self.ends = pairs.clone().map(|pair| pair.map(local)).collect();
        self.partners = pairs.flatten().filter(|&body| local(body).is_none()).collect();
        self.partners.sort_unstable();
        self.partners.dedup();
        let edges: Vec<_> = self.ends.iter().filter_map(|[a, b]| Some([(*a)?, (*b)?])).collect();
        let count = self.members.len();
        if self.elimination.count() != count || self.edges != edges {
            self.elimination = Elimination::default();
            let Some(elimination) = Elimination::new(&vec![6; count], edges.iter().copied(), REST_PRODUCTS) else {
                return Analysis::Unsuitable;
            };
            (self.elimination, self.edges) = (elimination, edges);
        }
        for vectors in [&mut self.momentum, &mut self.velocity, &mut self.before, &mut self.correction] {
            vectors.resize(count, BodyVector::zeros());
        }
        self.inertias.resize(count, (0.0, Matrix3::zeros()));
        self.contact_rows.resize(self.contacts.len(), DirectContact::default());
        self.points = self.joints.partition_point(|&joint| world.joint(joint).definition.is_ball());
        self.joint_rows.resize(self.points, DirectJoint::default());
        self.any_rows.resize(self.joints.len() - self.points, AnyJoint::default());
        self.blocks.resize(self.ends.len(), RowBlocks::default());
        Analysis::Done
    }

    /// The bodies that move, global indices, ascending.
    pub fn members(&self) -> &[u32] {
        &self.members
    }

    /// Its contacts, by slot.
    pub fn contacts(&self) -> &[u32] {
        &self.contacts
    }

    /// Whether it was analysed for those contacts, by slot, which are of the bodies that `pair` tells.
    pub fn is_of(&self, contacts: &[u32], pair: impl Fn(u32) -> [u32; 2]) -> bool {
        self.contacts == contacts && self.pairs.iter().copied().eq(contacts.iter().map(|&slot| pair(slot)))
    }

    /// Its joints, global indices.
    pub fn joints(&self) -> &[u32] {
        &self.joints
    }

    /// Whether it is joints alone, which tell what they carried at the end of the step.
    pub fn is_without_contacts(&self) -> bool {
        self.dual.is_some()
    }

    /// Scalar rows: of each contact its points and three of friction.
    pub fn rows(&self) -> u32 {
        let of_contacts: usize = self.contact_rows.iter().map(|contact| contact.points() + 3).sum();
        if let Some(dual) = &self.dual {
            return dual.row_count as u32;
        }
        let of_joints: usize = self.any_rows.iter().map(AnyJoint::rows).sum();
        (of_contacts + 3 * self.points + of_joints) as u32
    }

    /// Has it look again at what its joints are and between which bodies.
    pub fn renew(&mut self) {
        self.analysis = Analysis::Due;
        self.posture = None;
        self.factored.clear();
        self.blocks.clear();
        self.snapshots.clear();
    }

    /// The place of a member in the elimination.
    pub(super) fn place(&self, local: usize) -> usize {
        self.elimination.place(local as u32) as usize
    }

    /// Makes the rows of contacts, of `h`, s, with impulses taken `scale` times, and hands each on with those before.
    /// Those of which a body `stays` keep their geometry.
    pub(super) fn make_contact_rows(
        &mut self,
        world: &impl World,
        [h, scale, penalty]: [f64; 3],
        stays: impl Fn(&Body) -> bool,
        mut resume: impl FnMut(&mut DirectContact, &DirectContact),
    ) {
        let mass: f64 = self.members.iter().map(|&member| world.body(member).mass).sum();
        for ((rows, &slot), ends) in self.contact_rows.iter_mut().zip(&self.contacts).zip(&self.ends) {
            let pair = world.slot(slot).pair;
            if stays(world.body(pair.a)) || stays(world.body(pair.b)) {
                continue;
            }
            let before = std::mem::replace(rows, contact_rows(world, slot, ends, scale));
            (rows.penalty, rows.per_step) = (penalty * mass, 1.0 / h);
            resume(rows, &before);
        }
    }

    /// Has contacts foresee the substep that begins by the motion at its start.
    pub(super) fn foresee(&mut self, world: &impl World) {
        self.take_velocities(world);
        let Self { contact_rows, elimination, velocity, .. } = self;
        for rows in contact_rows {
            rows.foresee(&relative_motion(elimination, velocity, rows, &rows.prescribed));
        }
    }

    /// Has contacts bounce that come together faster than `least`, m/s, in the substep that begins; `penalty` is that of
    /// the others, over the mass of the island.
    pub(super) fn bounce(&mut self, world: &impl World, least: f64, penalty: f64) {
        self.take_velocities(world);
        let mass: f64 = self.members.iter().map(|&member| world.body(member).mass).sum();
        let Self { contact_rows, elimination, velocity, .. } = self;
        for rows in contact_rows {
            let motion = relative_motion(elimination, velocity, rows, &rows.prescribed);
            rows.bounce(&motion, least, penalty * mass);
        }
    }

    /// Makes the rows of joints that hold a point at a point, for `h`, s, and hands each on with those before.
    pub(super) fn make_joint_rows(
        &mut self,
        world: &impl World,
        h: f64,
        mut resume: impl FnMut(&mut DirectJoint, &DirectJoint, &Joint),
    ) {
        let ends = &self.ends[self.contacts.len()..];
        for ((rows, &joint), ends) in self.joint_rows.iter_mut().zip(&self.joints).zip(ends) {
            let joint = world.joint(joint);
            let before = std::mem::replace(rows, joint_rows(world, joint, ends, h));
            resume(rows, &before, joint);
        }
    }

    /// Makes the rows of all other joints at that time, s, for `h`, s; `ahead` is how far into it they are to turn with
    /// their bodies, s, the third span the approach from which limits bounce, m/s. Where they `resume`, those are active
    /// that were.
    pub(super) fn make_any_rows(&mut self, world: &impl World, time: f64, spans: [f64; 3], resume: bool) {
        let joints = self.joints[self.points..].iter().zip(&self.ends[self.contacts.len() + self.points..]);
        for (rows, (&joint, ends)) in self.any_rows.iter_mut().zip(joints) {
            let joint = world.joint(joint);
            let bodies = [world.body(joint.a), world.body(joint.b)];
            self.scratch.clear();
            joint.definition.rows_at(&bodies.map(BodyState::of), time, &mut self.scratch);
            rows.renew(joint, &self.scratch, bodies, ends, spans, resume);
        }
    }

    /// Active-set iterations: Newton's method on which rows are active. Whether it found out within so many: the fewer
    /// where the last can be gone on from.
    pub(super) fn iterate(&mut self, counts: RangeInclusive<usize>) -> bool {
        let momentum: f64 = self.momentum.iter().map(|vector| vector.fixed_rows::<3>(0).norm()).sum();
        let tolerance = IMPULSE_TOLERANCE * momentum / self.members.len() as f64;
        for iteration in 0..*counts.end() {
            if !self.factor() {
                self.velocity.iter_mut().for_each(|vector| vector.fill(0.0));
                return false;
            }
            std::mem::swap(&mut self.velocity, &mut self.before);
            self.velocity.copy_from_slice(&self.momentum);
            let Self { contact_rows, joint_rows, any_rows, elimination, velocity, matrix, .. } = self;
            for_each_constraint!((&*contact_rows, &*joint_rows, &*any_rows), |rows| {
                if rows.acts() {
                    apply(elimination, velocity, rows, &rows.impulse_at_rest());
                }
            });
            matrix.solve(elimination, &mut velocity[..]);
            self.find_motions();
            let share = if iteration == 0 { 1.0 } else { self.search_line() };
            let of_any = self.contact_rows.len() + self.joint_rows.len();
            for (rows, motion) in self.any_rows.iter_mut().zip(&self.motions[1][of_any..]) {
                rows.carry(motion, share);
            }
            if share < 1.0 {
                self.stop_at(share);
            }
            let Self { contact_rows, joint_rows, any_rows, motions, .. } = self;
            let (mut holds, mut motions) = (share == 1.0, motions[1].iter());
            for_each_constraint!((&mut *contact_rows, &mut *joint_rows, &mut *any_rows), |rows| {
                let motion = motions.next().expect("each constraint has one");
                holds &= rows.take(motion, tolerance);
            });
            if holds {
                return true;
            }
            if iteration + 1 >= *counts.start() && !self.has_gained() {
                return false;
            }
        }
        false
    }

    /// The relative motions at the velocity at hand; those that were are the ones before.
    fn find_motions(&mut self) {
        let Self { contact_rows, joint_rows, any_rows, elimination, velocity, motions, .. } = self;
        let [before, now] = motions;
        std::mem::swap(before, now);
        now.clear();
        for_each_constraint!((&*contact_rows, &*joint_rows, &*any_rows), |rows| {
            now.push(relative_motion(elimination, velocity, rows, rows.prescribed()));
        });
    }

    /// Has the velocity at hand be that share of the way from the one before.
    fn stop_at(&mut self, share: f64) {
        let pairs = self.velocity.iter_mut().zip(&self.before);
        pairs.for_each(|(velocity, before)| *velocity = before + (*velocity - before) * share);
        let [before, now] = &mut self.motions;
        let pairs = now.iter_mut().zip(&*before);
        pairs.for_each(|(now, before)| *now = before.plus(&now.plus(before, -1.0), share));
    }

    /// Whether it has more energy than its bodies would have alone. Contacts and joints only take energy, so that some row
    /// then has an impulse that is of another active set. (A support that moves gives energy, and costs an iteration more.)
    fn has_gained(&self) -> bool {
        let [kinetic, free] = self.energies();
        kinetic > ENERGY_ROUNDING * free
    }

    /// See [`energies`]; the velocity is that of the iteration at hand.
    fn energies(&self) -> [f64; 2] {
        energies(self.inertias.iter().enumerate().map(|(local, inertia)| {
            let place = self.place(local);
            (inertia, &self.velocity[place], &self.momentum[place])
        }))
    }

    /// What the impulses expected, q = Σ Jᵀλ̂, are beside what they are to leave at the present velocities, a = M v − p with
    /// the momenta p: aᵀM⁻¹a, aᵀM⁻¹q and qᵀM⁻¹q. None where an inertia has no inverse.
    pub(super) fn weigh_expected(&mut self) -> Option<[f64; 3]> {
        let Self { contact_rows, joint_rows, any_rows, elimination, velocity, before, momentum, inertias, .. } = self;
        before.fill(BodyVector::zeros());
        for_each_constraint!((&*contact_rows, &*joint_rows, &*any_rows), |rows| {
            apply(elimination, before, rows, &rows.expected());
        });
        let (mut left, mut along, mut square) = (0.0, 0.0, 0.0);
        for (local, (mass, inertia)) in inertias.iter().enumerate() {
            let place = elimination.place(local as u32) as usize;
            let [(force, torque), (linear, angular), (momentum, spin)] =
                [&before[place], &velocity[place], &momentum[place]].map(halves);
            let inverse = inertia.try_inverse()?;
            let (linear, angular) = (linear * *mass - momentum, inertia * angular - spin);
            let rates = (force / *mass, inverse * torque);
            left += linear.norm_squared() / *mass + angular.dot(&(inverse * angular));
            along += rates.0.dot(&linear) + rates.1.dot(&angular);
            square += rates.0.dot(&force) + rates.1.dot(&torque);
        }
        Some([left, along, square])
    }

    /// Expects a share of what it did.
    pub(super) fn expect_share(&mut self, share: f64) {
        let Self { contact_rows, joint_rows, any_rows, .. } = self;
        for_each_constraint!((contact_rows, joint_rows, any_rows), |rows| {
            rows.expect_share(share);
        });
    }

    /// Takes the impulses expected, q, s times, 0 ≤ s ≤ 1, where they would throw the bodies, with (p + q)ᵀM⁻¹(p + q) far
    /// above pᵀM⁻¹p for their momenta p: so that the former is least. Rows of contacts give way by λ̂ over their penalty, so
    /// that what iterations which did not end left there would be had as velocity.
    pub(super) fn expect_no_throw(&mut self) {
        self.velocity.fill(BodyVector::zeros());
        let Some([alone, along, square]) = self.weigh_expected() else { return };
        let mass: f64 = self.inertias.iter().map(|(mass, _)| mass).sum();
        let [times, speed] = EXPECTED_GAIN;
        if alone - 2.0 * along + square > times * alone + mass * speed * speed {
            self.expect_share((along / square).clamp(0.0, 1.0));
        }
    }

    /// Slows all down alike to the most energy that the bodies can have: what they would have alone, what springs and
    /// motors give, and what supports give that move at `speed`, m/s, which is no more than all bodies thrown ahead of
    /// them at twice that. For where the iterations did not end; rows that hold still do.
    pub(super) fn take_back_gain(&mut self, speed: f64) {
        let [kinetic, free] = self.energies();
        let Self { contact_rows, joint_rows, any_rows, elimination, velocity, inertias, .. } = self;
        let mut given = 0.0;
        // Work on the members alone: what a hand gives that moves is in it.
        for rows in joint_rows.iter().filter(|rows| rows.softness.is_some()) {
            given += rows.impulse.dot(&relative_motion(elimination, velocity, rows, &Twist::zero()).linear).max(0.0);
        }
        for rows in &*any_rows {
            given += rows.given(&relative_motion(elimination, velocity, rows, &Twist::zero()));
        }
        let mass: f64 = inertias.iter().map(|(mass, _)| mass).sum();
        let most = ((ENERGY_ROUNDING * free + 2.0 * given).sqrt() + 2.0 * speed * mass.sqrt()).powi(2);
        if kinetic <= most {
            return;
        }
        let share = (most / kinetic).sqrt();
        velocity.iter_mut().for_each(|velocity| *velocity *= share);
        contact_rows.iter_mut().for_each(|rows| rows.scale(share));
        joint_rows.iter_mut().for_each(|rows| rows.impulse *= share);
        any_rows.iter_mut().for_each(|rows| rows.scale(share));
    }

    /// Which share of the line from the velocity before to the one at hand to go. With the rows active that are active
    /// there,
    ///
    /// φ(v) = ½ (v − v₀)ᵀM(v − v₀) + Σ |λ(v)|²/(2ρ)
    ///
    /// is convex for a given limit of friction: on a line that goes down and ends in a climb, go to its least.
    fn search_line(&mut self) -> f64 {
        let (mut start, mut growth) = (0.0, 0.0);
        for (local, (mass, inertia)) in self.inertias.iter().enumerate() {
            let place = self.place(local);
            let line = self.velocity[place] - self.before[place];
            let times = |vector: &BodyVector| {
                let (linear, angular) = halves(vector);
                body_vector(&(linear * *mass), &(inertia * angular))
            };
            start += line.dot(&(times(&self.before[place]) - self.momentum[place]));
            growth += line.dot(&times(&line));
        }
        let Self { contact_rows, joint_rows, any_rows, motions: [from, to], lines, .. } = self;
        lines.clear();
        for_each_constraint!((&*contact_rows, &*joint_rows, &*any_rows), |rows| {
            let [from, to] = [&from[lines.len()], &to[lines.len()]];
            // Impulses are linear on the way, but for their bounds.
            let acts = [from, to].iter().any(|motion| rows.impulse_at(motion) != Wrench::zero());
            lines.push(acts.then(|| to.plus(from, -1.0)));
        });
        level(LINE_SEARCH_POINTS, |share| {
            let (mut given, mut lines) = (0.0, from.iter().zip(&*lines));
            for_each_constraint!((&*contact_rows, &*joint_rows, &*any_rows), |rows| {
                if let Some((from, Some(line))) = lines.next() {
                    given += line.dot(&rows.impulse_at(&from.plus(line, share)));
                }
            });
            start + share * growth - given
        })
    }

    /// Factors the matrix of the active rows, unless the factor at hand will do.
    pub(super) fn factor(&mut self) -> bool {
        let Self { matrix, contact_rows, joint_rows, any_rows, elimination, ends, factored, inertias, blocks, .. } =
            self;
        let (mut then, mut is_same) = (factored.iter(), factored.len() == ends.len());
        for_each_constraint!((&*contact_rows, &*joint_rows, &*any_rows), |rows| {
            is_same = is_same && then.next().is_some_and(|then| rows.key().is_nearly(then));
        });
        if is_same {
            return true;
        }
        factored.clear();
        matrix.clear(elimination);
        for (body, (mass, inertia)) in inertias.iter().enumerate() {
            let mut block = matrix.diagonal_mut::<6>(elimination.place(body as u32) as usize);
            block.fixed_view_mut::<3, 3>(0, 0).copy_from(&Matrix3::from_diagonal_element(*mass));
            block.fixed_view_mut::<3, 3>(3, 3).copy_from(inertia);
        }
        for_each_constraint!((&*contact_rows, &*joint_rows, &*any_rows), |rows| {
            let key = rows.key();
            blocks[factored.len()].update(&key, |blocks| rows.blocks(blocks));
            factored.push(key);
        });
        for ((held, [a, b]), key) in blocks.iter().zip(&*ends).zip(&*factored) {
            if key.active == 0 && key.across == [0.0; 2] {
                continue;
            }
            for (body, block) in [(a, &held.own[0]), (b, &held.own[1])] {
                if let Some(body) = *body {
                    let mut own = matrix.diagonal_mut::<6>(elimination.place(body) as usize);
                    own += block;
                }
            }
            if let (Some(a), Some(b)) = (*a, *b) {
                matrix.add(elimination.block(a, b), &held.across);
            }
        }
        let is_positive = matrix.factor(elimination);
        if !is_positive {
            factored.clear();
        }
        is_positive
    }

    /// Solves for the velocity that corrects position errors.
    pub(super) fn correct(&mut self, rates: &Correction) {
        let Self { contact_rows, joint_rows, any_rows, elimination, correction, matrix, factored, .. } = self;
        correction.fill(BodyVector::zeros());
        // A row that corrects must be in the factor.
        let mut keys = factored.iter();
        for_each_constraint!((&*contact_rows, &*joint_rows, &*any_rows), |rows| {
            if let Some(key) = keys.next() {
                apply(elimination, correction, rows, &rows.correction(key, rates));
            }
        });
        if correction.iter().any(|vector| *vector != BodyVector::zeros()) {
            matrix.solve(elimination, &mut correction[..]);
        }
    }

    /// Impulses of a contact, divided by `scale`, N·s.
    pub fn impulses(&self, contact: usize, scale: f64) -> Record<f32> {
        self.contact_rows[contact].impulses(scale)
    }

    /// Writes what a joint carried in `h`, s.
    pub fn store_joint(&self, index: usize, joint: &mut Joint, h: f64) {
        joint.is_doubtful = self.moves && self.posture.is_some() && !self.is_trusted;
        if let Some(dual) = self.dual.as_ref().filter(|_| self.moves) {
            dual.store(self.joints[index], joint);
            return;
        }
        match index.checked_sub(self.points) {
            None => joint.force = self.joint_rows[index].impulse / h,
            Some(index) => self.any_rows[index].store(joint, h),
        }
    }
}

/// Where a slope that starts negative and only grows is level, or 1 if it still falls there; looked for at so many points
/// at most.
pub(super) fn level(points: usize, slope: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = ((0.0, slope(0.0)), (1.0, slope(1.0)));
    let flat = LINE_SEARCH_SLOPE * low.1.abs();
    if high.1 <= flat || low.1 >= 0.0 {
        return 1.0;
    }
    for _ in 0..points {
        // By the secant, but not too near the ends.
        let (width, secant) = (high.0 - low.0, low.1 / (low.1 - high.1));
        let share = low.0 + width * secant.clamp(0.1, 0.9);
        let now = (share, slope(share));
        if now.1.abs() <= flat {
            return share;
        }
        if now.1 > 0.0 { high = now } else { low = now }
    }
    if low.0 > 0.0 { low.0 } else { high.0 }
}

/// M v + h f.
pub(super) fn momentum_of(body: &Body, inertia: &Matrix3<f64>, h: f64) -> BodyVector {
    let linear = body.linear * body.mass + body.force * h;
    let angular = inertia * body.angular + body.torque * h;
    body_vector(&linear, &angular)
}

/// Twice the kinetic energy of bodies of these masses and inertias at a velocity, and alone, with their momentum, each
/// given so, J.
pub(super) fn energies<'p>(
    bodies: impl Iterator<Item = (&'p (f64, Matrix3<f64>), &'p BodyVector, &'p BodyVector)>,
) -> [f64; 2] {
    let (mut kinetic, mut free) = (0.0, 0.0);
    for ((mass, inertia), velocity, momentum) in bodies {
        let (linear, angular) = halves(velocity);
        kinetic += mass * linear.norm_squared() + angular.dot(&(inertia * angular));
        let (linear, angular) = halves(momentum);
        let spin = inertia.cholesky().map_or_else(Vector3::zeros, |factor| factor.solve(&angular));
        free += linear.norm_squared() / mass + angular.dot(&spin);
    }
    [kinetic, free]
}

/// The relative motion that sides without a member give.
fn prescribed(sides: &[Side; 2], bodies: [&Body; 2], arms: [Vector3<f64>; 2]) -> Twist<f64> {
    let [a, b] = [0, 1].map(|side| match sides[side].body {
        Some(_) => Twist::zero(),
        None => Twist { linear: bodies[side].point_velocity(&arms[side]), angular: bodies[side].angular },
    });
    b.plus(&a, -1.0)
}

fn contact_rows(world: &impl World, slot: u32, ends: &[Option<u32>; 2], scale: f64) -> DirectContact {
    let (state, slot) = (world.state(slot), world.slot(slot));
    let bodies = [slot.pair.a, slot.pair.b].map(|body| world.body(body));
    let [a, b] = bodies;
    let origin = slot.origin_in_world(a);
    let offset = b.position - a.position + slot.ahead - origin;
    let turns = bodies.map(|body| body.rotation.to_rotation_matrix().into_inner());
    let mut contact = DirectContact::new(state, &turns, &offset, [f64::from(slot.restitution), scale]);
    contact.sides[0].arm += origin;
    for (side, body) in contact.sides.iter_mut().zip(ends) {
        side.body = *body;
    }
    contact.prescribed = prescribed(&contact.sides, bodies, contact.sides.map(|side| side.arm));
    contact
}

fn joint_rows(world: &impl World, joint: &Joint, ends: &[Option<u32>; 2], h: f64) -> DirectJoint {
    let bodies = [world.body(joint.a), world.body(joint.b)];
    let anchors = joint.anchors();
    let arms = [bodies[0].rotation * anchors[0], bodies[1].rotation * anchors[1]];
    let sides = [0, 1].map(|side| Side { body: ends[side], arm: arms[side] });
    let separation = bodies[1].position - bodies[0].position + arms[1] - arms[0];
    let softness = joint.softness().map(|Softness { frequency, damping_ratio, max_force }| {
        // As sweeps take it: of the pair's own mass.
        let terms = SoftTerms::<f64>::new(frequency, damping_ratio, UNLIMITED, 0.0, h);
        let inverse_mass: Matrix3<f64> = (0..2).map(|side| inverse_mass_at(bodies[side], &sides[side])).sum();
        let mass = inverse_mass.try_inverse().unwrap_or_else(Matrix3::zeros);
        SoftLaw::new(mass * (terms.mass / terms.impulse), separation * terms.rate, max_force * h)
    });
    let masses = (0..2).filter(|&side| sides[side].body.is_some()).map(|side| bodies[side].mass);
    DirectJoint {
        penalty: JOINT_PENALTY * masses.fold(f64::INFINITY, f64::min),
        softness,
        sides,
        prescribed: prescribed(&sides, bodies, arms),
        separation,
        expected: joint.force * h,
        impulse: Vector3::zeros(),
    }
}

/// Velocity at the arm of a body for an impulse there.
fn inverse_mass_at(body: &Body, side: &Side) -> Matrix3<f64> {
    if side.body.is_none() {
        return Matrix3::zeros();
    }
    let arm = side.arm.cross_matrix();
    let inverse_inertia = world_inverse_inertia(&body.inverse_inertia_body, &body.rotation, &body.rotation_freedom);
    Matrix3::from_diagonal(&body.inverse_mass) - arm * inverse_inertia * arm
}

/// Adds an impulse of rows on B, and its reaction on A.
pub(super) fn apply(elimination: &Elimination, vectors: &mut [BodyVector], rows: &impl Rows, impulse: &Wrench<f64>) {
    let [a, b] = rows.sides();
    if let Some(body) = a.body {
        vectors[elimination.place(body) as usize] -= rows.wrench_on(0, impulse);
    }
    if let Some(body) = b.body {
        vectors[elimination.place(body) as usize] += rows.wrench_on(1, impulse);
    }
}

/// B's motion less A's, besides what is prescribed.
pub(super) fn relative_motion(
    elimination: &Elimination,
    velocities: &[BodyVector],
    rows: &impl Rows,
    prescribed: &Twist<f64>,
) -> Twist<f64> {
    let [a, b] = [0, 1].map(|side| {
        let body = rows.sides()[side].body;
        body.map_or_else(Twist::zero, |body| rows.motion_of(side, &velocities[elimination.place(body) as usize]))
    });
    prescribed.plus(&b, 1.0).plus(&a, -1.0)
}
