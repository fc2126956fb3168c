//! The cone solver on the sites and links of a group.

use nalgebra::Vector3;

use super::super::mechanism::{Link, Member, Motion, stretch};
use super::flight::TOUCHING;
use super::sites::{Site, point_velocity};
use crate::physics::solver::cone::{ConeBody, ConeContact, ConeEnd, ConeJoint, ConeSolver, PerPoint};

/// What a point may be off its law by, m/s, and after too much work.
const TOLERANCES: [f64; 2] = [1e-10, 1e-5];

/// Work that a step may take: factorisations, and points in all of these. The hardest of `limbs` took a quarter of a
/// million points; few points may take more factorisations. After that no forecast is mended.
pub(super) const MOST_WORK: (u32, u64) = (1_000, 1_500_000);

/// Slip from which a point slides, m/s.
const SLIDES: f64 = 1e-6;

/// Bodies and rigid links; the first `moving` move.
#[derive(Clone, Copy)]
pub(super) struct View<'a> {
    pub members: &'a [Member],
    pub moving: usize,
    /// Those that do not give.
    pub links: &'a [Link],
}

/// A solver with what it is given and gives.
#[derive(Default)]
pub(super) struct Kernel {
    solver: ConeSolver,
    bodies: Vec<ConeBody>,
    contacts: Vec<ConeContact>,
    joints: Vec<ConeJoint>,
    velocities: Vec<[Vector3<f64>; 2]>,
    given: PerPoint,
    bias: PerPoint,
    /// λ, N·s, on B: the guess, then the solution.
    pub impulses: PerPoint,
    /// What the last solve left of the laws, m/s.
    pub residual: f64,
    /// Times the laws did not hold.
    pub failures: u32,
    pub steps: u32,
    /// Points in all of these.
    pub work: u64,
    /// Whether to solve to less digits.
    pub is_rough: bool,
}

impl Kernel {
    /// Takes in where bodies are and which sites hold. Velocities of what does not move count.
    pub fn set<'s>(&mut self, view: View, motion: &[Motion], sites: impl Iterator<Item = &'s Site>) {
        let moves = |end: u32| ((end as usize) < view.moving).then_some(end);
        let still = |ends: [u32; 2], arms: &[Vector3<f64>; 2]| {
            let of = |end: usize| match moves(ends[end]) {
                Some(_) => Vector3::zeros(),
                None => point_velocity(&motion[ends[end] as usize], &arms[end]),
            };
            of(1) - of(0)
        };
        self.bodies.clear();
        self.bodies.extend(view.members.iter().zip(motion).take(view.moving).map(|(member, motion)| {
            let rotation = motion.rotation.to_rotation_matrix().into_inner();
            ConeBody { inverse_mass: member.inverse_mass, inverse_inertia: member.inverse_inertia(&rotation, None) }
        }));
        self.contacts.clear();
        self.joints.clear();
        self.given.contacts.clear();
        self.given.joints.clear();
        for site in sites {
            let Site { ends, arms, normal, friction, .. } = site;
            let bodies = ends.map(moves);
            self.contacts.push(ConeContact { bodies, arms: *arms, normal: *normal, friction: *friction });
            self.given.contacts.push(still(*ends, arms));
        }
        for link in view.links {
            let arms = arms_of(link, motion);
            let ends = [link.a, link.b];
            self.joints.push(ConeJoint { bodies: ends.map(moves), arms });
            self.given.joints.push(still(ends, &arms));
        }
        self.solver.set(&self.bodies, &self.contacts, &self.joints);
    }

    /// How many of those sites slide such that no rigid motion exists: n·W(n − μ t̂) ≤ 0, W the mobility of the point
    /// and t̂ where it slides to (Painlevé 1895): pressing harder pulls its bodies further into each other.
    pub fn jammed<'s>(&self, sites: impl Iterator<Item = (&'s Site, Vector3<f64>)>) -> u32 {
        let mut count = 0;
        for ((site, velocity), contact) in sites.zip(&self.contacts) {
            let slip = velocity - site.normal * velocity.dot(&site.normal);
            if site.gap > TOUCHING || slip.norm() < SLIDES {
                continue;
            }
            let push = site.normal - slip.normalize() * site.friction;
            let moved = (0..2).filter_map(|end| {
                let body = &self.bodies[contact.bodies[end]? as usize];
                let arm = &contact.arms[end];
                let turned = body.inverse_inertia * arm.cross(&push);
                Some(body.inverse_mass.component_mul(&push) + turned.cross(arm))
            });
            count += u32::from(moved.sum::<Vector3<f64>>().dot(&site.normal) <= 0.0);
        }
        count
    }

    /// Whether a step has taken all the work that it may here.
    pub fn is_spent(&self) -> bool {
        self.steps >= MOST_WORK.0 && self.work >= MOST_WORK.1
    }

    /// Whether there is nothing to solve.
    pub fn is_empty(&self) -> bool {
        self.contacts.is_empty() && self.joints.is_empty()
    }

    /// Solves for what is to be gained along normals and at joints, m/s, from [`Self::impulses`]; velocities of
    /// `motion` are those without impulses, and with them on return.
    pub fn solve(&mut self, motion: &mut [Motion], gains: &[f64], joint_gains: &[Vector3<f64>]) {
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
        self.velocities.extend(motion.iter().take(self.bodies.len()).map(|motion| [motion.linear, motion.angular]));
        let tolerance = TOLERANCES[usize::from(self.is_rough)];
        let outcome = self.solver.solve(&mut self.velocities, &self.bias, &mut self.impulses, tolerance);
        self.residual = outcome.residual;
        self.steps += outcome.steps;
        self.work += u64::from(outcome.steps) * (self.contacts.len() + self.joints.len()) as u64;
        self.failures += u32::from(matches!(outcome.end, ConeEnd::Bounded | ConeEnd::NoRigidSolution));
        for (motion, [linear, angular]) in motion.iter_mut().zip(&self.velocities) {
            (motion.linear, motion.angular) = (*linear, *angular);
        }
    }
}

/// From the centres of mass of its bodies, world axes.
pub(super) fn arms_of(link: &Link, motion: &[Motion]) -> [Vector3<f64>; 2] {
    [motion[link.a as usize].rotation * link.anchor_a, motion[link.b as usize].rotation * link.anchor_b]
}

/// How far B's anchor is from A's, m.
pub(super) fn separation_of(link: &Link, motion: &[Motion]) -> Vector3<f64> {
    stretch(link, &arms_of(link, motion), motion)[0]
}
