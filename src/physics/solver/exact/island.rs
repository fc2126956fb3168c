//! A group of islands as the exact method takes it: pieces that joints hold together, bodies by themselves, and what
//! is in reach of something.

use nalgebra::Vector3;

use super::contact::{ContactTerms, Touching};
use super::free;
use super::mechanism::{Link, Mechanism, Member, Motion, Spring};
use super::stepper::{Effort, Stepper};
use crate::physics::body::{Bodies, Body};
use crate::physics::collision::{Contacts, Pair};
use crate::physics::contact::ContactCache;
use crate::physics::disjoint_sets::DisjointSets;
use crate::physics::island::Islands;
use crate::physics::joint::Softness;
use crate::physics::joint::{Joint, Joints};
use crate::physics::settings::{ExactIntegrator, FrictionModel};

/// A mechanism and the bodies and joints that it stands for.
#[derive(Default)]
struct Piece {
    /// Of each member.
    bodies: Vec<u32>,
    /// Of each link.
    joints: Vec<u32>,
    mechanism: Mechanism,
    stepper: Stepper,
    effort: Effort,
}

/// What a group was planned for.
#[derive(Clone, Debug, Default, PartialEq)]
struct Plan {
    bodies: Vec<u32>,
    joints: Vec<u32>,
    /// Bodies in reach of each other.
    pairs: Vec<Pair>,
    versions: (u64, u64),
    /// Whether axes of some body are locked.
    locked: bool,
}

/// One group, with all that is kept from step to step while it stays the same.
#[derive(Default)]
pub(crate) struct ExactGroup {
    group: usize,
    plan: Plan,
    next: Plan,
    pieces: Vec<Piece>,
    /// Bodies by themselves: where they go is known in closed form.
    free: Vec<(u32, Motion)>,
    touching: Vec<Touching>,
}

impl ExactGroup {
    pub fn begin(&mut self, group: usize) {
        self.group = group;
    }

    /// Takes the group's state in; plans it anew if it is another one.
    pub fn gather(
        &mut self,
        islands: &Islands,
        bodies: &Bodies,
        joints: &Joints,
        contacts: &Contacts,
        friction: FrictionModel,
    ) {
        let next = &mut self.next;
        next.bodies.clear();
        next.bodies.extend_from_slice(islands.bodies(self.group));
        next.joints.clear();
        next.joints.extend_from_slice(islands.joints(self.group));
        next.pairs.clear();
        next.pairs.extend(islands.manifolds(self.group).iter().map(|&found| contacts.manifolds[found as usize].pair));
        next.versions = (bodies.version, joints.version);
        next.locked = next.bodies.iter().any(|&body| is_locked(&bodies.list[body as usize]));
        if self.next != self.plan {
            self.plan.clone_from(&self.next);
            self.replan(bodies, joints);
        }
        for piece in &mut self.pieces {
            piece.gather(bodies, joints);
        }
        for touching in &mut self.touching {
            touching.gather(bodies, joints, friction);
        }
    }

