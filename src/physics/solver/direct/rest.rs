//! Islands at rest, solved for a whole step.

use nalgebra::Vector3;

use super::constants::{
    DUAL_REST_SPEED, INERTIA_CHANGE, LONGEST_PAUSE, REST_CONTACT_PENALTY, REST_CORRECTION, REST_CORRECTION_SPEED,
    REST_ITERATIONS, REST_SPEED, UNCHANGED_SPEED,
};
use super::island::{DirectIsland, momentum_of};
use super::rows::{Correction, halves};
use super::snapshot::Snapshot;
use super::world::{World, moves_freely, world_inertia};
use crate::physics::body::Body;
use crate::physics::solver::linear::BodyVector;

/// What became of an island in a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Outcome {
    /// It is for the sweeps.
    Moves,
    /// It was solved: its bodies, contacts and joints are to be written.
    Rests,
    /// Nothing changes.
    Unchanged,
}

impl DirectIsland {
    /// Tries a step of length `step`, s, of which the impulses of contacts are kept for `substeps` intervals.
    /// `may_skip`: nobody wants to know the impulses of contacts where nothing changes.
    pub fn solve(&mut self, world: &impl World, step: f64, substeps: u32, may_skip: bool) -> Outcome {
        let found_in = self.contacts.iter().map(|&slot| world.slot(slot).found_in).sum();
        let key = (step * f64::from(substeps), found_in);
        if (may_skip || self.contacts.is_empty()) && self.snapshot_key == key && self.is_unchanged(world) {
            return Outcome::Unchanged;
        }
        self.snapshots.clear();
        self.snapshot_key = key;
        if !self.is_suitable(world) {
            self.has_rows = false;
            return Outcome::Moves;
        }
        self.gather(world, step, f64::from(substeps));
        let has_converged = self.iterate(REST_ITERATIONS..=REST_ITERATIONS);
        if has_converged {
            let rates = [REST_CORRECTION / step; 2];
            self.correct(&Correction { rates, speeds: [REST_CORRECTION_SPEED, f64::INFINITY] });
        }
        self.pause = if has_converged { 0 } else { (2 * self.pause + 1).min(LONGEST_PAUSE) };
        self.pause_left = self.pause;
        let rests = has_converged && self.fastest(world, &self.velocity) <= self.rest_speed();
        self.moves = false;
        if rests { Outcome::Rests } else { Outcome::Moves }
    }

    /// Speed of a body up to which it is at rest, m/s.
    fn rest_speed(&self) -> f64 {
        if self.dual.is_some() { DUAL_REST_SPEED } else { REST_SPEED }
    }

    /// Whether it is at rest and can be solved here.
    fn is_suitable(&mut self, world: &impl World) -> bool {
        let most = self.rest_speed();
        let is_rigid = |&joint: &u32| {
            let definition = &world.joint(joint).definition;
            !definition.is_driven() && !definition.is_soft()
        };
        let is_slow = |&member: &u32| {
            let body = world.body(member);
            moves_freely(body) && body.linear.norm() + body.angular.norm() * body.radius <= most
        };
        // Of loads that are not unique the least are to be told, not those of the step before.
        if self.dual.as_ref().is_some_and(|dual| dual.has_loops) {
            return false;
        }
        if !self.members.iter().all(is_slow) || !self.joints.iter().all(is_rigid) {
            return false;
        }
        // One that meets something fast within the step has its points where they will be then.
        if self.contacts.iter().any(|&slot| world.slot(slot).ahead != Vector3::zeros()) {
            return false;
        }
        if self.pause_left > 0 {
            self.pause_left -= 1;
            return false;
        }
        self.is_analysed(world, 0.0)
    }

    /// Whether the last step changed nothing, nor anybody since: who changes a joint has it [renewed](Self::renew).
    fn is_unchanged(&self, world: &impl World) -> bool {
        let bodies = self.members.iter().chain(&self.partners);
        let is_as_then = |(&body, then): (&u32, &Snapshot)| Snapshot::of(world.body(body)) == *then;
        !self.snapshots.is_empty() && bodies.zip(&self.snapshots).all(is_as_then)
    }

    /// Takes in what the step left, if it was so little that the next need not be solved for.
    pub fn remember(&mut self, world: &impl World) {
        let moved = self.fastest(world, &self.velocity).max(self.fastest(world, &self.correction));
        if moved <= UNCHANGED_SPEED && self.joints.is_empty() {
            self.take_snapshots(world);
        }
    }

    /// The same of a step in motion without contacts, before and after which it was still. What springs hold or what is
    /// driven may turn round there.
    pub fn remember_motion(&mut self, world: &impl World) {
        let is_plain = |&joint: &u32| {
            let definition = &world.joint(joint).definition;
            !definition.is_driven() && !definition.is_soft()
        };
        let may = self.was_still && self.dual.is_some() && self.is_still(world);
        if may && self.joints.iter().all(is_plain) {
            self.take_snapshots(world);
        }
    }

    fn take_snapshots(&mut self, world: &impl World) {
        let bodies = self.members.iter().chain(&self.partners);
        self.snapshots.extend(bodies.map(|&body| Snapshot::of(world.body(body))));
    }

    /// Whether no body moves so fast that one could tell.
    pub(super) fn is_still(&self, world: &impl World) -> bool {
        let is_still = |&member: &u32| {
            let body = world.body(member);
            body.linear.norm() + body.angular.norm() * body.radius <= UNCHANGED_SPEED
        };
        self.members.iter().all(is_still)
    }

    /// The largest speed of a body, centre and rim together.
    fn fastest(&self, world: &impl World, velocities: &[BodyVector]) -> f64 {
        let speeds = self.members.iter().enumerate().map(|(local, &member)| {
            let (linear, angular) = halves(&velocities[self.place(local)]);
            linear.norm() + angular.norm() * world.body(member).radius
        });
        speeds.fold(0.0, f64::max)
    }

    fn gather(&mut self, world: &impl World, step: f64, substeps: f64) {
        let mut changed = false;
        for (local, (&member, known)) in self.members.iter().zip(&mut self.inertias).enumerate() {
            let body = world.body(member);
            let inertia = world_inertia(body);
            changed |= known.0 != body.mass || (known.1 - inertia).amax() > INERTIA_CHANGE * inertia.amax();
            self.momentum[self.elimination.place(local as u32) as usize] = momentum_of(body, &inertia, step);
            if changed {
                *known = (body.mass, inertia);
            }
        }
        if changed {
            self.factored.clear();
        }
        let has_rows = std::mem::replace(&mut self.has_rows, true);
        self.make_contact_rows(
            world,
            [step, substeps, REST_CONTACT_PENALTY],
            |_| false,
            |rows, before| {
                if has_rows {
                    rows.resume(before);
                }
            },
        );
        self.make_joint_rows(world, step, |_, _, _| {});
        // Nothing that changes with time rests.
        self.make_any_rows(world, 0.0, [step, 0.0, f64::INFINITY], false);
    }

    /// The state of a member at the end of the step, written to it.
    pub fn scatter(&self, local: usize, body: &mut Body, step: f64) {
        let place = self.place(local);
        let (velocity, correction) = (halves(&self.velocity[place]), halves(&self.correction[place]));
        body.linear = velocity.0 / (1.0 + body.drag.0 * step);
        body.angular = velocity.1 / (1.0 + body.drag.1 * step);
        body.has_stepped = true;
        body.advance(&((velocity.0 + correction.0) * step), &((velocity.1 + correction.1) * step));
    }
}
