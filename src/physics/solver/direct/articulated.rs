//! Trees of joints without contacts, in motion, by the articulated inertias of their bodies (Featherstone 1983; 2008,
//! chapter 7): SHAKE as [`DualSystem`](super::dual::DualSystem) has it, for joints that hold a point at a point and
//! besides no rotation, all but one (a hinge) or all. A hinge is one unknown here and five rows there, and what stands
//! in no row needs no matrix: a substep is linear in the joints, and each costs a fraction.
//!
//! *A link* joins a child to its parent, the body nearer to the root. With x = (v; ω) the change of the motion at its point
//! and x_p that of the parent there,
//!
//! x = x_p + S y + c,  I x = F + p,  SᵀF = 0,
//!
//! with S the free rotations, c what the joint is to change in the rest, F its impulse on the child, I = (M, H; Hᵀ, J) the
//! inertia of the child with all that hangs on it, about the point, and p the impulses of forces on these. So, from the
//! leaves to the root,
//!
//! D = SᵀIS,  U = IS,  I_a = I − U D⁻¹Uᵀ,  p_a = p − I_a c − U D⁻¹Sᵀp,
//!
//! which the parent adds to its own, moved to its point: with ℓ from there to the link's point and T = (1, −[ℓ]; 0, 1),
//! I += TᵀI_aT and p += Tᵀp_a. Back from the root, y = D⁻¹(Sᵀp − Uᵀ(x_p + c)). A root that nothing holds has I x = p.
//! As everywhere, I has the geometric stiffness that the substep cannot resolve
//! ([`StiffnessShares`](crate::physics::solver::joint_tree::StiffnessShares)), and what that damps is among p.
//!
//! *c* is first what makes the gap d and the tilt θ = a × n, with a and n the axis in parent and child, zero at the end of
//! the substep to second order. With the velocities when it begins, Ω = ω − ω_p, and J̇v as in
//! [`joint`](crate::physics::joint) (for a hinge whose axes agree, Ω × ω_p),
//!
//! c = −(d/h + ½ h J̇v + J v; θ/h + ½ h Ω × ω_p + Ω),
//!
//! and what the substep before still needed after that, which changes slowly. Then the bodies are moved, and c is −(d; θ)/h
//! at the end, with the inertias of the start, until both are small enough. That is the manifold of the rows, and these are
//! their impulses but for the last digits.

use nalgebra::{Cholesky, Matrix3, SMatrix, SVector, UnitQuaternion, Vector3};

use super::constants::{DUAL_ERRORS, DUAL_ITERATIONS, DUAL_START_ERROR};
use super::world::{World, world_inertia};
use crate::physics::body::Body;
use crate::physics::body::free_rotation::turn_freely;
use crate::physics::constraint::row::{Twist, Wrench};
use crate::physics::joint::{JointDefinition, JointHolds};
use crate::physics::solver::exact::MemberState;
use crate::physics::solver::joint_tree::{StiffnessShares, add_stiffness};

/// No link.
const NONE: u32 = u32::MAX;

/// What became of a piece of a substep.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Piece {
    Done,
    /// Joints were apart when it began: that is for the rows.
    Apart,
    /// No impulses along the joints as they stand lead to joints that hold.
    TooFar,
}

/// A joint as the tree needs it.
#[derive(Clone, Copy, Debug)]
pub(super) struct TreeJoint {
    /// Places of both bodies among the states.
    pub ends: [u32; 2],
    pub holds: JointHolds,
    /// Of the frames, in the axes of their bodies.
    pub anchors: [Vector3<f64>; 2],
    pub rotations: [UnitQuaternion<f64>; 2],
}

impl TreeJoint {
    /// Of a joint between those places; none where it holds something else.
    pub fn of(definition: &JointDefinition, ends: [u32; 2]) -> Option<Self> {
        let holds = definition.holds()?;
        let frames = &definition.frames;
        let (anchors, rotations) = ([0, 1].map(|end| frames[end].anchor), [0, 1].map(|end| frames[end].rotation));
        Some(Self { ends, holds, anchors, rotations })
    }
}

