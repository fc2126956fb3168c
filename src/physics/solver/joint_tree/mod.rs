//! Ball joints that form trees, solved exactly in linear time, in velocity and in position.
//!
//! A joint between a and b asks C = x_b + r_b − x_a − r_a = 0 and J V = 0 with
//! J = [−1, [r_a]×, 1, −[r_b]×]. All joints of a tree at once, with accumulated impulses λ and
//! softness γ:
//!
//! (J M⁻¹ Jᵀ + γ) Δλ = b − J V − γ λ,  V⁺ = V + M⁻¹ Jᵀ Δλ.
//!
//! J M⁻¹ Jᵀ has one 3×3 block per joint and one per pair of joints that share a moving body. Joints
//! are eliminated from the leaves to the root, as in Baraff (1996, "Linear-time dynamics using
//! Lagrange multipliers"), but in the smaller system of the joints alone (block L D Lᵀ):
//! - a body with two joints i, j (a *link*) fills nothing in: with E = J_j M⁻¹ J_iᵀ over that body,
//!   L = E D_i⁻¹ and D_j ← D_j − L Eᵀ. A chain is thus block tridiagonal;
//! - a body with more (a *hub*) would fill in a block per pair of them. Instead the hub carries N,
//!   its 6×6 inverse mass under the joints eliminated so far, and each joint takes its share away
//!   (the covariance update of the Kalman filter; the inverse of Featherstone's articulated inertia):
//!   D_i = … + J_i N J_iᵀ,  K = N J_iᵀ,  N ← N − K D_i⁻¹ Kᵀ. A joint costs the same on a hub of
//!   three as on one of a thousand.
//!
//! Only M⁻¹ appears, so locked axes (zero inverse mass) need no special case. A pivot that
//! cancellation has left without a significant digit belongs to a redundant row: its multiplier
//! stays zero, the rows before it having fixed that motion already.
//!
//! The root is the middle of the tree, and joints are eliminated level by level: the two halves of
//! a chain are then independent sequences that a processor overlaps.
//!
//! **A substep** that neither gains nor loses energy where it resolves the motion, with one
//! factorisation (that of the pose at the end of the substep before):
//! 1. [`JointTree::aim`] at the end of the drift, [`JointTree::damp`], v ← v + h g, free rotation;
//! 2. [`JointTree::clear_impulses`], then [`JointTree::solve_velocities`], in turn with contacts;
//! 3. drift;
//! 4. arms and inertias of the new pose, [`JointTree::stiffen`], [`JointTree::factor`];
//! 5. [`JointTree::project_positions`], once is enough; V ← V + ΔX/h. If `stiffen` returned more than
//!    [`UNRESOLVED`], step 4 again; or its arms alone and step 2 twice, the second time for what the factor misses.
//!
//! This is SHAKE (Ryckaert, Ciccotti and Berendsen 1977) as a velocity solver sees it: leapfrog, with
//! velocities half a substep behind the poses.
//!
//! **Which joints qualify.** The moving bodies of a component must form a tree. Bodies that do not
//! move do not connect: each joint to one is a leaf of its own (a *pin*), so that a component may
//! be pinned any number of times and J M⁻¹ Jᵀ keeps its structure. With one pin or none all rows are
//! independent; with more they may be redundant ([`JointTree::may_be_redundant`]): always when one
//! body has two pins, else where the bodies between two pins are stretched straight. Components
//! with a loop of moving bodies are left to the caller.

mod factor;
mod position;
mod stiffness;
mod structure;

#[cfg(test)]
mod tests;

pub(crate) use position::PoseChange;
pub(crate) use stiffness::{Swing, UNRESOLVED, add_pull};
pub(crate) use structure::{Partition, partition};

use nalgebra::{Matrix3, Vector3};

use crate::physics::constraint::row::Twist;

/// No joint, no hub.
const NONE: u32 = u32::MAX;