    fn replan(&mut self, bodies: &Bodies, joints: &Joints) {
        let Plan { bodies: own, joints: links, pairs, locked, .. } = &self.plan;
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
        for pair in pairs {
            if let [Some(a), Some(b)] = [pair.a, pair.b].map(place) {
                sets.union(a as u32, b as u32);
            }
        }
        let roots: Vec<u32> = (0..own.len() as u32).map(|body| sets.root(body)).collect();
        let root_of = |bodies: [u32; 2]| bodies.into_iter().find_map(place).map(|body| roots[body]);
        let mut left_alone = vec![true; own.len()];
        for root in pairs.iter().filter_map(|pair| root_of([pair.a, pair.b])) {
            left_alone[root as usize] = false;
        }
        let members_of = |root: usize| -> Vec<u32> {
            (root..own.len()).filter(|&body| roots[body] as usize == root).map(|body| own[body]).collect()
        };
        self.touching.clear();
        for root in (0..own.len()).filter(|&root| roots[root] as usize == root && !left_alone[root]) {
            let is_own = |bodies: [u32; 2]| root_of(bodies) == Some(root as u32);
            let of_joint = |joint: &&u32| is_own([joints.list[**joint as usize].a, joints.list[**joint as usize].b]);
            let links = links.iter().filter(of_joint).copied().collect();
            let pairs: Vec<Pair> = pairs.iter().filter(|pair| is_own([pair.a, pair.b])).copied().collect();
            self.touching.push(Touching::new(members_of(root), links, &pairs, joints));
        }
        self.free.clear();
        let mut kept = std::mem::take(&mut self.pieces).into_iter();
        for root in (0..own.len()).filter(|&root| roots[root] as usize == root && left_alone[root]) {
            let body = &bodies.list[own[root] as usize];
            if !jointed[root] && (!body.is_dynamic() || free::is_closed(&member(body))) {
                self.free.push((own[root], motion(body)));
                continue;
            }
            let members = members_of(root);
            let is_here = |joint: &u32| ends(*joint).into_iter().flatten().any(|body| roots[body] as usize == root);
            let links = if jointed[root] { links.iter().copied().filter(is_here).collect() } else { Vec::new() };
            let piece = kept.next().unwrap_or_default();
            self.pieces.push(piece.plan(members, &links, *locked, joints));
        }
    }

    /// Takes all through the step. `cache` has what contacts carried in the one before.
    pub fn step(&mut self, bodies: &Bodies, integrator: ExactIntegrator, terms: &ContactTerms, cache: &ContactCache) {
        let ContactTerms { h, parts, .. } = *terms;
        for touching in &mut self.touching {
            touching.step(terms, cache);
        }
        for (index, motion) in &mut self.free {
            let body = &bodies.list[*index as usize];
            *motion = self::motion(body);
            if body.is_dynamic() {
                free::fly(&member(body), motion, h * f64::from(parts));
            } else {
                motion.drift(h * f64::from(parts));
            }
        }
        for piece in &mut self.pieces {
            piece.effort = piece.stepper.advance(&mut piece.mechanism, integrator, h, parts);
        }
    }

    /// Writes bodies and joint forces back.
    pub fn scatter(&self, bodies: &mut [Body], joints: &mut [Joint]) {
        for (index, motion) in &self.free {
            put(motion, &mut bodies[*index as usize]);
        }
        for piece in &self.pieces {
            let mechanism = &piece.mechanism;
            for (index, motion) in piece.bodies.iter().zip(&mechanism.motion).take(mechanism.moving) {
                put(motion, &mut bodies[*index as usize]);
            }
            for (&joint, force) in piece.joints.iter().zip(&piece.stepper.forces) {
                joints[joint as usize].force = *force;
            }
        }
        for touching in &self.touching {
            touching.scatter(bodies, joints);
        }
    }

    /// What is in reach of something.
    pub fn touching(&self) -> &[Touching] {
        &self.touching
    }

    /// Rows, and what it took to solve them.
    pub fn efforts(&self) -> impl Iterator<Item = (u32, Effort)> + '_ {
        let pieces = self.pieces.iter().map(|piece| (3 * piece.joints.len() as u32, piece.effort));
        pieces.chain(self.touching.iter().map(|touching| (touching.rows(), touching.effort)))
    }

    /// All that the next step depends on beside bodies and joints.
    pub fn memory(&self) -> impl Iterator<Item = f64> + '_ {
        self.pieces.iter().flat_map(|piece| piece.stepper.memory())
    }
}

