//! One group of islands: its bodies and constraints, coloured, and the buffers to solve them, kept
//! from step to step. What is done to it, stage by stage, is in [`super::walk`].

use bevy::platform::collections::HashMap;

use super::bodies::GroupBodies;
use super::coloring::Coloring;
use super::constants::{DIRECT_BODIES, PARALLEL_BLOCKS};
use super::contact::{ContactBlock, ContactImpulses};
use super::impact::Restitution;
use super::joint::{Directions, JointBlock};
use super::method;
use super::stage::Stage;
use super::tree::TreeStep;
use crate::physics::body::{Bodies, Body};
use crate::physics::collision::{ContactGraph, ContactState, POINTS};
use crate::physics::grouped::Grouped;
use crate::physics::island::Islands;
use crate::physics::joint::{Joint, Joints};
use crate::physics::lanes::{Lanes, READ_ONLY, WIDTH};
use crate::physics::refill::Refill;
use crate::physics::settings::{Method, SolverSettings};
use crate::physics::solve_trace::Residuals;
use crate::physics::solver::direct::DirectIsland;
use crate::physics::solver::joint_tree::{Partition, partition};
use crate::physics::threads::{Claims, Stages};

/// What of a joint a block takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum JointPart {
    /// All of one that holds a point at a point.
    Point,
    /// A half of any other: the first comes before the second in every sweep.
    Half(u8),
}

impl JointPart {
    /// Which half it is.
    pub fn half(self) -> usize {
        match self {
            Self::Point => 0,
            Self::Half(half) => usize::from(half),
        }
    }
}

/// A joint as a group sees it.
#[derive(Clone, Copy, Debug)]
pub(super) struct GroupJoint {
    pub global: u32,
    pub part: JointPart,
    pub a: u32,
    pub b: u32,
}

/// A contact as a group sees it.
#[derive(Clone, Copy, Debug)]
pub(super) struct GroupContact {
    pub slot: u32,
    pub a: u32,
    pub b: u32,
}

/// What moves a body of the group.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Place {
    /// Free motion: no constraint holds or touches it.
    Free,
    /// A tree of joints that no contact touches.
    Tree,
    /// Sweeps, as the member of that index.
    Swept(u32),
    /// An island that is solved directly.
    DirectIsland,
}

/// What is solved without sweeps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct DirectScope {
    /// Trees of joints that no contact touches, and islands with joints in motion.
    pub trees: bool,
    /// Islands at rest.
    pub rest: bool,
}

impl DirectScope {
    /// As the settings want it.
    pub fn of(settings: &SolverSettings) -> Self {
        let rest = settings.impulse.fitted_effort && settings.method == Method::SoftStep;
        Self { trees: method::solves_trees(settings.method), rest }
    }
}

/// What a group is planned from.
#[derive(Clone, Copy)]
pub(super) struct PlanInput<'a> {
    pub islands: &'a Islands,
    pub bodies: &'a Bodies,
    pub joints: &'a Joints,
    pub graph: &'a ContactGraph,
}

impl PlanInput<'_> {
    /// Whether constraints move a body.
    fn moves(&self, body: u32) -> bool {
        self.bodies.list[body as usize].is_dynamic()
    }

    /// The place of a body that constraints move among those of a group.
    fn local_of(&self, body: u32, group: usize) -> Option<u32> {
        self.moves(body).then(|| self.islands.local_of(body, group)).flatten()
    }
}

/// How much of a group is solved directly.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct DirectCounts {
    /// Bodies at rest.
    pub resting: u32,
    pub rows: u32,
    /// Rows solved, over all substeps.
    pub row_updates: u32,
    /// Products of blocks that heavy loads took.
    pub spent: u64,
    /// Whether other islands are than in the step before.
    pub changed: bool,
}

