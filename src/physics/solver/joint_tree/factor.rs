//! The block L D Lᵀ of J M⁻¹ Jᵀ, and its two substitutions.

use nalgebra::{Matrix3, Vector3};

use super::constants::LEAST_PIVOT;
use super::tree::{Branch, Hub, JointTree, NONE, TreeInertia};
use crate::physics::constraint::row::Twist;

impl JointTree {
    /// Factors J M⁻¹ Jᵀ for the inertias and arms set.
    pub fn factor(&mut self) {
        for hub in &mut self.hubs {
            hub.reset(&self.inertias[hub.body as usize]);
        }
        for index in 0..self.joints.len() {
            self.assemble(index);
        }
        for index in 0..self.joints.len() {
            let (before, after) = self.joints.split_at_mut(index + 1);
            let joint = &mut before[index];
            if joint.child_hub != NONE {
                let hub = &self.hubs[joint.child_hub as usize];
                let (linear, angular) = hub.columns(&joint.arm_child);
                joint.pivot += linear - cross_columns(&joint.arm_child, &angular);
            }
            if joint.branch != NONE {
                let branch = &mut self.branches[joint.branch as usize];
                let hub = &mut self.hubs[branch.hub as usize];
                (branch.linear, branch.angular) = hub.columns(&joint.arm_parent);
                joint.pivot += branch.linear - cross_columns(&joint.arm_parent, &branch.angular);
                joint.pivot = inverse(&joint.pivot, &joint.scale);
                hub.take_away(branch, &joint.pivot);
                continue;
            }
            joint.pivot = inverse(&joint.pivot, &joint.scale);
            if joint.next != NONE {
                let coupling = joint.coupling;
                joint.coupling = product(&coupling, &joint.pivot);
                after[(joint.next as usize) - index - 1].pivot -= product(&joint.coupling, &coupling.transpose());
            }
        }
    }

    /// The joint's blocks of J M⁻¹ Jᵀ; hubs add theirs when their N is known.
    fn assemble(&mut self, index: usize) {
        let joint = &self.joints[index];
        let mut diagonal = Matrix3::zeros();
        let mut scale = Vector3::zeros();
        let mut coupling = Matrix3::zeros();
        if let Some(child) = self.inertias.get(joint.child as usize) {
            let block = child.between(&joint.arm_child, &joint.arm_child);
            scale += block.diagonal();
            if joint.child_hub == NONE {
                diagonal += block;
            }
        }
        let parent = &self.inertias[joint.parent as usize];
        let block = parent.between(&joint.arm_parent, &joint.arm_parent);
        scale += block.diagonal();
        if joint.branch == NONE {
            diagonal += block;
        }
        if joint.next != NONE {
            let next = &self.joints[joint.next as usize];
            // J has opposite signs on a joint's two bodies.
            coupling = if joint.next_is_sibling {
                parent.between(&next.arm_parent, &joint.arm_parent)
            } else {
                -parent.between(&next.arm_child, &joint.arm_parent)
            };
        }
        let joint = &mut self.joints[index];
        (joint.pivot, joint.scale, joint.coupling) = (diagonal, scale, coupling);
    }

    /// Solves for the unknowns, right-hand side in, solution out.
    pub(super) fn substitute(&mut self) {
        for hub in &mut self.hubs {
            hub.passing = Twist::zero();
        }
        for index in 0..self.joints.len() {
            self.forward(index);
        }
        for hub in &mut self.hubs {
            hub.passing = Twist::zero();
        }
        for index in (0..self.joints.len()).rev() {
            self.backward(index);
        }
    }

    /// L y = c, row by row.
    fn forward(&mut self, index: usize) {
        let joint = &self.joints[index];
        let mut known = self.unknowns[index];
        if joint.child_hub != NONE {
            known -= self.hubs[joint.child_hub as usize].passing_at(&joint.arm_child);
        }
        if joint.branch != NONE {
            let branch = &self.branches[joint.branch as usize];
            let hub = &mut self.hubs[branch.hub as usize];
            known += hub.passing_at(&joint.arm_parent);
            let impulse = joint.pivot * known;
            hub.passing.linear -= branch.linear * impulse;
            hub.passing.angular -= branch.angular * impulse;
        } else if joint.next != NONE {
            self.unknowns[joint.next as usize] -= joint.coupling * known;
        }
        self.unknowns[index] = known;
    }

