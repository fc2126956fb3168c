//! Islands whose joints make trees, in the coordinates that these leave free.
//!
//! A joint that holds a point at a point leaves three rotations, a hinge one, a rigid joint none, a body that nothing holds
//! six coordinates. With s their columns, all told at one origin O, the velocity of a body is
//!
//! V = c + Σ s q̇ over its own coordinates and those of the links between it and the root,
//!
//! c what the joints are to change besides. So the least of ½ VᵀMV − Vᵀp + Σ |λ|²/(2ρ) among the motions that keep to the
//! joints has H q̇ = Σ sᵀ(p − (M + K) c), K what rows add to the matrix of [`island`](super::island), with H by composite
//! inertias (Walker and Orin 1982; Featherstone 2008, chapter 6): H_ij = s_iᵀ C s_j, C the M + K of all that hangs on the
//! lower link, told at O. Contacts with what does not move add to their body alone, and cost nothing here. What rows of two
//! bodies have across stands in the coordinates of both ways to the root; rows that turn the two bodies of a joint stand in
//! its own.
//!
//! A figure of eleven bodies and ten joints is 28 unknowns here, and 66 with the penalties of ten joints there. H is dense,
//! with the coordinates of children before those of parents: what is zero then stays zero as far as it does in any order
//! (Featherstone 2008, section 6.5), and is passed over.
//!
//! Impulses of the joints are what is left of momenta, summed from the leaves on.

use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use super::constants::REDUCED_COORDINATES;
use super::rows::{RowBlocks, body_vector, halves};
use super::world::World;
use crate::physics::body::{Body, RigidBody};
use crate::physics::constraint::row::{Twist, Wrench};
use crate::physics::joint::{Joint, JointHolds, LawAxis};
use crate::physics::solver::exact::MemberState;
use crate::physics::solver::linear::{BodyBlock, BodyVector, Elimination};

/// No link, or no joint.
const NONE: u32 = u32::MAX;

/// A body with the joint towards the root.
#[derive(Clone, Debug)]
struct TreeLink {
    /// The body: its place among the members, and among the vectors of the island.
    member: u32,
    place: usize,
    /// The link of its parent; [`NONE`] where that does not move or is none.
    up: u32,
    /// Which of the island's joints it is; [`NONE`]: nothing holds the body.
    joint: u32,
    /// The joint's side that is the child.
    side: usize,
    holds: JointHolds,
    /// Its first coordinate, and how many it has.
    first: usize,
    count: usize,
    /// Centre of mass and the child's anchor, from O.
    center: Vector3<f64>,
    point: Vector3<f64>,
    /// Arms from the centres of mass of child and parent.
    arms: [Vector3<f64>; 2],
    /// The child's axis.
    axis: Vector3<f64>,
    /// From the parent's anchor to the child's, and how far the child is turned from where the joint holds it.
    gap: Vector3<f64>,
    tilt: Vector3<f64>,
    /// From the axes of frame A to the world's.
    turn_of_a: UnitQuaternion<f64>,
    /// Impulse of the joint on the child, told at O.
    load: BodyVector,
}

/// Trees of joints with their buffers.
#[derive(Default)]
pub(super) struct ReducedTrees {
    /// Children before their parents.
    links: Vec<TreeLink>,
    /// By member.
    link_of: Vec<u32>,
    /// The link of each of the island's joints, [`NONE`] for those that have rows.
    joint_links: Vec<u32>,
    coordinates: usize,
    /// s of each coordinate.
    columns: Vec<BodyVector>,
    /// c of each link.
    biases: Vec<BodyVector>,
    /// M + K of each link and of all that hangs on it, and what rows have across: between links of two bodies.
    own: Vec<BodyBlock>,
    composites: Vec<BodyBlock>,
    across: Vec<(u32, u32, BodyBlock)>,
    /// H, its lower half by columns, and then its factor.
    matrix: Vec<f64>,
    solution: Vec<f64>,
    /// Of each link: wrenches, then motions.
    sums: Vec<BodyVector>,
    /// Where the members are at the end of a substep.
    pub states: Vec<MemberState>,
}

