//! Puts the joints of an island together in its poses alone, the nearest way by masses.
//!
//! Newton's method on the gaps C of what is rigid, each time with the least ½ ΔqᵀMΔq + ½ Σ ρ (J Δq + C)²,
//!
//! (M + JᵀρJ) Δq = −JᵀρC,
//!
//! by the blocks of the bodies ([`linear`](crate::physics::solver::linear)): on a tree two products of 6 × 6 blocks a
//! body, and rows may be redundant. What the penalty leaves, 1/ρ of a gap, goes in the next iteration with what J turned.

use nalgebra::Matrix3;

use super::constants::{JOINT_PENALTY, PROJECTED, PROJECTION_ERROR, PROJECTIONS};
use super::rows::{body_vector, halves};
use super::world::{World, inertia_at, place_among, share_within};
use crate::physics::body::{Body, world_inverse_inertia};
use crate::physics::constraint::row::Twist;
use crate::physics::joint::{BodyState, Bound, JointRow};
use crate::physics::solver::exact::MemberState;
use crate::physics::solver::linear::{BlockLdl, BodyVector, Elimination, Inverse};

/// A joint of the island.
#[derive(Clone, Debug)]
struct Link {
    /// Global index.
    joint: u32,
    /// Places among the states; those of bodies that do not move come last.
    ends: [u32; 2],
    /// Nodes of the matrix, of bodies that move.
    nodes: [Option<u32>; 2],
}

/// A body that moves and is held by a joint.
#[derive(Clone, Debug)]
struct Node {
    /// Its place among the members.
    local: u32,
    /// 1/M.
    inverse_mass: f64,
    inverse_inertia: Matrix3<f64>,
}

/// The joints of an island, with buffers.
#[derive(Clone, Default)]
pub(super) struct Posture {
    links: Vec<Link>,
    nodes: Vec<Node>,
    elimination: Elimination,
    matrix: BlockLdl<f64, Inverse>,
    /// Members, then partners.
    states: Vec<MemberState>,
    /// How far the last projection moved each member.
    pub shifts: Vec<Twist<f64>>,
    /// By place in the elimination.
    moves: Vec<BodyVector>,
    /// Of all links, one after the other, and how many each has.
    rows: Vec<JointRow<f64>>,
    counts: Vec<usize>,
}

impl Posture {
    /// Of the joints of an island, by their global indices, between its members and partners; none where that takes more
    /// than so many products of blocks.
    pub fn new(world: &impl World, [members, partners, joints]: [&[u32]; 3], most: usize) -> Option<Self> {
        let place = |body: u32| place_among([members, partners], body);
        let mut node_of = vec![None; members.len()];
        let mut nodes = Vec::new();
        let mut node = |end: u32| {
            let own = node_of.get_mut(end as usize)?;
            Some(*own.get_or_insert_with(|| {
                nodes.push(Node { local: end, inverse_mass: 0.0, inverse_inertia: Matrix3::zeros() });
                nodes.len() as u32 - 1
            }))
        };
        let link = |&joint: &u32| {
            let ends = [world.joint(joint).a, world.joint(joint).b].map(place);
            Link { joint, ends, nodes: ends.map(&mut node) }
        };
        let links: Vec<Link> = joints.iter().map(link).collect();
        let edges = links.iter().filter_map(|link| Some([link.nodes[0]?, link.nodes[1]?]));
        let elimination = Elimination::new(&vec![6; nodes.len()], edges, most)?;
        Some(Self { links, nodes, elimination, ..Self::default() })
    }

    /// Has its joints find their bodies anew among the members, which are the same, and the partners.
    pub fn place(&mut self, world: &impl World, bodies: [&[u32]; 2]) {
        for link in &mut self.links {
            let joint = world.joint(link.joint);
            link.ends = [joint.a, joint.b].map(|body| place_among(bodies, body));
        }
    }

    /// Moves the members from these states at that time, s, those of partners behind them, to where their joints hold, the
    /// nearest by masses, and not further than so many metres at once; velocities stay. They are then in
    /// [`Self::projected`], and how far each went in [`Self::shifts`].
    pub fn project(
        &mut self,
        world: &impl World,
        members: &[u32],
        states: impl Iterator<Item = MemberState>,
        time: f64,
        most: f64,
    ) {
        self.states.clear();
        self.states.extend(states);
        self.shifts.clear();
        self.shifts.resize(members.len(), Twist::zero());
        for _ in 0..PROJECTIONS {
            let worst = self.place_rows(world, time);
            if worst <= PROJECTION_ERROR || !worst.is_finite() {
                return;
            }
            if !self.close_gaps(world, members, most) || worst <= PROJECTED {
                return;
            }
        }
    }

    /// The members' states after [`Self::project`].
    pub fn projected(&self) -> &[MemberState] {
        &self.states[..self.shifts.len()]
    }

