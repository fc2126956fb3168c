//! Islands with joints in motion ([`loaded`](super::loaded) tells of those without): the same direct solve, substep by substep.
//!
//! Sweeps pass the load of a limb on from joint to joint, and what is light under it is thrown about. So islands
//! with joints are solved here in motion, too, contacts and all, with the geometry that joints have in each substep:
//!
//! (M + h²K_δ + Σ JᵀρJ) v = M v₀ + h f + Σ Jᵀ (λ̂ − ρ b), b = ½ h J̇v₀ for joints,
//!
//! M with the geometric stiffness that the step cannot resolve ([`StiffnessShares`]), so that poses end on the joints to
//! second order; what is left of gaps is corrected by the same factor in the positions alone. Where joints hold more than
//! points, or have limits, their gaps are closed by Newton's method on the poses, the nearest way by masses, when the
//! step is over, and after each substep where something turns far or a spring pulls
//! ([`posture`](super::posture)). Contacts keep the geometry of the start of the step, as in
//! sweeps, unless a body turns far ([`Substeps`]) and none of the two is round: where a wheel touches does not turn with
//! it. Where active-set iterations do not end they are left as they stand: a row too many or too few for a substep is
//! corrected in the next. With limits, they go on for longer while the bodies have more energy than there can be, and
//! what is left of that is taken back. Impulses that were found so may be far too large, and cancel each other: sweeps
//! that take over such an island start from none of them.

use nalgebra::{Matrix3, Vector3};

use super::any_joint::AnyJoint;
use super::constants::{
    DEPTH_CORRECTION, GAP_CORRECTION, JOINED_PARTING, LONG_ITERATIONS, MOTION_CONTACT_PENALTY, MOTION_ITERATIONS,
    MOTION_PRODUCTS, MOTION_TURN, POSTURE_TURNS, SHORT_ITERATIONS, TORN,
};
use super::dual::{DualTerms, move_to};
use super::island::{DirectIsland, momentum_of, relative_motion};
use super::rows::{Correction, body_vector, curving_share, halves};
use super::world::{World, moves_freely, rim, state_of, world_inertia};
use crate::physics::Geometry;
use crate::physics::body::free_rotation::turn_freely;
use crate::physics::body::{Body, RigidBody};
use crate::physics::collision::{fastest_approach, turning_speed};
use crate::physics::constraint::row::Twist;
use crate::physics::contact::{rebound, restitution_threshold};
use crate::physics::joint::Joint;
use crate::physics::settings::SolverSettings;
use crate::physics::solver::exact::MemberState;
use crate::physics::solver::joint_tree::{StiffnessShares, add_stiffness};
use crate::physics::solver::linear::BodyVector;
use crate::physics::solver::substeps::{Intervals, Substeps};

/// What the motion of an island depends on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MotionTerms {
    pub substeps: Substeps,
    /// Simulation time at its start, s.
    pub time: f64,
    /// Whether there is something to spend on heavy loads.
    pub may_spend: bool,
    /// Fastest way out of an error, m/s.
    correction_speed: f64,
    /// Approach from which a contact bounces, m/s.
    restitution_speed: f64,
}

impl MotionTerms {
    /// As the settings want it, and whether there is something to spend on heavy loads.
    pub fn of(settings: &SolverSettings, time: f64, may_spend: bool) -> Self {
        Self {
            time,
            may_spend,
            substeps: Substeps::of(settings),
            correction_speed: settings.correction_speed.unwrap_or(f64::INFINITY),
            restitution_speed: restitution_threshold(settings),
        }
    }

    /// Fastest way out of an error, m/s.
    pub(super) fn correction_speed(&self) -> f64 {
        self.correction_speed
    }
}

