//! A group of islands as the exact method takes it: mechanisms, free bodies, and bodies in reach of each other.

use super::bodies::{links_of, member, place_in, put, state_of};
use super::contact::{ContactGroup, ContactTerms};
use super::event_stepper::{EventStepper, EventTerms};
use super::free;
use super::mechanism::{Mechanism, MemberState};
use super::stepper::StepEffort;
use crate::physics::body::{Bodies, Body};
use crate::physics::collision::{ContactGraph, Contacts, Manifold, Pair, PairKey, PartPair};
use crate::physics::disjoint_sets::DisjointSets;
use crate::physics::grouped::Grouped;
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

impl GroupContents {
    fn sort_pairs(&mut self) {
        self.pairs.sort_unstable_by_key(|key| (key.pair, key.parts));
    }
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
    /// Whether `next` is still to be planned.
    is_stale: bool,
}

/// The parts of groups whose contents have changed: what did not change itself goes on as if nothing had.
#[derive(Default)]
pub(super) struct LeftParts {
    contact_groups: Vec<LeftPart<ContactGroup>>,
    pieces: Vec<LeftPart<JointedPiece>>,
    /// The bodies of contact groups whose solves lately could not get below some residual, each with the group.
    stalled: Vec<(u32, StalledGroup)>,
}

/// A part until somebody takes it.
struct LeftPart<T> {
    /// The first of its bodies.
    first: u32,
    /// Whether it may be taken up as it is.
    is_current: bool,
    part: Option<T>,
}

impl<T> LeftPart<T> {
    fn new(first: u32, is_current: bool, part: T) -> Self {
        Self { first, is_current, part: Some(part) }
    }

    /// Takes the one with that first body from those in order, and whether it may be taken up as it is.
    fn take(list: &mut [Self], first: u32) -> Option<(bool, T)> {
        let known = list.binary_search_by_key(&first, |left| left.first).ok()?;
        Some((list[known].is_current, list[known].part.take()?))
    }
}

/// A group whose solves could not get below `residual`, m/s, and how many of its bodies moved.
#[derive(Clone, Copy)]
struct StalledGroup {
    /// The first of them.
    first: u32,
    size: usize,
    residual: f64,
}

impl LeftParts {
    /// Orders what was handed over.
    pub fn sort(&mut self) {
        let Self { contact_groups, pieces, stalled } = self;
        contact_groups.sort_unstable_by_key(|left| left.first);
        pieces.sort_unstable_by_key(|left| left.first);
        let groups = contact_groups.iter().filter_map(|left| left.part.as_ref());
        for group in groups.filter(|group| group.stalled() > 0.0) {
            let bodies = group.moving();
            let told = StalledGroup { first: bodies[0], size: bodies.len(), residual: group.stalled() };
            stalled.extend(bodies.iter().map(|&body| (body, told)));
        }
        stalled.sort_unstable_by_key(|(body, _)| *body);
    }

    /// The group of those bodies that move, joints and pairs: as it was, if it was; else planned, with the buffers of the one
    /// with the same first body.
    fn contact_group(
        &mut self,
        moving: &[u32],
        links: &[u32],
        pairs: &[PairKey],
        bodies: &Bodies,
        joints: &Joints,
        time: f64,
    ) -> ContactGroup {
        let buffers = match LeftPart::take(&mut self.contact_groups, moving[0]) {
            Some((true, group)) if group.is_of(moving, links, pairs) => return group,
            known => known.map(|(_, group)| group).unwrap_or_default(),
        };
        buffers.plan(moving.to_vec(), links, pairs, bodies, joints, time).after_stalled(self.stalled_of(moving))
    }

    /// The residual, m/s, that solves lately could not get below for a group of which these bodies are half at least: what is
    /// hard in it is hard still.
    fn stalled_of(&self, moving: &[u32]) -> f64 {
        let find = |body: &u32| self.stalled.binary_search_by_key(body, |(body, _)| *body).ok();
        let mut found: Vec<_> = moving.iter().filter_map(find).map(|at| self.stalled[at].1).collect();
        found.sort_unstable_by_key(|group| group.first);
        let shared = found.chunk_by(|one, other| one.first == other.first);
        shared.filter(|shared| 2 * shared.len() >= shared[0].size).map(|shared| shared[0].residual).fold(0.0, f64::max)
    }

