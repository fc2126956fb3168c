//! Islands with joints in motion: the same direct solve, substep by substep.
//!
//! Sweeps pass the load of a limb on from joint to joint, and what is light under it is thrown about. So islands
//! with joints are solved here in motion, too, contacts and all, with the geometry that joints have in each substep:
//!
//! (M + h²K_δ + Σ JᵀρJ) v = M v₀ + h f + Σ Jᵀ (λ̂ − ρ b), b = ½ h J̇v₀ for joints,
//!
//! M with the geometric stiffness that the step cannot resolve ([`StiffnessShares`]), so that poses end on the joints to
//! second order; what is left of gaps is corrected by the same factor in the positions alone. Where joints make trees,
//! the velocities are in the coordinates that these leave free ([`reduced`](super::reduced)), and gaps are closed by the
//! same factor at the end of the substep. Where trees have too many coordinates and joints hold more than points, or have
//! limits, their gaps are then closed by Newton's method on the poses, the nearest way by masses
//! ([`DualSystem::project`](super::dual::DualSystem::project)). Contacts keep the geometry of the start of the step, as
//! in sweeps, unless a body turns far ([`Substeps`]) and none of the two is round: where a wheel touches does not turn
//! with it. Where active-set iterations do not end they are left as they stand: a row too many or too few for a substep
//! is corrected in the next. With limits, they go on for longer while the bodies have more energy than there can be, and
//! what is left of that is taken back.

use bevy::math::DVec3;
use nalgebra::{Matrix3, Vector3};

use super::constants::{
    DEPTH_CORRECTION, GAP_CORRECTION, LONG_ITERATIONS, MOTION_CONTACT_PENALTY, MOTION_ITERATIONS, MOTION_PRODUCTS,
    MOTION_TURN, PROJECTION_ERROR, PROJECTIONS, RIMS, SHORT_ITERATIONS, STEADY_SPEED,
};
use super::dual::{DualTerms, move_to};
use super::island::{DirectIsland, apply, momentum_of, relative_motion};
use super::reduced::ReducedTrees;
use super::rows::{Correction, Rows, body_vector, curving_share, halves};
use super::world::{World, moves_freely, world_inertia};
use crate::physics::Geometry;
use crate::physics::body::free_rotation::turn_freely;
use crate::physics::body::{Body, RigidBody};
use crate::physics::collision::fastest_approach;
use crate::physics::constraint::row::Twist;
use crate::physics::contact::{rebound, restitution_threshold};
use crate::physics::joint::{BodyState, Joint};
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
    /// Fastest way out of an error, m/s.
    correction_speed: f64,
    /// Approach from which a contact bounces, m/s.
    restitution_speed: f64,
}

