//! Which joints form trees, and in what order to eliminate them. Run when joints change.

use nalgebra::{Matrix3, Vector3};

use super::tree::{Branch, Displacement, Hub, JointTree, NONE, TreeInertia, TreeJoint};
use crate::physics::constraint::row::Twist;

/// A body with more joints than this is a hub.
const LINK: usize = 2;

/// What [`partition`] makes of a set of joints.
#[derive(Clone, Debug, Default)]
pub(crate) struct Partition {
    /// Components whose moving bodies form a tree, by their lowest body.
    pub trees: Vec<JointTree>,
    /// Joints of components with a loop of moving bodies, ascending.
    pub left_over: Vec<u32>,
}

/// Sorts joints, given as pairs of body indices (a, b), into trees and the rest. Joints of a body
/// to itself and between bodies that do not move are in neither: no impulse acts there.
pub(crate) fn partition(joints: &[[u32; 2]], moves: &[bool]) -> Partition {
    let graph = Graph::new(joints, moves);
    let mut result = Partition::default();
    let mut walk = Walk { seen: vec![NONE; moves.len()], steps: Vec::new() };
    for body in 0..moves.len() as u32 {
        if walk.seen[body as usize] != NONE || graph.at(body).is_empty() {
            continue;
        }
        walk.from(body, &graph, moves);
        if walk.has_loop(&graph, moves) {
            result.left_over.extend(walk.joints(&graph));
            continue;
        }
        // The middle of the longest path: go to one end of it, then to the other, then half back.
        let end = walk.last_body();
        walk.again(end, &graph, moves);
        let middle = walk.half_way_back();
        walk.again(middle, &graph, moves);
        result.trees.push(walk.tree(&graph));
    }
    result.left_over.sort_unstable();
    result
}

/// Joints by body, for bodies that move.
struct Graph<'a> {
    joints: &'a [[u32; 2]],
    starts: Vec<u32>,
    entries: Vec<u32>,
}

impl<'a> Graph<'a> {
    fn new(joints: &'a [[u32; 2]], moves: &[bool]) -> Self {
        let ends = || {
            let indexed = joints.iter().enumerate().filter(|(_, [a, b])| a != b);
            indexed.flat_map(|(joint, pair)| pair.map(|body| (joint as u32, body as usize)))
        };
        let mut starts = vec![0; moves.len() + 1];
        for (_, body) in ends().filter(|&(_, body)| moves[body]) {
            starts[body + 1] += 1;
        }
        for body in 0..moves.len() {
            starts[body + 1] += starts[body];
        }
        let mut free = starts.clone();
        let mut entries = vec![0; starts[moves.len()] as usize];
        for (joint, body) in ends().filter(|&(_, body)| moves[body]) {
            entries[free[body] as usize] = joint;
            free[body] += 1;
        }
        Self { joints, starts, entries }
    }

    fn at(&self, body: u32) -> &[u32] {
        &self.entries[self.starts[body as usize] as usize..self.starts[body as usize + 1] as usize]
    }

    /// The body at the other end.
    fn across(&self, joint: u32, body: u32) -> u32 {
        let [a, b] = self.joints[joint as usize];
        if a == body { b } else { a }
    }
}

/// One body reached in a breadth-first walk.
#[derive(Clone, Copy, Debug)]
struct Step {
    body: u32,
    /// Step that led here and by which joint; NONE at the root.
    from: u32,
    by: u32,
    /// Does not move: the end of a pin.
    pin: bool,
}

/// A breadth-first walk over one component, pins included.
struct Walk {
    /// Step at which a moving body was reached.
    seen: Vec<u32>,
    steps: Vec<Step>,
}

impl Walk {
    fn from(&mut self, root: u32, graph: &Graph, moves: &[bool]) {
        self.steps.clear();
        self.steps.push(Step { body: root, from: NONE, by: NONE, pin: false });
        self.seen[root as usize] = 0;
        let mut next = 0;
        while next < self.steps.len() {
            let Step { body, by, pin, .. } = self.steps[next];
            for &joint in if pin { &[] } else { graph.at(body) } {
                let other = graph.across(joint, body);
                let pin = !moves[other as usize];
                if joint == by || !pin && self.seen[other as usize] != NONE {
                    continue;
                }
                if !pin {
                    self.seen[other as usize] = self.steps.len() as u32;
                }
                self.steps.push(Step { body: other, from: next as u32, by: joint, pin });
            }
            next += 1;
        }
    }

    fn again(&mut self, root: u32, graph: &Graph, moves: &[bool]) {
        for step in self.steps.iter().filter(|step| !step.pin) {
            self.seen[step.body as usize] = NONE;
        }
        self.from(root, graph, moves);
    }

    fn moving(&self) -> impl Iterator<Item = &Step> {
        self.steps.iter().filter(|step| !step.pin)
    }