    /// The mechanism of those bodies and joints, likewise.
    fn piece(&mut self, moving: &[u32], links: &[u32], bodies: &Bodies, joints: &Joints, time: f64) -> JointedPiece {
        let locked = moving.iter().any(|&body| is_locked(&bodies.list[body as usize]));
        let buffers = match LeftPart::take(&mut self.pieces, moving[0]) {
            Some((true, piece)) if piece.is_of(moving, links, locked) => return piece,
            known => known.map(|(_, piece)| piece).unwrap_or_default(),
        };
        buffers.plan(moving.to_vec(), links, locked, bodies, joints, time)
    }
}

impl ExactGroup {
    pub fn begin(&mut self, group: usize) {
        self.group = group;
    }

    /// Takes in what is in the group. Where that has changed, it is to be planned anew, and hands over its parts.
    pub fn take_stock(
        &mut self,
        islands: &Islands,
        bodies: &Bodies,
        joints: &Joints,
        contacts: &Contacts,
        left: &mut LeftParts,
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
        next.sort_pairs();
        next.versions = (bodies.version, joints.version);
        next.locked = next.bodies.iter().any(|&body| is_locked(&bodies.list[body as usize]));
        self.is_stale = self.next != self.plan;
        if self.is_stale {
            self.hand_over(left, self.next.versions);
        }
    }

    /// Hands over its parts; those that were planned for these versions of bodies and joints may be taken up as they are.
    pub fn hand_over(&mut self, left: &mut LeftParts, versions: (u64, u64)) {
        let is_current = self.plan.versions == versions;
        let groups = self.contact_groups.drain(..);
        left.contact_groups.extend(groups.map(|group| LeftPart::new(group.moving()[0], is_current, group)));
        let pieces = self.pieces.drain(..);
        left.pieces.extend(pieces.map(|piece| LeftPart::new(piece.bodies[0], is_current, piece)));
        self.plan = GroupContents::default();
    }

    /// Takes another group up into this one, with what that other is to have; both are to be planned anew.
    pub fn take_up(&mut self, other: &mut Self, left: &mut LeftParts) {
        let versions = self.next.versions;
        [&mut *self, &mut *other].into_iter().for_each(|group| group.hand_over(left, versions));
        let taken = std::mem::replace(&mut other.next, GroupContents { versions, ..GroupContents::default() });
        self.next.bodies.extend(taken.bodies);
        self.next.bodies.sort_unstable();
        self.next.joints.extend(taken.joints);
        self.next.joints.sort_unstable();
        self.next.pairs.extend(taken.pairs);
        self.next.locked |= taken.locked;
        (self.is_stale, other.is_stale) = (true, true);
    }

    /// Takes up pairs of its bodies, and is to be planned anew.
    pub fn take_up_pairs(&mut self, pairs: &[PairKey], left: &mut LeftParts) {
        self.hand_over(left, self.next.versions);
        self.next.pairs.extend_from_slice(pairs);
        self.next.sort_pairs();
        self.is_stale = true;
    }

    /// Whether it is to be planned anew.
    pub fn is_stale(&self) -> bool {
        self.is_stale
    }

    /// Whether some body is in it.
    pub fn has_body(&self, body: u32) -> bool {
        self.next.bodies.binary_search(&body).is_ok()
    }

    /// Whether those parts of two bodies are looked at in it.
    pub fn has_pair(&self, pair: Pair, parts: PartPair) -> bool {
        self.next.pairs.binary_search_by_key(&(pair, parts), |key| (key.pair, key.parts)).is_ok()
    }