/// A group of islands.
#[derive(Clone, Default)]
pub(crate) struct Group<L: Lanes> {
    /// Which of the islands' groups it is.
    pub(super) index: usize,
    /// Indices of its bodies: the first `own` move here, the others are guests.
    pub(super) members: Vec<u32>,
    pub(super) own: usize,
    guests: HashMap<u32, u32>,
    pub(super) place: Vec<Place>,
    pub(super) may_bounce: bool,
    /// Whether some joint's rows may change with time.
    is_driven: bool,
    /// Bodies that no constraint holds or touches.
    pub(super) free: Vec<u32>,
    pub(super) trees: Vec<TreeStep>,
    /// Islands with contacts or joints, to be solved directly where they rest or have joints.
    #[expect(clippy::vec_box, reason = "large, and moved from list to list whenever islands are found anew")]
    pub(super) islands: Vec<Box<DirectIsland>>,
    /// Which island each body begins, and members, contacts and joints by island.
    numbers: Vec<u32>,
    found: [Grouped; 3],
    pub(super) counts: DirectCounts,
    /// Version of the joints that it was planned for.
    joints_of: u64,
    /// Joints that are not in trees which no contact touches, global indices.
    other_joints: Vec<u32>,
    pub(super) joints: Vec<GroupJoint>,
    pub(super) contacts: Vec<GroupContact>,
    pub(super) joint_colors: Coloring,
    pub(super) contact_colors: Coloring,
    pairs: Vec<(u32, u32)>,
    /// Of each contact.
    point_counts: Vec<u32>,
    pub(super) bodies: GroupBodies<L::Scalar>,
    /// Of points held at points, and of other joints: numbered one after the other.
    pub(super) joint_blocks: Vec<JointBlock<L>>,
    pub(super) row_blocks: Vec<JointBlock<L, Directions<L>>>,
    pub(super) contact_blocks: Vec<ContactBlock<L>>,
    /// One for each block of contacts.
    pub(super) restitutions: Vec<Option<Restitution<L>>>,
    /// While somebody reads contact forces: the impulses of each block's contacts, summed over the substeps, N·s.
    pub(super) totals: Vec<[ContactImpulses; WIDTH]>,
    /// While somebody reads the residuals of sweeps: those of the step.
    pub(super) residuals: Residuals,
    pub(super) stages: Vec<Stage>,
    pub(super) progress: Stages,
    /// Of trees, blocks of points held at points and of other joints, and blocks of contacts with what goes with them.
    pub(super) claims: [Claims; 4],
}

impl<L: Lanes> Group<L> {
    /// Takes in which bodies and constraints the islands' group of its index has, and colours them. To be called
    /// whenever the islands have changed, or what is solved without sweeps.
    pub fn plan(&mut self, input: &PlanInput, scope: DirectScope) {
        self.place.clear();
        self.place.resize(input.islands.bodies(self.index).len(), Place::Free);
        self.find_trees(input, scope.trees);
        self.find_islands(input, scope);
        self.joints_of = input.joints.version;
        self.arrange(input);
    }

    /// Packs what is left to sweep when trees and islands that are solved directly are taken out. To be called whenever
    /// those have changed.
    pub fn arrange(&mut self, input: &PlanInput) {
        let PlanInput { islands, joints, graph, .. } = *input;
        let local_of = |body: u32| islands.local_of(body, self.index).map(|local| local as usize);
        for island in &self.islands {
            let place = if island.is_solved { Place::DirectIsland } else { Place::Swept(0) };
            island.members().iter().filter_map(|&body| local_of(body)).for_each(|local| self.place[local] = place);
        }
        self.members.clear();
        self.free.clear();
        for (local, &body) in islands.bodies(self.index).iter().enumerate().filter(|(_, body)| input.moves(**body)) {
            match &mut self.place[local] {
                Place::Free => self.free.push(body),
                Place::Tree | Place::DirectIsland => {}
                Place::Swept(index) => {
                    *index = self.members.len() as u32;
                    self.members.push(body);
                }
            }
        }
        self.own = self.members.len();
        self.guests.clear();
        let other_joints = std::mem::take(&mut self.other_joints);
        self.joints.clear();
        for &global in &other_joints {
            let Joint { a, b, ref definition, .. } = joints.list[global as usize];
            let Some([a, b]) = self.swept_pair(input, [a, b]) else { continue };
            let halves = (0..).zip(definition.halves()).filter(|(_, rows)| *rows > 0);
            if definition.is_ball() {
                self.joints.push(GroupJoint { global, part: JointPart::Point, a, b });
            } else {
                self.joints.extend(halves.map(|(half, _)| GroupJoint { global, part: JointPart::Half(half), a, b }));
            }
        }
        self.other_joints = other_joints;
        self.is_driven = self.joints.iter().any(|joint| joints.list[joint.global as usize].definition.is_driven());
        self.contacts.clear();
        for &slot in islands.manifolds(self.index) {
            let pair = graph.slots[slot as usize].pair;
            if let Some([a, b]) = self.swept_pair(input, [pair.a, pair.b]) {
                self.contacts.push(GroupContact { slot, a, b });
            }
        }
        self.may_bounce = self.contacts.iter().any(|contact| graph.slots[contact.slot as usize].restitution > 0.0);
        self.color(joints, &graph.states);
        self.bodies.resize(self.members.len());
        let Coloring { order, blocks, .. } = &self.joint_colors;
        let is_of_points =
            |&(start, _): &(u32, u32)| self.joints[order[start as usize] as usize].part == JointPart::Point;
        let points = blocks.partition_point(is_of_points);
        self.joint_blocks.resize_with(points, JointBlock::idle);
        self.row_blocks.resize_with(blocks.len() - points, JointBlock::idle);
        self.contact_blocks.resize_with(self.contact_colors.blocks.len(), ContactBlock::idle);
        self.restitutions.clear();
        self.restitutions.resize(self.contact_blocks.len(), None);
    }

