//! An island of contacts and joints, and the solve of all of it at once for given masses, momenta and rows.

use std::ops::RangeInclusive;

use nalgebra::{Matrix3, Vector3};

use super::any_joint::AnyJoint;
use super::constants::{
    DUAL_PRODUCTS, ENERGY_ROUNDING, IMPULSE_TOLERANCE, LINE_SEARCH_POINTS, LINE_SEARCH_SLOPE, REST_PRODUCTS,
};
use super::contact::DirectContact;
use super::dual::DualSystem;
use super::joint::DirectJoint;
use super::reduced::{ReducedTrees, change_of};
use super::rows::{Correction, RowBlocks, RowKey, Rows, body_vector, halves};
use super::snapshot::Snapshot;
use super::world::World;
use crate::physics::body::Body;
use crate::physics::constraint::row::{Twist, Wrench};
use crate::physics::joint::{BodyState, Joint, JointRow};
use crate::physics::lanes::Record;
use crate::physics::solver::exact::MemberState;
use crate::physics::solver::linear::{BlockLdl, BodyVector, Elimination, Inverse};
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
#[derive(Default)]
pub(crate) struct DirectIsland {
    /// Bodies that move, contacts by slot and joints, global indices; of joints first those that hold a point at a point.
    pub(super) members: Vec<u32>,
    pub(super) contacts: Vec<u32>,
    pub(super) joints: Vec<u32>,
    /// How many joints hold a point at a point.
    pub(super) points: usize,
    /// Which of its joints have rows, first those that hold a point at a point.
    pub(super) row_points: Vec<u32>,
    pub(super) row_others: Vec<u32>,
    /// Of contacts, then joints that have rows: both bodies' places among the members.
    ends: Vec<[Option<u32>; 2]>,
    analysis: Analysis,
    pub(super) elimination: Elimination,
    /// Whether it was solved here in the last step, at rest or in motion.
    pub is_solved: bool,
    /// How often it was factored since somebody last took the count.
    pub factorisations: u32,
    /// Whether the iterations of the last substep in motion ended.
    pub(super) has_converged: bool,
    /// Whether its contacts go on from substep to substep in its step in motion.
    pub(super) is_steady: bool,
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
    matrix: BlockLdl<f64, Inverse>,
    /// M v₀ + h f, by place in the elimination, like the next three.
    pub(super) momentum: Vec<BodyVector>,
    pub(super) velocity: Vec<BodyVector>,
    /// Velocity of the iteration before.
    pub(super) before: Vec<BodyVector>,
    /// Velocity that corrects position errors besides, and its sum over several corrections.
    pub(super) correction: Vec<BodyVector>,
    pub(super) shifts: Vec<BodyVector>,
    /// Where members were, and that sum, before the last of these.
    pub(super) states_before: Vec<MemberState>,
    pub(super) shifts_before: Vec<BodyVector>,
    /// Of contacts, then joints: the relative motion of the iteration before, and how far to the one at hand.
    lines: Vec<(Twist<f64>, Twist<f64>)>,
    pub(super) contact_rows: Vec<DirectContact>,
    pub(super) joint_rows: Vec<DirectJoint>,
    pub(super) any_rows: Vec<AnyJoint>,
    /// Rows of one joint, and how often those of joints were made.
    pub(super) scratch: Vec<JointRow<f64>>,
    made: u32,
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
    /// Where it has contacts, too: the trees of its joints.
    pub(super) reduced: Option<Box<ReducedTrees>>,
    /// Where these have too many coordinates: the system by which its joints are put together in the poses once all was
    /// solved for.
    pub(super) posture: Option<Box<DualSystem>>,
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
        Self { members, contacts, joints, has_converged: true, ..Self::default() }
    }

    /// Whether it can be factored, and then what that takes.
    pub(super) fn is_analysed(&mut self, world: &impl World, time: f64) -> bool {
        if self.analysis == Analysis::Due {
            self.analysis = self.analyse(world);
            let has_contacts = !self.contacts.is_empty();
            let may_reduce = has_contacts && self.analysis == Analysis::Done;
            let reduced = may_reduce.then(|| ReducedTrees::new(world, &self.members, &self.joints, &self.elimination));
            self.reduced = reduced.flatten().map(Box::new);
            let is_wanted = self.points < self.joints.len() && self.reduced.is_none();
            let parts = [&self.members[..], &self.partners, &self.joints];
            let system = is_wanted.then(|| DualSystem::new(world, time, parts, DUAL_PRODUCTS)).flatten().map(Box::new);
            (self.dual, self.posture) = if has_contacts { (None, system) } else { (system, None) };
            self.allot_rows(world);
        }
        self.analysis == Analysis::Done
    }

    /// Whether its joints hold more than points, and are put together in the poses.
    pub(super) fn holds_more_than_points(&self) -> bool {
        self.posture.is_some() || self.reduced.is_some() && self.points < self.joints.len()
    }

    /// Finds out which joints have rows.
    fn allot_rows(&mut self, world: &impl World) {
        let has_rows = |&joint: &u32| self.reduced.as_ref().is_none_or(|reduced| !reduced.holds(joint as usize));
        let points = self.points as u32;
        let row_points: Vec<u32> = (0..points).filter(has_rows).collect();
        let row_others: Vec<u32> = (points..self.joints.len() as u32).filter(has_rows).collect();
        let local = |body: u32| self.members.binary_search(&body).ok().map(|local| local as u32);
        self.ends.truncate(self.contacts.len());
        let with_rows = row_points.iter().chain(&row_others).map(|&joint| world.joint(self.joints[joint as usize]));
        self.ends.extend(with_rows.map(|joint| [joint.a, joint.b].map(local)));
        self.joint_rows.clear();
        self.joint_rows.resize(row_points.len(), DirectJoint::default());
        self.any_rows.clear();
        self.any_rows.resize(row_others.len(), AnyJoint::default());
        let ends = &self.ends[self.contacts.len() + row_points.len()..];
        if let Some(reduced) = &self.reduced {
            for ((rows, &joint), ends) in self.any_rows.iter_mut().zip(&row_others).zip(ends) {
                rows.link = reduced.link_between(world.joint(self.joints[joint as usize]), ends);
            }
        }
        self.blocks.resize(self.ends.len(), RowBlocks::default());
        (self.row_points, self.row_others) = (row_points, row_others);
    }

    fn analyse(&mut self, world: &impl World) -> Analysis {
        let local = |body: u32| self.members.binary_search(&body).ok().map(|local| local as u32);
        let of_contacts = self.contacts.iter().map(|&slot| world.slot(slot).pair).map(|pair| [pair.a, pair.b]);
        let of_joints = self.joints.iter().map(|&joint| world.joint(joint)).map(|joint| [joint.a, joint.b]);
        let pairs = of_contacts.chain(of_joints);
        self.ends = pairs.clone().map(|pair| pair.map(local)).collect();
        self.partners = pairs.flatten().filter(|&body| local(body).is_none()).collect();
        self.partners.sort_unstable();
        self.partners.dedup();
        let edges = self.ends.iter().filter_map(|[a, b]| Some([(*a)?, (*b)?]));
        let count = self.members.len();
        let Some(elimination) = Elimination::new(&vec![6; count], edges, REST_PRODUCTS) else {
            return Analysis::Unsuitable;
        };
        self.elimination = elimination;
        for vectors in [&mut self.momentum, &mut self.velocity, &mut self.before, &mut self.correction] {
            vectors.resize(count, BodyVector::zeros());
        }
        self.inertias.resize(count, (0.0, Matrix3::zeros()));
        self.contact_rows.resize(self.contacts.len(), DirectContact::default());
        self.points = self.joints.partition_point(|&joint| world.joint(joint).definition.is_ball());
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
        let of_trees = match &self.reduced {
            Some(reduced) => reduced.rows(),
            None => 0,
        };
        (of_contacts + 3 * self.joint_rows.len() + of_joints + of_trees) as u32
    }

    /// Has it look again at what its joints are and between which bodies.
    pub fn renew(&mut self) {
        self.analysis = Analysis::Due;
        self.factored.clear();
        self.blocks.clear();
        self.snapshots.clear();
    }

    /// Whether it is of these bodies, contacts and joints.
    pub fn is_of(&self, members: &[u32], contacts: &[u32], joints: &[u32]) -> bool {
        self.members == members && self.contacts == contacts && self.joints == joints
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
            let before = std::mem::replace(rows, DirectContact::of(world, slot, ends, scale));
            (rows.penalty, rows.per_step) = (penalty * mass, 1.0 / h);
            resume(rows, &before);
        }
    }

    /// Has contacts bounce that come together faster than `least`, m/s, in the substep that begins; `penalty` is that of
    /// the others, over the mass of the island.
    pub(super) fn bounce(&mut self, world: &impl World, least: f64, penalty: f64) {
        for (local, &member) in self.members.iter().enumerate() {
            let Body { linear, angular, .. } = world.body(member);
            self.velocity[self.elimination.place(local as u32) as usize] = body_vector(linear, angular);
        }
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
        for ((rows, &joint), ends) in self.joint_rows.iter_mut().zip(&self.row_points).zip(ends) {
            let joint = world.joint(self.joints[joint as usize]);
            let before = std::mem::replace(rows, DirectJoint::of(world, joint, ends, h));
            resume(rows, &before, joint);
        }
    }

    /// Makes the rows of all other joints at that time, s, for `h`, s; `ahead` is how far into it they are to turn with
    /// their bodies, s, the third span the approach from which limits bounce, m/s. `keeps`: which are active stays, and
    /// limits that are far away are not looked at.
    pub(super) fn make_any_rows(&mut self, world: &impl World, time: f64, spans: [f64; 3], keeps: bool) {
        self.made = self.made.wrapping_add(1);
        let ends = &self.ends[self.contacts.len() + self.row_points.len()..];
        for ((rows, &joint), ends) in self.any_rows.iter_mut().zip(&self.row_others).zip(ends) {
            if keeps && rows.is_idle() {
                continue;
            }
            let joint = world.joint(self.joints[joint as usize]);
            let bodies = [world.body(joint.a), world.body(joint.b)];
            self.scratch.clear();
            joint.definition.rows_at(&bodies.map(BodyState::of), time, &mut self.scratch);
            rows.made = self.made;
            rows.renew(joint, &self.scratch, bodies, ends, spans, keeps);
        }
    }

    /// Active-set iterations: Newton's method on which rows are active. Whether it found out within so many: the fewer
    /// where the last can be gone on from.
    pub(super) fn iterate(&mut self, counts: RangeInclusive<usize>) -> bool {
        let momentum: f64 = self.momentum.iter().map(|vector| vector.fixed_rows::<3>(0).norm()).sum();
        let tolerance = IMPULSE_TOLERANCE * momentum / self.members.len() as f64;
        let mut free = None;
        for iteration in 0..*counts.end() {
            if !self.factor() {
                self.velocity.iter_mut().for_each(|vector| vector.fill(0.0));
                return false;
            }
            std::mem::swap(&mut self.velocity, &mut self.before);
            self.velocity.copy_from_slice(&self.momentum);
            let Self { contact_rows, joint_rows, any_rows, elimination, velocity, .. } = self;
            for_each_constraint!((&*contact_rows, &*joint_rows, &*any_rows), |rows| {
                if !rows.is_idle() {
                    apply(elimination, velocity, rows, &rows.impulse_at_rest());
                }
            });
            self.solve_by_factor(|island| &mut island.velocity);
            let share = if iteration == 0 { 1.0 } else { self.search_line() };
            let Self { contact_rows, joint_rows, any_rows, elimination, velocity, before, .. } = self;
            for rows in any_rows.iter_mut().filter(|rows| !rows.is_idle()) {
                rows.carry(&relative_motion(elimination, velocity, rows, &rows.prescribed), share);
            }
            if share < 1.0 {
                let pairs = velocity.iter_mut().zip(&*before);
                pairs.for_each(|(velocity, before)| *velocity = before + (*velocity - before) * share);
            }
            let mut holds = share == 1.0;
            for_each_constraint!((&mut *contact_rows, &mut *joint_rows, &mut *any_rows), |rows| {
                let motion = relative_motion(elimination, velocity, rows, rows.prescribed());
                holds &= rows.take(&motion, tolerance);
            });
            if holds {
                return true;
            }
            if iteration + 1 >= *counts.start() {
                let free = *free.get_or_insert_with(|| self.free_energy());
                if !self.has_gained(free) {
                    return false;
                }
            }
        }
        false
    }

    /// From momenta to velocities by the factor at hand.
    fn solve_by_factor(&mut self, of: impl Fn(&mut Self) -> &mut Vec<BodyVector>) {
        let mut vectors = std::mem::take(of(self));
        match &mut self.reduced {
            Some(reduced) => reduced.solve(&mut vectors),
            None => self.matrix.solve(&self.elimination, &mut vectors[..]),
        }
        *of(self) = vectors;
    }

    /// Whether it has more energy than its bodies would have alone. Contacts and joints only take energy, so that some row
    /// then has an impulse that is of another active set. (A support that moves gives energy, and costs an iteration more.)
    fn has_gained(&self, free: f64) -> bool {
        self.kinetic_energy() > ENERGY_ROUNDING * free
    }

    /// Twice the kinetic energy at the velocity of the iteration at hand, J.
    fn kinetic_energy(&self) -> f64 {
        let bodies = self.inertias.iter().enumerate();
        bodies.map(|(local, inertia)| kinetic_energy(inertia, &self.velocity[self.place(local)])).sum()
    }

    /// The same of the bodies alone, with their momenta.
    fn free_energy(&self) -> f64 {
        let bodies = self.inertias.iter().enumerate();
        bodies.map(|(local, inertia)| free_energy(inertia, &self.momentum[self.place(local)])).sum()
    }

    /// Slows all down alike to the energy that the bodies would have alone, with what springs and motors give: for where
    /// the iterations did not end. Rows that hold still do.
    pub(super) fn take_back_gain(&mut self) {
        let (kinetic, free) = (self.kinetic_energy(), self.free_energy());
        let Self { reduced, joint_rows, any_rows, elimination, velocity, .. } = self;
        let mut given = 0.0;
        for rows in joint_rows.iter().filter(|rows| rows.softness.is_some()) {
            given += rows.impulse.dot(&relative_motion(elimination, velocity, rows, &rows.prescribed).linear).max(0.0);
        }
        for rows in &*any_rows {
            given += rows.given(&relative_motion(elimination, velocity, rows, &rows.prescribed));
        }
        let most = ENERGY_ROUNDING * free + 2.0 * given;
        if kinetic <= most {
            return;
        }
        let share = (most / kinetic).sqrt();
        velocity.iter_mut().for_each(|velocity| *velocity *= share);
        joint_rows.iter_mut().for_each(|rows| rows.impulse *= share);
        any_rows.iter_mut().for_each(|rows| rows.scale(share));
        if let Some(reduced) = reduced {
            reduced.scale_loads(share);
        }
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
        let Self { contact_rows, joint_rows, any_rows, elimination, velocity, before, lines, .. } = self;
        lines.clear();
        for_each_constraint!((&*contact_rows, &*joint_rows, &*any_rows), |rows| {
            if !rows.is_idle() {
                let [from, to] = [&*before, &*velocity]
                    .map(|velocity| relative_motion(elimination, velocity, rows, rows.prescribed()));
                lines.push((from, to.plus(&from, -1.0)));
            }
        });
        level(|share| {
            let (mut given, mut lines) = (0.0, lines.iter());
            for_each_constraint!((&*contact_rows, &*joint_rows, &*any_rows), |rows| {
                if !rows.is_idle() {
                    let (from, line) = lines.next().expect("each constraint has one");
                    given += line.dot(&rows.impulse_at(&from.plus(line, share)));
                }
            });
            start + share * growth - given
        })
    }

    /// Factors the matrix of the active rows, unless the factor at hand will do.
    fn factor(&mut self) -> bool {
        let Self { matrix, reduced, contact_rows, joint_rows, any_rows, .. } = self;
        let Self { elimination, ends, factored, inertias, blocks, factorisations, .. } = self;
        let (mut then, mut is_same) = (factored.iter(), factored.len() == ends.len());
        for_each_constraint!((&*contact_rows, &*joint_rows, &*any_rows), |rows| {
            is_same = is_same && then.next().is_some_and(|then| rows.key().is_nearly(then));
        });
        if is_same {
            return true;
        }
        *factorisations += 1;
        factored.clear();
        for_each_constraint!((&*contact_rows, &*joint_rows, &*any_rows), |rows| {
            let key = rows.key();
            blocks[factored.len()].update(&key, || rows.blocks());
            factored.push(key);
        });
        let acting = blocks.iter().zip(&*ends).filter(|(held, _)| held.acts);
        let is_positive = match reduced {
            Some(reduced) => {
                reduced.begin(inertias);
                acting.for_each(|(held, ends)| reduced.add_rows(held, ends));
                reduced.assemble();
                for (rows, link) in any_rows.iter().filter_map(|rows| Some((rows, rows.link?))) {
                    rows.turning_rows().for_each(|(row, penalty)| reduced.add_turning(link, &row, penalty));
                }
                reduced.factor()
            }
            None => {
                matrix.clear(elimination);
                for (body, (mass, inertia)) in inertias.iter().enumerate() {
                    let mut block = matrix.diagonal_mut::<6>(elimination.place(body as u32) as usize);
                    block.fixed_view_mut::<3, 3>(0, 0).copy_from(&Matrix3::from_diagonal_element(*mass));
                    block.fixed_view_mut::<3, 3>(3, 3).copy_from(inertia);
                }
                for (held, [a, b]) in acting {
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
                matrix.factor(elimination)
            }
        };
        if !is_positive {
            factored.clear();
        }
        is_positive
    }

    /// Solves for the velocity that corrects position errors.
    pub(super) fn correct(&mut self, rates: &Correction) {
        self.correction.fill(BodyVector::zeros());
        let closes = self.reduced.as_mut().is_some_and(|reduced| reduced.close(|gap| rates.of_gap(gap)));
        self.apply_corrections(rates, true);
        if closes || self.correction.iter().any(|vector| *vector != BodyVector::zeros()) {
            self.solve_by_factor(|island| &mut island.correction);
        }
    }

    /// Adds the impulses that correct position errors, those of contacts only where that is wanted.
    pub(super) fn apply_corrections(&mut self, rates: &Correction, with_contacts: bool) {
        let Self { contact_rows, joint_rows, any_rows, elimination, correction, factored, .. } = self;
        // A row that corrects must be in the factor.
        let contacts = if with_contacts { &contact_rows[..] } else { &[] };
        let mut keys = factored.iter().skip(contact_rows.len() - contacts.len());
        for_each_constraint!((contacts, &*joint_rows, &*any_rows), |rows| {
            if let Some(key) = keys.next()
                && !rows.is_idle()
            {
                apply(elimination, correction, rows, &rows.correction(key, rates));
            }
        });
    }

    /// Finds what the joints of trees carried.
    pub(super) fn find_loads(&mut self) {
        let Self { reduced, contact_rows, joint_rows, any_rows, elimination, .. } = self;
        let Self { before, velocity, momentum, inertias, factored, .. } = self;
        let Some(reduced) = reduced.as_mut().filter(|_| !factored.is_empty()) else { return };
        for (local, inertia) in inertias.iter().enumerate() {
            let place = elimination.place(local as u32) as usize;
            before[place] = change_of(inertia, &velocity[place], &momentum[place]);
        }
        for_each_constraint!((&*contact_rows, &*joint_rows, &*any_rows), |rows| {
            if !rows.is_idle() {
                let impulse = rows.impulse();
                apply(elimination, before, rows, &Wrench::zero().plus(&impulse, -1.0));
            }
        });
        reduced.find_loads(before);
    }

    /// Impulses of a contact, divided by `scale`, N·s.
    pub fn impulses(&self, contact: usize, scale: f64) -> Record<f32> {
        self.contact_rows[contact].impulses(scale)
    }

    /// Writes what a joint carried in `h`, s.
    pub fn store_joint(&self, index: usize, joint: &mut Joint, h: f64) {
        joint.is_doubtful = self.moves && self.holds_more_than_points() && !self.has_converged;
        if let Some(dual) = self.dual.as_ref().filter(|_| self.moves) {
            dual.store(self.joints[index], joint);
            return;
        }
        if let Some(reduced) = self.reduced.as_ref().filter(|reduced| reduced.holds(index)) {
            reduced.store(index, joint, h);
            return;
        }
        let own = index as u32;
        match self.row_points.binary_search(&own) {
            Ok(row) => joint.force = self.joint_rows[row].impulse / h,
            Err(_) => {
                let row = self.row_others.binary_search(&own).expect("what is no link has rows");
                self.any_rows[row].store(joint, h);
            }
        }
    }
}

/// Where a slope that starts negative and only grows is level, or 1 if it still falls there.
pub(super) fn level(slope: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = ((0.0, slope(0.0)), (1.0, slope(1.0)));
    let flat = LINE_SEARCH_SLOPE * low.1.abs();
    if high.1 <= flat || low.1 >= 0.0 {
        return 1.0;
    }
    for _ in 0..LINE_SEARCH_POINTS {
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

/// Twice the kinetic energy of a body of that mass and inertia at a velocity, J.
pub(super) fn kinetic_energy((mass, inertia): &(f64, Matrix3<f64>), velocity: &BodyVector) -> f64 {
    let (linear, angular) = halves(velocity);
    mass * linear.norm_squared() + angular.dot(&(inertia * angular))
}

/// The same with that momentum.
pub(super) fn free_energy((mass, inertia): &(f64, Matrix3<f64>), momentum: &BodyVector) -> f64 {
    let (linear, angular) = halves(momentum);
    let spin = inertia.cholesky().map_or_else(Vector3::zeros, |factor| factor.solve(&angular));
    linear.norm_squared() / mass + angular.dot(&spin)
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