impl DirectIsland {
    /// Whether it is taken through a step here, in motion. To be followed by the substeps.
    pub fn set_off(&mut self, world: &impl World, terms: &MotionTerms) -> bool {
        let sets_off = self.can_set_off(world, terms);
        if sets_off {
            self.is_pulled = self.joints.iter().any(|&joint| world.joint(joint).softness().is_some());
            // Without contacts, where joints hold more than points, motion is told to second order: fewer substeps would be
            // felt, unless all has come to lie still and nothing drives it. What a hand presses to the ground gets into it.
            let is_driven = self.joints.iter().any(|&joint| world.joint(joint).definition.is_driven());
            let is_new = self.members.iter().any(|&member| !world.body(member).has_stepped);
            let [far, fast] = match (&self.dual, &self.posture) {
                (None, None) => [MOTION_TURN; 2],
                _ if is_driven || is_new => [-1.0; 2],
                (None, Some(_)) if !self.is_pulled => POSTURE_TURNS,
                _ => [0.0; 2],
            };
            let members = self.members.iter().map(|&member| world.body(member));
            self.intervals = terms.substeps.for_bodies(members, far, fast);
            self.moves = true;
            self.was_still = self.dual.is_some() && self.is_still(world);
        }
        sets_off
    }

    fn can_set_off(&mut self, world: &impl World, terms: &MotionTerms) -> bool {
        let may = !self.joints.is_empty() || self.may_set_off_loaded(world, terms);
        if !may || !self.members.iter().all(|&member| moves_freely(world.body(member))) {
            return false;
        }
        let bounces = |&slot: &u32| {
            let slot = world.slot(slot);
            let [a, b] = [slot.pair.a, slot.pair.b].map(|body| world.body(body));
            rebound(f64::from(slot.restitution), fastest_approach(a, b), terms.restitution_speed) > 0.0
        };
        // What holds points alone bounces as well by sweeps, which do not stand limits that are hit.
        self.bounces = self.contacts.iter().any(bounces);
        self.is_analysed(world, terms.time)
            && (!self.bounces || self.posture.is_some())
            && (self.dual.is_some() || self.elimination.products() <= self.most_products())
    }

    /// Products of blocks up to which it is solved in motion.
    fn most_products(&self) -> usize {
        if self.joints.is_empty() { self.loaded_products() } else { MOTION_PRODUCTS }
    }

    /// Into what its step is cut.
    pub fn intervals(&self) -> Intervals {
        self.intervals
    }

    /// What does not move here but touches or holds it.
    pub fn partners(&self) -> &[u32] {
        &self.partners
    }

    /// Solves for the substep of that index: velocities and impulses, and the correction of position errors. Whether what
    /// came out is to be believed; if not, the step is to be as if it had not begun, and is for the sweeps.
    pub fn substep(&mut self, world: &impl World, terms: &MotionTerms, substep: u32) -> bool {
        if self.joints.is_empty() {
            self.has_rows = false;
            return self.substep_loaded(world, terms, substep == 0);
        }
        self.substep_with_joints(world, terms, substep);
        true
    }

    /// Whether sweeps are to start from none of its impulses: iterations that found what its joints carried did not end.
    pub fn is_doubtful(&self, world: &impl World) -> bool {
        self.joints.iter().any(|&joint| world.joint(joint).is_doubtful)
    }