    /// The rows at the states. The largest gap, m or rad.
    fn place_rows(&mut self, world: &impl World, time: f64) -> f64 {
        let Self { links, states, rows, counts, .. } = self;
        rows.clear();
        counts.clear();
        for link in links {
            let first = rows.len();
            let bodies = link.ends.map(|end| BodyState::from(&states[end as usize]));
            world.joint(link.joint).definition.rows_at(&bodies, time, rows);
            counts.push(rows.len() - first);
        }
        rows.iter().map(gap).fold(0.0, |worst: f64, gap| if gap.is_nan() { gap } else { worst.max(gap.abs()) })
    }

    /// Moves the members towards where their gaps are closed, no point of a body further than `most`, m. False if that
    /// way cannot be found.
    fn close_gaps(&mut self, world: &impl World, members: &[u32], most: f64) -> bool {
        self.assemble(world, members);
        if !self.matrix.factor(&self.elimination) {
            return false;
        }
        self.matrix.solve(&self.elimination, &mut self.moves[..]);
        let Self { nodes, elimination, moves, states, shifts, .. } = self;
        let moves = nodes.iter().zip(0..).map(|(node, place)| {
            let (linear, angular) = halves(&moves[elimination.place(place) as usize]);
            (node.local as usize, Twist { linear, angular })
        });
        let share = share_within(most, moves.clone().map(|(local, moved)| (world.body(members[local]), moved)));
        if !share.is_finite() {
            return false;
        }
        for (local, moved) in moves {
            let moved = Twist::zero().plus(&moved, share);
            states[local].position += moved.linear;
            states[local].turn(&moved.angular);
            shifts[local] = shifts[local].plus(&moved, 1.0);
        }
        true
    }

    /// M + JᵀρJ and −JᵀρC.
    fn assemble(&mut self, world: &impl World, members: &[u32]) {
        let Self { links, nodes, elimination, matrix, states, moves, rows, counts, .. } = self;
        matrix.clear(elimination);
        moves.clear();
        moves.resize(nodes.len(), BodyVector::zeros());
        for (node, place) in nodes.iter_mut().zip(0..) {
            let Body { inverse_inertia_body, rotation_freedom, mass, .. } = world.body(members[node.local as usize]);
            let rotation = &states[node.local as usize].rotation;
            node.inverse_mass = 1.0 / mass;
            node.inverse_inertia = world_inverse_inertia(inverse_inertia_body, rotation, rotation_freedom);
            let mut block = matrix.diagonal_mut::<6>(elimination.place(place) as usize);
            block.fixed_view_mut::<3, 3>(0, 0).copy_from(&Matrix3::from_diagonal_element(*mass));
            block.fixed_view_mut::<3, 3>(3, 3).copy_from(&inertia_at(rotation, inverse_inertia_body));
        }
        let mut rest = &rows[..];
        for (link, &count) in links.iter().zip(&*counts) {
            let own;
            (own, rest) = rest.split_at(count);
            let place_of = link.nodes.map(|node| Some(elimination.place(node?) as usize));
            let across = link.nodes[0].zip(link.nodes[1]).map(|(a, b)| elimination.block(a, b));
            for row in own.iter().filter(|row| is_placed(row)) {
                let jacobian = [0, 1].map(|side| row.jacobian.of(side));
                let mobility: f64 = (0..2)
                    .filter_map(|side| Some((&nodes[link.nodes[side]? as usize], &jacobian[side])))
                    .map(|(node, row)| {
                        node.inverse_mass * row.linear.norm_squared()
                            + row.angular.dot(&(node.inverse_inertia * row.angular))
                    })
                    .sum();
                if mobility <= 0.0 {
                    continue;
                }
                let penalty = JOINT_PENALTY / mobility;
                let [a, b] = jacobian.map(|row| body_vector(&row.linear, &row.angular));
                for (place, side) in place_of.iter().zip([&a, &b]) {
                    if let Some(place) = *place {
                        let mut block = matrix.diagonal_mut::<6>(place);
                        block += (side * penalty) * side.transpose();
                        moves[place] += side * (penalty * gap(row));
                    }
                }
                if let Some(across) = across {
                    matrix.add(across, &((a * penalty) * b.transpose()));
                }
            }
        }
    }
}

/// Whether it is to be at its place: what a largest force keeps from it has a right to its error.
fn is_placed(row: &JointRow<f64>) -> bool {
    let is_open = row.bound != Bound::None && row.bound.open(row.error) == row.error;
    row.spring.is_none() && !row.is_rate && !row.bound.is_boxed() && !is_open
}

/// −C of what is to be closed, m or rad.
fn gap(row: &JointRow<f64>) -> f64 {
    if is_placed(row) { row.bound.open(row.error) - row.error } else { 0.0 }
}