impl ReducedTrees {
    /// Of an island with those members and joints, whose vectors are in the order of an elimination; none where no joint is
    /// fit for a tree or the trees have too many coordinates.
    pub fn new(world: &impl World, members: &[u32], joints: &[u32], elimination: &Elimination) -> Option<Self> {
        let local = |body: u32| members.binary_search(&body).ok();
        let ends: Vec<[Option<usize>; 2]> =
            joints.iter().map(|&joint| world.joint(joint)).map(|joint| [joint.a, joint.b].map(local)).collect();
        let holds: Vec<Option<JointHolds>> =
            joints.iter().map(|&joint| world.joint(joint).definition.holds()).collect();
        let mut at = vec![Vec::new(); members.len()];
        for (index, ends) in ends.iter().enumerate().filter(|(index, _)| holds[*index].is_some()) {
            ends.iter().flatten().for_each(|&end| at[end].push(index));
        }
        let mut trees =
            Self { link_of: vec![NONE; members.len()], joint_links: vec![NONE; joints.len()], ..Self::default() };
        // From the root on, then the other way round: held bodies first, then those with most joints.
        let pin = |member: usize| at[member].iter().copied().find(|&joint| ends[joint].contains(&None));
        let mut roots: Vec<usize> = (0..members.len()).collect();
        roots.sort_by_key(|&member| (pin(member).is_none(), std::cmp::Reverse(at[member].len())));
        let mut next = 0;
        for root in roots {
            if trees.link_of[root] != NONE {
                continue;
            }
            match pin(root) {
                Some(joint) => {
                    let side = usize::from(ends[joint][0].is_none());
                    trees.hang(root, NONE, Some((joint, side)), holds[joint]);
                }
                None => trees.hang(root, NONE, None, None),
            }
            while next < trees.links.len() {
                let parent = trees.links[next].member as usize;
                for &joint in &at[parent] {
                    let [Some(a), Some(b)] = ends[joint] else { continue };
                    let (child, side) = if a == parent { (b, 1) } else { (a, 0) };
                    if trees.link_of[child] == NONE {
                        trees.hang(child, next as u32, Some((joint, side)), holds[joint]);
                    }
                }
                next += 1;
            }
        }
        trees.reverse();
        for link in &mut trees.links {
            link.place = elimination.place(link.member) as usize;
            link.first = trees.coordinates;
            trees.coordinates += link.count;
        }
        let has_joint = trees.links.iter().any(|link| link.joint != NONE);
        trees.states.resize(members.len(), MemberState::REST);
        (has_joint && trees.coordinates <= REDUCED_COORDINATES).then_some(trees)
    }

    fn hang(&mut self, member: usize, up: u32, joint: Option<(usize, usize)>, holds: Option<JointHolds>) {
        let own = self.links.len() as u32;
        self.link_of[member] = own;
        if let Some((joint, _)) = joint {
            self.joint_links[joint] = own;
        }
        let zero = Vector3::zeros();
        self.links.push(TreeLink {
            member: member as u32,
            place: 0,
            up,
            joint: joint.map_or(NONE, |(joint, _)| joint as u32),
            side: joint.map_or(0, |(_, side)| side),
            holds: holds.unwrap_or(JointHolds::Point),
            first: 0,
            count: match (joint, holds) {
                (None, _) => 6,
                (_, Some(JointHolds::Axis)) => 1,
                (_, Some(JointHolds::All)) => 0,
                _ => 3,
            },
            center: zero,
            point: zero,
            arms: [zero; 2],
            axis: zero,
            gap: zero,
            tilt: zero,
            turn_of_a: UnitQuaternion::identity(),
            load: BodyVector::zeros(),
        });
    }

