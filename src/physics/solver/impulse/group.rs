//! One group of islands: its bodies and constraints, coloured, and the buffers to solve them, kept
//! from step to step. What is done to it, stage by stage, is in [`super::stage`].

use std::collections::BTreeMap;

use bevy::platform::collections::HashMap;

use super::bodies::GroupBodies;
use super::coloring::Coloring;
use super::contact::{ContactBlock, ContactImpulses};
use super::joint::JointBlock;
use super::method;
use super::tree::TreeStep;
use crate::physics::body::{Bodies, Body};
use crate::physics::collision::{ContactGraph, POINTS};
use crate::physics::disjoint_sets::DisjointSets;
use crate::physics::island::Islands;
use crate::physics::joint::{Joint, Joints};
use crate::physics::lanes::{Lanes, READ_ONLY};
use crate::physics::settings::{Method, SolverSettings};
use crate::physics::solver::direct::DirectIsland;
use crate::physics::solver::joint_tree::{Partition, partition};
use crate::physics::threads::Stages;

/// Blocks from which on a group is worth more threads than one.
const LARGE: usize = 96;

/// Bodies of a group beyond which none of its islands without joints is solved directly, and of an island.
const MOST_DIRECTLY: usize = 512;

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
    /// In an island that is solved directly.
    Directly,
}

/// What needs no sweeps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Exactly {
    /// Trees of joints that nothing touches, and islands with joints in motion.
    pub trees: bool,
    /// Islands at rest.
    pub rest: bool,
}

impl Exactly {
    /// As the settings want it.
    pub fn of(settings: &SolverSettings) -> Self {
        let rest = settings.impulse.fitted_effort && settings.method == Method::SoftStep;
        Self { trees: method::solves_trees(settings.method), rest }
    }
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
    /// Islands with contacts or joints, to be solved directly where they rest or have joints.
    pub(super) islands: Vec<DirectIsland>,
    /// Joints that are not in trees which nothing touches, global indices.
    linked: Vec<u32>,
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
            islands: Vec::new(),
            linked: Vec::new(),
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
    /// islands have changed, or what is solved exactly.
    pub fn plan(
        &mut self,
        group: usize,
        islands: &Islands,
        bodies: &Bodies,
        joints: &Joints,
        graph: &ContactGraph,
        exactly: Exactly,
    ) {
        let world = Outside { group, islands, bodies, joints, graph };
        self.place.clear();
        self.place.resize(islands.bodies(group).len(), Place::Alone);
        self.find_trees(&world, exactly.trees);
        self.find_islands(&world, exactly);
        self.arrange(group, islands, bodies, joints, graph);
    }