impl Piece {
    /// Of those bodies that move and those joints, with the buffers of another.
    fn plan(mut self, members: Vec<u32>, links: &[u32], locked: bool, joints: &Joints) -> Self {
        let moving = members.len();
        self.bodies = members;
        let mut place = |body: u32| place_in(&mut self.bodies, moving, body);
        let ends = |joint: &u32| [joints.list[*joint as usize].a, joints.list[*joint as usize].b];
        let pairs: Vec<[u32; 2]> = links.iter().map(|joint| ends(joint).map(&mut place)).collect();
        let gives = links.iter().any(|&joint| joints.list[joint as usize].softness().is_some());
        let (order, mut mechanism) = Mechanism::plan(moving, locked, gives, &pairs);
        self.joints = order.iter().map(|&link| links[link as usize]).collect();
        let link = |&link: &u32| link_of(&joints.list[links[link as usize] as usize], pairs[link as usize]);
        mechanism.links = order.iter().map(link).collect();
        self.mechanism = mechanism;
        self.stepper.forget();
        self
    }

    fn gather(&mut self, bodies: &Bodies, joints: &Joints) {
        let Mechanism { members, motion, links, moving, .. } = &mut self.mechanism;
        let known = members.len() == self.bodies.len();
        members.clear();
        members.extend(self.bodies.iter().map(|&body| member(&bodies.list[body as usize])));
        if !known {
            motion.clear();
            motion.resize(self.bodies.len(), Motion::REST);
        }
        let mut moved = !known;
        for (index, (old, &body)) in motion.iter_mut().zip(&self.bodies).enumerate() {
            let now = self::motion(&bodies.list[body as usize]);
            moved |= index < *moving && now != *old;
            *old = now;
        }
        debug_assert!(links.len() == self.joints.len() && joints.list.len() >= links.len());
        if moved {
            self.stepper.forget();
        }
    }
}

fn is_locked(body: &Body) -> bool {
    body.is_dynamic() && (body.inverse_mass.min() == 0.0 || body.rotation_freedom.min() == 0.0)
}

/// The place of a body among those of a piece, of which the first `moving` are in order; one that is new there comes
/// last.
pub(super) fn place_in(bodies: &mut Vec<u32>, moving: usize, body: u32) -> u32 {
    let known = bodies[..moving].binary_search(&body).ok();
    // Those that do not move are few.
    let known = known.or_else(|| bodies[moving..].iter().position(|&other| other == body).map(|at| at + moving));
    known.unwrap_or_else(|| {
        bodies.push(body);
        bodies.len() - 1
    }) as u32
}

/// A joint between those places.
pub(super) fn link_of(joint: &Joint, [a, b]: [u32; 2]) -> Link {
    let spring = |softness: Softness| Spring {
        frequency: std::f64::consts::TAU * softness.frequency,
        damping_ratio: softness.damping_ratio,
        most: softness.max_force,
    };
    let [anchor_a, anchor_b] = joint.anchors();
    Link { a, b, anchor_a, anchor_b, spring: joint.softness().map(spring) }
}

pub(super) fn motion(body: &Body) -> Motion {
    Motion { position: body.position, rotation: body.rotation, linear: body.linear, angular: body.angular }
}

pub(super) fn put(motion: &Motion, body: &mut Body) {
    body.position = motion.position;
    body.rotation = motion.rotation;
    body.linear = motion.linear;
    body.angular = motion.angular;
}

pub(super) fn member(body: &Body) -> Member {
    if !body.is_dynamic() {
        return Member::FIXED;
    }
    Member {
        mass: body.mass,
        inverse_mass: body.inverse_mass,
        inertia: body.inverse_inertia_body.map(f64::recip),
        freedom: body.rotation_freedom,
        drag: body.drag,
        force: body.force,
        torque: body.torque,
    }
}

impl Member {
    /// What constraints do not move.
    pub const FIXED: Self = Self {
        mass: 0.0,
        inverse_mass: Vector3::new(0.0, 0.0, 0.0),
        inertia: Vector3::new(0.0, 0.0, 0.0),
        freedom: Vector3::new(1.0, 1.0, 1.0),
        drag: (0.0, 0.0),
        force: Vector3::new(0.0, 0.0, 0.0),
        torque: Vector3::new(0.0, 0.0, 0.0),
    };
}