    /// The local indices of two bodies, those that do not move here taken in as guests; none if either is in an island
    /// that is solved directly.
    fn swept_pair(&mut self, input: &PlanInput, pair: [u32; 2]) -> Option<[u32; 2]> {
        let places = pair.map(|body| input.local_of(body, self.index).map(|local| self.place[local as usize]));
        if places.contains(&Some(Place::DirectIsland)) {
            return None;
        }
        let local = |(body, place)| match place {
            Some(Place::Swept(index)) => index,
            _ => {
                let members = &mut self.members;
                let guest = self.guests.entry(body).or_insert_with(|| {
                    members.push(body);
                    members.len() as u32 - 1
                });
                READ_ONLY | *guest
            }
        };
        Some([(pair[0], places[0]), (pair[1], places[1])].map(local))
    }

    /// Finds the islands that may be solved directly, those that were there before with all that is known of them.
    fn find_islands(&mut self, input: &PlanInput, scope: DirectScope) {
        let PlanInput { islands, joints, graph, .. } = *input;
        let own = islands.bodies(self.index);
        let mut old = std::mem::take(&mut self.islands).into_iter().peekable();
        let with_joints = scope.trees && !self.other_joints.is_empty();
        let without = scope.rest && own.len() <= DIRECT_BODIES;
        if !with_joints && !without {
            return;
        }
        let of_slot = |slot: u32| {
            let pair = graph.slots[slot as usize].pair;
            [pair.a, pair.b]
        };
        let of_contacts = islands.manifolds(self.index).iter().map(|&slot| (slot, of_slot(slot)));
        let of_joints = self.other_joints.iter().map(|&joint| (joint, &joints.list[joint as usize]));
        let of_joints = of_joints.map(|(index, joint)| (index, [joint.a, joint.b]));
        // The first body of an island stands for it.
        let first = |body: u32| islands.local_of(islands.root_of(body), self.index).map(|local| local as usize);
        let of_pair = |pair: [u32; 2]| pair.into_iter().find(|&body| input.local_of(body, self.index).is_some());
        let Self { numbers, found: [found_members, found_contacts, found_joints], .. } = self;
        numbers.reset(own.len(), Grouped::NONE);
        for (_, pair) in of_contacts.clone().chain(of_joints.clone()) {
            if let Some(first) = of_pair(pair).and_then(first) {
                numbers[first] = 0;
            }
        }
        let mut count = 0;
        for number in numbers.iter_mut().filter(|number| **number != Grouped::NONE) {
            *number = count;
            count += 1;
        }
        let number = |body: Option<u32>| body.and_then(first).map_or(Grouped::NONE, |first| numbers[first]);
        found_members.rebuild(count, own.iter().map(|&body| (body, number(Some(body)))));
        found_contacts.rebuild(count, of_contacts.map(|(slot, pair)| (slot, number(of_pair(pair)))));
        found_joints.rebuild(count, of_joints.map(|(joint, pair)| (joint, number(of_pair(pair)))));
        for island in 0..count as usize {
            let [members, contacts, joints] =
                [&*found_members, found_contacts, found_joints].map(|found| found.of(island));
            if members.len() > DIRECT_BODIES || !(without || with_joints && !joints.is_empty()) {
                continue;
            }
            while old.next_if(|island| island.members()[0] < members[0]).is_some() {}
            let known = old.next_if(|island| island.members() == members && island.joints() == joints);
            // By their indices; what has them may be others.
            let are_same = self.joints_of == input.joints.version;
            self.islands.push(match known {
                Some(mut known) if known.is_of(contacts, of_slot) => {
                    if !are_same {
                        known.renew();
                    }
                    known
                }
                Some(known) if are_same => Box::new(known.with_contacts(contacts)),
                _ => Box::new(DirectIsland::new(members.to_vec(), contacts.to_vec(), joints.to_vec())),
            });
        }
    }

