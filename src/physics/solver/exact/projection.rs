//! Back onto the joints: places and velocities moved the least way, as masses count, to where joints hold to rounding.
//!
//! Places: δ = M⁻¹Jᵀμ with J M⁻¹ Jᵀ μ = −C, again until C is zero to rounding (Newton's method on the group, J and its
//! factor those of the first turn while that does: the error is small when it starts). Velocities:
//! v −= M⁻¹Jᵀ(J M⁻¹ Jᵀ)⁻¹ J v.

use nalgebra::{Matrix3, Vector3};

use super::mechanism::{Mechanism, Motion};
use super::rows::{Rows, Screw, Weight};

/// Turns at most.
const MOST_TURNS: usize = 60;

/// What of a joint's arms may be left, as a share of them: some units of rounding.
const ROUNDING: f64 = 4e-16;

/// Levers, as a share, that count little: by trial, with 1e-4 a sheet of 30 × 30 joints parts, with 3e-3 four-bar loops
/// lose energy as they pass flat poses.
const PROJECTED: f64 = 1e-3;

/// Share of errors that a step leaves from which on the next is taken with the rows of the pose it led to.
const SLOW: f64 = 0.8;

/// Share with such rows from which on nothing is gained.
const STUCK: f64 = 0.95;

/// How far members may have moved, m or rad, from where rows were factored that velocities are projected with: near a
/// singular pose others tell too little of where they are singular, and what is left grows from turn to turn.
const STRAYED: f64 = 1e-6;

/// Shortest share of a step.
const LEAST_SHARE: f64 = 1e-3;

/// Softness of what does not hold, 1/kg.
pub(super) const LOOSE: f64 = 1e200;

/// Buffers.
#[derive(Clone, Debug, Default)]
pub(crate) struct Projection {
    pub rows: Rows,
    rotations: Vec<Matrix3<f64>>,
    errors: Vec<Vector3<f64>>,
    forces: Vec<Vector3<f64>>,
    motion: Vec<Screw>,
    /// How far members have moved since the rows were factored, m or rad.
    strayed: f64,
    /// The mechanism before a step.
    before: Vec<Motion>,
}

/// How far joints are from where they hold.
#[derive(Clone, Copy, Debug)]
pub(super) struct Gaps {
    /// m, along an axis.
    pub largest: f64,
    /// What rounding may leave of it.
    pub rounding: f64,
    /// Σ |C|².
    square: f64,
}

impl Projection {
    /// Arms, weights and the factor at the present pose.
    pub fn assemble(&mut self, mechanism: &Mechanism) {
        self.strayed = 0.0;
        self.set_arms(mechanism);
        self.rows.weights.clear();
        for (member, rotation) in mechanism.members.iter().zip(&self.rotations) {
            let weight = Weight { linear: member.inverse_mass, angular: member.inverse_inertia(rotation, None) };
            self.rows.weights.push(weight);
        }
        self.rows.assemble(mechanism, PROJECTED, |_, _| Matrix3::from_diagonal_element(LOOSE));
    }

    fn set_arms(&mut self, mechanism: &Mechanism) {
        self.rotations.clear();
        self.rotations.extend(mechanism.motion.iter().map(|motion| motion.rotation.to_rotation_matrix().into_inner()));
        self.rows.arms.clear();
        for link in &mechanism.links {
            let arm_a = self.rotations[link.a as usize] * link.anchor_a;
            let arm_b = self.rotations[link.b as usize] * link.anchor_b;
            self.rows.arms.push([arm_a, arm_b]);
        }
    }

    /// Places and velocities of a tree from its rotations and angular velocities, its centre of mass kept where nothing
    /// holds it.
    fn follow(&mut self, mechanism: &mut Mechanism) {
        let Mechanism { members, links, motion, tree, moving, .. } = mechanism;
        let Some(tree) = tree.as_ref() else { return };
        let floats = tree.len() < *moving;
        let mean = |motion: &[Motion]| {
            let mut sum = (0.0, Vector3::zeros(), Vector3::zeros());
            for (member, motion) in members.iter().zip(motion).take(*moving) {
                sum.0 += member.mass;
                sum.1 += motion.position * member.mass;
                sum.2 += motion.linear * member.mass;
            }
            (sum.1 / sum.0, sum.2 / sum.0)
        };
        let before = if floats { mean(motion) } else { Default::default() };
        for &(link, end) in tree {
            let link = &links[link as usize];
            let ends = [(link.a, &link.anchor_a), (link.b, &link.anchor_b)];
            let ((near, near_anchor), (far, far_anchor)) = (ends[end], ends[1 - end]);
            let (near, arms) = {
                let near = motion[near as usize];
                (near, [near.rotation * near_anchor, motion[far as usize].rotation * far_anchor])
            };
            let far = &mut motion[far as usize];
            far.position = near.position + (arms[0] - arms[1]);
            far.linear = near.linear + near.angular.cross(&arms[0]) - far.angular.cross(&arms[1]);
        }
        if floats {
            let after = mean(motion);
            for motion in &mut motion[..*moving] {
                motion.position += before.0 - after.0;
                motion.linear += before.1 - after.1;
            }
        }
    }

