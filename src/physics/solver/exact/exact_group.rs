//! A group of islands as the exact method takes it: mechanisms, free bodies, and bodies in reach of each other.

use super::bodies::{links_of, member, place_in, put, state_of};
use super::contact::{ContactGroup, ContactTerms};
use super::event_stepper::{EventStepper, EventTerms};
use super::free;
use super::mechanism::{Mechanism, MemberState};
use super::stepper::StepEffort;
use crate::physics::body::{Bodies, Body};
use crate::physics::collision::{ContactGraph, Contacts, Manifold, PairKey};
use crate::physics::disjoint_sets::DisjointSets;
use crate::physics::island::Islands;
use crate::physics::joint::{Joint, Joints};
use crate::physics::settings::{ExactIntegrator, FrictionModel};

/// A mechanism with the bodies and joints that it is made of.
#[derive(Clone, Default)]
struct JointedPiece {
    /// The body of each member.
    bodies: Vec<u32>,
    /// The joint of each link.
    joints: Vec<u32>,
    mechanism: Mechanism,
    stepper: EventStepper,
    effort: StepEffort,
}

/// The contents of a group, which its plan depends on.
#[derive(Clone, Debug, Default, PartialEq)]
struct GroupContents {
    bodies: Vec<u32>,
    joints: Vec<u32>,
    /// Bodies in reach of each other, with their slots.
    pairs: Vec<PairKey>,
    versions: (u64, u64),
    /// Whether axes of some body are locked.
    locked: bool,
}

/// One group, with what is kept from step to step while its contents stay the same.
#[derive(Clone, Default)]
pub(crate) struct ExactGroup {
    group: usize,
    plan: GroupContents,
    next: GroupContents,
    pieces: Vec<JointedPiece>,
    /// Free bodies with a motion in closed form.
    free: Vec<(u32, MemberState)>,
    contact_groups: Vec<ContactGroup>,
}

impl ExactGroup {
    pub fn begin(&mut self, group: usize) {
        self.group = group;
    }

    /// Takes in the state, and plans the group where its contents have changed.
    pub fn gather(
        &mut self,
        islands: &Islands,
        bodies: &Bodies,
        joints: &Joints,
        contacts: &Contacts,
        friction: FrictionModel,
        time: f64,
    ) {
        let next = &mut self.next;
        next.bodies.clear();
        next.bodies.extend_from_slice(islands.bodies(self.group));
        next.joints.clear();
        next.joints.extend_from_slice(islands.joints(self.group));
        next.pairs.clear();
        let found = islands.manifolds(self.group).iter().map(|&found| &contacts.manifolds[found as usize]);
        next.pairs.extend(found.map(Manifold::key));
        // They were found along x: columns on each other come in an order that rounding changes.
        next.pairs.sort_unstable_by_key(|key| (key.pair.a, key.pair.b, key.parts));
        next.versions = (bodies.version, joints.version);
        next.locked = next.bodies.iter().any(|&body| is_locked(&bodies.list[body as usize]));
        if self.next != self.plan {
            self.plan.clone_from(&self.next);
            self.replan(bodies, joints, time);
        }
        for piece in &mut self.pieces {
            piece.gather(bodies, joints);
        }
        for group in &mut self.contact_groups {
            group.gather(bodies, joints, friction);
        }
    }

