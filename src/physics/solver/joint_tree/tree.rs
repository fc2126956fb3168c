//! One tree of joints: what is known of it, and its solve for velocities.

use nalgebra::{Matrix3, Quaternion, Vector3};

use crate::physics::constraint::row::{Twist, Wrench};

/// No joint, no hub.
pub(super) const NONE: u32 = u32::MAX;

/// One component: its moving bodies form a tree. Bodies and joints have local indices: bodies the
/// moving ones first, joints in the order of elimination.
#[derive(Clone, Debug, Default)]
pub(crate) struct JointTree {
    /// The caller's index of each body; one that does not move appears once per joint to it.
    pub(super) bodies: Vec<u32>,
    pub(super) moving: usize,
    /// The caller's index of each joint.
    pub(super) sources: Vec<u32>,
    pub(super) inertias: Vec<TreeInertia>,
    pub(super) joints: Vec<TreeJoint>,
    pub(super) hubs: Vec<Hub>,
    pub(super) branches: Vec<Branch>,
    /// Right-hand side, then solution, per joint.
    pub(super) unknowns: Vec<Vector3<f64>>,
    /// Jᵀ of the solution, per moving body.
    pub(super) wrenches: Vec<Wrench<f64>>,
    /// Of the projection under way, per body, and before its present iteration.
    pub(super) displacements: Vec<Displacement>,
    pub(super) earlier: Vec<Displacement>,
    /// What is left of each moving body's angular velocity after a substep's damping.
    pub(super) dampings: Vec<Matrix3<f64>>,
    pub(super) may_be_redundant: bool,
}

/// A change of pose under way; bodies that do not move keep the identity.
#[derive(Clone, Copy, Debug)]
pub(super) struct Displacement {
    pub(super) linear: Vector3<f64>,
    pub(super) rotation: Quaternion<f64>,
}

impl Default for Displacement {
    fn default() -> Self {
        Self { linear: Vector3::zeros(), rotation: Quaternion::identity() }
    }
}

/// Inverse mass of a body, world axes.
#[derive(Clone, Copy, Debug)]
pub(super) struct TreeInertia {
    pub(super) inverse_mass: Vector3<f64>,
    pub(super) inverse_inertia: Matrix3<f64>,
}

/// One joint, from the body nearer the root (parent, a in J) to the other (child, b in J).
#[derive(Clone, Debug)]
pub(super) struct TreeJoint {
    pub(super) child: u32,
    pub(super) parent: u32,
    /// Joint that the parent, a link, couples this one to; NONE: no later one.
    pub(super) next: u32,
    /// The parent's other joint leads to a sibling of the child, not to the grandparent.
    pub(super) next_is_sibling: bool,
    /// NONE: the child is no hub.
    pub(super) child_hub: u32,
    /// Index into the branches; NONE: the parent is no hub.
    pub(super) branch: u32,
    /// −1 where the caller's b is the parent.
    pub(super) sign: f64,
    pub(super) arm_child: Vector3<f64>,
    pub(super) arm_parent: Vector3<f64>,
    /// D, then D⁻¹.
    pub(super) pivot: Matrix3<f64>,
    /// E, then L = E D⁻¹.
    pub(super) coupling: Matrix3<f64>,
    /// Diagonal of J M⁻¹ Jᵀ: what the pivot is measured against.
    pub(super) scale: Vector3<f64>,
    pub(super) impulse: Vector3<f64>,
}

/// A body with more than two joints.
#[derive(Clone, Debug)]
pub(super) struct Hub {
    pub(super) body: u32,
    /// N = [[linear, mixed], [mixedᵀ, angular]].
    pub(super) linear: Matrix3<f64>,
    pub(super) mixed: Matrix3<f64>,
    pub(super) angular: Matrix3<f64>,
    /// Forward: motion by the joints eliminated so far. Backward: impulse of the joints after.
    pub(super) passing: Twist<f64>,
}

/// A joint whose parent is a hub.
#[derive(Clone, Debug)]
pub(super) struct Branch {
    pub(super) hub: u32,
    /// K = N Jᵀ, linear and angular rows.
    pub(super) linear: Matrix3<f64>,
    pub(super) angular: Matrix3<f64>,
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
        self.inertias[body] = TreeInertia { inverse_mass, inverse_inertia };
    }

    /// Arms from the centres of mass of the caller's a and b, world axes, m.
    pub fn set_arms(&mut self, joint: usize, arm_a: Vector3<f64>, arm_b: Vector3<f64>) {
        let joint = &mut self.joints[joint];
        (joint.arm_parent, joint.arm_child) = if joint.sign > 0.0 { (arm_a, arm_b) } else { (arm_b, arm_a) };
    }

    /// Accumulated impulse on the caller's b, N s.
    pub fn impulse(&self, joint: usize) -> Vector3<f64> {
        self.joints[joint].impulse * self.joints[joint].sign
    }

    /// Sets the accumulated impulse; it is not applied.
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

    /// Whether some arm turns faster than that, rad/s, at those velocities (local order).
    pub fn turns_arms_beyond(&self, most: f64, twists: &[Twist<f64>]) -> bool {
        let square = most * most;
        // No arm turns faster than its body.
        if twists.iter().all(|twist| twist.angular.norm_squared() <= square) {
            return false;
        }
        let turning = |body: u32, arm: &Vector3<f64>| {
            twists[body as usize].angular.cross(arm).norm_squared() > square * arm.norm_squared()
        };
        self.joints
            .iter()
            .any(|joint| turning(joint.child, &joint.arm_child) || turning(joint.parent, &joint.arm_parent))
    }

    /// Changes velocities (local order) so that every joint's relative velocity J V is its
    /// target; `targets` in m/s, b relative to a, empty for all zero. Needs [`Self::factor`].
    pub fn solve_velocities(&mut self, twists: &mut [Twist<f64>], targets: &[Vector3<f64>]) {
        for (joint, unknown) in self.joints.iter().zip(&mut self.unknowns) {
            let (child, parent) = (&twists[joint.child as usize], &twists[joint.parent as usize]);
            let relative = child.linear + child.angular.cross(&joint.arm_child)
                - parent.linear
                - parent.angular.cross(&joint.arm_parent);
            *unknown = -relative;
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
    pub(super) fn gather_wrenches(&mut self) {
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

impl TreeInertia {
    pub(super) const FIXED: Self = Self {
        inverse_mass: Vector3::new(0.0, 0.0, 0.0),
        inverse_inertia: Matrix3::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
    };

    /// M⁻¹ times an impulse.
    pub(super) fn response(&self, wrench: &Wrench<f64>) -> Twist<f64> {
        Twist {
            linear: wrench.linear.component_mul(&self.inverse_mass),
            angular: self.inverse_inertia * wrench.angular,
        }
    }
}
