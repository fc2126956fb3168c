//! Projection onto the joints: positions and velocities change least, in the metric of the masses, so that joints hold
//! to rounding.
//!
//! Positions: δ = M⁻¹Jᵀμ with J M⁻¹ Jᵀ μ = −C, iterated until C is zero to rounding (Newton's method on the group, with J
//! and its factor of the first iteration while that does: the error is small when it starts). Velocities:
//! v −= M⁻¹Jᵀ(J M⁻¹ Jᵀ)⁻¹ (J v + ∂C/∂t).

use nalgebra::Vector3;

use super::constants::{
    JOINT_ROUNDING, PROJECTED_TURN, PROJECTION_ITERATIONS, SHORTEST_SHARE, SLOW_PROJECTION, STALE_ROWS,
    STUCK_PROJECTION,
};
use super::mechanism::{Mechanism, MemberState, RowSpring};
use super::rows::{MechanismRows, add_wrenches};
use crate::physics::constraint::row::{Twist, Wrench};
use crate::physics::joint::JointRow;

/// The rows and the buffers.
#[derive(Clone, Debug, Default)]
pub(crate) struct JointProjection {
    /// At the present states.
    pub rows: Vec<JointRow<f64>>,
    pub system: MechanismRows,
    errors: Vec<f64>,
    /// λ of the last [`Self::project_velocities`], N·s or N·m·s.
    pub impulses: Vec<f64>,
    /// Those of springs in the last [`Self::kick`].
    pub pulls: Vec<f64>,
    moved: Vec<Twist<f64>>,
    /// Displacement of members since the rows were factored, m or rad.
    displaced: f64,
    /// The states before an iteration.
    before: Vec<MemberState>,
}

/// The errors of all joints.
#[derive(Clone, Copy, Debug)]
pub(super) struct JointErrors {
    /// The largest of a row, m or rad.
    pub largest: f64,
    /// What rounding may leave of it.
    pub rounding: f64,
    /// Σ C².
    square: f64,
}

impl JointProjection {
    /// Rows and their factor at the present states and that time, s.
    pub fn assemble(&mut self, mechanism: &Mechanism, time: f64) {
        mechanism.place_rows(&mechanism.states, time, &mut self.rows);
        self.factor(mechanism);
    }