/// One component: its moving bodies form a tree. Bodies and joints have local indices: bodies the
/// moving ones first, joints in the order of elimination.
#[derive(Clone, Debug, Default)]
pub(crate) struct JointTree {
    /// The caller's index of each body; one that does not move appears once per joint to it.
    bodies: Vec<u32>,
    moving: usize,
    /// The caller's index of each joint.
    sources: Vec<u32>,
    inertias: Vec<Inertia>,
    joints: Vec<TreeJoint>,
    hubs: Vec<Hub>,
    branches: Vec<Branch>,
    /// Right-hand side, then solution, per joint.
    unknowns: Vec<Vector3<f64>>,
    /// Jᵀ of the solution, per moving body.
    wrenches: Vec<Twist<f64>>,
    motions: Vec<position::Motion>,
    earlier_motions: Vec<position::Motion>,
    /// What is left of each moving body's angular velocity after a substep's damping.
    dampings: Vec<Matrix3<f64>>,
    may_be_redundant: bool,
}

/// Inverse mass of a body, world axes.
#[derive(Clone, Copy, Debug)]
struct Inertia {
    inverse_mass: Vector3<f64>,
    inverse_inertia: Matrix3<f64>,
}

/// One joint, from the body nearer the root (parent, a in J) to the other (child, b in J).
#[derive(Clone, Debug)]
struct TreeJoint {
    child: u32,
    parent: u32,
    /// Joint that the parent, a link, couples this one to; NONE: no later one.
    next: u32,
    /// The parent's other joint leads to a sibling of the child, not to the grandparent.
    next_is_sibling: bool,
    /// NONE: the child is no hub.
    child_hub: u32,
    /// Index into the branches; NONE: the parent is no hub.
    branch: u32,
    /// −1 where the caller's b is the parent.
    sign: f64,
    arm_child: Vector3<f64>,
    arm_parent: Vector3<f64>,
    softness: f64,
    /// D, then D⁻¹.
    pivot: Matrix3<f64>,
    /// E, then L = E D⁻¹.
    coupling: Matrix3<f64>,
    /// Diagonal of J M⁻¹ Jᵀ + γ: what the pivot is measured against.
    scale: Vector3<f64>,
    impulse: Vector3<f64>,
}

/// A body with more than two joints.
#[derive(Clone, Debug)]
struct Hub {
    body: u32,
    /// N = [[linear, mixed], [mixedᵀ, angular]].
    linear: Matrix3<f64>,
    mixed: Matrix3<f64>,
    angular: Matrix3<f64>,
    /// Forward: motion by the joints eliminated so far. Backward: impulse of the joints after.
    passing: Twist<f64>,
}

/// A joint whose parent is a hub.
#[derive(Clone, Debug)]
struct Branch {
    hub: u32,
    /// K = N Jᵀ, linear and angular rows.
    linear: Matrix3<f64>,
    angular: Matrix3<f64>,
}

impl JointTree {
    /// The caller's indices of the bodies, in local order: those that move, then those that do not.
    pub fn bodies(&self) -> &[u32] {
        &self.bodies
    }

    /// How many of the bodies move.
    pub fn moving(&self) -> usize {
        self.moving
    }

    /// The caller's indices of the joints, in local order.
    pub fn joints(&self) -> &[u32] {
        &self.sources
    }

    /// The local bodies at the ends of a joint, in no particular order.
    pub fn ends(&self, joint: usize) -> [u32; 2] {
        [self.joints[joint].child, self.joints[joint].parent]
    }

    /// Whether two pins may make rows redundant; such rows are dropped where they are.
    pub fn may_be_redundant(&self) -> bool {
        self.may_be_redundant
    }

    /// Inverse mass per world axis and inverse inertia in world axes of a moving body; zero along
    /// locked axes.
    pub fn set_inertia(&mut self, body: usize, inverse_mass: Vector3<f64>, inverse_inertia: Matrix3<f64>) {
        self.inertias[body] = Inertia { inverse_mass, inverse_inertia };
    }

    /// Arms from the centres of mass of the caller's a and b, world axes, m.
    pub fn set_arms(&mut self, joint: usize, arm_a: Vector3<f64>, arm_b: Vector3<f64>) {
        let joint = &mut self.joints[joint];
        (joint.arm_parent, joint.arm_child) = if joint.sign > 0.0 { (arm_a, arm_b) } else { (arm_b, arm_a) };
    }

    /// γ, 1/kg, ≥ 0: with a spring k and damper c, γ = 1/(h (h k + c)) and b = −k C/(h k + c).
    #[cfg(test)]
    pub fn set_softness(&mut self, joint: usize, softness: f64) {
        self.joints[joint].softness = softness;
    }

