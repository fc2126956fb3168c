//! A group of islands as the exact method takes it: pieces that joints hold together, bodies by themselves, and what
//! touches something.

use nalgebra::Vector3;

use super::free;
use super::mechanism::{Link, Mechanism, Member, Motion, Spring};
use super::stepper::{Effort, Stepper};
use crate::physics::bodies::{Bodies, Body, Joint, Joints};
use crate::physics::disjoint_sets::DisjointSets;
use crate::physics::island::Islands;
use crate::physics::joint::Softness;
use crate::physics::settings::Integrator;

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
    /// Bodies that touch something.
    touching: Vec<u32>,
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
    /// Whether some body touches something: contact has a solver of its own.
    pub touches: bool,
}

impl ExactGroup {
    pub fn begin(&mut self, group: usize) {
        self.group = group;
    }

    /// Takes the group's state in; plans it anew if it is another one. `touching` are the bodies of contacts, ascending.
    pub fn gather(&mut self, islands: &Islands, bodies: &Bodies, joints: &Joints, touching: &[u32]) {
        let next = &mut self.next;
        next.bodies.clear();
        next.bodies.extend_from_slice(islands.bodies(self.group));
        next.joints.clear();
        next.joints.extend_from_slice(islands.joints(self.group));
        next.touching.clear();
        next.touching.extend(next.bodies.iter().filter(|body| touching.binary_search(body).is_ok()));
        next.versions = (bodies.version, joints.version);
        next.locked = next.bodies.iter().any(|&body| is_locked(&bodies.list[body as usize]));
        if self.next != self.plan {
            self.plan.clone_from(&self.next);
            self.replan(bodies, joints);
        }
        for piece in &mut self.pieces {
            piece.gather(bodies, joints);
        }
    }

    fn replan(&mut self, bodies: &Bodies, joints: &Joints) {
        let Plan { bodies: own, joints: links, touching, locked, .. } = &self.plan;
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
        let roots: Vec<u32> = (0..own.len() as u32).map(|body| sets.root(body)).collect();
        let mut left_alone = vec![true; own.len()];
        for body in touching.iter().filter_map(|&body| place(body)) {
            left_alone[roots[body] as usize] = false;
        }
        self.touches = !touching.is_empty();
        self.free.clear();
        let mut kept = std::mem::take(&mut self.pieces).into_iter();
        for root in (0..own.len()).filter(|&root| roots[root] as usize == root && left_alone[root]) {
            let body = &bodies.list[own[root] as usize];
            if !jointed[root] && (!body.is_dynamic() || free::is_closed(&member(body))) {
                self.free.push((own[root], motion(body)));
                continue;
            }
            let members =
                (root..own.len()).filter(|&body| roots[body] as usize == root).map(|body| own[body]).collect();
            let is_here = |joint: &u32| ends(*joint).into_iter().flatten().any(|body| roots[body] as usize == root);
            let links = if jointed[root] { links.iter().copied().filter(is_here).collect() } else { Vec::new() };
            let piece = kept.next().unwrap_or_default();
            self.pieces.push(piece.plan(members, &links, *locked, joints));
        }
    }

    /// Takes all that touches nothing through the step.
    pub fn step(&mut self, bodies: &Bodies, integrator: Integrator, h: f64, parts: u32) {
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
    }

    /// Rows, and what it took to solve them.
    pub fn efforts(&self) -> impl Iterator<Item = (u32, Effort)> + '_ {
        self.pieces.iter().map(|piece| (3 * piece.joints.len() as u32, piece.effort))
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
        let mut place = |body: u32| {
            // Those that move are in order; the few others are found one by one.
            let known = self.bodies[..moving].binary_search(&body).ok();
            let known =
                known.or_else(|| self.bodies[moving..].iter().position(|&other| other == body).map(|at| at + moving));
            known.unwrap_or_else(|| {
                self.bodies.push(body);
                self.bodies.len() - 1
            }) as u32
        };
        let ends = |joint: &u32| [joints.list[*joint as usize].a, joints.list[*joint as usize].b];
        let pairs: Vec<[u32; 2]> = links.iter().map(|joint| ends(joint).map(&mut place)).collect();
        let gives = links.iter().any(|&joint| joints.list[joint as usize].softness.is_some());
        let (order, mut mechanism) = Mechanism::plan(moving, locked, gives, &pairs);
        self.joints = order.iter().map(|&link| links[link as usize]).collect();
        let spring = |softness: Softness| Spring {
            frequency: std::f64::consts::TAU * softness.frequency,
            damping_ratio: softness.damping_ratio,
            most: softness.max_force,
        };
        let link = |&link: &u32| {
            let Joint { anchor_a, anchor_b, softness, .. } = &joints.list[links[link as usize] as usize];
            let [a, b] = pairs[link as usize];
            Link { a, b, anchor_a: *anchor_a, anchor_b: *anchor_b, spring: softness.map(spring) }
        };
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

fn motion(body: &Body) -> Motion {
    Motion { position: body.position, rotation: body.rotation, linear: body.linear, angular: body.angular }
}

fn put(motion: &Motion, body: &mut Body) {
    body.position = motion.position;
    body.rotation = motion.rotation;
    body.linear = motion.linear;
    body.angular = motion.angular;
}

fn member(body: &Body) -> Member {
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