    /// Where the bodies that move end.
    pub fn ends(&self) -> impl Iterator<Item = (u32, &MemberState)> + Clone {
        let of_pieces = self.pieces.iter().flat_map(JointedPiece::ends);
        let free = self.free.iter().map(|(body, state)| (*body, state));
        of_pieces.chain(free).chain(self.contact_groups.iter().flat_map(ContactGroup::ends))
    }

    /// Plans the group if that is to be done, with what others have handed over.
    pub fn plan(&mut self, left: &mut LeftParts, bodies: &Bodies, joints: &Joints, time: f64) {
        if std::mem::take(&mut self.is_stale) {
            self.plan.clone_from(&self.next);
            self.replan(left, bodies, joints, time);
        }
    }

    /// Takes in the state.
    pub fn gather(&mut self, bodies: &Bodies, joints: &Joints, friction: FrictionModel) {
        for piece in &mut self.pieces {
            piece.gather(bodies, joints);
        }
        for group in &mut self.contact_groups {
            group.gather(bodies, joints, friction);
        }
    }

    fn replan(&mut self, left: &mut LeftParts, bodies: &Bodies, joints: &Joints, time: f64) {
        let GroupContents { bodies: own, joints: links, pairs, .. } = &self.plan;
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
        let root_of =
            |places: [Option<usize>; 2]| places.into_iter().flatten().next().map_or(Grouped::NONE, |at| roots[at]);
        let [mut members, mut own_links, mut own_pairs] = [(); 3].map(|()| Grouped::default());
        let count = own.len() as u32;
        members.rebuild(count, own.iter().zip(&roots).map(|(&body, &root)| (body, root)));
        own_links.rebuild(count, links.iter().map(|&joint| (joint, root_of(ends(joint)))));
        let root_of_pair = |key: &PairKey| root_of([key.pair.a, key.pair.b].map(place));
        own_pairs.rebuild(count, (0..).zip(pairs).map(|(index, key)| (index, root_of_pair(key))));
        self.free.clear();
        for root in (0..own.len()).filter(|&root| roots[root] as usize == root) {
            let (members, links) = (members.of(root), own_links.of(root));
            if !own_pairs.of(root).is_empty() {
                let pairs: Vec<_> = own_pairs.of(root).iter().map(|&pair| pairs[pair as usize]).collect();
                self.contact_groups.push(left.contact_group(members, links, &pairs, bodies, joints, time));
                continue;
            }
            let body = &bodies.list[own[root] as usize];
            if !jointed[root] && (!body.is_dynamic() || free::is_closed(&member(body))) {
                self.free.push((own[root], state_of(body)));
                continue;
            }
            self.pieces.push(left.piece(members, links, bodies, joints, time));
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
    /// Whether it was planned for those bodies that move and those joints, ascending.
    fn is_of(&self, moving: &[u32], links: &[u32], locked: bool) -> bool {
        let Mechanism { moving: count, locked: was_locked, .. } = self.mechanism;
        let mut joints = self.joints.clone();
        joints.sort_unstable();
        self.bodies[..count] == *moving && joints == links && was_locked == locked
    }

    /// Where the bodies that move are at the end of the step.
    fn ends(&self) -> impl Iterator<Item = (u32, &MemberState)> + Clone {
        self.bodies.iter().copied().zip(&self.mechanism.states).take(self.mechanism.moving)
    }

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

#[cfg(test)]
mod tests {
    use super::*;

    /// Of ten bodies, 0 to 5 were in a group that stalled.
    #[test]
    fn a_group_stalls_where_half_of_one_that_stalled_is_in_it() {
        let told = StalledGroup { first: 0, size: 6, residual: 1e-6 };
        let left = LeftParts { stalled: (0..6).map(|body| (body, told)).collect(), ..LeftParts::default() };
        for (moving, residual) in
            [(vec![0, 1], 0.0), (vec![3, 4, 5], 1e-6), (vec![1, 3, 5, 8, 9], 1e-6), (vec![7], 0.0)]
        {
            assert_eq!(left.stalled_of(&moving), residual, "{moving:?}");
        }
    }
}