/// One link, with the values of the substep at hand.
#[derive(Clone, Debug)]
struct Link {
    /// Places among the states.
    child: u32,
    parent: u32,
    /// The link of the parent to its own parent; [`NONE`] where that does not move.
    up: u32,
    /// Whether it is a joint; else it is the root of a tree that nothing holds.
    is_joint: bool,
    /// Whether its child is the joint's A.
    is_reversed: bool,
    holds: JointHolds,
    /// Of child and parent, in the axes of their bodies.
    anchors: [Vector3<f64>; 2],
    axes: [Vector3<f64>; 2],
    rotations: [UnitQuaternion<f64>; 2],
    /// ℓ: from the point of the parent's own link.
    lever: Vector3<f64>,
    /// I, then I_a.
    inertia: Articulated,
    /// D⁻¹ of a hinge, and J⁻¹ of a point alone.
    inverse: f64,
    inverse_rotation: Matrix3<f64>,
    /// U of a hinge; H J⁻¹ of a point alone.
    along: Twist<f64>,
    across: Matrix3<f64>,
    bias: Twist<f64>,
    /// What was left to it after the prediction of the last piece, over h².
    lag: Twist<f64>,
    momentum: Wrench<f64>,
    /// D⁻¹(Sᵀp − Uᵀc), or J⁻¹Sᵀp.
    turn: Vector3<f64>,
    motion: Twist<f64>,
    /// Force on the child and torque about the point, N and N·m.
    load: Wrench<f64>,
}

/// Where the halves of a link are.
#[derive(Clone, Copy, Debug, Default)]
struct LinkPose {
    /// From the centres of mass of child and parent.
    arms: [Vector3<f64>; 2],
    /// d, from the parent's point to the child's.
    gap: Vector3<f64>,
    /// n, the child's axis.
    axis: Vector3<f64>,
    /// θ.
    tilt: Vector3<f64>,
}

/// (M, H; Hᵀ, J).
#[derive(Clone, Copy, Debug, Default)]
struct Articulated {
    mass: Matrix3<f64>,
    mixed: Matrix3<f64>,
    turning: Matrix3<f64>,
}

/// A body that moves.
#[derive(Clone, Copy, Debug, Default)]
struct Member {
    mass: f64,
    /// About its centre of mass, world axes, with stiffness.
    inertia: Matrix3<f64>,
    inverse_inertia_body: Vector3<f64>,
    /// Of forces, and what stiffness takes.
    impulse: Wrench<f64>,
    velocity: Twist<f64>,
}

/// A tree of joints, children before their parents.
#[derive(Clone, Debug, Default)]
pub(super) struct ArticulatedTree {
    links: Vec<Link>,
    /// The link of each joint.
    link_of: Vec<u32>,
    members: Vec<Member>,
    stiffnesses: Vec<Matrix3<f64>>,
    /// Poses of the links when the piece begins, and at its end, which are those at the start of the next.
    poses: Vec<LinkPose>,
    ends: Vec<LinkPose>,
    has_poses: bool,
}

impl ArticulatedTree {
    /// Of joints that connect so many bodies that move, and of bodies that do not at most one by one joint; none where
    /// that is no tree.
    pub fn new(joints: &[TreeJoint], moving: usize) -> Option<Self> {
        let is_pin = |joint: &TreeJoint| joint.ends.iter().any(|&end| end as usize >= moving);
        let pins = joints.iter().filter(|joint| is_pin(joint)).count();
        if pins > 1 || joints.len() + 1 - pins != moving {
            return None;
        }
        let mut at = vec![Vec::new(); moving];
        for (index, joint) in (0..).zip(joints) {
            for (side, &end) in joint.ends.iter().enumerate().filter(|(_, end)| (**end as usize) < moving) {
                at[end as usize].push((index, side));
            }
        }
        let mut links = Vec::with_capacity(moving);
        let mut link_of = vec![NONE; joints.len()];
        match joints.iter().position(is_pin) {
            Some(pin) => {
                let parent = usize::from(joints[pin].ends[1] as usize >= moving);
                link_of[pin] = 0;
                links.push(Link::of(&joints[pin], parent, NONE));
            }
            None => links.push(Link::root(0)),
        }
        // From the root on, then the other way round.
        let mut next = 0;
        while next < links.len() {
            let body = links[next].child;
            for &(joint, parent) in &at[body as usize] {
                if link_of[joint as usize] == NONE {
                    link_of[joint as usize] = links.len() as u32;
                    links.push(Link::of(&joints[joint as usize], parent, next as u32));
                }
            }
            next += 1;
        }
        if links.len() != moving {
            return None;
        }
        links.reverse();
        let reversed = |link: &mut u32| *link = if *link == NONE { NONE } else { moving as u32 - 1 - *link };
        links.iter_mut().for_each(|link| reversed(&mut link.up));
        link_of.iter_mut().for_each(reversed);
        Some(Self { links, link_of, ..Self::default() })
    }