    fn reverse(&mut self) {
        self.links.reverse();
        let last = self.links.len() as u32 - 1;
        let reversed = |link: &mut u32| *link = if *link == NONE { NONE } else { last - *link };
        self.links.iter_mut().for_each(|link| reversed(&mut link.up));
        self.link_of.iter_mut().for_each(reversed);
        self.joint_links.iter_mut().for_each(reversed);
    }

    /// The members that a joint of a tree holds, and its arms from their centres of mass: of A and of B.
    pub fn sides(&self, joint: usize) -> ([Option<u32>; 2], [Vector3<f64>; 2]) {
        let link = &self.links[self.joint_links[joint] as usize];
        let parent = self.links.get(link.up as usize).map(|link| link.member);
        let (mut ends, mut arms) = ([parent, Some(link.member)], [link.arms[1], link.arms[0]]);
        if link.side == 0 {
            (ends, arms) = ([ends[1], ends[0]], [arms[1], arms[0]]);
        }
        (ends, arms)
    }

    /// Whether a joint is a link, and has no rows.
    pub fn holds(&self, joint: usize) -> bool {
        self.joint_links[joint] != NONE
    }

    /// The link between the two members that a joint without translations turns against each other, if there is one.
    pub fn link_between(&self, joint: &Joint, ends: &[Option<u32>; 2]) -> Option<u32> {
        let is_turning = |axis: LawAxis| match axis {
            LawAxis::Coordinate(axis) => axis.is_angle(),
            LawAxis::Turning(_) => true,
        };
        if !joint.definition.laws.as_ref().is_some_and(|laws| laws.iter().all(|law| is_turning(law.axis))) {
            return None;
        }
        let [a, b] = ends.map(|end| end.map(|member| self.link_of[member as usize]));
        let is_up = |child: u32, parent: Option<u32>| {
            let link = &self.links[child as usize];
            link.joint != NONE && link.up == parent.unwrap_or(NONE)
        };
        match (a, b) {
            (a, Some(b)) if is_up(b, a) => Some(b),
            (Some(a), b) if is_up(a, b) => Some(a),
            _ => None,
        }
    }

    /// Takes in where bodies and joints are.
    pub fn place(&mut self, world: &impl World, members: &[u32], joints: &[u32]) {
        let origin = world.body(members[self.links.last().map_or(0, |root| root.member as usize)]).position;
        let Self { links, columns, .. } = self;
        columns.clear();
        for link in links {
            let child = world.body(members[link.member as usize]);
            link.center = child.position - origin;
            if link.joint == NONE {
                link.point = link.center;
                columns.extend([0, 1, 2].map(|axis| body_vector(&Vector3::ith(axis, 1.0), &Vector3::zeros())));
            } else {
                let joint = world.joint(joints[link.joint as usize]);
                let parent = world.body(if link.side == 0 { joint.b } else { joint.a });
                link.look(joint, [&state_of(child), &state_of(parent)]);
                link.point = link.center + link.arms[0];
            }
            let turning = |axis: Vector3<f64>| body_vector(&link.point.cross(&axis), &axis);
            match (link.joint, link.holds) {
                (NONE, _) | (_, JointHolds::Point) => {
                    columns.extend([0, 1, 2].map(|axis| turning(Vector3::ith(axis, 1.0))))
                }
                (_, JointHolds::Axis) => columns.push(turning(link.axis)),
                (_, JointHolds::All) => {}
            }
        }
    }

