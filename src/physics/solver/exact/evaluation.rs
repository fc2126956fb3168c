//! Joint forces at one state: M a = F − (0, ω × I ω) + Jᵀλ with J a + J̇ v = 0, so that
//! J M⁻¹ Jᵀ λ = −J M⁻¹(F − (0, ω × I ω)) − J̇ v, J̇ v = ω_B × (ω_B × r_B) − ω_A × (ω_A × r_A).

use nalgebra::{Matrix3, Vector3};

use super::mechanism::{Link, Mechanism, Motion, stretch};
use super::rows::{Rows, Screw, Weight};

/// Buffers, and what the last evaluation found.
#[derive(Clone, Debug, Default)]
pub(crate) struct Evaluation {
    pub rows: Rows,
    /// λ of each link.
    pub forces: Vec<Vector3<f64>>,
    /// Acceleration of each member without joint forces.
    accelerations: Vec<Screw>,
    rotations: Vec<Matrix3<f64>>,
    wrenches: Vec<Screw>,
    right: Vec<Vector3<f64>>,
}

impl Evaluation {
    /// At a state of the mechanism's members, for a step of h, s.
    pub fn evaluate(&mut self, mechanism: &Mechanism, motion: &[Motion], h: f64) {
        self.assemble(mechanism, motion, h);
        self.find_wrenches(mechanism, motion);
        self.accelerations.clear();
        self.accelerations
            .extend(self.wrenches.iter().zip(&self.rows.weights).map(|(wrench, weight)| weight.of(wrench)));
        self.right.clear();
        for (index, (link, [arm_a, arm_b])) in mechanism.links.iter().zip(&self.rows.arms).enumerate() {
            let swirl = |member: u32, arm: &Vector3<f64>| {
                let omega = &motion[member as usize].angular;
                omega.cross(&omega.cross(arm))
            };
            let gain = self.rows.relative(index, link.a, link.b, &self.accelerations);
            let right = -gain - (swirl(link.b, arm_b) - swirl(link.a, arm_a));
            self.right.push(if link.spring.is_some() { Vector3::zeros() } else { right });
        }
        self.rows.solve(mechanism, &self.right, &mut self.forces);
        for (index, link) in mechanism.links.iter().enumerate().filter(|(_, link)| link.spring.is_some()) {
            self.forces[index] = pull(link, index, motion, &self.rows);
        }
    }

    /// Arms, weights and the factor at a state.
    pub fn assemble(&mut self, mechanism: &Mechanism, motion: &[Motion], h: f64) {
        self.rotations.clear();
        self.rotations.extend(motion.iter().map(|motion| motion.rotation.to_rotation_matrix().into_inner()));
        self.rows.arms.clear();
        for Link { a, b, anchor_a, anchor_b, .. } in &mechanism.links {
            self.rows.arms.push([self.rotations[*a as usize] * anchor_a, self.rotations[*b as usize] * anchor_b]);
        }
        self.rows.weights.clear();
        for (member, rotation) in mechanism.members.iter().zip(&self.rotations) {
            let weight = Weight { linear: member.inverse_mass, angular: member.inverse_inertia(rotation, None) };
            self.rows.weights.push(weight);
        }
        let turn = h * motion.iter().fold(0.0, |most: f64, motion| most.max(motion.angular.norm_squared())).sqrt();
        self.rows.assemble(mechanism, turn, |_, _| Vector3::repeat(super::projection::LOOSE));
    }

    /// F less the gyroscopic torque and drag.
    fn find_wrenches(&mut self, mechanism: &Mechanism, motion: &[Motion]) {
        self.wrenches.clear();
        for ((member, motion), rotation) in mechanism.members.iter().zip(motion).zip(&self.rotations) {
            if !member.moves() {
                self.wrenches.push(Screw::ZERO);
                continue;
            }
            let spin = rotation.tr_mul(&motion.angular);
            let momentum = member.inertia.component_mul(&spin);
            let force = member.force - motion.linear * (member.mass * member.drag.0);
            let torque = member.torque - rotation * (spin.cross(&momentum) + momentum * member.drag.1);
            self.wrenches.push(Screw { linear: force, angular: torque });
        }
        if mechanism.gives {
            // What springs do counts as given to the rows of the other links.
            self.forces.clear();
            let links = mechanism.links.iter().enumerate();
            self.forces.extend(links.map(|(index, link)| pull(link, index, motion, &self.rows)));
            self.rows.add_wrenches(mechanism, &self.forces, &mut self.wrenches);
        }
    }
}

/// Force of a spring on its B, N.
fn pull(link: &Link, index: usize, motion: &[Motion], rows: &Rows) -> Vector3<f64> {
    let Some(spring) = &link.spring else { return Vector3::zeros() };
    let [apart, speed] = stretch(link, &rows.arms[index], motion);
    spring.give(&spring.ask(&apart, &speed), &rows.mobility[index])
}
