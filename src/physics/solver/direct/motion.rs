//! Islands with joints in motion: the same direct solve, substep by substep.
//!
//! Sweeps pass the load of a limb on from joint to joint, and what is light under it is thrown about. So islands
//! with joints are solved here in motion, too, contacts and all, with the geometry that joints have in each substep:
//!
//! (M + h²K_δ + Σ JᵀρJ) v = M v₀ + h f + Σ Jᵀ (λ̂ − ρ b), b = ½ h J̇v₀ for joints,
//!
//! M with the geometric stiffness that the step cannot resolve ([`Swing`]), so that poses end on the joints to second
//! order; what is left of gaps is closed by the same factor in the positions alone. Contacts keep the geometry of the
//! start of the step, as in sweeps, unless a body turns far ([`Substeps`]). Newton's method on which rows act is left
//! as it stands after [`ITERATIONS`] guesses: a row too many or too few for a substep is mended in the next.

use nalgebra::{Matrix3, Vector3};

use super::{
    Closing, DirectIsland, Motion, World, across, halves, inertia_of_spin, link_of, momentum_of, moves_freely, patch_of,
};
use crate::physics::body::Body;
use crate::physics::body::RigidBody;
use crate::physics::body::free_rotation::turn_freely;
use crate::physics::collision::fastest_approach;
use crate::physics::contact::{rebound, restitution_threshold};
use crate::physics::settings::SolverSettings;
use crate::physics::solver::joint_tree::{Swing, add_pull};
use crate::physics::solver::linear::BodyVector as Part;
use crate::physics::solver::substeps::{Parts, Substeps};

/// Products of blocks in a factorisation up to which an island is solved in motion.
const MOST_PRODUCTS: usize = 1_000;
/// Turn of a body in a step from which on the island takes all substeps, rad. Limbs that lie on each other roll about
/// this fast, and their joints part no more; from 0.13 rad on some do by centimetres.
const FAR: f64 = 0.1;
/// Weight of rows of contacts over the mass of the island: of what comes fast, so much is stopped in a substep; what
/// rests is exact, as the rows act about what pushed before. With much more, guesses do not come to an end.
const HARDNESS: f64 = 3.0;
/// Guesses which rows act, in a substep.
const ITERATIONS: usize = 6;
/// Guesses after a substep whose guesses did not come to an end: limbs in a heap, most of which slide, seldom have
/// theirs come to one, and their next substep goes on from the last.
const ENOUGH: usize = 2;
/// Share of the gaps of joints that is closed in a substep.
const JOINTS_CLOSED: f64 = 0.5;
/// Share of depths that is closed in a substep.
const DEPTHS_CLOSED: f64 = 0.1;

/// What the motion of an island depends on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MotionTerms {
    pub substeps: Substeps,
    /// Fastest way out of an error, m/s.
    correction_speed: f64,
    /// Approach from which a contact bounces, m/s.
    restitution_speed: f64,
}

impl MotionTerms {
    /// As the settings want it.
    pub fn of(settings: &SolverSettings) -> Self {
        Self {
            substeps: Substeps::of(settings),
            correction_speed: settings.correction_speed.unwrap_or(f64::INFINITY),
            restitution_speed: restitution_threshold(settings),
        }
    }
}

impl DirectIsland {
    /// Whether it is taken through a step here, in motion. To be followed by the substeps.
    pub fn set_off(&mut self, world: &impl World, terms: &MotionTerms) -> bool {
        let sets_off = self.can_set_off(world, terms);
        if sets_off {
            self.parts = terms.substeps.for_bodies(self.members.iter().map(|&member| world.body(member)), FAR);
        }
        sets_off
    }

    fn can_set_off(&mut self, world: &impl World, terms: &MotionTerms) -> bool {
        if self.joints.is_empty() || !self.members.iter().all(|&member| moves_freely(world.body(member))) {
            return false;
        }
        let bounces = |&slot: &u32| {
            let slot = world.slot(slot);
            let [a, b] = [slot.pair.a, slot.pair.b].map(|body| world.body(body));
            rebound(f64::from(slot.restitution), fastest_approach(a, b), terms.restitution_speed) > 0.0
        };
        if self.contacts.iter().any(bounces) {
            return false;
        }
        self.is_analysed(world) && self.pattern.products() <= MOST_PRODUCTS
    }

    /// Into what its step is cut.
    pub fn parts(&self) -> Parts {
        self.parts
    }

    /// What does not move here but touches or holds it.
    pub fn partners(&self) -> &[u32] {
        &self.partners
    }