    /// Takes in the forces, N, that the joints had on their B, and that their poses are not known.
    pub fn resume(&mut self, forces: impl Iterator<Item = Vector3<f64>>) {
        self.has_poses = false;
        let Self { links, link_of, .. } = self;
        links.iter_mut().for_each(|link| link.lag = Twist::zero());
        for (&link, force) in link_of.iter().zip(forces) {
            let link = &mut links[link as usize];
            link.load.linear = if link.is_reversed { -force } else { force };
        }
    }

    /// Force on B and torque about its anchor of a joint in the last piece, N and N·m.
    pub fn load(&self, joint: usize) -> Wrench<f64> {
        let link = &self.links[self.link_of[joint] as usize];
        let sign = if link.is_reversed { -1.0 } else { 1.0 };
        Wrench { linear: link.load.linear * sign, angular: link.load.angular * sign }
    }

    /// From its B's centre of mass to a joint's anchor when the last piece began.
    pub fn arm(&self, joint: usize) -> Vector3<f64> {
        let link = self.link_of[joint] as usize;
        self.poses[link].arms[usize::from(self.links[link].is_reversed)]
    }

    /// Takes the states from `starts` to `ends` in h, s, with forces that act for `kick`, s.
    pub fn take_piece(
        &mut self,
        world: &impl World,
        members: &[u32],
        starts: &[MemberState],
        ends: &mut Vec<MemberState>,
        [h, kick]: [f64; 2],
    ) -> Piece {
        if !self.place(starts) {
            return Piece::Apart;
        }
        ends.clear();
        ends.extend_from_slice(starts);
        for state in &mut ends[members.len()..] {
            state.drift(h);
        }
        self.gather(world, members, starts, [h, kick]);
        let mut least = f64::INFINITY;
        for _ in 0..DUAL_ITERATIONS {
            let worst = self.advance(starts, ends, h);
            if worst <= DUAL_ERRORS[0] {
                self.find_loads(starts, kick);
                self.has_poses = true;
                return Piece::Done;
            }
            if worst.is_nan() || worst >= least {
                break;
            }
            least = worst;
            self.pass_on();
        }
        Piece::TooFar
    }

    /// The poses of the links when the piece begins. Whether all joints hold.
    fn place(&mut self, starts: &[MemberState]) -> bool {
        if std::mem::replace(&mut self.has_poses, false) {
            std::mem::swap(&mut self.poses, &mut self.ends);
            return true;
        }
        self.poses.clear();
        self.poses.extend(self.links.iter().map(|link| link.look(starts)));
        self.ends.clone_from(&self.poses);
        self.poses.iter().all(|pose| pose.error() <= DUAL_START_ERROR)
    }

    /// From the leaves to the root: inertias with stiffness, momenta of forces, what joints are to change, and all that
    /// moved on to the parents.
    fn gather(&mut self, world: &impl World, members: &[u32], starts: &[MemberState], [h, kick]: [f64; 2]) {
        let Self { links, members: own, stiffnesses, poses, .. } = self;
        stiffnesses.clear();
        stiffnesses.resize(members.len(), Matrix3::zeros());
        own.resize(members.len(), Member::default());
        for link in &mut *links {
            (link.inertia, link.momentum) = (Articulated::default(), Wrench::zero());
        }
        for index in 0..links.len() {
            let pose = poses[index];
            let below = poses.get(links[index].up as usize).map_or_else(Vector3::zeros, |up| up.arms[0]);
            let link = &mut links[index];
            link.lever = pose.arms[1] - below;
            let (child, force) = (link.child as usize, link.load.linear);
            add_stiffness(&mut stiffnesses[child], &pose.arms[0], &force);
            if let Some(stiffness) = stiffnesses.get_mut(link.parent as usize) {
                add_stiffness(stiffness, &pose.arms[1], &-force);
            }
            let member = Member::new(world.body(members[child]), &starts[child], &stiffnesses[child], [h, kick]);
            link.inertia.add_body(&member, &pose.arms[0]);
            link.momentum.linear += member.impulse.linear;
            link.momentum.angular += member.impulse.angular - pose.arms[0].cross(&member.impulse.linear);
            own[child] = member;
            link.eliminate(&pose.axis);
            if link.is_joint {
                link.predict(&pose, starts, h);
            }
            let passed = link.pass(&pose.axis);
            // Children come before their parents.
            let (done, left) = links.split_at_mut(index + 1);
            let link = &done[index];
            if let Some(parent) = left.get_mut((link.up as usize).wrapping_sub(index + 1)) {
                parent.inertia.add(&link.inertia, &link.lever);
                parent.take(&passed, &link.lever);
            }
        }
    }

