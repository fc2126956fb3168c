//! A mechanism: bodies that joints hold together, and what stays the same from step to step.
//!
//! Bodies that constraints move come first; those after them (static, kinematic, or of no concern here) have a zero
//! inverse mass. Links, its joints, stand in the order in which their rows are eliminated (see
//! [`Elimination`]).

use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};

use super::constants::KICKED_SPRING;
use super::rotation::{exponential, in_world};
use crate::physics::constraint::row::bounded;
use crate::physics::solver::linear::Elimination;

/// The properties of a body that do not change in a step. SI; world axes unless stated.
#[derive(Clone, Debug)]
pub(crate) struct Member {
    /// 0 for a body that constraints do not move.
    pub mass: f64,
    /// Zero along locked axes.
    pub inverse_mass: Vector3<f64>,
    /// Principal, body axes; zero for a body that constraints do not move.
    pub inertia: Vector3<f64>,
    /// 0 about a locked world axis, 1 else.
    pub freedom: Vector3<f64>,
    /// 1/s, linear and angular.
    pub drag: (f64, f64),
    pub force: Vector3<f64>,
    pub torque: Vector3<f64>,
}

impl Member {
    /// Whether constraints move it.
    pub fn moves(&self) -> bool {
        self.mass > 0.0
    }

    /// Whether its inertia is the same about all axes.
    pub fn is_round(&self) -> bool {
        self.inertia.x == self.inertia.y && self.inertia.y == self.inertia.z
    }

    /// Whether it turns about all axes.
    pub fn turns_freely(&self) -> bool {
        self.freedom == Vector3::repeat(1.0)
    }

    /// Kinetic energy, J.
    pub fn kinetic_energy(&self, state: &MemberState) -> f64 {
        let spin = state.rotation.inverse_transform_vector(&state.angular);
        0.5 * (self.mass * state.linear.norm_squared() + spin.dot(&self.inertia.component_mul(&spin)))
    }

    /// Inertia in world axes.
    pub fn world_inertia(&self, rotation: &Matrix3<f64>) -> Matrix3<f64> {
        if self.is_round() { Matrix3::from_diagonal(&self.inertia) } else { in_world(&self.inertia, rotation) }
    }

    /// The inverse of the world inertia plus `added`, on the axes about which it turns.
    pub fn inverse_inertia(&self, rotation: &Matrix3<f64>, added: Option<&Matrix3<f64>>) -> Matrix3<f64> {
        if !self.moves() {
            return Matrix3::zeros();
        }
        if added.is_none() && self.turns_freely() {
            let inverse = self.inertia.map(f64::recip);
            return if self.is_round() { Matrix3::from_diagonal(&inverse) } else { in_world(&inverse, rotation) };
        }
        let sum = self.world_inertia(rotation) + added.copied().unwrap_or_else(Matrix3::zeros);
        invert_on(&sum, &self.freedom)
    }
}

/// (P m P)⁺ for a symmetric positive definite m and a projection P on some axes.
fn invert_on(m: &Matrix3<f64>, freedom: &Vector3<f64>) -> Matrix3<f64> {
    let free = Matrix3::from_diagonal(freedom);
    let rest = Matrix3::from_diagonal(&freedom.map(|free| 1.0 - free));
    let inverse = (free * m * free + rest).try_inverse().unwrap_or_else(Matrix3::zeros);
    let inverse = free * inverse * free;
    (inverse + inverse.transpose()) * 0.5
}

/// Pose and velocity of a member.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct MemberState {
    pub position: Vector3<f64>,
    pub rotation: UnitQuaternion<f64>,
    pub linear: Vector3<f64>,
    pub angular: Vector3<f64>,
}

impl MemberState {
    /// At rest at the origin.
    pub const REST: Self = Self {
        position: Vector3::new(0.0, 0.0, 0.0),
        rotation: UnitQuaternion::new_unchecked(Quaternion::new(1.0, 0.0, 0.0, 0.0)),
        linear: Vector3::new(0.0, 0.0, 0.0),
        angular: Vector3::new(0.0, 0.0, 0.0),
    };

    /// Whether it does not move.
    pub fn is_still(&self) -> bool {
        self.linear == Vector3::zeros() && self.angular == Vector3::zeros()
    }

    /// Moves on with the present velocities for h, s.
    pub fn drift(&mut self, h: f64) {
        self.position += self.linear * h;
        self.turn(&(self.angular * h));
    }

