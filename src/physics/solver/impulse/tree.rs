//! A tree of rigid ball joints that nothing touches, taken through a step on its own: in `f64`,
//! exactly, by [`JointTree`], with the geometry of each substep.

use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use super::constants::{TREE_CLOSED, TREE_FACTOR_LAG, TREE_FOLLOWED, TREE_START_ITERATIONS, TREE_TURN};
use crate::physics::body::free_rotation::turn_freely;
use crate::physics::body::{Body, rotation_by, world_inverse_inertia};
use crate::physics::constraint::row::Twist;
use crate::physics::joint::Joint;
use crate::physics::solver::joint_tree::{JointTree, PoseChange, UNRESOLVED};
use crate::physics::solver::substeps::{Intervals, Substeps};

/// A body as its tree moves it.
#[derive(Clone, Debug)]
struct TreeBody {
    position: Vector3<f64>,
    rotation: UnitQuaternion<f64>,
    linear: Vector3<f64>,
    angular: Vector3<f64>,
    /// Principal; zero along what is locked.
    inverse_inertia_body: Vector3<f64>,
    rotation_freedom: Vector3<f64>,
    inverse_mass: Vector3<f64>,
    force: Vector3<f64>,
    torque: Vector3<f64>,
    drag: (f64, f64),
    moves: bool,
}

impl TreeBody {
    fn of(body: &Body, moves: bool) -> Self {
        Self {
            position: body.position,
            rotation: body.rotation,
            linear: body.linear,
            angular: body.angular,
            inverse_inertia_body: body.inverse_inertia_body,
            rotation_freedom: body.rotation_freedom,
            inverse_mass: body.inverse_mass,
            force: body.force,
            torque: body.torque,
            drag: body.drag,
            moves,
        }
    }

    fn is_where(&self, body: &Body) -> bool {
        self.position == body.position
            && self.rotation == body.rotation
            && self.linear == body.linear
            && self.angular == body.angular
            && self.inverse_mass == body.inverse_mass
            && self.inverse_inertia_body == body.inverse_inertia_body
            && self.rotation_freedom == body.rotation_freedom
    }

    fn inverse_inertia(&self) -> Matrix3<f64> {
        world_inverse_inertia(&self.inverse_inertia_body, &self.rotation, &self.rotation_freedom)
    }

    /// External forces, and what turning does to the angular velocity of a body that is not round.
    fn kick(&mut self, h: f64) {
        self.linear += self.inverse_mass.component_mul(&self.force) * h;
        if self.torque != Vector3::zeros() {
            self.angular += self.inverse_inertia() * self.torque * h;
        }
        self.linear /= 1.0 + self.drag.0 * h;
        self.angular /= 1.0 + self.drag.1 * h;
    }

    fn drift(&mut self, h: f64) {
        self.position += self.linear * h;
        let Self { rotation, angular, inverse_inertia_body, rotation_freedom, .. } = self;
        turn_freely(rotation, angular, inverse_inertia_body, rotation_freedom, h);
        self.rotation.renormalize_fast();
    }
}

/// A joint of the tree, in its order.
#[derive(Clone, Copy, Debug, PartialEq)]
struct AnchoredJoint {
    global: u32,
    /// Local bodies A and B.
    bodies: [usize; 2],
    anchors: [Vector3<f64>; 2],
}

/// A tree of joints and the state of its bodies.
#[derive(Clone)]
pub(crate) struct TreeStep {
    tree: JointTree,
    /// Global indices, in the tree's order.
    members: Vec<u32>,
    bodies: Vec<TreeBody>,
    joints: Vec<AnchoredJoint>,
    twists: Vec<Twist<f64>>,
    targets: Vec<Vector3<f64>>,
    separations: Vec<Vector3<f64>>,
    /// Length of the substeps that it is factored for, s; none: not factored for where it is.
    factored: Option<f64>,
    /// Whether arms are those of the pose, which the factor is not quite.
    is_refined: bool,
}