    /// Packs what is left to sweep when trees and islands that rest are taken out. To be called whenever those have
    /// changed.
    pub fn arrange(&mut self, group: usize, islands: &Islands, bodies: &Bodies, joints: &Joints, graph: &ContactGraph) {
        let world = Outside { group, islands, bodies, joints, graph };
        let local_of = |body: u32| islands.local_of(body, group).map(|local| local as usize);
        for island in &self.islands {
            let place = if island.is_solved { Place::Directly } else { Place::Swept(0) };
            island.members().iter().filter_map(|&body| local_of(body)).for_each(|local| self.place[local] = place);
        }
        self.members.clear();
        self.flying.clear();
        let dynamic = |body: &u32| bodies.list[*body as usize].is_dynamic();
        for (local, &body) in islands.bodies(group).iter().enumerate().filter(|(_, body)| dynamic(body)) {
            match &mut self.place[local] {
                Place::Alone => self.flying.push(body),
                Place::InTree | Place::Directly => {}
                Place::Swept(index) => {
                    *index = self.members.len() as u32;
                    self.members.push(body);
                }
            }
        }
        self.own = self.members.len();
        self.guests.clear();
        let is_directly = |place: &[Place], pair: [u32; 2]| {
            let moves = pair.into_iter().filter(dynamic);
            moves.filter_map(local_of).any(|local| place[local] == Place::Directly)
        };
        self.joints.clear();
        for &global in &self.linked {
            let Joint { a, b, .. } = joints.list[global as usize];
            if !is_directly(&self.place, [a, b]) {
                let [a, b] = [a, b].map(|body| local(&mut self.members, &mut self.guests, &self.place, &world, body));
                self.joints.push(GroupJoint { global, a, b });
            }
        }
        self.contacts.clear();
        for &slot in islands.manifolds(group) {
            let pair = graph.slots[slot as usize].pair;
            if !is_directly(&self.place, [pair.a, pair.b]) {
                let [a, b] =
                    [pair.a, pair.b].map(|body| local(&mut self.members, &mut self.guests, &self.place, &world, body));
                self.contacts.push(GroupContact { slot, a, b });
            }
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

    /// Finds the islands that may be solved directly, those that were there before with all that is known of them.
    fn find_islands(&mut self, world: &Outside, exactly: Exactly) {
        let Outside { group, islands, bodies, joints, graph } = *world;
        let own = islands.bodies(group);
        let mut old = std::mem::take(&mut self.islands).into_iter().peekable();
        let Exactly { trees, rest } = exactly;
        let (with_joints, without) = (trees && !self.linked.is_empty(), rest && own.len() <= MOST_DIRECTLY);
        if !with_joints && !without {
            return;
        }
        let mut sets = DisjointSets::new(own.len());
        let moving = |body: u32| {
            let local = bodies.list[body as usize].is_dynamic().then(|| islands.local_of(body, group));
            local.flatten()
        };
        let of_contacts = islands.manifolds(group).iter().map(|&slot| graph.slots[slot as usize].pair);
        let of_contacts = of_contacts.map(|pair| [pair.a, pair.b].map(moving));
        let of_joints = self.linked.iter().map(|&joint| &joints.list[joint as usize]);
        let of_joints = of_joints.map(|joint| [joint.a, joint.b].map(moving));
        for pair in of_contacts.clone().chain(of_joints.clone()) {
            if let [Some(a), Some(b)] = pair {
                sets.union(a, b);
            }
        }
        // By the first body of each: its bodies, contacts and joints.
        let mut parts: BTreeMap<u32, [Vec<u32>; 3]> = BTreeMap::new();
        let mut root = |[a, b]: [Option<u32>; 2]| a.or(b).map(|local| sets.root(local));
        for (pair, &slot) in of_contacts.zip(islands.manifolds(group)) {
            if let Some(root) = root(pair) {
                parts.entry(root).or_default()[1].push(slot);
            }
        }
        for (pair, &joint) in of_joints.zip(&self.linked) {
            if let Some(root) = root(pair) {
                parts.entry(root).or_default()[2].push(joint);
            }
        }
        for (local, &body) in own.iter().enumerate() {
            if let Some(part) = parts.get_mut(&sets.root(local as u32)) {
                part[0].push(body);
            }
        }
        let is_wanted = |[members, _, joints]: &[Vec<u32>; 3]| {
            members.len() <= MOST_DIRECTLY && if joints.is_empty() { without } else { with_joints || without }
        };
        for [members, contacts, joints] in parts.into_values().filter(is_wanted) {
            while old.next_if(|island| island.members()[0] < members[0]).is_some() {}
            let known = old.next_if(|island| island.is_of(&members, &contacts, &joints));
            self.islands.push(known.unwrap_or_else(|| DirectIsland::new(members, contacts, joints)));
        }
    }

    /// Finds out which bodies need sweeps, which joints make trees that nothing touches, and leaves the other
    /// joints in `linked`.
    fn find_trees(&mut self, world: &Outside, exact_trees: bool) {
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
        self.linked.clear();
        if islands.joints(group).is_empty() {
            self.trees.clear();
            return;
        }
        let is_spring = |global: &u32| joints.list[*global as usize].softness().is_some();
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
            let is_swept = !exact_trees || moving.iter().any(|&body| place[body as usize] != Place::Alone);
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
        self.linked.extend(left_over.iter().map(|&joint| rigid[joint as usize]).chain(springs));
    }

    fn color(&mut self, joints: &Joints) {
        let count = self.members.len();
        let is_spring = |joint: &GroupJoint| joints.list[joint.global as usize].softness().is_some();
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

    /// How far a body turns at most in a `step`, s, rad; none where no joint is swept.
    pub fn turn(&self, bodies: &[Body], step: f64) -> Option<f64> {
        let turns = self.members[..self.own].iter().map(|&member| bodies[member as usize].angular.norm() * step);
        (!self.joint_blocks.is_empty()).then(|| turns.fold(0.0, f64::max))
    }

    /// Whether any of its contacts may bounce.
    pub fn may_bounce(&self) -> bool {
        self.may_bounce
    }

    /// Whether anything is left to do when islands at rest are done.
    pub fn has_work(&self) -> bool {
        self.own > 0 || !self.flying.is_empty() || !self.trees.is_empty()
    }

    /// Whether it is worth more threads than one.
    pub fn is_large(&self) -> bool {
        self.joint_blocks.len() + self.contact_blocks.len() > LARGE
    }
}