    /// Turns by a rotation vector.
    pub fn turn(&mut self, turn: &Vector3<f64>) {
        if *turn != Vector3::zeros() {
            self.rotation = UnitQuaternion::new_normalize((exponential(turn) * self.rotation).into_inner());
        }
    }
}

/// A ball joint between two members.
#[derive(Clone, Debug)]
pub(crate) struct MechanismLink {
    pub a: u32,
    pub b: u32,
    /// From the centres of mass, body axes.
    pub anchor_a: Vector3<f64>,
    pub anchor_b: Vector3<f64>,
    pub spring: Option<JointSpring>,
}

/// A spring in place of a rigid joint: λ = −m (ω² C + 2ζω Ċ) along each axis, m the effective mass there; where its norm is
/// over the largest force, the force of that size along it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct JointSpring {
    /// ω, rad/s.
    pub frequency: f64,
    /// ζ.
    pub damping_ratio: f64,
    /// Largest norm of the force, N.
    pub most: f64,
}

impl JointSpring {
    /// −(ω²C + 2ζωĊ), m/s²: its unbounded force on B for each kg.
    pub fn ask(&self, apart: &Vector3<f64>, speed: &Vector3<f64>) -> Vector3<f64> {
        (apart * self.frequency + speed * (2.0 * self.damping_ratio)) * -self.frequency
    }

    /// The mean of that over a kick of that time, s. Damped motion decays exponentially, so that no damping is too
    /// strong; a spring too stiff for the time is softened.
    pub fn ask_in_kick(&self, apart: &Vector3<f64>, speed: &Vector3<f64>, time: f64) -> Vector3<f64> {
        let stiffness = self.frequency.min(KICKED_SPRING / time).powi(2);
        let damping = -(-2.0 * self.damping_ratio * self.frequency * time).exp_m1() / time;
        apart * -stiffness - speed * damping
    }

    /// The force on B for that acceleration along axes of that mobility, 1/kg, in N.
    pub fn give(&self, asked: &Vector3<f64>, mobility: &Vector3<f64>) -> Vector3<f64> {
        bounded(self.elastic(asked, mobility), self.most)
    }

    /// The same without its bound.
    pub fn elastic(&self, asked: &Vector3<f64>, mobility: &Vector3<f64>) -> Vector3<f64> {
        asked.zip_map(mobility, |asked, mobility| if mobility > 0.0 { asked / mobility } else { 0.0 })
    }
}

/// Separation of B's anchor from A's, m, and its rate, m/s, for those arms from the centres of mass.
pub(super) fn stretch(link: &MechanismLink, arms: &[Vector3<f64>; 2], states: &[MemberState]) -> [Vector3<f64>; 2] {
    let (a, b) = (&states[link.a as usize], &states[link.b as usize]);
    let apart = b.position - a.position + (arms[1] - arms[0]);
    [apart, b.linear + b.angular.cross(&arms[1]) - a.linear - a.angular.cross(&arms[0])]
}

/// A block of J M⁻¹ Jᵀ below the diagonal: two links that share a member that moves.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Coupling {
    /// Place and end (0: A, 1: B) of the link of the row and of the column.
    pub row: (u32, usize),
    pub column: (u32, usize),
    pub member: u32,
    pub sign: f64,
    /// Block of the factor.
    pub block: u32,
}

/// The links at each of the first `moving` members, with the end (0: A, 1: B) that is there.
pub(crate) fn links_at(moving: usize, links: &[[u32; 2]]) -> Vec<Vec<(u32, usize)>> {
    let mut at = vec![Vec::new(); moving];
    for (link, ends) in (0..).zip(links) {
        for (end, &member) in ends.iter().enumerate().filter(|(_, member)| (**member as usize) < moving) {
            at[member as usize].push((link, end));
        }
    }
    at
}

/// Which links share members, and in what order they are to be eliminated.
pub(crate) struct Couplings {
    /// The link at each place.
    pub order: Vec<u32>,
    pub elimination: Elimination,
    pub list: Vec<Coupling>,
}