impl TreeStep {
    /// A tree whose bodies and joints are told by indices into these lists.
    pub fn new(tree: JointTree, members: &[u32], globals: &[u32], joints: &[Joint]) -> Self {
        let members: Vec<u32> = tree.bodies().iter().map(|&body| members[body as usize]).collect();
        let of_tree = tree.joints().iter().enumerate().map(|(index, &joint)| {
            let global = globals[joint as usize];
            let joint = &joints[global as usize];
            // One that does not move appears once for each of its joints.
            let mut bodies = tree.ends(index).map(|local| local as usize);
            if members[bodies[0]] != joint.a {
                bodies.reverse();
            }
            AnchoredJoint { global, bodies, anchors: joint.anchors() }
        });
        let joints: Vec<AnchoredJoint> = of_tree.collect();
        Self {
            twists: vec![Twist::zero(); members.len()],
            targets: vec![Vector3::zeros(); joints.len()],
            separations: vec![Vector3::zeros(); joints.len()],
            bodies: Vec::new(),
            members,
            joints,
            tree,
            factored: None,
            is_refined: false,
        }
    }

    /// The bodies that move, global indices.
    pub fn moving(&self) -> &[u32] {
        &self.members[..self.tree.moving()]
    }

    /// The joints, global indices.
    pub fn joints(&self) -> impl Iterator<Item = u32> {
        self.joints.iter().map(|joint| joint.global)
    }

    /// Whether `other` has the same bodies and joints.
    pub fn is_same_as(&self, other: &Self) -> bool {
        self.members == other.members && self.joints == other.joints
    }