    /// Has the joints part as little to second order as they do to first, in a substep of which so much lies before the
    /// middle, s: c.
    pub fn curve(&mut self, world: &impl World, members: &[u32], joints: &[u32], ahead: impl Fn([&Body; 2]) -> f64) {
        let (links, parent_of) = (&self.links, |link: &TreeLink| {
            let joint = world.joint(joints[link.joint as usize]);
            world.body(if link.side == 0 { joint.b } else { joint.a })
        });
        let origin = |link: &TreeLink| world.body(members[link.member as usize]).position - link.center;
        self.biases.clear();
        self.biases.resize(links.len(), BodyVector::zeros());
        for (index, link) in links.iter().enumerate().rev().filter(|(_, link)| link.joint != NONE) {
            let (child, parent) = (world.body(members[link.member as usize]), parent_of(link));
            let above = match self.biases.get(link.up as usize) {
                Some(above) => *above,
                None if parent.kind == RigidBody::Kinematic => {
                    let arm = origin(link) - parent.position;
                    body_vector(&(parent.linear + parent.angular.cross(&arm)), &parent.angular)
                }
                None => BodyVector::zeros(),
            };
            let ahead = ahead([child, parent]);
            let of_parent = if parent.kind == RigidBody::Static { Vector3::zeros() } else { parent.angular };
            let inward = |omega: &Vector3<f64>, arm: &Vector3<f64>| omega.cross(&omega.cross(arm));
            let parting = inward(&child.angular, &link.arms[0]) - inward(&of_parent, &link.arms[1]);
            let tilting = (child.angular - of_parent).cross(&of_parent);
            self.biases[index] = above + link.jump(&(parting * -ahead), &(tilting * -ahead));
        }
    }

    /// Nothing but q̇ moves.
    pub fn rest(&mut self) {
        self.biases.clear();
        self.biases.resize(self.links.len(), BodyVector::zeros());
    }

    /// Has the joints close their gaps at the rates that their sizes tell, 1/s: c. Whether there are any.
    pub fn close(&mut self, rate: impl Fn(f64) -> f64) -> bool {
        self.rest();
        let mut closes = false;
        for (index, link) in self.links.iter().enumerate().rev().filter(|(_, link)| link.joint != NONE) {
            let above = self.biases.get(link.up as usize).copied().unwrap_or_default();
            let [gap, tilt] = [&link.gap, &link.tilt].map(|error| error * -rate(error.norm()));
            closes |= gap != Vector3::zeros() || tilt != Vector3::zeros();
            self.biases[index] = above + link.jump(&gap, &tilt);
        }
        closes
    }

    /// Looks how far the joints are apart with the members at [`Self::states`], m or rad.
    pub fn find_gaps(&mut self, world: &impl World, joints: &[u32], members: &[u32]) -> f64 {
        let Self { links, states, .. } = self;
        let mut worst: f64 = 0.0;
        for link in links.iter_mut().filter(|link| link.joint != NONE) {
            let joint = world.joint(joints[link.joint as usize]);
            let parent = if link.side == 0 { joint.b } else { joint.a };
            let held = members.binary_search(&parent).map_or_else(|_| state_of(world.body(parent)), |at| states[at]);
            // Arms and axes stay those of the factor.
            (link.gap, link.tilt) = link.errors(joint, [&states[link.member as usize], &held]);
            worst = worst.max(link.gap.amax()).max(link.tilt.amax());
        }
        worst
    }

    /// Begins a matrix with the masses and inertias of members.
    pub fn begin(&mut self, inertias: &[(f64, Matrix3<f64>)]) {
        let Self { links, own, across, .. } = self;
        own.clear();
        own.extend(links.iter().map(|link| {
            let (mass, inertia) = &inertias[link.member as usize];
            let mut block = BodyBlock::zeros();
            block.fixed_view_mut::<3, 3>(0, 0).fill_diagonal(*mass);
            block.fixed_view_mut::<3, 3>(3, 3).copy_from(inertia);
            block
        }));
        across.clear();
    }

    /// Adds what a constraint's rows add to the matrix.
    pub fn add_rows(&mut self, blocks: &RowBlocks, ends: &[Option<u32>; 2]) {
        let links = ends.map(|end| end.map(|member| self.link_of[member as usize]));
        for (link, block) in links.iter().zip(&blocks.own) {
            if let Some(link) = link {
                self.own[*link as usize] += block;
            }
        }
        if let [Some(a), Some(b)] = links {
            self.across.push((a, b, blocks.across));
        }
    }

