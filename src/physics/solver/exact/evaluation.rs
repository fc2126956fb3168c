//! Joint forces at one state: M a = F − (0, ω × I ω) + Jᵀλ with J a + J̇ v = 0, so that
//! J M⁻¹ Jᵀ λ = −J M⁻¹(F − (0, ω × I ω)) − J̇ v, J̇ v = ω_B × (ω_B × r_B) − ω_A × (ω_A × r_A).

use nalgebra::{Matrix3, Vector3};

use super::constants::LOOSE;
use super::mechanism::{Mechanism, MechanismLink, MemberState, stretch};
use super::rows::{InverseMass, MechanismRows, SpatialVector, place_arms};

/// The last evaluation, and its buffers.
#[derive(Clone, Debug, Default)]
pub(crate) struct Evaluation {
    pub rows: MechanismRows,
    /// λ of each link.
    pub forces: Vec<Vector3<f64>>,
    /// Acceleration of each member without joint forces.
    accelerations: Vec<SpatialVector>,
    rotations: Vec<Matrix3<f64>>,
    wrenches: Vec<SpatialVector>,
    right: Vec<Vector3<f64>>,
}

impl Evaluation {
    /// Evaluates the forces at states of the members, for a step of h, s.
    pub fn evaluate(&mut self, mechanism: &Mechanism, states: &[MemberState], h: f64) {
        self.assemble(mechanism, states, h);
        self.find_wrenches(mechanism, states);
        self.accelerations.clear();
        self.accelerations.extend(
            self.wrenches.iter().zip(&self.rows.inverse_masses).map(|(wrench, inverse_mass)| inverse_mass.of(wrench)),
        );
        self.right.clear();
        for (index, (link, [arm_a, arm_b])) in mechanism.links.iter().zip(&self.rows.arms).enumerate() {
            let swirl = |member: u32, arm: &Vector3<f64>| {
                let omega = &states[member as usize].angular;
                omega.cross(&omega.cross(arm))
            };
            let gain = self.rows.relative(index, link.a, link.b, &self.accelerations);
            let right = -gain - (swirl(link.b, arm_b) - swirl(link.a, arm_a));
            self.right.push(if link.spring.is_some() { Vector3::zeros() } else { right });
        }
        self.rows.solve(mechanism, &self.right, &mut self.forces);
        for (index, link) in mechanism.links.iter().enumerate().filter(|(_, link)| link.spring.is_some()) {
            self.forces[index] = spring_force(link, index, states, &self.rows);
        }
    }

    /// Arms, inverse masses and the factor at those states.
    pub fn assemble(&mut self, mechanism: &Mechanism, states: &[MemberState], h: f64) {
        self.rotations.clear();
        self.rotations.extend(states.iter().map(|state| state.rotation.to_rotation_matrix().into_inner()));
        place_arms(mechanism, &self.rotations, &mut self.rows.arms);
        self.rows.inverse_masses.clear();
        for (member, rotation) in mechanism.members.iter().zip(&self.rotations) {
            let inverse_mass =
                InverseMass { linear: member.inverse_mass, angular: member.inverse_inertia(rotation, None) };
            self.rows.inverse_masses.push(inverse_mass);
        }
        let turn = h * states.iter().fold(0.0, |most: f64, state| most.max(state.angular.norm_squared())).sqrt();
        self.rows.assemble(mechanism, turn, |_, _| Matrix3::from_diagonal_element(LOOSE));
    }

    /// F less the gyroscopic torque and drag.
    fn find_wrenches(&mut self, mechanism: &Mechanism, states: &[MemberState]) {
        self.wrenches.clear();
        for ((member, state), rotation) in mechanism.members.iter().zip(states).zip(&self.rotations) {
            if !member.moves() {
                self.wrenches.push(SpatialVector::ZERO);
                continue;
            }
            let spin = rotation.tr_mul(&state.angular);
            let momentum = member.inertia.component_mul(&spin);
            let force = member.force - state.linear * (member.mass * member.drag.0);
            let torque = member.torque - rotation * (spin.cross(&momentum) + momentum * member.drag.1);
            self.wrenches.push(SpatialVector { linear: force, angular: torque });
        }
        if mechanism.gives {
            // The forces of springs are given to the rows of the other links.
            self.forces.clear();
            let links = mechanism.links.iter().enumerate();
            self.forces.extend(links.map(|(index, link)| spring_force(link, index, states, &self.rows)));
            self.rows.add_wrenches(mechanism, &self.forces, &mut self.wrenches);
        }
    }
}

/// Force of a spring on B, N.
fn spring_force(link: &MechanismLink, index: usize, states: &[MemberState], rows: &MechanismRows) -> Vector3<f64> {
    let Some(spring) = &link.spring else { return Vector3::zeros() };
    let [apart, speed] = stretch(link, &rows.arms[index], states);
    spring.give(&spring.ask(&apart, &speed), &rows.mobility[index])
}