impl MotionTerms {
    /// As the settings want it.
    pub fn of(settings: &SolverSettings, time: f64) -> Self {
        Self {
            time,
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
            // Where joints hold more than points, motion is told to second order: fewer substeps would be felt, unless
            // it is slow, or all has come to lie still, and nothing drives it.
            let is_driven = self.joints.iter().any(|&joint| world.joint(joint).definition.is_driven());
            let is_new = self.members.iter().any(|&member| !world.body(member).has_stepped);
            let is_slow = |&member: &u32| {
                let body = world.body(member);
                body.linear.norm() + body.angular.norm() * body.radius < STEADY_SPEED
            };
            // What springs, motors and hands pull starts its iterations far from where they end.
            let is_soft = self.joints.iter().any(|&joint| world.joint(joint).definition.is_soft());
            let is_held = self.partners.iter().any(|&partner| world.body(partner).kind == RigidBody::Kinematic);
            self.is_steady = !(is_driven || is_soft || is_held) && self.members.iter().all(is_slow);
            let far = match self.dual.is_some() || self.holds_more_than_points() {
                false => MOTION_TURN,
                true if is_driven || is_new => -1.0,
                true if self.is_steady && self.reduced.is_some() => MOTION_TURN,
                true => 0.0,
            };
            self.intervals = terms.substeps.for_bodies(self.members.iter().map(|&member| world.body(member)), far);
            self.moves = true;
            self.was_still = self.dual.is_some() && self.is_still(world);
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
        // What holds points alone bounces as well by sweeps, which do not stand limits that are hit.
        self.bounces = self.contacts.iter().any(bounces);
        self.is_analysed(world, terms.time)
            && (!self.bounces || self.holds_more_than_points())
            && (self.dual.is_some() || self.elimination.products() <= MOTION_PRODUCTS)
    }

    /// Into what its step is cut.
    pub fn intervals(&self) -> Intervals {
        self.intervals
    }

    /// What does not move here but touches or holds it.
    pub fn partners(&self) -> &[u32] {
        &self.partners
    }

    /// Solves for the substep of that index: velocities and impulses, and the correction of position errors.
    pub fn substep(&mut self, world: &impl World, terms: &MotionTerms, substep: u32) {
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
            // What is round rolls: its contact does not turn with it.
            let stays = |body: &Body| !is_first && body.geometry.as_ref().is_some_and(Geometry::is_round);
            let is_steady = self.is_steady;
            self.make_contact_rows(world, [h, replaces, MOTION_CONTACT_PENALTY], stays, |rows, before| {
                if is_steady {
                    rows.go_on(before);
                }
            });
        }
        if self.bounces {
            self.bounce(world, terms.restitution_speed, MOTION_CONTACT_PENALTY);
        }
        self.make_joint_rows(world, h, |rows, before, joint| match (&mut rows.softness, &before.softness) {
            (Some(now), Some(before)) if !is_first => now.resume(before),
            (Some(_), _) => {}
            (None, _) => {
                let ahead = 0.5 * h * curving_share([joint.a, joint.b].map(|body| world.body(body)), h);
                rows.prescribed.linear += turning_acceleration(world, joint, rows.sides.map(|side| side.arm)) * ahead;
            }
        });
        self.make_any_rows(world, time, [h, 0.5 * h, terms.restitution_speed], !is_first);
        if let Some(reduced) = &mut self.reduced {
            reduced.place(world, &self.members, &self.joints);
            reduced.curve(world, &self.members, &self.joints, |bodies| 0.5 * h * curving_share(bodies, h));
        }
        self.take_momenta(world, h);
        self.factored.clear();
        let may_end = self.has_converged || self.is_steady;
        let least = if may_end { MOTION_ITERATIONS } else { SHORT_ITERATIONS };
        let has_limits = self.holds_more_than_points();
        self.has_converged = self.iterate(least..=if has_limits { LONG_ITERATIONS } else { MOTION_ITERATIONS });
        // As they were when the velocities were solved for: to slow all down is no impulse of a joint.
        self.find_loads();
        let is_given = |&partner: &u32| world.body(partner).kind == RigidBody::Kinematic;
        if has_limits && !self.has_converged && !self.partners.iter().any(is_given) {
            self.take_back_gain();
        }
        if self.factored.is_empty() {
            self.correction.fill(BodyVector::zeros());
            return;
        }
        let rates = [DEPTH_CORRECTION / h, GAP_CORRECTION / h];
        self.correct(&Correction { rates, speeds: [terms.correction_speed; 2] });
        self.put_together(world, time, terms.correction_speed, h);
        self.close_gaps(world, time + h, terms.correction_speed * h, h);
    }