    /// The same with the inertias at hand, of what joints are to change alone.
    fn pass_on(&mut self) {
        let Self { links, poses, .. } = self;
        for index in 0..links.len() {
            let link = &mut links[index];
            let (lever, up) = (link.lever, link.up);
            let passed = link.pass(&poses[index].axis);
            if let Some(parent) = links.get_mut(up as usize) {
                parent.take(&passed, &lever);
            }
        }
    }

    /// From the root to the leaves: the velocities, where they take the bodies, and what the joints are to change next. The
    /// largest error that is left, m or rad.
    fn advance(&mut self, starts: &[MemberState], ends: &mut [MemberState], h: f64) -> f64 {
        let Self { links, members, poses, ends: end_poses, .. } = self;
        let (rate, mut worst) = (1.0 / h, 0.0_f64);
        for index in (0..links.len()).rev() {
            let (pose, above) =
                (&poses[index], links.get(links[index].up as usize).map_or_else(Twist::zero, |up| up.motion));
            let link = &mut links[index];
            let parent = Twist { linear: above.linear + above.angular.cross(&link.lever), angular: above.angular };
            link.motion = link.moved(&parent, &pose.axis);
            let Twist { linear, angular } = link.motion;
            let child = link.child as usize;
            let Member { velocity, inverse_inertia_body, .. } = &mut members[child];
            velocity.linear += linear - angular.cross(&pose.arms[0]);
            velocity.angular += angular;
            let mut state = MemberState { linear: velocity.linear, angular: velocity.angular, ..starts[child] };
            state.position += state.linear * h;
            let MemberState { rotation, angular, .. } = &mut state;
            turn_freely(rotation, angular, inverse_inertia_body, &Vector3::repeat(1.0), h);
            rotation.renormalize_fast();
            ends[child] = state;
            if link.is_joint {
                let end = link.look(ends);
                worst = worst.max(end.error());
                link.bias = Twist { linear: end.gap * -rate, angular: end.tilt * -rate };
                link.lag = link.lag.plus(&link.bias, rate * rate);
                end_poses[index] = end;
            }
        }
        worst
    }

    /// What the joints carried while forces acted for `kick`, s.
    fn find_loads(&mut self, starts: &[MemberState], kick: f64) {
        let Self { links, members, poses, .. } = self;
        for link in &mut *links {
            link.load = Wrench::zero();
        }
        for index in 0..links.len() {
            let link = &mut links[index];
            let child = link.child as usize;
            let Member { mass, inertia, impulse, velocity, .. } = &members[child];
            // So far what its children take, about the point of its own link.
            let gained = velocity.plus(&starts[child].twist(), -1.0);
            let force = (gained.linear * *mass - impulse.linear) / kick;
            link.load.linear += force;
            link.load.angular +=
                (inertia * gained.angular - impulse.angular) / kick - poses[index].arms[0].cross(&force);
            let (load, lever, up) = (link.load, link.lever, link.up);
            if let Some(parent) = links.get_mut(up as usize) {
                parent.load.linear += load.linear;
                parent.load.angular += load.angular + lever.cross(&load.linear);
            }
        }
    }
}

impl Member {
    /// In the substep that it begins so, with that stiffness of forces.
    #[inline(always)]
    fn new(body: &Body, state: &MemberState, stiffness: &Matrix3<f64>, [h, kick]: [f64; 2]) -> Self {
        let stiffness = stiffness * (h * h);
        let (mut inertia, mut moment) = (world_inertia(body), body.torque * kick);
        let smallest = 1.0 / body.inverse_inertia_body.max();
        if let Some(shares) = StiffnessShares::of(0.5 * stiffness.trace() / smallest) {
            inertia += stiffness * (shares.added + shares.damped);
            moment -= stiffness * state.angular * shares.damped;
        }
        let (velocity, inverse_inertia_body) = (state.twist(), body.inverse_inertia_body);
        let impulse = Wrench { linear: body.force * kick, angular: moment };
        Self { mass: body.mass, inertia, inverse_inertia_body, impulse, velocity }
    }
}