    /// Makes H of it, of which that of links is left to be added.
    pub fn assemble(&mut self) {
        let Self { links, columns, own, composites, across, matrix, coordinates, .. } = self;
        let n = *coordinates;
        matrix.clear();
        matrix.resize(n * n, 0.0);
        for (link, own) in links.iter().zip(&mut *own) {
            *own = at_origin(own, [&link.center; 2]);
        }
        composites.clone_from(own);
        for (index, link) in links.iter().enumerate() {
            let composite = composites[index];
            if let Some(above) = composites.get_mut(link.up as usize) {
                *above += composite;
            }
            for column in link.first..link.first + link.count {
                let wrench = composite * columns[column];
                for row in column..link.first + link.count {
                    matrix[column * n + row] = columns[row].dot(&wrench);
                }
                for_each_above(links, link.up, |row| matrix[column * n + row] = columns[row].dot(&wrench));
            }
        }
        for (a, b, block) in across {
            let [of_a, of_b] = [&*a, &*b].map(|link| &links[*link as usize].center);
            *block = at_origin(block, [of_a, of_b]);
            for_each_above(links, *b, |column| {
                let wrench = *block * columns[column];
                for_each_above(links, *a, |row| {
                    let share = columns[row].dot(&wrench);
                    let (low, high) = (column.min(row), column.max(row));
                    matrix[low * n + high] += if low == high { 2.0 * share } else { share };
                });
            });
        }
    }

    /// Adds a row of that penalty that turns the child of a link against its parent.
    pub fn add_turning(&mut self, link: u32, row: &Vector3<f64>, penalty: f64) {
        let (n, link) = (self.coordinates, &self.links[link as usize]);
        let along = |index: usize| if link.count == 1 { row.dot(&link.axis) } else { row[index] };
        for column in 0..link.count {
            for row in column..link.count {
                self.matrix[(link.first + column) * n + link.first + row] += penalty * along(column) * along(row);
            }
        }
    }

    /// Factors H. False if it is not positive.
    pub fn factor(&mut self) -> bool {
        factor(&mut self.matrix, self.coordinates)
    }

    /// From momenta to velocities, by place.
    pub fn solve(&mut self, vectors: &mut [BodyVector]) {
        let Self { links, columns, biases, own, across, matrix, solution, sums, coordinates, .. } = self;
        sums.clear();
        sums.extend(links.iter().zip(&*own).zip(&*biases).map(|((link, own), bias)| {
            let (linear, angular) = halves(&vectors[link.place]);
            body_vector(&linear, &(angular + link.center.cross(&linear))) - own * bias
        }));
        for (a, b, block) in &*across {
            let (a, b) = (*a as usize, *b as usize);
            sums[a] -= block * biases[b];
            sums[b] -= block.tr_mul(&biases[a]);
        }
        solution.clear();
        for (index, link) in links.iter().enumerate() {
            let sum = sums[index];
            if let Some(above) = sums.get_mut(link.up as usize) {
                *above += sum;
            }
            solution.extend(columns[link.first..link.first + link.count].iter().map(|column| column.dot(&sum)));
        }
        substitute(matrix, solution, *coordinates);
        for (index, link) in links.iter().enumerate().rev() {
            let mut motion = sums.get(link.up as usize).copied().unwrap_or_default();
            for coordinate in link.first..link.first + link.count {
                motion += columns[coordinate] * solution[coordinate];
            }
            sums[index] = motion;
            let (linear, angular) = halves(&(motion + biases[index]));
            vectors[link.place] = body_vector(&(linear + angular.cross(&link.center)), &angular);
        }
    }