    /// Both, at the present pose. The largest error of a place that is left, m.
    pub fn project(&mut self, mechanism: &mut Mechanism) -> f64 {
        if mechanism.tree.is_some() {
            self.follow(mechanism);
            return 0.0;
        }
        self.assemble(mechanism);
        let left = self.project_places(mechanism);
        if self.strayed > STRAYED {
            self.assemble(mechanism);
        }
        self.project_velocities(mechanism);
        left
    }

    /// The largest error that is left, m. Where a step does not lessen the errors it is halved: a chain that is almost
    /// straight gives way with the square of its bends, which a linear step misses by far.
    fn project_places(&mut self, mechanism: &mut Mechanism) -> f64 {
        let mut left = self.find_errors(mechanism);
        let mut is_fresh = true;
        for _ in 0..MOST_TURNS {
            if left.largest <= left.rounding {
                break;
            }
            self.rows.solve_once(mechanism, &mut self.errors);
            self.rows.respond(mechanism, &self.errors, &mut self.motion);
            self.before.clone_from(&mechanism.motion);
            let mut share = 1.0;
            let found = loop {
                self.go(mechanism, share);
                let found = self.find_errors(mechanism);
                if found.square < left.square || share < LEAST_SHARE {
                    break found;
                }
                share *= 0.5;
                mechanism.motion.clone_from(&self.before);
            };
            let is_less = found.square < left.square;
            let kept = if is_less { (found.square / left.square).sqrt() } else { 1.0 };
            if is_less {
                left = found;
                let most = self.motion.iter().map(|moved| moved.linear.amax().max(moved.angular.amax()));
                self.strayed += share * most.fold(0.0, f64::max);
            } else {
                mechanism.motion.clone_from(&self.before);
                self.set_arms(mechanism);
                self.find_errors(mechanism);
            }
            if is_fresh && kept > STUCK {
                break;
            }
            is_fresh = kept > SLOW || share < 1.0;
            if is_fresh {
                self.assemble(mechanism);
            }
        }
        left.largest
    }

    /// Moves members by that share of the step found.
    fn go(&mut self, mechanism: &mut Mechanism, share: f64) {
        for (motion, moved) in mechanism.motion.iter_mut().zip(&self.motion) {
            if moved.linear != Vector3::zeros() || moved.angular != Vector3::zeros() {
                motion.position += moved.linear * share;
                motion.turn(&(moved.angular * share));
            }
        }
        self.set_arms(mechanism);
    }

    /// −C of all links at the present pose.
    pub fn errors_of(&mut self, mechanism: &Mechanism, errors: &mut Vec<Vector3<f64>>) -> Gaps {
        self.set_arms(mechanism);
        let found = self.find_errors(mechanism);
        errors.clone_from(&self.errors);
        found
    }

    /// −C of all links, arms being those of the present pose.
    fn find_errors(&mut self, mechanism: &Mechanism) -> Gaps {
        self.errors.clear();
        let mut gaps = Gaps { largest: 0.0, rounding: 0.0, square: 0.0 };
        for (link, [arm_a, arm_b]) in mechanism.links.iter().zip(&self.rows.arms) {
            if link.spring.is_some() {
                self.errors.push(Vector3::zeros());
                continue;
            }
            let (a, b) = (&mechanism.motion[link.a as usize], &mechanism.motion[link.b as usize]);
            let error = a.position - b.position + (arm_a - arm_b);
            gaps.largest = gaps.largest.max(error.amax());
            gaps.rounding = gaps.rounding.max(ROUNDING * (arm_a.amax() + arm_b.amax() + a.position.amax()));
            gaps.square += error.norm_squared();
            self.errors.push(error);
        }
        gaps
    }

    /// What the last [`Self::project_velocities`] pushed at each link, N·s on B.
    pub fn impulses(&self) -> &[Vector3<f64>] {
        &self.forces
    }

    /// Velocities, with the rows of [`Self::assemble`].
    pub fn project_velocities(&mut self, mechanism: &mut Mechanism) {
        self.motion.clear();
        let screws = mechanism.motion.iter().map(|motion| Screw { linear: motion.linear, angular: motion.angular });
        self.motion.extend(screws);
        self.errors.clear();
        for (index, link) in mechanism.links.iter().enumerate() {
            let error = -self.rows.relative(index, link.a, link.b, &self.motion);
            self.errors.push(if link.spring.is_some() { Vector3::zeros() } else { error });
        }
        self.rows.solve(mechanism, &self.errors, &mut self.forces);
        self.rows.respond(mechanism, &self.forces, &mut self.motion);
        for (motion, gained) in mechanism.motion.iter_mut().zip(&self.motion) {
            motion.linear += gained.linear;
            motion.angular += gained.angular;
        }
    }
}