    /// The same by the factor at hand, with the trees of its joints: no point goes further than `most`, m, at once.
    fn close_gaps(&mut self, world: &impl World, time: f64, most: f64, h: f64) {
        let Some(mut reduced) = self.reduced.take() else { return };
        for (local, &member) in self.members.iter().enumerate() {
            reduced.states[local] = self.end_of(local, world.body(member), h);
        }
        let mut shifts = std::mem::take(&mut self.shifts);
        shifts.clone_from(&self.correction);
        let at_once = Correction { rates: [1.0; 2], speeds: [f64::INFINITY; 2] };
        let mut least = f64::INFINITY;
        for projection in 0..=PROJECTIONS {
            let gaps = reduced.find_gaps(world, &self.joints, &self.members);
            let worst = gaps.max(self.find_errors(world, &reduced.states, time));
            let is_better = worst < least;
            if !is_better && projection > 0 {
                // Where what closes loops is all but stretched, there is no pose so near that closes them, and the way
                // to the nearest that does so to first order leads further from it.
                self.go_back(&mut reduced, &mut shifts);
            }
            if !is_better || worst <= PROJECTION_ERROR || projection == PROJECTIONS {
                break;
            }
            least = worst;
            reduced.close(|_| 1.0);
            self.correction.fill(BodyVector::zeros());
            self.apply_corrections(&at_once, false);
            reduced.solve(&mut self.correction);
            self.correct_others(&mut reduced);
            let reach = |(local, &member): (usize, &u32)| {
                let (linear, angular) = halves(&self.correction[self.place(local)]);
                linear.norm() + angular.norm() * world.body(member).radius.clamp(RIMS[0], RIMS[1])
            };
            let furthest = self.members.iter().enumerate().map(reach).fold(0.0, f64::max);
            let share = if furthest > most { most / furthest } else { 1.0 };
            if !share.is_finite() {
                break;
            }
            self.states_before.clone_from(&reduced.states);
            self.shifts_before.clone_from(&shifts);
            self.correction.iter_mut().for_each(|moved| *moved *= share);
            for (local, state) in reduced.states.iter_mut().enumerate() {
                let place = self.place(local);
                let (linear, angular) = halves(&self.correction[place]);
                state.position += linear;
                state.turn(&angular);
                shifts[place] += self.correction[place] / h;
            }
        }
        std::mem::swap(&mut self.correction, &mut shifts);
        (self.shifts, self.reduced) = (shifts, Some(reduced));
    }

    /// Takes back the last projection of members and their shifts.
    fn go_back(&self, reduced: &mut ReducedTrees, shifts: &mut [BodyVector]) {
        reduced.states.clone_from(&self.states_before);
        shifts.copy_from_slice(&self.shifts_before);
    }

    /// Adds what corrects rows that are not in the factor, one after the other.
    fn correct_others(&mut self, reduced: &mut ReducedTrees) {
        let first = self.contact_rows.len() + self.joint_rows.len();
        reduced.rest();
        for row in 0..self.any_rows.len() {
            let rows = &self.any_rows[row];
            for (error, impulse) in rows.errors_besides(&self.factored[first + row]) {
                let mut response = std::mem::take(&mut self.before);
                response.fill(BodyVector::zeros());
                apply(&self.elimination, &mut response, rows, &impulse);
                reduced.solve(&mut response);
                let along = |vectors: &[BodyVector]| {
                    impulse.dot(&relative_motion(&self.elimination, vectors, rows, &Twist::zero()))
                };
                let (mobility, left) = (along(&response), error + along(&self.correction));
                if mobility > 0.0 && left * error > 0.0 {
                    let share = -left / mobility;
                    self.correction.iter_mut().zip(&response).for_each(|(sum, more)| *sum += more * share);
                }
                self.before = response;
            }
        }
    }

