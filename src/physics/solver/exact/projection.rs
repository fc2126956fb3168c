//! Projection onto the joints: positions and velocities change least, in the metric of the masses, so that joints hold
//! to rounding.
//!
//! Positions: δ = M⁻¹Jᵀμ with J M⁻¹ Jᵀ μ = −C, iterated until C is zero to rounding (Newton's method on the group, with J
//! and its factor of the first iteration while that does: the error is small when it starts). Velocities:
//! v −= M⁻¹Jᵀ(J M⁻¹ Jᵀ)⁻¹ J v.

use nalgebra::{Matrix3, Vector3};

use super::constants::{
    JOINT_ROUNDING, LOOSE, PROJECTED_TURN, PROJECTION_ITERATIONS, SHORTEST_SHARE, SLOW_PROJECTION, STALE_ROWS,
    STUCK_PROJECTION,
};
use super::mechanism::{Mechanism, MemberState};
use super::rows::{InverseMass, MechanismRows, SpatialVector, place_arms};

/// The rows and the buffers.
#[derive(Clone, Debug, Default)]
pub(crate) struct JointProjection {
    pub rows: MechanismRows,
    rotations: Vec<Matrix3<f64>>,
    errors: Vec<Vector3<f64>>,
    forces: Vec<Vector3<f64>>,
    moved: Vec<SpatialVector>,
    /// Displacement of members since the rows were factored, m or rad.
    displaced: f64,
    /// The states before an iteration.
    before: Vec<MemberState>,
}

/// The errors of all joints.
#[derive(Clone, Copy, Debug)]
pub(super) struct JointErrors {
    /// The largest, m, along an axis.
    pub largest: f64,
    /// What rounding may leave of it, m.
    pub rounding: f64,
    /// Σ |C|².
    square: f64,
}

impl JointProjection {
    /// Arms, inverse masses and the factor at the present pose.
    pub fn assemble(&mut self, mechanism: &Mechanism) {
        self.displaced = 0.0;
        self.set_arms(mechanism);
        self.rows.inverse_masses.clear();
        for (member, rotation) in mechanism.members.iter().zip(&self.rotations) {
            let inverse_mass =
                InverseMass { linear: member.inverse_mass, angular: member.inverse_inertia(rotation, None) };
            self.rows.inverse_masses.push(inverse_mass);
        }
        self.rows.assemble(mechanism, PROJECTED_TURN, |_, _| Matrix3::from_diagonal_element(LOOSE));
    }

    fn set_arms(&mut self, mechanism: &Mechanism) {
        self.rotations.clear();
        self.rotations.extend(mechanism.states.iter().map(|state| state.rotation.to_rotation_matrix().into_inner()));
        place_arms(mechanism, &self.rotations, &mut self.rows.arms);
    }

    /// Positions and linear velocities of a tree from its rotations and angular velocities; the centre of mass of a tree
    /// that nothing holds stays.
    fn follow(&mut self, mechanism: &mut Mechanism) {
        let Mechanism { members, links, states, tree, moving, .. } = mechanism;
        let Some(tree) = tree.as_ref() else { return };
        let floats = tree.len() < *moving;
        let mean = |states: &[MemberState]| {
            let mut sum = (0.0, Vector3::zeros(), Vector3::zeros());
            for (member, state) in members.iter().zip(states).take(*moving) {
                sum.0 += member.mass;
                sum.1 += state.position * member.mass;
                sum.2 += state.linear * member.mass;
            }
            (sum.1 / sum.0, sum.2 / sum.0)
        };
        let before = if floats { mean(states) } else { Default::default() };
        for &(link, end) in tree {
            let link = &links[link as usize];
            let ends = [(link.a, &link.anchor_a), (link.b, &link.anchor_b)];
            let ((near, near_anchor), (far, far_anchor)) = (ends[end], ends[1 - end]);
            let (near, arms) = {
                let near = states[near as usize];
                (near, [near.rotation * near_anchor, states[far as usize].rotation * far_anchor])
            };
            let far = &mut states[far as usize];
            far.position = near.position + (arms[0] - arms[1]);
            far.linear = near.linear + near.angular.cross(&arms[0]) - far.angular.cross(&arms[1]);
        }
        if floats {
            let after = mean(states);
            for state in &mut states[..*moving] {
                state.position += before.0 - after.0;
                state.linear += before.1 - after.1;
            }
        }
    }