    /// Finds out which bodies need sweeps, which joints make trees that no contact touches, and leaves the other
    /// joints in `other_joints`.
    fn find_trees(&mut self, input: &PlanInput, solves_trees: bool) {
        let PlanInput { islands, bodies, joints, graph } = *input;
        let (index, place) = (self.index, &mut self.place);
        let sweep = |place: &mut Vec<Place>, pair: [u32; 2]| {
            for local in pair.into_iter().filter_map(|body| islands.local_of(body, index)) {
                place[local as usize] = Place::Swept(0);
            }
        };
        for &slot in islands.manifolds(index) {
            let pair = graph.slots[slot as usize].pair;
            sweep(place, [pair.a, pair.b]);
        }
        self.other_joints.clear();
        if islands.joints(index).is_empty() {
            self.trees.clear();
            return;
        }
        let ends = |global: u32| [joints.list[global as usize].a, joints.list[global as usize].b];
        let all = islands.joints(index).iter().copied();
        let is_tree_joint = |global: &u32| {
            let definition = &joints.list[*global as usize].definition;
            definition.is_ball() && !definition.is_soft()
        };
        let (rigid, mut others): (Vec<u32>, Vec<u32>) = all.partition(is_tree_joint);
        others.sort_by_key(|&global| !joints.list[global as usize].definition.is_ball());
        others.iter().for_each(|&global| sweep(place, ends(global)));
        // Bodies of the group by their place in it; any other is one that does not move.
        let own = islands.bodies(index);
        let mut globals = own.to_vec();
        let mut moves: Vec<bool> = own.iter().map(|&body| bodies.list[body as usize].is_dynamic()).collect();
        let mut local = |body: u32| {
            islands.local_of(body, index).unwrap_or_else(|| {
                globals.push(body);
                moves.push(false);
                globals.len() as u32 - 1
            })
        };
        let pairs: Vec<[u32; 2]> = rigid.iter().map(|&global| ends(global).map(&mut local)).collect();
        let Partition { trees, mut left_over } = partition(&pairs, &moves);
        let mut old = std::mem::take(&mut self.trees);
        for tree in trees {
            let moving = &tree.bodies()[..tree.moving()];
            let is_swept = !solves_trees || moving.iter().any(|&body| place[body as usize] != Place::Free);
            let new_place = if is_swept { Place::Swept(0) } else { Place::Tree };
            moving.iter().for_each(|&body| place[body as usize] = new_place);
            if is_swept {
                left_over.extend_from_slice(tree.joints());
            } else {
                let tree = TreeStep::new(tree, &globals, &rigid, &joints.list);
                let known = old.iter().position(|old| old.is_same_as(&tree));
                self.trees.push(known.map_or(tree, |known| old.swap_remove(known)));
            }
        }
        left_over.sort_unstable();
        self.other_joints.extend(left_over.iter().map(|&joint| rigid[joint as usize]));
        self.other_joints.iter().for_each(|&global| sweep(place, ends(global)));
        self.other_joints.extend(others);
    }

    fn color(&mut self, joints: &Joints, states: &[ContactState]) {
        let count = self.members.len();
        let kind = |&GroupJoint { global, part, .. }: &GroupJoint| {
            (part, joints.list[global as usize].definition.is_soft_half(part.half()))
        };
        self.joints.sort_by_key(kind);
        let runs = self.joints.chunk_by(|one, next| kind(one) == kind(next)).map(<[GroupJoint]>::len);
        self.pairs.clear();
        self.pairs.extend(self.joints.iter().map(|joint| (joint.a, joint.b)));
        self.joint_colors.set(count, &self.pairs, runs, L::COUNT);
        // What rests on something that does not move has the last word in a sweep.
        let is_grounded = |contact: &GroupContact| (contact.a | contact.b) & READ_ONLY != 0;
        self.contacts.sort_by_key(is_grounded);
        let free = self.contacts.partition_point(|contact| !is_grounded(contact));
        self.pairs.clear();
        self.pairs.extend(self.contacts.iter().map(|contact| (contact.a, contact.b)));
        self.contact_colors.set(count, &self.pairs, [free, self.pairs.len() - free], L::COUNT);
        // A block takes as many rows as the most of its manifolds have points.
        let Self { contacts, point_counts, .. } = self;
        point_counts.refill(contacts.iter().map(|contact| states[contact.slot as usize].geometry.point_count() as u32));
        self.contact_colors.sort_colors(POINTS as u32 + 1, |contact| self.point_counts[contact as usize]);
    }

    /// How far a body turns at most in a `step`, s, rad; none where no joint is swept.
    pub fn turn(&self, bodies: &[Body], step: f64) -> Option<f64> {
        if self.is_driven {
            // Its rows change with time alone, too.
            return Some(f64::INFINITY);
        }
        let turns = self.members[..self.own].iter().map(|&member| bodies[member as usize].angular.norm() * step);
        (!self.joints.is_empty()).then(|| turns.fold(0.0, f64::max))
    }

    /// Whether anything is left to do when islands that are solved directly are done.
    pub fn has_work(&self) -> bool {
        self.own > 0 || !self.free.is_empty() || !self.trees.is_empty()
    }

    /// Whether it is worth more threads than one.
    pub fn is_large(&self) -> bool {
        self.joint_blocks.len() + self.row_blocks.len() + self.contact_blocks.len() > PARALLEL_BLOCKS
    }
}
