//! One group of islands: its bodies and constraints, coloured, and the buffers to solve them, kept
//! from step to step. What is done to it, stage by stage, is in [`super::stage`].

use bevy::platform::collections::HashMap;

use super::bodies::GroupBodies;
use super::coloring::Coloring;
use super::contact::{ContactBlock, ContactImpulses};
use super::joint::JointBlock;
use super::tree::TreeStep;
use crate::physics::bodies::{Bodies, Body, Joint, Joints};
use crate::physics::collision::{ContactGraph, POINTS};
use crate::physics::island::Islands;
use crate::physics::lanes::{Lanes, READ_ONLY};
use crate::physics::solver::joint_tree::{Partition, partition};
use crate::physics::threads::Stages;

/// Blocks from which on a group is worth more threads than one.
const LARGE: usize = 96;

/// Turn in a step beyond which rows of joints that stay as they were are wrong by a tenth of a limb, rad.
const FAR: f64 = 0.1;

/// A joint as a group sees it.
#[derive(Clone, Copy, Debug)]
pub(super) struct GroupJoint {
    pub global: u32,
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

/// What a block of contacts of which some bounce remembers of the step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounce<L> {
    /// Speed at which each point is to part, m/s; 0 for those that come slowly.
    pub parting: [L; POINTS],
    /// The most each has pushed in a substep, N·s.
    pub peak: [L; POINTS],
}

/// How a body of the group is moved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Place {
    /// Nothing holds or touches it.
    Alone,
    /// In a tree of joints that nothing touches.
    InTree,
    /// By sweeps, as the member of that index.
    Swept(u32),
}

/// What a group is planned from.
#[derive(Clone, Copy)]
struct Outside<'a> {
    group: usize,
    islands: &'a Islands,
    bodies: &'a Bodies,
    joints: &'a Joints,
    graph: &'a ContactGraph,
}

/// The local index of a body; one that does not move here is taken in as a guest.
fn local(members: &mut Vec<u32>, guests: &mut HashMap<u32, u32>, place: &[Place], world: &Outside, body: u32) -> u32 {
    if world.bodies.list[body as usize].is_dynamic()
        && let Some(local) = world.islands.local_of(body, world.group)
        && let Place::Swept(index) = place[local as usize]
    {
        return index;
    }
    READ_ONLY
        | *guests.entry(body).or_insert_with(|| {
            members.push(body);
            members.len() as u32 - 1
        })
}

/// A group of islands.
pub(crate) struct Group<L: Lanes> {
    /// Indices of its bodies: the first `own` move here, the others are guests.
    pub(super) members: Vec<u32>,
    pub(super) own: usize,
    guests: HashMap<u32, u32>,
    place: Vec<Place>,
    may_bounce: bool,
    pub(super) flying: Vec<u32>,
    pub(super) trees: Vec<TreeStep>,
    pub(super) joints: Vec<GroupJoint>,
    pub(super) contacts: Vec<GroupContact>,
    pub(super) joint_colors: Coloring,
    pub(super) contact_colors: Coloring,
    pairs: Vec<(u32, u32)>,
    pub(super) bodies: GroupBodies<L::Scalar>,
    pub(super) joint_blocks: Vec<JointBlock<L>>,
    pub(super) contact_blocks: Vec<ContactBlock<L>>,
    /// One for each block of contacts.
    pub(super) bounces: Vec<Option<Bounce<L>>>,
    /// While somebody reads contact forces: what each contact pushed over the substeps, N·s.
    pub(super) totals: Vec<ContactImpulses>,
    pub(super) progress: Stages,
}

impl<L: Lanes> Default for Group<L> {
    fn default() -> Self {
        Self {
            members: Vec::new(),
            own: 0,
            guests: HashMap::default(),
            place: Vec::new(),
            may_bounce: false,
            flying: Vec::new(),
            trees: Vec::new(),
            joints: Vec::new(),
            contacts: Vec::new(),
            joint_colors: Coloring::default(),
            contact_colors: Coloring::default(),
            pairs: Vec::new(),
            bodies: GroupBodies::default(),
            joint_blocks: Vec::new(),
            contact_blocks: Vec::new(),
            bounces: Vec::new(),
            totals: Vec::new(),
            progress: Stages::default(),
        }
    }
}

impl<L: Lanes> Group<L> {
    /// Takes in which bodies and constraints it has, and colours them. To be called whenever the
    /// islands have changed.
    pub fn plan(&mut self, group: usize, islands: &Islands, bodies: &Bodies, joints: &Joints, graph: &ContactGraph) {
        let own = islands.bodies(group);
        let world = Outside { group, islands, bodies, joints, graph };
        self.place.clear();
        self.place.resize(own.len(), Place::Alone);
        self.find_trees(&world);
        self.members.clear();
        self.flying.clear();
        let dynamic = |body: &u32| bodies.list[*body as usize].is_dynamic();
        for (local, &body) in own.iter().enumerate().filter(|(_, body)| dynamic(body)) {
            match &mut self.place[local] {
                Place::Alone => self.flying.push(body),
                Place::InTree => {}
                Place::Swept(index) => {
                    *index = self.members.len() as u32;
                    self.members.push(body);
                }
            }
        }
        self.own = self.members.len();
        self.guests.clear();
        for joint in &mut self.joints {
            let Joint { a, b, .. } = joints.list[joint.global as usize];
            (joint.a, joint.b) = (
                local(&mut self.members, &mut self.guests, &self.place, &world, a),
                local(&mut self.members, &mut self.guests, &self.place, &world, b),
            );
        }
        self.contacts.clear();
        for &slot in islands.manifolds(group) {
            let pair = graph.slots[slot as usize].pair;
            let [a, b] =
                [pair.a, pair.b].map(|body| local(&mut self.members, &mut self.guests, &self.place, &world, body));
            self.contacts.push(GroupContact { slot, a, b });
        }
        self.may_bounce = self.contacts.iter().any(|contact| graph.slots[contact.slot as usize].restitution > 0.0);
        self.color(joints);
        let count = self.members.len();
        self.bodies.resize(count);
        self.joint_blocks.resize_with(self.joint_colors.blocks.len(), JointBlock::idle);
        self.contact_blocks.resize_with(self.contact_colors.blocks.len(), ContactBlock::idle);
        self.bounces.clear();
        self.bounces.resize(self.contact_blocks.len(), None);
    }