    /// Projects positions and velocities. The largest error of a joint that is left, m.
    pub fn project(&mut self, mechanism: &mut Mechanism) -> f64 {
        if mechanism.tree.is_some() {
            self.follow(mechanism);
            return 0.0;
        }
        self.assemble(mechanism);
        let left = self.project_positions(mechanism);
        if self.displaced > STALE_ROWS {
            self.assemble(mechanism);
        }
        self.project_velocities(mechanism);
        left
    }

    /// The largest error that is left, m. A displacement that does not lessen the errors is halved: a chain that is almost
    /// straight shortens with the square of its bends, which a linear step misses by far.
    fn project_positions(&mut self, mechanism: &mut Mechanism) -> f64 {
        let mut left = self.find_errors(mechanism);
        let mut is_fresh = true;
        for _ in 0..PROJECTION_ITERATIONS {
            if left.largest <= left.rounding {
                break;
            }
            self.rows.solve_once(mechanism, &mut self.errors);
            self.rows.respond(mechanism, &self.errors, &mut self.moved);
            self.before.clone_from(&mechanism.states);
            let mut share = 1.0;
            let found = loop {
                self.displace(mechanism, share);
                let found = self.find_errors(mechanism);
                if found.square < left.square || share < SHORTEST_SHARE {
                    break found;
                }
                share *= 0.5;
                mechanism.states.clone_from(&self.before);
            };
            let is_less = found.square < left.square;
            let kept = if is_less { (found.square / left.square).sqrt() } else { 1.0 };
            if is_less {
                left = found;
                let most = self.moved.iter().map(|moved| moved.linear.amax().max(moved.angular.amax()));
                self.displaced += share * most.fold(0.0, f64::max);
            } else {
                mechanism.states.clone_from(&self.before);
                self.set_arms(mechanism);
                self.find_errors(mechanism);
            }
            if is_fresh && kept > STUCK_PROJECTION {
                break;
            }
            is_fresh = kept > SLOW_PROJECTION || share < 1.0;
            if is_fresh {
                self.assemble(mechanism);
            }
        }
        left.largest
    }

    /// Moves members by that share of the displacement found.
    fn displace(&mut self, mechanism: &mut Mechanism, share: f64) {
        for (state, moved) in mechanism.states.iter_mut().zip(&self.moved) {
            if moved.linear != Vector3::zeros() || moved.angular != Vector3::zeros() {
                state.position += moved.linear * share;
                state.turn(&(moved.angular * share));
            }
        }
        self.set_arms(mechanism);
    }

    /// −C of all links at the present pose.
    pub fn errors_of(&mut self, mechanism: &Mechanism, errors: &mut Vec<Vector3<f64>>) -> JointErrors {
        self.set_arms(mechanism);
        let found = self.find_errors(mechanism);
        errors.clone_from(&self.errors);
        found
    }

    /// −C of all links, arms being those of the present pose.
    fn find_errors(&mut self, mechanism: &Mechanism) -> JointErrors {
        self.errors.clear();
        let mut gaps = JointErrors { largest: 0.0, rounding: 0.0, square: 0.0 };
        for (link, [arm_a, arm_b]) in mechanism.links.iter().zip(&self.rows.arms) {
            if link.spring.is_some() {
                self.errors.push(Vector3::zeros());
                continue;
            }
            let (a, b) = (&mechanism.states[link.a as usize], &mechanism.states[link.b as usize]);
            let error = a.position - b.position + (arm_a - arm_b);
            gaps.largest = gaps.largest.max(error.amax());
            gaps.rounding = gaps.rounding.max(JOINT_ROUNDING * (arm_a.amax() + arm_b.amax() + a.position.amax()));
            gaps.square += error.norm_squared();
            self.errors.push(error);
        }
        gaps
    }

    /// Impulses of the last [`Self::project_velocities`], N·s on B of each link.
    pub fn impulses(&self) -> &[Vector3<f64>] {
        &self.forces
    }

    /// Projects velocities, with the rows of [`Self::assemble`].
    pub fn project_velocities(&mut self, mechanism: &mut Mechanism) {
        self.moved.clear();
        let velocities =
            mechanism.states.iter().map(|state| SpatialVector { linear: state.linear, angular: state.angular });
        self.moved.extend(velocities);
        self.errors.clear();
        for (index, link) in mechanism.links.iter().enumerate() {
            let error = -self.rows.relative(index, link.a, link.b, &self.moved);
            self.errors.push(if link.spring.is_some() { Vector3::zeros() } else { error });
        }
        self.rows.solve(mechanism, &self.errors, &mut self.forces);
        self.rows.respond(mechanism, &self.forces, &mut self.moved);
        for (state, gained) in mechanism.states.iter_mut().zip(&self.moved) {
            state.linear += gained.linear;
            state.angular += gained.angular;
        }
    }
}