    /// Accumulated impulse on the caller's b, N s.
    pub fn impulse(&self, joint: usize) -> Vector3<f64> {
        self.joints[joint].impulse * self.joints[joint].sign
    }

    /// Sets the accumulated impulse, which only soft joints depend on; it is not applied.
    #[cfg(test)]
    pub fn set_impulse(&mut self, joint: usize, impulse: Vector3<f64>) {
        let joint = &mut self.joints[joint];
        joint.impulse = impulse * joint.sign;
    }

    /// Takes the accumulated impulses to be those of a substep that is so much as long.
    pub fn scale_impulses(&mut self, ratio: f64) {
        for joint in &mut self.joints {
            joint.impulse *= ratio;
        }
    }

    /// Forgets the accumulated impulses: a new substep begins.
    pub fn clear_impulses(&mut self) {
        for joint in &mut self.joints {
            joint.impulse = Vector3::zeros();
        }
    }

    /// Targets of [`Self::solve_velocities`] for which a drift over h, s, ends on the joints to second
    /// order: −½ h J̇V, J̇V = ω_b × (ω_b × r_b) − ω_a × (ω_a × r_a). From the velocities (local order)
    /// of the substep before; with them, solving, drifting and projecting is the SHAKE step, which
    /// neither gains nor loses energy in the long run; with zero it loses ω²h per second.
    pub fn aim(&self, twists: &[Twist<f64>], h: f64, targets: &mut [Vector3<f64>]) {
        for (joint, target) in self.joints.iter().zip(targets) {
            let (child, parent) = (&twists[joint.child as usize].angular, &twists[joint.parent as usize].angular);
            let child = child.cross(&child.cross(&joint.arm_child));
            let parent = parent.cross(&parent.cross(&joint.arm_parent));
            *target = (parent - child) * (0.5 * h * joint.sign);
        }
    }

    /// Changes velocities (local order) so that every joint's relative velocity J V + γ λ is its
    /// target; `targets` in m/s, b relative to a, empty for all zero. Needs [`Self::factor`].
    pub fn solve_velocities(&mut self, twists: &mut [Twist<f64>], targets: &[Vector3<f64>]) {
        for (joint, unknown) in self.joints.iter().zip(&mut self.unknowns) {
            let (child, parent) = (&twists[joint.child as usize], &twists[joint.parent as usize]);
            let relative = child.linear + child.angular.cross(&joint.arm_child)
                - parent.linear
                - parent.angular.cross(&joint.arm_parent);
            *unknown = -relative - joint.impulse * joint.softness;
        }
        for ((unknown, joint), target) in self.unknowns.iter_mut().zip(&self.joints).zip(targets) {
            *unknown += target * joint.sign;
        }
        self.substitute();
        for (joint, impulse) in self.joints.iter_mut().zip(&self.unknowns) {
            joint.impulse += impulse;
        }
        self.gather_wrenches();
        let moving = twists.iter_mut().zip(&self.inertias).zip(&self.wrenches);
        for ((twist, inertia), wrench) in moving {
            let change = inertia.response(wrench);
            twist.linear += change.linear;
            twist.angular += change.angular;
        }
    }

    /// Jᵀ of the unknowns.
    fn gather_wrenches(&mut self) {
        self.wrenches.fill(Twist::zero());
        for (joint, impulse) in self.joints.iter().zip(&self.unknowns) {
            // A child that does not move has no place among the wrenches.
            if let Some(child) = self.wrenches.get_mut(joint.child as usize) {
                child.linear += impulse;
                child.angular += joint.arm_child.cross(impulse);
            }
            let parent = &mut self.wrenches[joint.parent as usize];
            parent.linear -= impulse;
            parent.angular -= joint.arm_parent.cross(impulse);
        }
    }
}

impl Inertia {
    const FIXED: Self = Self {
        inverse_mass: Vector3::new(0.0, 0.0, 0.0),
        inverse_inertia: Matrix3::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
    };

    /// M⁻¹ times an impulse.
    fn response(&self, wrench: &Twist<f64>) -> Twist<f64> {
        Twist {
            linear: wrench.linear.component_mul(&self.inverse_mass),
            angular: self.inverse_inertia * wrench.angular,
        }
    }
}