    fn substep_with_joints(&mut self, world: &impl World, terms: &MotionTerms, substep: u32) {
        let Intervals { h, replaces, turns_far, .. } = self.intervals;
        let (time, is_first) = (terms.time + h * f64::from(substep), substep == 0);
        self.has_rows = false;
        if let Some(dual) = &mut self.dual {
            let MotionTerms { correction_speed, restitution_speed: least_bounce, .. } = *terms;
            let terms = DualTerms { time, h, correction_speed, least_bounce };
            dual.substep(world, &self.members, &self.partners, &terms, is_first);
            return;
        }
        if is_first || turns_far {
            self.make_turned_rows(world, [h, replaces, MOTION_CONTACT_PENALTY], is_first);
            self.foresee(world);
        }
        if self.bounces {
            self.bounce(world, terms.restitution_speed, MOTION_CONTACT_PENALTY);
        }
        self.make_joint_rows(world, h, |rows, before, joint| match (&mut rows.softness, &before.softness) {
            (Some(now), Some(before)) if !is_first => now.resume(before),
            (Some(_), _) => {}
            (None, _) => {
                rows.prescribed.linear += gained_by_turning(world, joint, rows.sides.map(|side| side.arm), h);
            }
        });
        self.make_any_rows(world, time, [h, 0.5 * h, terms.restitution_speed], !is_first);
        if self.is_torn(world) {
            self.joint_rows.iter_mut().for_each(|rows| rows.expected = Vector3::zeros());
            self.any_rows.iter_mut().for_each(AnyJoint::forget);
        }
        self.take_momenta(world, h);
        if !self.has_converged || is_first && self.is_doubtful(world) {
            self.expect_no_throw();
        }
        self.factored.clear();
        let least = if self.has_converged { MOTION_ITERATIONS } else { SHORT_ITERATIONS };
        let has_limits = self.posture.is_some();
        self.has_converged = self.iterate(least..=if has_limits { LONG_ITERATIONS } else { MOTION_ITERATIONS });
        self.is_trusted = self.has_converged && (is_first || self.is_trusted);
        if has_limits && !self.has_converged {
            self.take_back_gain(self.fastest_support(world));
        }
        if self.factored.is_empty() {
            self.correction.fill(BodyVector::zeros());
            return;
        }
        let rates = [DEPTH_CORRECTION / h, GAP_CORRECTION / h];
        self.correct(&Correction { rates, speeds: [terms.correction_speed; 2] });
        // In the substeps before the last nobody sees what is left of gaps.
        let is_last = substep + 1 == self.intervals.count;
        self.is_put_together = self.posture.is_some() && (is_last || turns_far || self.is_pulled);
        if self.is_put_together {
            self.put_together(world, time, terms.correction_speed, h);
        }
    }

    /// Whether some joint is so far apart that it cannot hold. What those carry that hands tied so that they cannot grows with
    /// each substep, until a turn of it throws all about.
    fn is_torn(&self, world: &impl World) -> bool {
        let points =
            self.joint_rows.iter().map(|rows| if rows.softness.is_some() { 0.0 } else { rows.separation.norm() });
        let gaps = points.chain(self.any_rows.iter().map(AnyJoint::gap));
        self.joints.iter().zip(gaps).any(|(&joint, gap)| {
            let joint = world.joint(joint);
            let rims = [joint.a, joint.b].map(|body| rim(world.body(body)));
            gap > TORN * rims[0].min(rims[1])
        })
    }

    /// Greatest speed of a point of what moves it by contacts or joints that do not give, m/s.
    fn fastest_support(&self, world: &impl World) -> f64 {
        let of_contacts = self.contacts.iter().map(|&slot| world.slot(slot).pair).map(|pair| [pair.a, pair.b]);
        let joints = self.joints.iter().map(|&joint| world.joint(joint));
        let of_joints = joints.filter(|joint| joint.softness().is_none()).map(|joint| [joint.a, joint.b]);
        let supports = of_contacts.chain(of_joints).flatten().map(|body| world.body(body));
        let moving = supports.filter(|body| body.kind == RigidBody::Kinematic);
        moving.map(|body| body.linear.norm() + turning_speed(body)).fold(0.0, f64::max)
    }

    /// Makes the rows of contacts, in a substep that is not the first of those that have turned.
    pub(super) fn make_turned_rows(&mut self, world: &impl World, terms: [f64; 3], is_first: bool) {
        // What is round rolls: its contact does not turn with it.
        let stays = |body: &Body| !is_first && body.geometry.as_ref().is_some_and(Geometry::is_round);
        self.make_contact_rows(world, terms, stays, |_, _| {});
    }

    /// Closes what the substep left of gaps of joints, in the poses alone.
    fn put_together(&mut self, world: &impl World, time: f64, correction_speed: f64, h: f64) {
        let Some(mut posture) = self.posture.take() else { return };
        let states = self.members.iter().enumerate().map(|(local, &member)| self.end_of(local, world.body(member), h));
        let partners = self.partners.iter().map(|&body| state_of(world.body(body)));
        posture.project(world, &self.members, states.chain(partners), time + h, correction_speed * h);
        for (local, shift) in posture.shifts.iter().enumerate() {
            let place = self.place(local);
            self.correction[place] += body_vector(&shift.linear, &shift.angular) / h;
        }
        self.posture = Some(posture);
    }