    fn replan(&mut self, bodies: &Bodies, joints: &Joints, time: f64) {
        let GroupContents { bodies: own, joints: links, pairs, locked, .. } = &self.plan;
        let place = |body: u32| own.binary_search(&body).ok().filter(|_| bodies.list[body as usize].is_dynamic());
        let mut sets = DisjointSets::new(own.len());
        let mut jointed = vec![false; own.len()];
        let ends = |joint: u32| [joints.list[joint as usize].a, joints.list[joint as usize].b].map(place);
        for &joint in links {
            if let [Some(a), Some(b)] = ends(joint) {
                sets.union(a as u32, b as u32);
            }
            ends(joint).into_iter().flatten().for_each(|body| jointed[body] = true);
        }
        for PairKey { pair, .. } in pairs {
            if let [Some(a), Some(b)] = [pair.a, pair.b].map(place) {
                sets.union(a as u32, b as u32);
            }
        }
        let roots: Vec<u32> = (0..own.len() as u32).map(|body| sets.root(body)).collect();
        let root_of = |bodies: [u32; 2]| bodies.into_iter().find_map(place).map(|body| roots[body]);
        let mut left_alone = vec![true; own.len()];
        for root in pairs.iter().filter_map(|PairKey { pair, .. }| root_of([pair.a, pair.b])) {
            left_alone[root as usize] = false;
        }
        let members_of = |root: usize| -> Vec<u32> {
            (root..own.len()).filter(|&body| roots[body] as usize == root).map(|body| own[body]).collect()
        };
        let stalled = self.contact_groups.iter().map(ContactGroup::stalled).fold(0.0, f64::max);
        // By the first of their bodies, ascending.
        let mut kept: Vec<_> = self.contact_groups.drain(..).map(|group| (group.moving()[0], Some(group))).collect();
        for root in (0..own.len()).filter(|&root| roots[root] as usize == root && !left_alone[root]) {
            let is_own = |bodies: [u32; 2]| root_of(bodies) == Some(root as u32);
            let of_joint = |joint: &&u32| is_own([joints.list[**joint as usize].a, joints.list[**joint as usize].b]);
            let links = links.iter().filter(of_joint).copied().collect();
            let pairs: Vec<_> = pairs.iter().filter(|PairKey { pair, .. }| is_own([pair.a, pair.b])).copied().collect();
            let group = kept.binary_search_by_key(&own[root], |(first, _)| *first).ok();
            let group = group.and_then(|place| kept[place].1.take()).unwrap_or_default();
            let group = group.plan(members_of(root), links, &pairs, bodies, joints, time);
            self.contact_groups.push(group.after_stalled(stalled));
        }
        self.free.clear();
        let mut kept = std::mem::take(&mut self.pieces).into_iter();
        for root in (0..own.len()).filter(|&root| roots[root] as usize == root && left_alone[root]) {
            let body = &bodies.list[own[root] as usize];
            if !jointed[root] && (!body.is_dynamic() || free::is_closed(&member(body))) {
                self.free.push((own[root], state_of(body)));
                continue;
            }
            let members = members_of(root);
            let is_here = |joint: &u32| ends(*joint).into_iter().flatten().any(|body| roots[body] as usize == root);
            let links = if jointed[root] { links.iter().copied().filter(is_here).collect() } else { Vec::new() };
            let piece = kept.next().unwrap_or_default();
            self.pieces.push(piece.plan(members, &links, *locked, bodies, joints, time));
        }
    }

    /// Takes all through the step. `graph` has the contact forces of the step before.
    pub fn step(&mut self, bodies: &Bodies, integrator: ExactIntegrator, terms: &ContactTerms, graph: &ContactGraph) {
        let ContactTerms { time, h, parts, restitution_speed, reads_loads, .. } = *terms;
        for group in &mut self.contact_groups {
            group.step(terms, graph);
        }
        for (index, state) in &mut self.free {
            let body = &bodies.list[*index as usize];
            *state = state_of(body);
            if body.is_dynamic() {
                free::advance(&member(body), state, h * f64::from(parts));
            } else {
                state.drift(h * f64::from(parts));
            }
        }
        for piece in &mut self.pieces {
            let terms = EventTerms { integrator, time, h, substeps: parts, restitution_speed, reads_loads };
            piece.effort = piece.stepper.advance(&mut piece.mechanism, &terms);
        }
    }