    /// Finds out which bodies need sweeps, which joints make trees that nothing touches, and leaves the other
    /// joints in `joints`.
    fn find_trees(&mut self, world: &Outside) {
        let Outside { group, islands, bodies, joints, graph } = *world;
        let place = &mut self.place;
        let swept = |place: &mut Vec<Place>, body: u32| {
            if let Some(local) = islands.local_of(body, group) {
                place[local as usize] = Place::Swept(0);
            }
        };
        for &slot in islands.manifolds(group) {
            let pair = graph.slots[slot as usize].pair;
            [pair.a, pair.b].into_iter().for_each(|body| swept(place, body));
        }
        self.joints.clear();
        if islands.joints(group).is_empty() {
            self.trees.clear();
            return;
        }
        let is_spring = |global: &u32| joints.list[*global as usize].softness.is_some();
        for &global in islands.joints(group).iter().filter(|global| is_spring(global)) {
            let Joint { a, b, .. } = joints.list[global as usize];
            [a, b].into_iter().for_each(|body| swept(place, body));
        }
        // Bodies of the group by their place in it; any other is one that does not move.
        let own = islands.bodies(group);
        let mut globals = own.to_vec();
        let mut moves: Vec<bool> = own.iter().map(|&body| bodies.list[body as usize].is_dynamic()).collect();
        let rigid: Vec<u32> = islands.joints(group).iter().copied().filter(|global| !is_spring(global)).collect();
        let pairs: Vec<[u32; 2]> = rigid
            .iter()
            .map(|&global| {
                let Joint { a, b, .. } = joints.list[global as usize];
                [a, b].map(|body| {
                    islands.local_of(body, group).unwrap_or_else(|| {
                        globals.push(body);
                        moves.push(false);
                        globals.len() as u32 - 1
                    })
                })
            })
            .collect();
        let Partition { trees, mut left_over } = partition(&pairs, &moves);
        let mut old = std::mem::take(&mut self.trees);
        for tree in trees {
            let moving = &tree.bodies()[..tree.moving()];
            let is_swept = moving.iter().any(|&body| place[body as usize] != Place::Alone);
            let new_place = if is_swept { Place::Swept(0) } else { Place::InTree };
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
        for &joint in &left_over {
            let Joint { a, b, .. } = joints.list[rigid[joint as usize] as usize];
            [a, b].into_iter().for_each(|body| swept(place, body));
        }
        let springs = islands.joints(group).iter().copied().filter(is_spring);
        let global = left_over.iter().map(|&joint| rigid[joint as usize]).chain(springs);
        self.joints.extend(global.map(|global| GroupJoint { global, a: 0, b: 0 }));
    }

    fn color(&mut self, joints: &Joints) {
        let count = self.members.len();
        let is_spring = |joint: &GroupJoint| joints.list[joint.global as usize].softness.is_some();
        self.joints.sort_by_key(is_spring);
        let springs = self.joints.partition_point(|joint| !is_spring(joint));
        self.joint_colors.clear();
        self.pairs.clear();
        self.pairs.extend(self.joints.iter().map(|joint| (joint.a, joint.b)));
        self.joint_colors.add(count, 0, &self.pairs[..springs], L::COUNT);
        self.joint_colors.add(count, springs as u32, &self.pairs[springs..], L::COUNT);
        // What rests on something that does not move has the last word in a sweep.
        let is_grounded = |contact: &GroupContact| (contact.a | contact.b) & READ_ONLY != 0;
        self.contacts.sort_by_key(is_grounded);
        let grounded = self.contacts.partition_point(|contact| !is_grounded(contact));
        self.contact_colors.clear();
        self.pairs.clear();
        self.pairs.extend(self.contacts.iter().map(|contact| (contact.a, contact.b)));
        self.contact_colors.add(count, 0, &self.pairs[..grounded], L::COUNT);
        self.contact_colors.add(count, grounded as u32, &self.pairs[grounded..], L::COUNT);
    }

    /// Whether bodies on swept joints turn so far in a `step`, s, that its rows should turn with them.
    pub fn turns_far(&self, bodies: &[Body], step: f64) -> bool {
        let turns = |&member: &u32| bodies[member as usize].angular.norm() * step > FAR;
        !self.joint_blocks.is_empty() && self.members[..self.own].iter().any(turns)
    }

    /// Whether any of its contacts may bounce.
    pub fn may_bounce(&self) -> bool {
        self.may_bounce
    }

    /// Whether it is worth more threads than one.
    pub fn is_large(&self) -> bool {
        self.joint_blocks.len() + self.contact_blocks.len() > LARGE
    }
}