    /// Where a member is after a substep of length `h`, s, that it begins so.
    fn end_of(&self, local: usize, body: &Body, h: f64) -> MemberState {
        let place = self.place(local);
        let (linear, mut angular) = halves(&self.velocity[place]);
        let (shift, turn) = halves(&self.correction[place]);
        let mut rotation = body.rotation;
        turn_freely(&mut rotation, &mut angular, &body.inverse_inertia_body, &body.rotation_freedom, h);
        let mut state = MemberState { position: body.position + (linear + shift) * h, rotation, linear, angular };
        state.turn(&(turn * h));
        state.rotation.renormalize_fast();
        state
    }

    /// Momenta, and inertias with the geometric stiffness of the impulses of joints.
    pub(super) fn take_momenta(&mut self, world: &impl World, h: f64) {
        let Self { stiffnesses, joint_rows, any_rows, members, inertias, momentum, elimination, .. } = self;
        stiffnesses.clear();
        stiffnesses.resize(members.len(), Matrix3::zeros());
        let points = joint_rows.iter().map(|rows| (&rows.sides, rows.expected));
        for (sides, expected) in points.chain(any_rows.iter().map(|rows| (&rows.sides, rows.expected_force()))) {
            for (side, impulse) in sides.iter().zip([-expected, expected]) {
                if let Some(body) = side.body {
                    add_stiffness(&mut stiffnesses[body as usize], &side.arm, &impulse);
                }
            }
        }
        for (local, (&member, stiffness)) in members.iter().zip(&*stiffnesses).enumerate() {
            let body = world.body(member);
            let mut inertia = world_inertia(body);
            let stiffness = stiffness * h;
            let smallest = 1.0 / body.inverse_inertia_body.max();
            let mut damped = Matrix3::zeros();
            if let Some(shares) = StiffnessShares::of(0.5 * stiffness.trace() / smallest) {
                inertia += stiffness * shares.added;
                damped = stiffness * shares.damped;
            }
            momentum[elimination.place(local as u32) as usize] = momentum_of(body, &inertia, h);
            inertias[local] = (body.mass, inertia + damped);
        }
    }

    /// The state of a member after a substep of length `h`, s, written to it.
    pub fn move_on(&self, local: usize, body: &mut Body, h: f64) {
        if let Some(dual) = &self.dual {
            dual.move_on(local, body, h);
            return;
        }
        match &self.posture {
            Some(posture) if self.is_put_together && !self.factored.is_empty() => {
                move_to(&posture.projected()[local], body, h)
            }
            _ => move_to(&self.end_of(local, body, h), body, h),
        }
    }

    /// Has contacts go on from what the substep did.
    pub fn carry_on(&mut self, h: f64) {
        let Self { contact_rows, elimination, velocity, correction, .. } = self;
        for rows in contact_rows.iter_mut() {
            let moved = relative_motion(elimination, velocity, rows, &rows.prescribed);
            let corrected = relative_motion(elimination, correction, rows, &Twist::zero());
            rows.advance(&moved.plus(&corrected, 1.0), h);
        }
    }
}

/// ½ h J̇V: how fast the anchors of a joint come to part in half of a substep, of length `h`, s, as its bodies turn.
///
/// V is of the start, where anchors that were held until then part at about that speed, for the half of a substep that they
/// have turned since. Anchors that part much faster have only just been joined: V is not what it will be when they are
/// held, and a body that spins about a point far from it would be thrown by what is of second order in its spin.
fn gained_by_turning(world: &impl World, joint: &Joint, arms: [Vector3<f64>; 2], h: f64) -> Vector3<f64> {
    let bodies = [joint.a, joint.b].map(|body| world.body(body));
    let [a, b] = [0, 1].map(|side| {
        let (body, arm) = (bodies[side], &arms[side]);
        let turning = match body.kind {
            RigidBody::Static => Vector3::zeros(),
            RigidBody::Dynamic | RigidBody::Kinematic => body.angular.cross(arm),
        };
        (body.linear + turning, body.angular.cross(&turning))
    });
    let gained = (b.1 - a.1) * (0.5 * h * curving_share(bodies, h));
    let is_new = joint.force == Vector3::zeros();
    if is_new && (b.0 - a.0).norm() > JOINED_PARTING * gained.norm() { Vector3::zeros() } else { gained }
}