    /// Factors the rows at hand.
    pub fn factor(&mut self, mechanism: &Mechanism) {
        self.displaced = 0.0;
        self.system.assemble_rigid(mechanism, &mechanism.states, &self.rows, PROJECTED_TURN);
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
            let ends = [(link.a, link.anchor(0)), (link.b, link.anchor(1))];
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

    /// Projects positions and velocities at that time, s. The largest error of a joint that is left, m or rad.
    pub fn project(&mut self, mechanism: &mut Mechanism, time: f64) -> f64 {
        if mechanism.tree.is_some() {
            self.follow(mechanism);
            return 0.0;
        }
        self.assemble(mechanism, time);
        let left = self.project_positions(mechanism, time);
        if self.displaced > STALE_ROWS {
            self.factor(mechanism);
        }
        self.project_velocities(mechanism);
        left
    }

    /// The largest error that is left, m or rad. A displacement that does not lessen the errors is halved: a chain that
    /// is almost straight shortens with the square of its bends, which a linear step misses by far.
    pub fn project_positions(&mut self, mechanism: &mut Mechanism, time: f64) -> f64 {
        let mut left = self.find_errors(mechanism);
        let mut is_fresh = true;
        for _ in 0..PROJECTION_ITERATIONS {
            if left.largest <= left.rounding {
                break;
            }
            self.system.solve_once(mechanism, &mut self.errors);
            self.system.respond(mechanism, &self.errors, &mut self.moved);
            self.before.clone_from(&mechanism.states);
            let mut share = 1.0;
            let found = loop {
                self.displace(mechanism, share);
                let found = self.errors_at(mechanism, time);
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
                self.errors_at(mechanism, time);
            }
            if is_fresh && kept > STUCK_PROJECTION {
                break;
            }
            is_fresh = kept > SLOW_PROJECTION || share < 1.0;
            if is_fresh {
                self.factor(mechanism);
            }
        }
        left.largest
    }

    /// Moves members by that share of the displacement found.
    fn displace(&self, mechanism: &mut Mechanism, share: f64) {
        for (state, moved) in mechanism.states.iter_mut().zip(&self.moved) {
            if moved.linear != Vector3::zeros() || moved.angular != Vector3::zeros() {
                state.position += moved.linear * share;
                state.turn(&(moved.angular * share));
            }
        }
    }

    /// The errors at the present states and that time, s.
    pub fn errors_at(&mut self, mechanism: &Mechanism, time: f64) -> JointErrors {
        mechanism.place_rows(&mechanism.states, time, &mut self.rows);
        self.system.set_jacobians(&self.rows);
        self.find_errors(mechanism)
    }

    /// −C of all rows of the last errors; zero of springs.
    pub fn errors(&self) -> &[f64] {
        &self.errors
    }

    fn find_errors(&mut self, mechanism: &Mechanism) -> JointErrors {
        self.errors.clear();
        let mut found = JointErrors { largest: 0.0, rounding: 0.0, square: 0.0 };
        for link in &mechanism.links {
            let mut only_turns = true;
            for row in &self.rows[link.rows.clone()] {
                let error = if row.spring.is_some() || row.given().is_some() { 0.0 } else { -row.error };
                found.largest = found.largest.max(error.abs());
                found.square += error * error;
                only_turns &= row.only_turns();
                self.errors.push(error);
            }
            let [a, b] = link.ends().map(|member| &mechanism.states[member as usize].position);
            let arms = link.anchor(0).norm() + link.anchor(1).norm();
            let size = if only_turns { 2.0 } else { (arms + a.amax()).max((b - a).amax()) };
            found.rounding = found.rounding.max(JOINT_ROUNDING * size);
        }
        found
    }

    /// Kicks all members by forces, springs and drag over a time, s, with the rows of [`Self::assemble`].
    pub fn kick(
        &mut self,
        mechanism: &mut Mechanism,
        time: f64,
        pull: impl Fn(&RowSpring, &[JointRow<f64>], &Vector3<f64>) -> Vector3<f64>,
    ) {
        let Self { rows, system, pulls, moved, .. } = self;
        system.pulls(rows, |spring, mobility| pull(spring, rows, mobility), pulls);
        pulls.iter_mut().for_each(|pull| *pull *= time);
        moved.clear();
        moved.resize(mechanism.members.len(), Wrench::zero());
        add_wrenches(&mechanism.links, rows.iter().map(|row| &row.jacobian), pulls, moved);
        let Mechanism { members, states, .. } = mechanism;
        for (((member, state), impulse), inverse_mass) in
            members.iter().zip(states).zip(&*moved).zip(&system.inverse_masses)
        {
            member.kick(state, impulse, inverse_mass, time);
        }
    }

    /// The largest rate of a row that is to have none, m/s or rad/s, with the rows of [`Self::assemble`].
    pub fn fastest_parting(&mut self, mechanism: &Mechanism) -> f64 {
        self.find_rates(mechanism);
        self.errors.iter().fold(0.0, |most, rate| most.max(rate.abs()))
    }

    /// −(J v + ∂C/∂t) of all rows, zero of springs, instead of the last errors.
    fn find_rates(&mut self, mechanism: &Mechanism) {
        self.errors.clear();
        for link in &mechanism.links {
            let own = self.rows[link.rows.clone()].iter().zip(link.rates(&self.rows, &mechanism.states));
            self.errors.extend(own.map(|(row, rate)| if row.spring.is_some() { 0.0 } else { -rate }));
        }
        self.system.given.iter().for_each(|&row| self.errors[row] = 0.0);
    }

    /// Projects velocities, with the rows of [`Self::assemble`].
    pub fn project_velocities(&mut self, mechanism: &mut Mechanism) {
        self.find_rates(mechanism);
        self.system.solve(mechanism, &self.errors, &mut self.impulses);
        self.system.respond(mechanism, &self.impulses, &mut self.moved);
        for (state, gained) in mechanism.states.iter_mut().zip(&self.moved) {
            state.linear += gained.linear;
            state.angular += gained.angular;
        }
    }
}