    /// Writes bodies and joint forces back.
    pub fn scatter(&self, bodies: &mut [Body], joints: &mut [Joint]) {
        for (index, state) in &self.free {
            put(state, &mut bodies[*index as usize]);
        }
        for piece in &self.pieces {
            let mechanism = &piece.mechanism;
            for (index, state) in piece.bodies.iter().zip(&mechanism.states).take(mechanism.moving) {
                put(state, &mut bodies[*index as usize]);
            }
            for (&joint, (mean, at_end)) in piece.joints.iter().zip(piece.stepper.loads()) {
                let joint = &mut joints[joint as usize];
                joint.set_load(mean, [0.0; 6]);
                joint.load_at_end = at_end;
                // Another method is not to start from it.
                joint.is_doubtful = piece.effort.unsettled > 0;
            }
        }
        for group in &self.contact_groups {
            group.scatter(bodies, joints);
        }
    }

    /// Bodies in reach of each other.
    pub fn contact_groups(&self) -> &[ContactGroup] {
        &self.contact_groups
    }

    /// Rows of each part, and the work it took to solve them.
    pub fn efforts(&self) -> impl Iterator<Item = (u32, StepEffort)> + '_ {
        let pieces = self.pieces.iter().map(|piece| (piece.mechanism.rows() as u32, piece.effort));
        pieces.chain(self.contact_groups.iter().map(|group| (group.rows(), group.effort)))
    }

    /// Bodies that move, with how often their rows were solved.
    pub fn solves(&self) -> impl Iterator<Item = (u32, u32)> + '_ {
        let of_piece = |piece: &JointedPiece| (piece.mechanism.moving, piece.effort.solves);
        let pieces = self.pieces.iter().map(move |piece| (&piece.bodies[..], of_piece(piece)));
        let groups = self.contact_groups.iter().map(|group| (group.moving(), group.effort.solves));
        let pieces = pieces.map(|(bodies, (moving, solves))| (&bodies[..moving], solves));
        pieces.chain(groups).flat_map(|(bodies, solves)| bodies.iter().map(move |body| (*body, solves)))
    }

    /// All that the next step depends on beside bodies and joints.
    pub fn memory(&self) -> impl Iterator<Item = f64> + '_ {
        let of_pieces = self.pieces.iter().flat_map(|piece| piece.stepper.memory());
        of_pieces.chain(self.contact_groups.iter().map(ContactGroup::stayed))
    }
}

impl JointedPiece {
    /// A mechanism of those bodies that move and those joints, with the buffers of another.
    fn plan(
        mut self,
        members: Vec<u32>,
        joints: &[u32],
        locked: bool,
        bodies: &Bodies,
        all_joints: &Joints,
        time: f64,
    ) -> Self {
        let moving = members.len();
        self.bodies = members;
        let (joints, links) =
            links_of(joints, all_joints, bodies, time, |body| place_in(&mut self.bodies, moving, body));
        let (order, mechanism) = Mechanism::plan(moving, locked, &links);
        self.joints = order.iter().map(|&link| joints[link as usize]).collect();
        self.mechanism = mechanism;
        self.stepper.forget();
        self
    }

    fn gather(&mut self, bodies: &Bodies, joints: &Joints) {
        let Mechanism { members, states, moving, .. } = &mut self.mechanism;
        let known = members.len() == self.bodies.len();
        members.clear();
        members.extend(self.bodies.iter().map(|&body| member(&bodies.list[body as usize])));
        if !known {
            states.clear();
            states.resize(self.bodies.len(), MemberState::REST);
        }
        let mut moved = !known;
        for (index, (old, &body)) in states.iter_mut().zip(&self.bodies).enumerate() {
            let now = state_of(&bodies.list[body as usize]);
            moved |= index < *moving && now != *old;
            *old = now;
        }
        self.mechanism.renew(self.joints.iter().map(|&joint| &joints.list[joint as usize].definition));
        if moved {
            self.stepper.forget();
        }
    }
}

fn is_locked(body: &Body) -> bool {
    body.is_dynamic() && (body.inverse_mass.min() == 0.0 || body.rotation_freedom.min() == 0.0)
}