    /// D Lᵀ λ = y, row by row.
    fn backward(&mut self, index: usize) {
        let joint = &self.joints[index];
        let mut impulse = joint.pivot * self.unknowns[index];
        if joint.branch != NONE {
            let branch = &self.branches[joint.branch as usize];
            let later = &mut self.hubs[branch.hub as usize].passing;
            let motion = branch.linear.tr_mul(&later.linear) + branch.angular.tr_mul(&later.angular);
            impulse += joint.pivot * motion;
            later.linear -= impulse;
            later.angular -= joint.arm_parent.cross(&impulse);
        } else if joint.next != NONE {
            impulse -= joint.coupling.tr_mul(&self.unknowns[joint.next as usize]);
        }
        if joint.child_hub != NONE {
            let angular = joint.arm_child.cross(&impulse);
            self.hubs[joint.child_hub as usize].passing = Twist { linear: impulse, angular };
        }
        self.unknowns[index] = impulse;
    }
}

impl TreeInertia {
    /// m⁻¹ − [a]× I⁻¹ [b]×: the velocity at arm a per impulse at arm b.
    pub(super) fn between(&self, a: &Vector3<f64>, b: &Vector3<f64>) -> Matrix3<f64> {
        let turned = cross_columns(a, &self.inverse_inertia);
        let mut block = cross_columns(b, &turned.transpose()).transpose();
        for axis in 0..3 {
            block[(axis, axis)] += self.inverse_mass[axis];
        }
        block
    }
}

impl Hub {
    fn reset(&mut self, inertia: &TreeInertia) {
        self.linear = Matrix3::from_diagonal(&inertia.inverse_mass);
        self.mixed = Matrix3::zeros();
        self.angular = inertia.inverse_inertia;
    }

    /// N [1; [r]×]: the motion per impulse at arm r.
    fn columns(&self, arm: &Vector3<f64>) -> (Matrix3<f64>, Matrix3<f64>) {
        (self.linear - cross_rows(&self.mixed, arm), self.mixed.transpose() - cross_rows(&self.angular, arm))
    }

    /// N ← N − K D⁻¹ Kᵀ.
    fn take_away(&mut self, branch: &Branch, inverse_pivot: &Matrix3<f64>) {
        let linear = product(&branch.linear, inverse_pivot);
        let angular = product(&branch.angular, inverse_pivot);
        let (linear_rows, angular_rows) = (branch.linear.transpose(), branch.angular.transpose());
        self.linear -= product(&linear, &linear_rows);
        self.mixed -= product(&linear, &angular_rows);
        self.angular -= product(&angular, &angular_rows);
    }

    /// Velocity at that arm of the motion that passes.
    fn passing_at(&self, arm: &Vector3<f64>) -> Vector3<f64> {
        self.passing.linear + self.passing.angular.cross(arm)
    }
}

/// A B, with fused multiply–adds.
pub(super) fn product(a: &Matrix3<f64>, b: &Matrix3<f64>) -> Matrix3<f64> {
    Matrix3::from_fn(|row, column| {
        let sum = a[(row, 0)].mul_add(b[(0, column)], a[(row, 1)] * b[(1, column)]);
        a[(row, 2)].mul_add(b[(2, column)], sum)
    })
}

/// [r]× M.
#[inline(always)]
pub(crate) fn cross_columns(r: &Vector3<f64>, m: &Matrix3<f64>) -> Matrix3<f64> {
    Matrix3::from_columns(&[r.cross(&m.column(0)), r.cross(&m.column(1)), r.cross(&m.column(2))])
}

/// −M [r]×: each row of M crossed with −r, that is r × row.
#[inline(always)]
pub(crate) fn cross_rows(m: &Matrix3<f64>, r: &Vector3<f64>) -> Matrix3<f64> {
    cross_columns(r, &m.transpose()).transpose()
}

/// Inverse of a symmetric positive semidefinite block by L D Lᵀ. Pivots that are rounding
/// error next to `scale` count as zero, and so do their inverses: a solution that leaves out
/// redundant rows.
fn inverse(block: &Matrix3<f64>, scale: &Vector3<f64>) -> Matrix3<f64> {
    let reciprocal = |pivot: f64, scale: f64| if pivot > LEAST_PIVOT * scale { 1.0 / pivot } else { 0.0 };
    let d1 = reciprocal(block.m11, scale.x);
    let l21 = block.m21 * d1;
    let l31 = block.m31 * d1;
    let d2 = reciprocal(block.m22 - l21 * block.m21, scale.y);
    let below = block.m32 - l31 * block.m21;
    let l32 = below * d2;
    let d3 = reciprocal(block.m33 - l31 * block.m31 - l32 * below, scale.z);
    let i31 = l21 * l32 - l31;
    let m33 = d3;
    let m32 = -l32 * d3;
    let m31 = i31 * d3;
    let m22 = d2 - l32 * m32;
    let m21 = -l21 * d2 - l32 * m31;
    let m11 = d1 + l21 * l21 * d2 + i31 * m31;
    Matrix3::new(m11, m21, m31, m21, m22, m32, m31, m32, m33)
}
