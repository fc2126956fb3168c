//! The cone solver on the contact points and joints of a group.

use nalgebra::Vector3;

use super::super::constants::{MOST_FACTORISATIONS, MOST_POINT_FACTORISATIONS, SLIDING, TOLERANCES, TOUCHING};
use super::super::mechanism::{MechanismLink, Member, MemberState, stretch};
use super::gap_points::{GapPoint, point_velocity};
use crate::physics::solver::cone::{ConeBody, ConeContact, ConeEnd, ConeJoint, ConeSolver, PerPoint};

/// Bodies and rigid links; the first `moving` move.
#[derive(Clone, Copy)]
pub(super) struct GroupView<'a> {
    pub members: &'a [Member],
    pub moving: usize,
    /// Rigid joints.
    pub links: &'a [MechanismLink],
}

/// The cone solver with its input and output.
#[derive(Default)]
pub(super) struct GroupSolver {
    solver: ConeSolver,
    bodies: Vec<ConeBody>,
    contacts: Vec<ConeContact>,
    joints: Vec<ConeJoint>,
    velocities: Vec<[Vector3<f64>; 2]>,
    given: PerPoint,
    bias: PerPoint,
    /// λ, N·s, on B: where the iteration starts, then the solution.
    pub impulses: PerPoint,
    /// Residual of the last solve, m/s.
    pub residual: f64,
    /// Solves that did not come to an end.
    pub failures: u32,
    pub steps: u32,
    /// Points times factorisations.
    pub work: u64,
    /// Whether to solve to fewer digits.
    pub is_rough: bool,
}

impl GroupSolver {
    /// Takes in the poses and the points to hold. Bodies that constraints do not move have the velocities of `states`.
    pub fn set<'s>(&mut self, view: GroupView, states: &[MemberState], points: impl Iterator<Item = &'s GapPoint>) {
        let moves = |end: u32| ((end as usize) < view.moving).then_some(end);
        let still = |ends: [u32; 2], arms: &[Vector3<f64>; 2]| {
            let of = |end: usize| match moves(ends[end]) {
                Some(_) => Vector3::zeros(),
                None => point_velocity(&states[ends[end] as usize], &arms[end]),
            };
            of(1) - of(0)
        };
        self.bodies.clear();
        self.bodies.extend(view.members.iter().zip(states).take(view.moving).map(|(member, state)| {
            let rotation = state.rotation.to_rotation_matrix().into_inner();
            ConeBody { inverse_mass: member.inverse_mass, inverse_inertia: member.inverse_inertia(&rotation, None) }
        }));
        self.contacts.clear();
        self.joints.clear();
        self.given.contacts.clear();
        self.given.joints.clear();
        for point in points {
            let GapPoint { ends, arms, normal, friction, .. } = point;
            let bodies = ends.map(moves);
            self.contacts.push(ConeContact { bodies, arms: *arms, normal: *normal, friction: *friction });
            self.given.contacts.push(still(*ends, arms));
        }
        for link in view.links {
            let arms = arms_of(link, states);
            let ends = [link.a, link.b];
            self.joints.push(ConeJoint::ball(ends.map(moves), &arms));
            self.given.joints.push(still(ends, &arms));
        }
        self.solver.set(&self.bodies, &self.contacts, &self.joints);
    }

    /// How many of those points slide such that no rigid motion exists: n·W(n − μ t̂) ≤ 0, W the mobility of the point
    /// and t̂ the direction in which it slides (Painlevé 1895): pressing harder pulls its bodies further into each other.
    pub fn jammed<'s>(&self, points: impl Iterator<Item = (&'s GapPoint, Vector3<f64>)>) -> u32 {
        let mut count = 0;
        for ((point, velocity), contact) in points.zip(&self.contacts) {
            let slip = velocity - point.normal * velocity.dot(&point.normal);
            if point.gap > TOUCHING || slip.norm() < SLIDING {
                continue;
            }
            let push = point.normal - slip.normalize() * point.friction;
            let moved = (0..2).filter_map(|end| {
                let body = &self.bodies[contact.bodies[end]? as usize];
                let arm = &contact.arms[end];
                let turned = body.inverse_inertia * arm.cross(&push);
                Some(body.inverse_mass.component_mul(&push) + turned.cross(arm))
            });
            count += u32::from(moved.sum::<Vector3<f64>>().dot(&point.normal) <= 0.0);
        }
        count
    }

    /// Whether a step has taken its share of work here.
    pub fn is_spent(&self) -> bool {
        self.steps >= MOST_FACTORISATIONS && self.work >= MOST_POINT_FACTORISATIONS
    }

    /// Whether there is nothing to solve.
    pub fn is_empty(&self) -> bool {
        self.contacts.is_empty() && self.joints.is_empty()
    }

    /// Solves for the velocities to be gained along normals and at joints, m/s, from [`Self::impulses`]; velocities of
    /// `states` are those without impulses, and with them on return.
    pub fn solve(&mut self, states: &mut [MemberState], gains: &[f64], joint_gains: &[Vector3<f64>]) {
        self.residual = 0.0;
        if self.is_empty() {
            return;
        }
        self.bias.clone_from(&self.given);
        for ((bias, contact), gain) in self.bias.contacts.iter_mut().zip(&self.contacts).zip(gains) {
            *bias += contact.normal * *gain;
        }
        for (bias, gain) in self.bias.joints.iter_mut().zip(joint_gains) {
            *bias += gain;
        }
        self.velocities.clear();
        self.velocities.extend(states.iter().take(self.bodies.len()).map(|state| [state.linear, state.angular]));
        let tolerance = TOLERANCES[usize::from(self.is_rough)];
        let outcome = self.solver.solve(&mut self.velocities, &self.bias, &mut self.impulses, tolerance);
        self.residual = outcome.residual;
        self.steps += outcome.steps;
        self.work += u64::from(outcome.steps) * (self.contacts.len() + self.joints.len()) as u64;
        self.failures += u32::from(matches!(outcome.end, ConeEnd::Bounded | ConeEnd::NoRigidSolution));
        for (state, [linear, angular]) in states.iter_mut().zip(&self.velocities) {
            (state.linear, state.angular) = (*linear, *angular);
        }
    }
}

/// Arms of a joint from the centres of mass of its bodies, world axes.
pub(super) fn arms_of(link: &MechanismLink, states: &[MemberState]) -> [Vector3<f64>; 2] {
    [states[link.a as usize].rotation * link.anchor_a, states[link.b as usize].rotation * link.anchor_b]
}

/// How far B's anchor is from A's, m.
pub(super) fn separation_of(link: &MechanismLink, states: &[MemberState]) -> Vector3<f64> {
    stretch(link, &arms_of(link, states), states)[0]
}