    /// Takes in how far rows of joints that are in the factor are from where they belong with the members in these states,
    /// m or rad. The largest.
    fn find_errors(&mut self, world: &impl World, states: &[MemberState], time: f64) -> f64 {
        let first = self.contact_rows.len();
        let Self { members, joints, row_points, row_others, joint_rows, any_rows, factored, scratch, .. } = self;
        let state = |body: u32| match members.binary_search(&body) {
            Ok(local) => BodyState::from(&states[local]),
            Err(_) => BodyState::of(world.body(body)),
        };
        let (of_points, of_others) = factored[first..].split_at(joint_rows.len());
        let mut worst: f64 = 0.0;
        for (rows, &joint) in joint_rows.iter_mut().zip(&*row_points).filter(|_| !of_points.is_empty()) {
            let joint = world.joint(joints[joint as usize]);
            let [a, b] = [joint.a, joint.b].map(state);
            rows.separation = separation(joint, [&a, &b]);
            if rows.softness.is_none() {
                worst = worst.max(rows.separation.amax());
            }
        }
        for ((rows, key), &joint) in any_rows.iter_mut().zip(of_others).zip(&*row_others) {
            if !rows.is_idle() || rows.is_in(key) {
                let joint = world.joint(joints[joint as usize]);
                scratch.clear();
                joint.definition.rows_at(&[joint.a, joint.b].map(state), time, scratch);
                worst = worst.max(rows.take_errors(scratch));
            }
        }
        worst
    }

    /// Closes what the substep left of gaps of joints, in the poses alone.
    fn put_together(&mut self, world: &impl World, time: f64, correction_speed: f64, h: f64) {
        let Some(mut posture) = self.posture.take() else { return };
        let states = self.members.iter().enumerate().map(|(local, &member)| self.end_of(local, world.body(member), h));
        posture.project(world, states, [&self.members, &self.partners], time + h, correction_speed * h);
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
    fn take_momenta(&mut self, world: &impl World, h: f64) {
        let Self { stiffnesses, joint_rows, any_rows, members, inertias, momentum, elimination, .. } = self;
        let (joints, reduced) = (&self.joints, &self.reduced);
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
        for (index, &joint) in joints.iter().enumerate() {
            let Some(reduced) = reduced.as_ref().filter(|reduced| reduced.holds(index)) else { continue };
            let joint = world.joint(joint);
            let (ends, arms) = reduced.sides(index);
            for ((end, arm), impulse) in ends.iter().zip(&arms).zip([-joint.force * h, joint.force * h]) {
                if let Some(body) = end {
                    add_stiffness(&mut stiffnesses[*body as usize], arm, &impulse);
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
        let is_together = !self.factored.is_empty();
        match (&self.posture, &self.reduced) {
            (Some(posture), _) if is_together => move_to(posture.projected(local), body, h),
            (None, Some(reduced)) if is_together => move_to(&reduced.states[local], body, h),
            _ => move_to(&self.end_of(local, body, h), body, h),
        }
    }

    /// Has contacts go on from what the substep did.
    pub fn carry_on(&mut self, h: f64) {
        let Self { contact_rows, any_rows, elimination, velocity, correction, .. } = self;
        for rows in any_rows.iter_mut().filter(|rows| rows.is_idle()) {
            rows.advance(&relative_motion(elimination, velocity, rows, &rows.prescribed), h);
        }
        for rows in contact_rows.iter_mut() {
            let moved = relative_motion(elimination, velocity, rows, &rows.prescribed);
            let corrected = relative_motion(elimination, correction, rows, &Twist::zero());
            rows.advance(&moved.plus(&corrected, 1.0), h);
        }
    }
}

/// From A's anchor to B's with the bodies in these states.
fn separation(joint: &Joint, [a, b]: [&BodyState; 2]) -> Vector3<f64> {
    let [on_a, on_b] = joint.anchors();
    let point =
        |state: &BodyState, anchor: Vector3<f64>| Vector3::from(state.position + state.rotation * DVec3::from(anchor));
    point(b, on_b) - point(a, on_a)
}

/// J̇V of a joint: how its anchors would part for turning alone.
fn turning_acceleration(world: &impl World, joint: &Joint, [arm_a, arm_b]: [Vector3<f64>; 2]) -> Vector3<f64> {
    let inward = |body: &Body, arm: &Vector3<f64>| match body.kind {
        RigidBody::Static => Vector3::zeros(),
        RigidBody::Dynamic | RigidBody::Kinematic => body.angular.cross(&body.angular.cross(arm)),
    };
    inward(world.body(joint.b), &arm_b) - inward(world.body(joint.a), &arm_a)
}