    /// Solves for a substep: velocities and impulses, and what closes gaps besides.
    pub fn substep(&mut self, world: &impl World, terms: &MotionTerms, is_first: bool) {
        let Parts { h, replaces, turns_far, .. } = self.parts;
        self.is_going_on = false;
        let (of_contacts, of_joints) = self.ends.split_at(self.contacts.len());
        if is_first || turns_far {
            for ((patch, &slot), ends) in self.patches.iter_mut().zip(&self.contacts).zip(of_contacts) {
                *patch = patch_of(world, slot, ends, replaces);
            }
        }
        for ((link, &joint), ends) in self.links.iter_mut().zip(&self.joints).zip(of_joints) {
            let spring = link.spring;
            *link = link_of(world, joint, ends, h);
            if !is_first && let (Some(now), Some(before)) = (&mut link.spring, spring) {
                now.resume(&before);
            }
            if link.spring.is_none() {
                link.given.linear += turning_acceleration(world, joint, link.sides.map(|side| side.arm)) * (0.5 * h);
            }
        }
        self.take_momenta(world, h);
        self.factored.clear();
        self.hardness = HARDNESS;
        let enough = if self.has_settled { ITERATIONS } else { ENOUGH };
        self.has_settled = self.settle(1.0 / h, enough..=ITERATIONS);
        if self.factored.is_empty() {
            self.correction.fill(Part::zeros());
            return;
        }
        let closing = |share| Closing { share_per_step: share / h, fastest: terms.correction_speed };
        self.correct([closing(DEPTHS_CLOSED), closing(JOINTS_CLOSED)]);
    }

    /// Momenta and inertias, stiffened by what joints pull with.
    fn take_momenta(&mut self, world: &impl World, h: f64) {
        let Self { stiffnesses, links, members, inertias, momentum, pattern, .. } = self;
        stiffnesses.clear();
        stiffnesses.resize(members.len(), Matrix3::zeros());
        for link in links.iter() {
            for (side, pull) in link.sides.iter().zip([-link.expected, link.expected]) {
                if let Some(body) = side.body {
                    add_pull(&mut stiffnesses[body as usize], &side.arm, &pull);
                }
            }
        }
        for (local, (&member, stiffness)) in members.iter().zip(&*stiffnesses).enumerate() {
            let body = world.body(member);
            let mut inertia = inertia_of_spin(body);
            let stiffness = stiffness * h;
            let smallest = 1.0 / body.inverse_inertia_body.max();
            let swing = Swing::of(0.5 * stiffness.trace() / smallest);
            let mut damped = Matrix3::zeros();
            if let Some(swing) = swing {
                inertia += stiffness * swing.added;
                damped = stiffness * swing.damped;
            }
            momentum[pattern.place(local as u32) as usize] = momentum_of(body, &inertia, h);
            inertias[local] = (body.mass, inertia + damped);
        }
    }

    /// The state of a member after a substep of length `h`, s, written to it.
    pub fn move_on(&self, local: usize, body: &mut Body, h: f64) {
        let place = self.pattern.place(local as u32) as usize;
        let (linear, angular) = halves(&self.velocity[place]);
        let (shift, turn) = halves(&self.correction[place]);
        body.linear = linear;
        body.angular = angular;
        body.position += (linear + shift) * h;
        let Body { rotation, angular, inverse_inertia_body, rotation_freedom, .. } = body;
        turn_freely(rotation, angular, inverse_inertia_body, rotation_freedom, h);
        body.advance(&Vector3::zeros(), &(turn * h));
        body.rotation.renormalize_fast();
        body.linear /= 1.0 + body.drag.0 * h;
        body.angular /= 1.0 + body.drag.1 * h;
        body.has_stepped = true;
    }

    /// Has contacts go on from what the substep did.
    pub fn carry_on(&mut self, h: f64) {
        let Self { patches, pattern, velocity, correction, .. } = self;
        for patch in patches.iter_mut() {
            let moved = across(pattern, velocity, &patch.sides, &patch.given);
            let corrected = across(pattern, correction, &patch.sides, &Motion::default());
            patch.go_on(&moved.plus(&corrected, 1.0), h);
        }
    }
}

/// J̇V of a joint: how its anchors would part for turning alone.
fn turning_acceleration(world: &impl World, joint: u32, [arm_a, arm_b]: [Vector3<f64>; 2]) -> Vector3<f64> {
    let joint = world.joint(joint);
    let inward = |body: &Body, arm: &Vector3<f64>| match body.kind {
        RigidBody::Static => Vector3::zeros(),
        RigidBody::Dynamic | RigidBody::Kinematic => body.angular.cross(&body.angular.cross(arm)),
    };
    inward(world.body(joint.b), &arm_b) - inward(world.body(joint.a), &arm_a)
}