    /// Joints of the component, each once; each joint between moving bodies is listed at both.
    fn joints<'a>(&'a self, graph: &'a Graph) -> impl Iterator<Item = u32> + 'a {
        self.moving().flat_map(|step| {
            let own = graph.at(step.body).iter().copied();
            own.filter(|&joint| {
                graph.joints[joint as usize][0] == step.body || {
                    let other = graph.across(joint, step.body);
                    self.seen[other as usize] == NONE
                }
            })
        })
    }

    /// A connected graph of n bodies is a tree if and only if it has n − 1 joints.
    fn has_loop(&self, graph: &Graph, moves: &[bool]) -> bool {
        let inner = self.joints(graph).filter(|&joint| graph.joints[joint as usize].iter().all(|&b| moves[b as usize]));
        inner.count() + 1 != self.moving().count()
    }

    fn last_body(&self) -> u32 {
        self.moving().last().map_or(0, |step| step.body)
    }

    fn half_way_back(&self) -> u32 {
        let mut path = Vec::new();
        let mut at = self.seen[self.last_body() as usize];
        while at != NONE {
            path.push(self.steps[at as usize].body);
            at = self.steps[at as usize].from;
        }
        path[path.len() / 2]
    }

    /// The tree below the walk's root: the deepest joints first.
    fn tree(&self, graph: &Graph) -> JointTree {
        let local = self.local_indices();
        let moving = self.moving().count();
        let may_be_redundant = self.steps.len() > moving + 1;
        let mut tree = JointTree { moving, may_be_redundant, ..Default::default() };
        tree.bodies = vec![0; self.steps.len()];
        for (step, &index) in self.steps.iter().zip(&local) {
            tree.bodies[index as usize] = step.body;
        }
        for (step, &child) in self.steps.iter().zip(&local).skip(1).rev() {
            let sign = if graph.joints[step.by as usize][1] == step.body { 1.0 } else { -1.0 };
            tree.sources.push(step.by);
            tree.joints.push(TreeJoint::new(child, local[step.from as usize], sign));
        }
        tree.inertias = vec![TreeInertia::FIXED; tree.moving];
        tree.unknowns = vec![Vector3::zeros(); tree.joints.len()];
        tree.wrenches = vec![Twist::zero(); tree.moving];
        tree.displacements = vec![Displacement::default(); tree.bodies.len()];
        tree.earlier = tree.displacements.clone();
        tree.dampings = vec![Matrix3::identity(); tree.moving];
        tree.couple();
        tree
    }

    /// Steps in order, those that move before the pins.
    fn local_indices(&self) -> Vec<u32> {
        let (mut moving, mut pins) = (0, self.moving().count() as u32);
        let index = |step: &Step| {
            let next = if step.pin { &mut pins } else { &mut moving };
            *next += 1;
            *next - 1
        };
        self.steps.iter().map(index).collect()
    }
}

impl TreeJoint {
    fn new(child: u32, parent: u32, sign: f64) -> Self {
        Self {
            child,
            parent,
            next: NONE,
            next_is_sibling: false,
            child_hub: NONE,
            branch: NONE,
            sign,
            arm_child: Vector3::zeros(),
            arm_parent: Vector3::zeros(),
            pivot: Matrix3::zeros(),
            coupling: Matrix3::zeros(),
            scale: Vector3::zeros(),
            impulse: Vector3::zeros(),
        }
    }
}

impl JointTree {
    /// Links couple their two joints, hubs get their N.
    fn couple(&mut self) {
        let mut degree = vec![0; self.bodies.len()];
        let mut last = vec![NONE; self.bodies.len()];
        for (index, joint) in self.joints.iter().enumerate() {
            for body in [joint.child, joint.parent] {
                degree[body as usize] += 1;
                last[body as usize] = index as u32;
            }
        }
        let mut hub_of = vec![NONE; self.bodies.len()];
        for body in (0..self.moving).filter(|&body| degree[body] > LINK) {
            hub_of[body] = self.hubs.len() as u32;
            self.hubs.push(Hub::new(body as u32));
        }
        for index in 0..self.joints.len() {
            let (child, parent) = (self.joints[index].child as usize, self.joints[index].parent as usize);
            let other = last[parent];
            let sibling = self.joints[other as usize].parent as usize == parent;
            let joint = &mut self.joints[index];
            joint.child_hub = hub_of[child];
            if hub_of[parent] != NONE {
                joint.branch = self.branches.len() as u32;
                let zero = Matrix3::zeros();
                self.branches.push(Branch { hub: hub_of[parent], linear: zero, angular: zero });
            } else if other != index as u32 {
                joint.next = other;
                joint.next_is_sibling = sibling;
            }
        }
    }
}

impl Hub {
    fn new(body: u32) -> Self {
        let zero = Matrix3::zeros();
        Self { body, linear: zero, mixed: zero, angular: zero, passing: Twist::zero() }
    }
}