    /// Finds what the joints carried: what of the changes of momenta, by place, rows did not give.
    pub fn find_loads(&mut self, given: &[BodyVector]) {
        for link in &mut self.links {
            let (linear, angular) = halves(&given[link.place]);
            link.load = body_vector(&linear, &(angular + link.center.cross(&linear)));
        }
        for index in 0..self.links.len() {
            let TreeLink { load, up, .. } = self.links[index];
            if let Some(above) = self.links.get_mut(up as usize) {
                above.load += load;
            }
        }
    }

    /// Has the joints carry another share of what they did.
    pub fn scale_loads(&mut self, share: f64) {
        self.links.iter_mut().for_each(|link| link.load *= share);
    }

    /// Impulse of a joint on B, and its moment about the anchor.
    fn load(&self, joint: usize) -> Wrench<f64> {
        let link = &self.links[self.joint_links[joint] as usize];
        let (linear, angular) = halves(&link.load);
        let sign = if link.side == 1 { 1.0 } else { -1.0 };
        Wrench { linear: linear * sign, angular: (angular - link.point.cross(&linear)) * sign }
    }

    /// Rows that its joints stand for.
    pub fn rows(&self) -> usize {
        let held = self.links.iter().filter(|link| link.joint != NONE);
        held.map(|link| 6 - link.count).sum()
    }

    /// Writes what a joint carried in `h`, s.
    pub fn store(&self, index: usize, joint: &mut Joint, h: f64) {
        let Wrench { linear, angular } = self.load(index);
        (joint.force, joint.torque) = (linear / h, angular / h);
        let along = self.links[self.joint_links[index] as usize].turn_of_a.inverse() * joint.torque;
        joint.multipliers[..3].copy_from_slice(joint.force.as_slice());
        let count = match joint.definition.holds() {
            Some(JointHolds::Axis) => 2,
            Some(JointHolds::All) => 3,
            _ => 0,
        };
        joint.multipliers[3..3 + count].copy_from_slice(&along.as_slice()[3 - count..]);
    }
}

impl TreeLink {
    /// Takes in where the joint is with the child and the parent in those states.
    fn look(&mut self, joint: &Joint, [child, parent]: [&MemberState; 2]) {
        let frames = &joint.definition.frames;
        self.arms = [child.rotation * frames[self.side].anchor, parent.rotation * frames[1 - self.side].anchor];
        if self.holds == JointHolds::Axis {
            self.axis = child.rotation * (frames[self.side].rotation * Vector3::x());
        }
        if self.holds != JointHolds::Point {
            self.turn_of_a = if self.side == 1 { parent.rotation } else { child.rotation } * frames[0].rotation;
        }
        (self.gap, self.tilt) = self.errors(joint, [child, parent]);
    }

    /// How far the child is from where the joint holds it, m and rad, with both in those states.
    fn errors(&self, joint: &Joint, [child, parent]: [&MemberState; 2]) -> (Vector3<f64>, Vector3<f64>) {
        let frames = &joint.definition.frames;
        let (own, other) = (&frames[self.side], &frames[1 - self.side]);
        let arms = [child.rotation * own.anchor, parent.rotation * other.anchor];
        let gap = child.position - parent.position + arms[0] - arms[1];
        let tilt = match self.holds {
            JointHolds::Point => Vector3::zeros(),
            JointHolds::Axis => {
                let [axis, other] = [(child, own), (parent, other)]
                    .map(|(state, frame)| state.rotation * (frame.rotation * Vector3::x()));
                other.cross(&axis)
            }
            JointHolds::All => {
                let turn = (child.rotation * own.rotation) * (parent.rotation * other.rotation).inverse();
                turn.imag() * 2.0_f64.copysign(turn.w)
            }
        };
        (gap, tilt)
    }