    /// A whole step. Returns the length of its substeps, s.
    pub fn step<'w>(&mut self, body: impl Fn(u32) -> &'w Body, substeps: &Substeps) -> f64 {
        self.gather(&body);
        let Intervals { count, h, .. } =
            substeps.for_bodies(self.moving().iter().map(|&member| body(member)), TREE_TURN, TREE_TURN);
        // Velocities are half a substep behind the poses; those that a user gave are not.
        let is_new = self.moving().iter().all(|&member| !body(member).has_stepped);
        if is_new {
            // What another scene's joints pulled with, that had the same indices, is nothing to these.
            self.tree.clear_impulses();
        }
        let before = self.factored.replace(h);
        match before {
            Some(before) if before == h => {}
            Some(before) => {
                self.tree.scale_impulses(h / before);
                self.prepare(h);
            }
            None => {
                self.prepare(h);
                // What was solved otherwise so far, or moved by hand, is closed at once and without a kick.
                self.tree.project_positions(&self.separations, TREE_START_ITERATIONS, TREE_CLOSED);
                self.take_pose_changes(|_, _| {});
                self.prepare(h);
            }
        }
        let mut behind = if is_new { 0.0 } else { 0.5 * before.unwrap_or(h) };
        for _ in 0..count {
            self.substep(h, behind + 0.5 * h);
            behind = 0.5 * h;
        }
        h
    }

    fn gather<'w>(&mut self, body: &impl Fn(u32) -> &'w Body) {
        let moving = self.tree.moving();
        let same = self.bodies.len() == self.members.len()
            && self.bodies.iter().zip(&self.members).all(|(known, &member)| known.is_where(body(member)));
        if same {
            for (known, &member) in self.bodies.iter_mut().zip(&self.members) {
                let now = body(member);
                (known.force, known.torque, known.drag) = (now.force, now.torque, now.drag);
            }
            return;
        }
        self.factored = None;
        self.is_refined = false;
        self.bodies.clear();
        let members = self.members.iter().enumerate();
        self.bodies.extend(members.map(|(local, &member)| TreeBody::of(body(member), local < moving)));
    }

    /// Arms, inertias and factors of the present pose; the largest ω²h² of a body under tension.
    fn prepare(&mut self, h: f64) -> f64 {
        self.set_arms();
        for (local, body) in self.bodies.iter().enumerate().filter(|(_, body)| body.moves) {
            self.tree.set_inertia(local, body.inverse_mass, body.inverse_inertia());
        }
        let phase_squared = self.tree.stiffen(h);
        self.tree.factor();
        phase_squared
    }

    fn set_arms(&mut self) {
        let Self { tree, bodies, joints, separations, .. } = self;
        for (index, (joint, separation)) in joints.iter().zip(separations).enumerate() {
            let [a, b] = joint.bodies.map(|local| &bodies[local]);
            let (arm_a, arm_b) = (a.rotation * joint.anchors[0], b.rotation * joint.anchors[1]);
            tree.set_arms(index, arm_a, arm_b);
            *separation = (b.position - a.position) + arm_b - arm_a;
        }
    }

    fn substep(&mut self, h: f64, kick: f64) {
        for (twist, body) in self.twists.iter_mut().zip(&self.bodies) {
            *twist = Twist { linear: body.linear, angular: body.angular };
        }
        self.tree.aim(&self.twists, h, &mut self.targets);
        self.tree.damp(&mut self.twists);
        for (body, twist) in self.bodies.iter_mut().zip(&mut self.twists).filter(|(body, _)| body.moves) {
            (body.linear, body.angular) = (twist.linear, twist.angular);
            body.kick(kick);
            *twist = Twist { linear: body.linear, angular: body.angular };
        }
        self.tree.clear_impulses();
        self.tree.solve_velocities(&mut self.twists, &self.targets);
        if self.is_refined {
            self.tree.solve_velocities(&mut self.twists, &self.targets);
        }
        // Where arms turn too far to be followed, only what can give no energy is left: velocities that joints take from.
        let is_followed = !self.tree.turns_arms_beyond(TREE_FOLLOWED / h, &self.twists);
        if !is_followed {
            for (twist, body) in self.twists.iter_mut().zip(&self.bodies) {
                *twist = Twist { linear: body.linear, angular: body.angular };
            }
            self.tree.clear_impulses();
            self.tree.solve_velocities(&mut self.twists, &[]);
        }
        for (body, twist) in self.bodies.iter_mut().zip(&self.twists) {
            if body.moves {
                (body.linear, body.angular) = (twist.linear, twist.angular);
                body.drift(h);
            } else {
                body.position += body.linear * h;
                body.rotation = rotation_by(&(body.angular * h)) * body.rotation;
            }
        }
        let phase_squared = self.prepare(h);
        self.tree.project_positions(&self.separations, 1, TREE_CLOSED);
        let mut turn: f64 = 0.0;
        self.take_pose_changes(|body, change| {
            turn = turn.max(change.rotation.imag().amax());
            if !is_followed {
                return;
            }
            body.linear += change.linear / h;
            // The turn is that of a drift's error; its angle and twice its sine differ by a third power.
            body.angular += change.rotation.imag() * (2.0 / h);
        });
        self.is_refined =
            phase_squared > UNRESOLVED && turn * phase_squared < TREE_FACTOR_LAG && !self.tree.may_be_redundant();
        if self.is_refined {
            self.set_arms();
        } else if phase_squared > UNRESOLVED {
            self.prepare(h);
        }
    }

    /// Moves the bodies as the projection found, and does something else with each.
    fn take_pose_changes(&mut self, mut also: impl FnMut(&mut TreeBody, &PoseChange)) {
        for (change, body) in self.tree.pose_changes().zip(&mut self.bodies).filter(|(_, body)| body.moves) {
            body.position += change.linear;
            body.rotation = change.rotation * body.rotation;
            also(body, &change);
        }
    }

    /// The state of a body that moves, by its place among them, written to it.
    pub fn scatter(&mut self, index: usize, body: &mut Body) {
        let known = &mut self.bodies[index];
        known.rotation.renormalize_fast();
        body.position = known.position;
        body.rotation = known.rotation;
        body.linear = known.linear;
        body.angular = known.angular;
        body.has_stepped = true;
    }

    /// The force on B of each joint, in their order, N, in the last substep of length h.
    pub fn forces(&self, h: f64) -> impl Iterator<Item = Vector3<f64>> {
        (0..self.joints.len()).map(move |index| self.tree.impulse(index) / h)
    }
}
