//! Nonlinear projection: poses moved onto C = 0 by Newton's method.
//!
//! Each iteration solves (J M⁻¹ Jᵀ) μ = −C and moves by M⁻¹ Jᵀ μ, the shortest way in the metric of
//! the masses. J stays that of the factorisation (simplified Newton): the residual shrinks by the
//! rotation since then, a factor of about hω per iteration, and quadratically in its own size.
//! Only arms and separations enter, so that a scene far from the origin loses no digits.

use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use super::constants::STEP_LENGTHS;
use super::tree::{Displacement, JointTree};
use crate::physics::constraint::row::Twist;

/// How a body is moved: x ← x + `linear`, q ← `rotation` q.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PoseChange {
    pub linear: Vector3<f64>,
    pub rotation: UnitQuaternion<f64>,
}

impl JointTree {
    /// Finds pose changes that close `separations` (C = x_b + r_b − x_a − r_a per joint, local
    /// order, m, at the arms set), in at most that many iterations or until none is over
    /// `tolerance`, m. Returns the largest separation left. Needs [`Self::factor`], from these arms or a little
    /// earlier ones.
    pub fn project_positions(&mut self, separations: &[Vector3<f64>], iterations: usize, tolerance: f64) -> f64 {
        self.displacements.fill(Displacement::default());
        let mut worst: f64 = 0.0;
        for ((joint, separation), unknown) in self.joints.iter().zip(separations).zip(&mut self.unknowns) {
            *unknown = separation * -joint.sign;
            worst = worst.max(separation.norm_squared());
        }
        worst = worst.sqrt();
        for _ in 0..iterations {
            if worst <= tolerance {
                break;
            }
            self.substitute();
            self.gather_wrenches();
            self.earlier.copy_from_slice(&self.displacements);
            self.step();
            let mut share = 1.0;
            let mut left = f64::INFINITY;
            // Newton's direction closes joints, but its length may be too great. Where no pose closes
            // them, no length helps.
            for _ in 0..STEP_LENGTHS {
                self.advance(share);
                left = self.separations_left(separations);
                if left < worst {
                    break;
                }
                share *= 0.5;
            }
            if left.is_nan() || left >= worst {
                self.advance(0.0);
                break;
            }
            worst = left;
        }
        worst
    }

    /// What [`Self::project_positions`] found, per moving body in local order.
    pub fn pose_changes(&self) -> impl Iterator<Item = PoseChange> + '_ {
        let moving = self.displacements[..self.moving].iter();
        moving.map(|displacement| PoseChange {
            linear: displacement.linear,
            rotation: UnitQuaternion::new_normalize(displacement.rotation),
        })
    }

    /// Puts −C into the unknowns; the largest |C|.
    fn separations_left(&mut self, separations: &[Vector3<f64>]) -> f64 {
        let mut largest: f64 = 0.0;
        for ((joint, separation), unknown) in self.joints.iter().zip(separations).zip(&mut self.unknowns) {
            let child = self.displacements[joint.child as usize].shift_of(&joint.arm_child);
            let parent = self.displacements[joint.parent as usize].shift_of(&joint.arm_parent);
            *unknown = parent - child - separation * joint.sign;
            largest = largest.max(unknown.norm_squared());
        }
        largest.sqrt()
    }

    /// Turns the wrenches into the step M⁻¹ Jᵀ μ.
    fn step(&mut self) {
        for (wrench, inertia) in self.wrenches.iter_mut().zip(&self.inertias) {
            *wrench = inertia.response(wrench);
        }
    }

    /// Moves by that share of the step from where the iteration began.
    fn advance(&mut self, share: f64) {
        for ((step, earlier), displacement) in self.wrenches.iter().zip(&self.earlier).zip(&mut self.displacements) {
            *displacement = earlier.then(step, share);
        }
    }
}

impl Displacement {
    /// Turned by the unit quaternion along (1, ½θ), which differs from exp(θ) in third order.
    fn then(&self, step: &Twist<f64>, share: f64) -> Self {
        let turn = Quaternion::from_parts(1.0, step.angular * (0.5 * share));
        Self { linear: self.linear + step.linear * share, rotation: turn * self.rotation / turn.norm() }
    }

    /// How far the end of that arm has moved: the translation and 2 v × (w r + v × r).
    fn shift_of(&self, arm: &Vector3<f64>) -> Vector3<f64> {
        let (w, v) = (self.rotation.w, self.rotation.imag());
        self.linear + v.cross(&(arm * w + v.cross(arm))) * 2.0
    }
}
