//! Which bodies joints hold to each other: one of them cannot be held back without the others.

use bevy::prelude::*;
use nalgebra::{UnitQuaternion, Vector3};

use super::time_of_impact::advanced;
use crate::physics::Body;
use crate::physics::bit_set::BitSet;
use crate::physics::disjoint_sets::DisjointSets;
use crate::physics::grouped::Grouped;
use crate::physics::joint::{Joint, Joints};

/// The dynamic bodies that joints hold together, each such mechanism by the lowest index of a body in it.
#[derive(Resource, Default, Clone)]
pub(crate) struct Mechanisms {
    members: Grouped,
    /// By their indices.
    joints: Grouped,
    /// The mechanism of each body.
    of_body: Vec<u32>,
    /// Those that joints hold to what is not dynamic.
    anchored: BitSet,
    /// Those that were held back in this step.
    held: BitSet,
    /// The joints that they are of.
    version: u64,
}

impl Mechanisms {
    /// None has been held back in the step.
    pub(super) fn begin_step(&mut self) {
        self.held.clear();
    }

    /// Brings them up to date with bodies and joints.
    pub(super) fn update(&mut self, bodies: &[Body], joints: &Joints) {
        if self.version == joints.version && self.of_body.len() == bodies.len() {
            return;
        }
        self.version = joints.version;
        let is_dynamic = |body: u32| body != Joint::GONE && bodies[body as usize].is_dynamic();
        let mut sets = DisjointSets::new(bodies.len());
        let both = joints.list.iter().filter(|joint| is_dynamic(joint.a) && is_dynamic(joint.b));
        both.for_each(|joint| sets.union(joint.a, joint.b));
        self.of_body.clear();
        self.of_body.extend((0..bodies.len() as u32).map(|body| sets.root(body)));
        let Self { members, of_body, joints: own_joints, anchored, .. } = self;
        let of_body = |body: u32| if is_dynamic(body) { of_body[body as usize] } else { Grouped::NONE };
        let count = bodies.len() as u32;
        members.rebuild(count, (0..count).map(|body| (body, of_body(body))));
        let of_joint = |(index, joint): (u32, &Joint)| (index, of_body(joint.a).min(of_body(joint.b)));
        own_joints.rebuild(count, (0..).zip(&joints.list).map(of_joint));
        anchored.clear();
        for joint in &joints.list {
            let ends = [joint.a, joint.b].map(of_body);
            if ends.contains(&Grouped::NONE) {
                ends.into_iter().filter(|&end| end != Grouped::NONE).for_each(|end| anchored.set(end, true));
            }
        }
    }

    /// The bodies of the one that a dynamic body is in; that body alone where no joint holds it.
    fn members_with(&self, body: u32) -> &[u32] {
        self.members.of(self.of_body[body as usize] as usize)
    }

    /// Whether joints hold two bodies together.
    pub(super) fn are_joined(&self, one: u32, other: u32) -> bool {
        self.of_body[one as usize] == self.of_body[other as usize]
    }

    /// Whether joints hold the mechanism of a dynamic body to what is not dynamic.
    fn is_anchored(&self, body: u32) -> bool {
        self.anchored.contains(self.of_body[body as usize])
    }

    /// Holds the mechanism of a body back, and with it a dynamic one that it has met with that one's own: their bodies go to where they
    /// are on their ways at a time, s. A kinematic one ends where it was, and takes along what it has met, unless joints hold that to
    /// something else.
    pub(super) fn hold(
        &mut self,
        bodies: &mut [Body],
        [body, met]: [u32; 2],
        met_way: &Body,
        way: impl Fn(&Body, u32) -> Body,
        time: f64,
    ) {
        let held = |body: &Body, member: u32| advanced(&way(body, member), time);
        self.held.set(self.of_body[body as usize], true);
        if bodies[met as usize].is_dynamic() {
            self.held.set(self.of_body[met as usize], true);
            put_back(bodies, self.members_with(met), held);
            put_back(bodies, self.members_with(body), held);
        } else if self.is_anchored(body) {
            put_back(bodies, self.members_with(body), held);
        } else {
            let (met_at, met_turned) = advanced(met_way, time);
            let Body { position: ends_at, rotation: ends_turned, .. } = bodies[met as usize];
            let turned = ends_turned * met_turned.inverse();
            put_back(bodies, self.members_with(body), |body, member| {
                let (position, rotation) = held(body, member);
                (ends_at + turned * (position - met_at), turned * rotation)
            });
        }
    }

    /// The bodies and joints of each that was held back in this step, by their indices, ascending.
    pub fn held(&self) -> impl Iterator<Item = (&[u32], &[u32])> {
        self.held.iter().map(|one| (self.members.of(one as usize), self.joints.of(one as usize)))
    }
}

/// Puts members of a mechanism where they were before. What they have fallen since then they have not: their speeds lose the energy
/// that forces gave them on that way.
fn put_back(bodies: &mut [Body], members: &[u32], before: impl Fn(&Body, u32) -> (Vector3<f64>, UnitQuaternion<f64>)) {
    let (mut given, mut energy) = (0.0, 0.0);
    for &member in members {
        let body = &mut bodies[member as usize];
        let (position, rotation) = before(body, member);
        given += body.force.dot(&(body.position - position));
        energy += kinetic_energy(body);
        (body.position, body.rotation) = (position, rotation);
    }
    if given > 0.0 {
        let share = (1.0 - given / energy).max(0.0).sqrt();
        for &member in members {
            let body = &mut bodies[member as usize];
            body.linear *= share;
            body.angular *= share;
        }
    }
}

/// J.
fn kinetic_energy(body: &Body) -> f64 {
    let spin = body.rotation.inverse_transform_vector(&body.angular);
    let turning = spin.iter().zip(&body.inverse_inertia_body).filter(|(_, inverse)| **inverse > 0.0);
    0.5 * (body.mass * body.linear.norm_squared() + turning.map(|(spin, inverse)| spin * spin / inverse).sum::<f64>())
}