impl Link {
    /// Of a joint whose side `parent` is nearer to the root; `up` is the parent's own link.
    fn of(joint: &TreeJoint, parent: usize, up: u32) -> Self {
        let of = |values: [Vector3<f64>; 2]| if parent == 0 { [values[1], values[0]] } else { values };
        let rotations = if parent == 0 { [joint.rotations[1], joint.rotations[0]] } else { joint.rotations };
        Self {
            child: joint.ends[1 - parent],
            parent: joint.ends[parent],
            up,
            is_joint: true,
            is_reversed: parent == 1,
            holds: joint.holds,
            anchors: of(joint.anchors),
            axes: rotations.map(|rotation| rotation * Vector3::x()),
            rotations,
            ..Self::root(0)
        }
    }

    /// A body that nothing holds.
    fn root(body: u32) -> Self {
        let zero = Vector3::zeros();
        Self {
            child: body,
            parent: NONE,
            up: NONE,
            is_joint: false,
            is_reversed: false,
            holds: JointHolds::Point,
            anchors: [zero; 2],
            axes: [zero; 2],
            rotations: [UnitQuaternion::identity(); 2],
            lever: zero,
            inertia: Articulated::default(),
            inverse: 0.0,
            inverse_rotation: Matrix3::zeros(),
            along: Twist::zero(),
            across: Matrix3::zeros(),
            bias: Twist::zero(),
            lag: Twist::zero(),
            momentum: Wrench::zero(),
            turn: zero,
            motion: Twist::zero(),
            load: Wrench::zero(),
        }
    }

    /// Its pose where the bodies are.
    #[inline(always)]
    fn look(&self, states: &[MemberState]) -> LinkPose {
        if !self.is_joint {
            return LinkPose::default();
        }
        let [child, parent] = [self.child, self.parent].map(|place| &states[place as usize]);
        let arms = [child.rotation * self.anchors[0], parent.rotation * self.anchors[1]];
        let gap = child.position - parent.position + arms[0] - arms[1];
        let (axis, tilt) = match self.holds {
            JointHolds::Point => (Vector3::zeros(), Vector3::zeros()),
            JointHolds::Axis => {
                let axis = child.rotation * self.axes[0];
                (axis, (parent.rotation * self.axes[1]).cross(&axis))
            }
            JointHolds::All => {
                let [turned, base] = [child.rotation * self.rotations[0], parent.rotation * self.rotations[1]];
                let turn = turned * base.inverse();
                (Vector3::zeros(), turn.imag() * (2.0 * turn.w.signum()))
            }
        };
        LinkPose { arms, gap, axis, tilt }
    }

    /// c from the velocities when the piece begins.
    #[inline(always)]
    fn predict(&mut self, pose: &LinkPose, starts: &[MemberState], h: f64) {
        let [child, parent] = [self.child, self.parent].map(|place| &starts[place as usize]);
        let [arm_child, arm_parent] = &pose.arms;
        let [swing_child, swing_parent] = [child.angular.cross(arm_child), parent.angular.cross(arm_parent)];
        let parting = child.linear + swing_child - parent.linear - swing_parent;
        let swirl = child.angular.cross(&swing_child) - parent.angular.cross(&swing_parent);
        let turning = child.angular - parent.angular;
        let bias = Twist {
            linear: -parting - pose.gap / h - swirl * (0.5 * h),
            angular: -turning - pose.tilt / h - turning.cross(&parent.angular) * (0.5 * h),
        };
        self.bias = bias.plus(&self.lag, h * h);
    }

    /// Takes in what a child of its child passes on, at that lever.
    fn take(&mut self, passed: &Wrench<f64>, lever: &Vector3<f64>) {
        self.momentum.linear += passed.linear;
        self.momentum.angular += passed.angular + lever.cross(&passed.linear);
    }

    /// I_a from I.
    #[inline(always)]
    fn eliminate(&mut self, axis: &Vector3<f64>) {
        let Articulated { mass, mixed, turning } = &mut self.inertia;
        if !self.is_joint {
            return;
        }
        match self.holds {
            JointHolds::Point => {
                let inverse = turning.try_inverse().unwrap_or_else(Matrix3::zeros);
                self.across = *mixed * inverse;
                *mass -= self.across * mixed.transpose();
                (*mixed, *turning) = (Matrix3::zeros(), Matrix3::zeros());
                self.inverse_rotation = inverse;
            }
            JointHolds::Axis => {
                let along = Twist { linear: *mixed * axis, angular: *turning * axis };
                let own = axis.dot(&along.angular);
                self.inverse = if own > 0.0 { 1.0 / own } else { 0.0 };
                let scaled = Twist { linear: along.linear * self.inverse, angular: along.angular * self.inverse };
                *mass -= scaled.linear * along.linear.transpose();
                *mixed -= scaled.linear * along.angular.transpose();
                *turning -= scaled.angular * along.angular.transpose();
                self.along = along;
            }
            JointHolds::All => {}
        }
    }