    /// A motion of the child against the parent, of which the joint has what it holds, told at O.
    fn jump(&self, linear: &Vector3<f64>, angular: &Vector3<f64>) -> BodyVector {
        let held = match self.holds {
            JointHolds::Point => Vector3::zeros(),
            JointHolds::Axis => angular - self.axis * self.axis.dot(angular),
            JointHolds::All => *angular,
        };
        body_vector(&(linear + self.point.cross(&held)), &held)
    }
}

fn state_of(body: &Body) -> MemberState {
    MemberState { position: body.position, rotation: body.rotation, linear: body.linear, angular: body.angular }
}

/// Does the same for the coordinates of a link and of all above it.
fn for_each_above(links: &[TreeLink], from: u32, mut work: impl FnMut(usize)) {
    let mut link = links.get(from as usize);
    while let Some(TreeLink { first, count, up, .. }) = link {
        (*first..first + count).for_each(&mut work);
        link = links.get(*up as usize);
    }
}

/// T_xᵀ block T_y for centres of mass x and y from O, T = (1, −[x]ₓ; 0, 1).
fn at_origin(block: &BodyBlock, [x, y]: [&Vector3<f64>; 2]) -> BodyBlock {
    let part = |row: usize, column: usize| Matrix3::from(block.fixed_view::<3, 3>(row, column));
    let (x, y) = (x.cross_matrix(), y.cross_matrix());
    let (upper, lower) = (part(0, 0), part(3, 0));
    let right = part(0, 3) - upper * y;
    let mut moved = BodyBlock::zeros();
    moved.fixed_view_mut::<3, 3>(0, 0).copy_from(&upper);
    moved.fixed_view_mut::<3, 3>(0, 3).copy_from(&right);
    moved.fixed_view_mut::<3, 3>(3, 0).copy_from(&(x * upper + lower));
    moved.fixed_view_mut::<3, 3>(3, 3).copy_from(&(x * right + part(3, 3) - lower * y));
    moved
}

/// LDLᵀ where the matrix stands: columns of L below D⁻¹. False if a pivot is not positive.
fn factor(matrix: &mut [f64], n: usize) -> bool {
    for pivot in 0..n {
        let (done, left) = matrix.split_at_mut((pivot + 1) * n);
        let column = &mut done[pivot * n..];
        let square = column[pivot];
        if square.is_nan() || square <= 0.0 {
            return false;
        }
        let inverse = 1.0 / square;
        for (other, target) in (pivot + 1..n).zip(left.chunks_exact_mut(n)) {
            if column[other] != 0.0 {
                let share = -column[other] * inverse;
                for (sum, &value) in target[other..].iter_mut().zip(&column[other..]) {
                    *sum = value.mul_add(share, *sum);
                }
            }
        }
        column[pivot + 1..].iter_mut().for_each(|value| *value *= inverse);
        column[pivot] = inverse;
    }
    true
}

/// Solves by that factor.
fn substitute(factor: &[f64], x: &mut [f64], n: usize) {
    for pivot in 0..n {
        let (known, rest) = x[pivot..].split_first_mut().expect("as many as pivots");
        let column = &factor[pivot * n + pivot..(pivot + 1) * n];
        for (value, share) in rest.iter_mut().zip(&column[1..]) {
            *value = share.mul_add(-*known, *value);
        }
        *known *= column[0];
    }
    for pivot in (0..n).rev() {
        let (own, known) = x[pivot..].split_first_mut().expect("as many as pivots");
        let column = &factor[pivot * n + pivot + 1..(pivot + 1) * n];
        *own -= column.iter().zip(&*known).map(|(share, value)| share * value).sum::<f64>();
    }
}

/// What momenta change beyond forces, by place: M v − p.
pub(super) fn change_of(inertia: &(f64, Matrix3<f64>), velocity: &BodyVector, momentum: &BodyVector) -> BodyVector {
    let (linear, angular) = halves(velocity);
    let Twist { linear, angular } = Twist { linear: linear * inertia.0, angular: inertia.1 * angular };
    body_vector(&linear, &angular) - momentum
}

#[cfg(test)]
mod tests;