impl Couplings {
    /// Of that many links, from [`links_at`] of their members.
    pub fn of(at: &[Vec<(u32, usize)>], links: usize) -> Self {
        let pairs = (0..).zip(at).flat_map(|(member, ends)| {
            let earlier = move |later: usize| ends[..later].iter().map(move |&one| (member, one, ends[later]));
            (1..ends.len()).flat_map(earlier).filter(|(_, one, other)| one.0 != other.0)
        });
        let edges = pairs.clone().map(|(_, one, other)| [one.0, other.0]);
        let elimination = Elimination::new(&vec![3; links], edges, usize::MAX).unwrap_or_default();
        let mut order = vec![0; links];
        for link in 0..links as u32 {
            order[elimination.place(link) as usize] = link;
        }
        let coupling = |(member, one, other): (u32, (u32, usize), (u32, usize))| {
            let (block, one_is_column) = elimination.block(one.0, other.0);
            let (column, row) = if one_is_column { (one, other) } else { (other, one) };
            let place = |(link, end): (u32, usize)| (elimination.place(link), end);
            let sign = if row.1 == column.1 { 1.0 } else { -1.0 };
            Coupling { row: place(row), column: place(column), member, sign, block }
        };
        let list = pairs.map(coupling).collect();
        Self { order, elimination, list }
    }
}

/// Links from the member that is held, or the first one, outwards, each with its nearer end; none if not all members
/// are reached, each once.
fn walk(moving: usize, links: &[[u32; 2]], at: &[Vec<(u32, usize)>]) -> Option<Vec<(u32, usize)>> {
    let moves = |member: u32| (member as usize) < moving;
    let held = (0..).zip(links).find(|(_, ends)| !ends.iter().all(|&member| moves(member)));
    let mut tree: Vec<(u32, usize)> = Vec::with_capacity(links.len());
    let mut reached = vec![false; moving];
    let reach = |link: u32, end: usize, tree: &mut Vec<(u32, usize)>, reached: &mut [bool]| {
        tree.push((link, end));
        !std::mem::replace(&mut reached[links[link as usize][1 - end] as usize], true)
    };
    match held {
        Some((link, ends)) => _ = reach(link, usize::from(moves(ends[0])), &mut tree, &mut reached),
        None => {
            *reached.first_mut()? = true;
            for &(link, end) in &at[0] {
                if !reach(link, end, &mut tree, &mut reached) {
                    return None;
                }
            }
        }
    }
    let mut next = 0;
    while let Some(&(by, end)) = tree.get(next) {
        let member = links[by as usize][1 - end];
        for &(link, end) in at[member as usize].iter().filter(|(link, _)| *link != by) {
            if !moves(links[link as usize][1 - end]) || !reach(link, end, &mut tree, &mut reached) {
                return None;
            }
        }
        next += 1;
    }
    reached.iter().all(|&reached| reached).then_some(tree)
}

/// Bodies and joints, and the structure of their rows.
#[derive(Clone, Debug, Default)]
pub(crate) struct Mechanism {
    pub members: Vec<Member>,
    /// The number of members that constraints move: the first ones.
    pub moving: usize,
    pub links: Vec<MechanismLink>,
    pub states: Vec<MemberState>,
    /// Whether some link is a spring.
    pub gives: bool,
    /// Where the members that move make a tree, held at one point or none: its links from the root outwards, each with
    /// the end (0: A, 1: B) that is nearer to the root.
    pub(super) tree: Option<Vec<(u32, usize)>>,
    /// Whether rows may be redundant or contradict each other: loops, several fixed points, locked axes.
    pub may_be_singular: bool,
    pub(super) elimination: Elimination,
    pub(super) couplings: Vec<Coupling>,
}

impl Mechanism {
    /// The order in which `links` (pairs of members) are to stand, and a mechanism without members and links whose
    /// structure is for that order. `locked`: axes of some member are locked; `gives`: some link is a spring.
    pub fn plan(moving: usize, locked: bool, gives: bool, links: &[[u32; 2]]) -> (Vec<u32>, Self) {
        let at = links_at(moving, links);
        let Couplings { order, elimination, list } = Couplings::of(&at, links.len());
        // A tree of so many bodies with one fixed point has as many links; any more close a loop.
        let may_be_singular = locked || links.len() > moving;
        let tree = if may_be_singular || gives { None } else { walk(moving, links, &at) };
        let tree = tree.map(|tree| tree.into_iter().map(|(link, end)| (elimination.place(link), end)).collect());
        (order, Self { moving, may_be_singular, gives, tree, elimination, couplings: list, ..Self::default() })
    }
}