    /// p_a, with which p is done.
    #[inline(always)]
    fn pass(&mut self, axis: &Vector3<f64>) -> Wrench<f64> {
        let momentum = std::mem::take(&mut self.momentum);
        if !self.is_joint {
            self.bias = self.inertia.solve(&momentum);
            return Wrench::zero();
        }
        let rest = momentum.plus(&self.inertia.of(&self.bias), -1.0);
        match self.holds {
            JointHolds::Point => {
                self.turn = self.inverse_rotation * momentum.angular;
                Wrench { linear: rest.linear - self.across * momentum.angular, angular: Vector3::zeros() }
            }
            JointHolds::Axis => {
                let along = self.inverse * axis.dot(&momentum.angular);
                self.turn.x = along - self.inverse * self.along.dot(&self.bias);
                rest.plus(&self.along, -along)
            }
            JointHolds::All => rest,
        }
    }

    /// x from x_p.
    #[inline(always)]
    fn moved(&self, parent: &Twist<f64>, axis: &Vector3<f64>) -> Twist<f64> {
        let held = parent.plus(&self.bias, 1.0);
        match self.holds {
            JointHolds::Point if self.is_joint => {
                Twist { linear: held.linear, angular: self.turn - self.across.tr_mul(&held.linear) }
            }
            JointHolds::Axis => {
                let turn = self.turn.x - self.inverse * self.along.dot(parent);
                Twist { linear: held.linear, angular: held.angular + axis * turn }
            }
            JointHolds::Point | JointHolds::All => held,
        }
    }
}

impl LinkPose {
    /// m or rad.
    fn error(&self) -> f64 {
        self.gap.amax().max(self.tilt.amax())
    }
}

impl Articulated {
    /// Adds a body about a point at the end of that arm from its centre of mass: (m, m[r]; −m[r], I − m[r][r]).
    #[inline(always)]
    fn add_body(&mut self, Member { mass, inertia, .. }: &Member, arm: &Vector3<f64>) {
        let moment = arm * *mass;
        for axis in 0..3 {
            self.mass[(axis, axis)] += mass;
            self.turning[(axis, axis)] += moment.dot(arm);
        }
        self.mixed += moment.cross_matrix();
        self.turning += inertia - moment * arm.transpose();
    }

    /// Adds Tᵀ I T.
    #[inline(always)]
    fn add(&mut self, Self { mass, mixed, turning }: &Self, lever: &Vector3<f64>) {
        let moved = mixed - times_cross(mass, lever);
        self.mass += mass;
        self.mixed += moved;
        self.turning +=
            turning - times_cross(&moved.transpose(), lever).transpose() - times_cross(&mixed.transpose(), lever);
    }

    #[inline(always)]
    fn of(&self, motion: &Twist<f64>) -> Wrench<f64> {
        Wrench {
            linear: self.mass * motion.linear + self.mixed * motion.angular,
            angular: self.mixed.tr_mul(&motion.linear) + self.turning * motion.angular,
        }
    }

    /// The motion that a momentum gives.
    fn solve(&self, momentum: &Wrench<f64>) -> Twist<f64> {
        let entry = |row: usize, column: usize| match (row < 3, column < 3) {
            (true, true) => self.mass[(row, column)],
            (true, false) => self.mixed[(row, column - 3)],
            (false, true) => self.mixed[(column, row - 3)],
            (false, false) => self.turning[(row - 3, column - 3)],
        };
        let right = SVector::<f64, 6>::from_iterator(momentum.linear.iter().chain(&momentum.angular).copied());
        let solution = Cholesky::new(SMatrix::<f64, 6, 6>::from_fn(entry)).map(|factor| factor.solve(&right));
        let solution = solution.unwrap_or_else(SVector::zeros);
        Twist { linear: solution.fixed_rows::<3>(0).into(), angular: solution.fixed_rows::<3>(3).into() }
    }
}

/// A [r].
#[inline(always)]
fn times_cross(a: &Matrix3<f64>, r: &Vector3<f64>) -> Matrix3<f64> {
    let [x, y, z] = [a.column(0), a.column(1), a.column(2)];
    Matrix3::from_columns(&[y * r.z - z * r.y, z * r.x - x * r.z, x * r.y - y * r.x])
}
