//! A mechanism: bodies that joints hold together, and what stays the same from step to step.
//!
//! Bodies that constraints move come first; those after them (static, kinematic, or of no concern here) have a zero
//! inverse mass. Links, its joints, stand in the order in which their rows are eliminated (see
//! [`Elimination`]).

use std::ops::Range;
use std::sync::Arc;

use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};

use super::constants::KICKED_SPRING;
use super::redundancy::may_be_redundant;
use super::rotation::{exponential, in_world};
use super::row_mode::RowMode;
use crate::physics::body::free_rotation::free_rotation;
use crate::physics::constraint::row::{Twist, Wrench, bounded};
use crate::physics::joint::{BodyState, Bound, JointDefinition, JointRow, LawPart, SpringConstants};
use crate::physics::solver::linear::Elimination;

/// The properties of a body that do not change in a step. SI; world axes unless stated.
#[derive(Clone, Debug, PartialEq)]
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

    /// What forces leave for joints at an acceleration: F − (0, ω × I ω) − M a, drag included.
    pub fn wrench(&self, state: &MemberState, rotation: &Matrix3<f64>, acceleration: &Twist<f64>) -> Wrench<f64> {
        if !self.moves() {
            return Wrench::zero();
        }
        let slowed = state.linear * self.drag.0 + acceleration.linear;
        let change = if self.is_round() && self.drag.1 == 0.0 {
            acceleration.angular * self.inertia.x
        } else {
            // In body axes, where the inertia is diagonal.
            let (spin, gain) = (rotation.tr_mul(&state.angular), rotation.tr_mul(&acceleration.angular));
            let momentum = self.inertia.component_mul(&spin);
            rotation * (self.inertia.component_mul(&gain) + spin.cross(&momentum) + momentum * self.drag.1)
        };
        Wrench { linear: self.force - slowed * self.mass, angular: self.torque - change }
    }

    /// Inertia in world axes.
    fn world_inertia(&self, rotation: &Matrix3<f64>) -> Matrix3<f64> {
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

    /// A kick of forces and drag over h, with an impulse besides.
    pub fn kick(&self, state: &mut MemberState, impulse: &Wrench<f64>, inverse_mass: &InverseMass, h: f64) {
        if !self.moves() {
            return;
        }
        let given = Wrench { linear: self.force * h + impulse.linear, angular: self.torque * h + impulse.angular };
        let gain = inverse_mass.of(&given);
        let kept = ((-self.drag.0 * h).exp(), (-self.drag.1 * h).exp());
        state.linear = state.linear * kept.0 + gain.linear;
        state.angular = state.angular * kept.1 + gain.angular;
    }

    /// Free motion over h.
    pub fn move_freely(&self, state: &mut MemberState, h: f64) {
        let inverse = self.inertia.map(|inertia| if inertia > 0.0 { inertia.recip() } else { 0.0 });
        let free = free_rotation(&state.rotation, &state.angular, &inverse, &self.freedom, h);
        if let Some((angular, rotation)) = free {
            state.position += state.linear * h;
            (state.angular, state.rotation) = (angular, rotation);
        } else {
            state.drift(h);
        }
    }

    /// M⁻¹ in a state.
    pub fn inverse_mass_at(&self, state: &MemberState) -> InverseMass {
        let rotation = state.rotation.to_rotation_matrix().into_inner();
        InverseMass { linear: self.inverse_mass, angular: self.inverse_inertia(&rotation, None) }
    }
}

/// W of one member: zero where constraints do not move it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct InverseMass {
    pub linear: Vector3<f64>,
    pub angular: Matrix3<f64>,
}

impl InverseMass {
    #[inline]
    pub fn of(&self, wrench: &Wrench<f64>) -> Twist<f64> {
        Twist { linear: self.linear.component_mul(&wrench.linear), angular: self.angular * wrench.angular }
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

impl From<&MemberState> for BodyState {
    fn from(state: &MemberState) -> Self {
        Self::new(&state.position, &state.rotation, [&state.linear, &state.angular])
    }
}

impl MemberState {
    /// At rest at the origin.
    pub const REST: Self = Self {
        position: Vector3::new(0.0, 0.0, 0.0),
        rotation: UnitQuaternion::new_unchecked(Quaternion::new(1.0, 0.0, 0.0, 0.0)),
        linear: Vector3::new(0.0, 0.0, 0.0),
        angular: Vector3::new(0.0, 0.0, 0.0),
    };

    pub fn twist(&self) -> Twist<f64> {
        Twist { linear: self.linear, angular: self.angular }
    }

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

/// Kinetic energy of each member, J.
pub(super) fn kinetic_energies<'a>(members: &'a [Member], states: &'a [MemberState]) -> impl Iterator<Item = f64> + 'a {
    members.iter().zip(states).map(|(member, state)| member.kinetic_energy(state))
}

/// Whether nothing but constant forces does work on the members that move, the first so many.
pub(super) fn only_forces_work(
    members: &[Member],
    moving: usize,
    states: &[MemberState],
    links: &[MechanismLink],
) -> bool {
    states[moving..].iter().all(MemberState::is_still)
        && members[..moving].iter().all(|member| member.torque == Vector3::zeros())
        && !links.iter().any(MechanismLink::may_do_work)
}

/// A joint between two members.
#[derive(Clone, Debug)]
pub(crate) struct MechanismLink {
    pub a: u32,
    pub b: u32,
    pub definition: JointDefinition,
    /// Its rows among those of all links.
    pub rows: Range<usize>,
    /// Whether λ of some row may be bounded other than by a spring.
    pub may_be_bounded: bool,
    /// Whether all its rows are limits.
    only_limits: bool,
}

impl MechanismLink {
    /// Between bodies that are in those states at a time, s.
    pub fn new(definition: &JointDefinition, [a, b]: [u32; 2], states: [&MemberState; 2], time: f64) -> Self {
        let mut rows = Vec::new();
        definition.rows_at(&states.map(BodyState::from), time, &mut rows);
        let may_be_bounded =
            definition.function.is_some() || rows.iter().any(|row| matches!(row.bound, Bound::Within(..)));
        let only_limits = has_only_limits(definition, rows.len());
        Self { a, b, definition: definition.clone(), rows: 0..rows.len(), may_be_bounded, only_limits }
    }

    /// Takes in what of its joint changes from step to step: the numbers of its laws, and its turns. Whether the former
    /// are others than before.
    pub fn renew(&mut self, definition: &JointDefinition) -> bool {
        let is_same = match (&self.definition.laws, &definition.laws) {
            (Some(own), Some(laws)) => Arc::ptr_eq(own, laws),
            _ => true,
        };
        if !is_same {
            self.definition.laws.clone_from(&definition.laws);
            self.only_limits = has_only_limits(definition, self.rows.len());
        }
        self.definition.turned = definition.turned;
        !is_same
    }

    /// From the centre of mass of A (0) or of B (1), body axes.
    pub fn anchor(&self, end: usize) -> &Vector3<f64> {
        &self.definition.frames[end].anchor
    }

    pub fn ends(&self) -> [u32; 2] {
        [self.a, self.b]
    }

    /// Its rows that are translations.
    pub fn translations(&self) -> Range<usize> {
        let first = self.rows.start;
        first..self.rows.end.min(first + self.definition.translation.locked())
    }

    /// Whether it holds a point at a point, and nothing else.
    pub fn is_point(&self) -> bool {
        self.definition.is_ball() && !self.gives()
    }

    /// Whether springs stand for some of its rows.
    pub fn gives(&self) -> bool {
        self.definition.is_soft()
    }

    /// Whether it may do work on its bodies.
    pub fn may_do_work(&self) -> bool {
        self.definition.may_do_work()
    }

    /// Whether its rows may change with time.
    pub fn is_driven(&self) -> bool {
        self.definition.is_driven()
    }

    /// Adds its rows to those of the links before it.
    fn place_rows(&self, states: &[MemberState], time: f64, rows: &mut Vec<JointRow<f64>>) {
        let ends = self.ends().map(|member| BodyState::from(&states[member as usize]));
        self.definition.rows_at(&ends, time, rows);
        if rows.len() != self.rows.end {
            // A constraint of a user's own that is not what it promised.
            rows.resize(self.rows.end, JointRow::EMPTY);
        }
    }

    /// Ċ of its rows for the velocities in those states.
    pub fn rates<'r>(&self, rows: &'r [JointRow<f64>], states: &[MemberState]) -> impl Iterator<Item = f64> + use<'r> {
        let [a, b] = self.ends().map(|member| states[member as usize].twist());
        rows[self.rows.clone()].iter().map(move |row| row.jacobian.dot(&a, &b) + row.time_rate)
    }

    /// From B's centre of mass to its anchor, world axes.
    pub fn arm_b(&self, states: &[MemberState]) -> Vector3<f64> {
        states[self.b as usize].rotation * self.anchor(1)
    }

    /// The wrench on B about its anchor of that λ of all rows.
    pub fn load(&self, arm_b: &Vector3<f64>, rows: &[JointRow<f64>], lambda: &[f64]) -> Wrench<f64> {
        let own = rows[self.rows.clone()].iter().zip(&lambda[self.rows.clone()]);
        own.fold(Wrench::zero(), |sum, (row, &lambda)| sum.plus(&row.wrench_about(arm_b), lambda))
    }

    /// λ of its rows for such a load, where they are independent of each other.
    pub fn multipliers<'r>(
        &self,
        arm_b: &'r Vector3<f64>,
        rows: &'r [JointRow<f64>],
        load: &'r Wrench<f64>,
    ) -> impl Iterator<Item = f64> + 'r {
        rows[self.rows.clone()].iter().map(move |row| {
            let unit = row.wrench_about(arm_b);
            let square = unit.dot(&unit);
            if square > 0.0 { unit.dot(load) / square } else { 0.0 }
        })
    }
}

/// Whether all rows of a definition, of which there are so many, are limits.
fn has_only_limits(definition: &JointDefinition, rows: usize) -> bool {
    let laws = definition.laws.as_deref().unwrap_or_default();
    laws.len() == rows && laws.iter().all(|law| matches!(law.part, LawPart::Limit { .. }))
}

/// Gives links their rows one after the other.
pub(super) fn number_rows(links: &mut [MechanismLink]) {
    let mut end = 0;
    for link in links {
        link.rows = end..end + link.rows.len();
        end = link.rows.end;
    }
}

/// The rows of all links at those states and that time, s.
pub(super) fn place_rows(links: &[MechanismLink], states: &[MemberState], time: f64, rows: &mut Vec<JointRow<f64>>) {
    rows.clear();
    links.iter().for_each(|link| link.place_rows(states, time, rows));
}

/// A spring along up to three rows in place of rigid ones: λ = −m (s C + d Ċ) along each, with m the effective mass there
/// and s, d the stiffness and damping for each unit of it, or λ = −(k C + c Ċ) where these are given; where its norm is
/// over the largest force, the force of that size along it. Vectors here have zeros for rows that it has not.
#[derive(Clone, Debug)]
pub(crate) struct RowSpring {
    /// Its link.
    pub link: u32,
    /// Among the rows of all links.
    pub rows: Range<usize>,
    pub constants: SpringConstants,
    /// Largest norm of λ, N or N·m.
    pub most: f64,
}

impl RowSpring {
    /// The springs of the link of that index.
    pub fn of<'r>(
        (index, link): (usize, &MechanismLink),
        rows: &'r [JointRow<f64>],
    ) -> impl Iterator<Item = Self> + use<'r> {
        link.rows.clone().filter_map(move |first| match (rows[first].spring, rows[first].bound) {
            (Some(constants), Bound::Norm { most, place: 0, count }) => {
                Some(Self { link: index as u32, rows: first..first + count as usize, constants, most })
            }
            _ => None,
        })
    }

    /// A number of each row.
    pub fn each(&self, number: impl Fn(usize) -> f64) -> Vector3<f64> {
        Vector3::from_fn(|k, _| if k < self.rows.len() { number(self.rows.start + k) } else { 0.0 })
    }

    /// Stiffness and damping along rows of that mobility, 1/kg: the negative derivatives of λ.
    pub fn stiffness(&self, mobility: &Vector3<f64>) -> [Vector3<f64>; 2] {
        let masses = mobility.map(|mobility| if mobility > 0.0 { 1.0 / mobility } else { 0.0 });
        match self.constants {
            SpringConstants::PerMass { stiffness, damping } => [masses * stiffness, masses * damping],
            SpringConstants::Given { stiffness, damping } => {
                [stiffness, damping].map(|constant| self.each(|_| constant))
            }
        }
    }

    /// λ for those errors and rates along rows of that mobility, 1/kg.
    pub fn pull(&self, rows: &[JointRow<f64>], mobility: &Vector3<f64>) -> Vector3<f64> {
        bounded(self.elastic(rows, mobility), self.most)
    }

    /// The same without its bound.
    pub fn elastic(&self, rows: &[JointRow<f64>], mobility: &Vector3<f64>) -> Vector3<f64> {
        let [stiffness, damping] = self.stiffness(mobility);
        let (error, rate) = (self.each(|row| rows[row].error), self.each(|row| rows[row].rate));
        -(error.component_mul(&stiffness) + rate.component_mul(&damping))
    }

    /// The mean of λ over a kick of that time, s, for such rates. Damped motion decays exponentially, so that no damping
    /// is too strong; a spring too stiff for the time is softened.
    pub fn pull_in_kick(
        &self,
        rows: &[JointRow<f64>],
        rate: &Vector3<f64>,
        mobility: &Vector3<f64>,
        time: f64,
    ) -> Vector3<f64> {
        let most = (KICKED_SPRING / time).powi(2);
        let along = |row: usize| {
            let mass = if mobility[row] > 0.0 { 1.0 / mobility[row] } else { 0.0 };
            let [stiffness, damping] = self.constants.per_mass(mass);
            let error = rows[self.rows.start + row].error;
            mass * (error * stiffness.min(most) - rate[row] * (-damping * time).exp_m1() / time)
        };
        bounded(-Vector3::from_fn(|row, _| if row < self.rows.len() { along(row) } else { 0.0 }), self.most)
    }
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
#[derive(Clone, Default)]
pub(crate) struct Couplings {
    /// The link at each place.
    pub order: Vec<u32>,
    pub elimination: Elimination,
    pub list: Vec<Coupling>,
}

impl Couplings {
    /// Of links with so many rows each, from [`links_at`] of their members.
    pub fn of(at: &[Vec<(u32, usize)>], rows: &[u8]) -> Self {
        let pairs = (0..).zip(at).flat_map(|(member, ends)| {
            let earlier = move |later: usize| ends[..later].iter().map(move |&one| (member, one, ends[later]));
            (1..ends.len()).flat_map(earlier).filter(|(_, one, other)| one.0 != other.0)
        });
        let edges = pairs.clone().map(|(_, one, other)| [one.0, other.0]);
        let elimination = Elimination::new(rows, edges, usize::MAX).unwrap_or_default();
        let mut order = vec![0; rows.len()];
        for link in 0..rows.len() as u32 {
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

/// Whether rows of a mechanism may be redundant or contradict each other.
fn is_singular(moving: usize, locked: bool, links: &[MechanismLink]) -> bool {
    let pieces = links.iter().map(|link| (link.ends(), &link.definition));
    locked || links.iter().any(MechanismLink::is_driven) || may_be_redundant(moving, pieces)
}

/// Links from the member that is held, or the first one, outwards, each with its nearer end; none if they are no
/// tree.
fn walk(moving: usize, links: &[[u32; 2]], at: &[Vec<(u32, usize)>]) -> Option<Vec<(u32, usize)>> {
    let held = |ends: &[u32; 2]| ends.iter().position(|&member| member as usize >= moving);
    let held = (0..).zip(links).find_map(|(link, ends)| Some((link, held(ends)?)));
    let mut tree = held.map_or_else(|| at.first().cloned().unwrap_or_default(), |held| vec![held]);
    let mut next = 0;
    while let Some(&(by, end)) = tree.get(next) {
        let far = links[by as usize][1 - end];
        tree.extend(at[far as usize].iter().filter(|(link, _)| *link != by));
        if tree.len() > links.len() {
            return None;
        }
        next += 1;
    }
    (tree.len() == links.len()).then_some(tree)
}

/// Bodies and joints, and the structure of their rows.
#[derive(Clone, Debug, Default)]
pub(crate) struct Mechanism {
    pub members: Vec<Member>,
    /// The number of members that constraints move: the first ones.
    pub moving: usize,
    pub links: Vec<MechanismLink>,
    pub states: Vec<MemberState>,
    /// Whether some link has springs.
    pub gives: bool,
    /// Where all links are points and the members that move make a tree, held at one point or none: its links from the
    /// root outwards, each with the end (0: A, 1: B) that is nearer to the root.
    pub(super) tree: Option<Vec<(u32, usize)>>,
    /// Whether axes of some member are locked.
    pub locked: bool,
    /// Whether rows may be redundant or contradict each other: loops, several fixed points, locked axes, rows of a
    /// user's own.
    pub may_be_singular: bool,
    /// What each row does; empty where none has a bounded λ.
    pub modes: Vec<RowMode>,
    pub(super) elimination: Elimination,
    pub(super) couplings: Vec<Coupling>,
}

impl Mechanism {
    /// A mechanism of those links, without members, and where each of its links stood in the list. `locked`: axes of
    /// some member are locked.
    pub fn plan(moving: usize, locked: bool, links: &[MechanismLink]) -> (Vec<u32>, Self) {
        let ends: Vec<[u32; 2]> = links.iter().map(|link| link.ends()).collect();
        let rows: Vec<u8> = links.iter().map(|link| link.rows.len() as u8).collect();
        let at = links_at(moving, &ends);
        let Couplings { order, elimination, list } = Couplings::of(&at, &rows);
        let may_be_singular = is_singular(moving, locked, links);
        // A piece that closes no loop has as many links as bodies, or one less if nothing holds it.
        let is_tree = !may_be_singular && links.iter().all(MechanismLink::is_point);
        let place = |(link, end): (u32, usize)| (elimination.place(link), end);
        let tree = if is_tree { walk(moving, &ends, &at) } else { None };
        let tree = tree.map(|tree| tree.into_iter().map(place).collect());
        let gives = links.iter().any(MechanismLink::gives);
        let mut links: Vec<_> = order.iter().map(|&link| links[link as usize].clone()).collect();
        number_rows(&mut links);
        let plan = Self {
            moving,
            locked,
            may_be_singular,
            gives,
            tree,
            elimination,
            couplings: list,
            links,
            ..Self::default()
        };
        (order, plan)
    }

    /// Takes in what of each link's joint changes from step to step.
    pub fn renew<'d>(&mut self, definitions: impl Iterator<Item = &'d JointDefinition>) {
        let renewed = self.links.iter_mut().zip(definitions).map(|(link, definition)| link.renew(definition));
        // Not `any`, which would leave out those after the first.
        if renewed.fold(false, |some, changed| some | changed) {
            self.may_be_singular = is_singular(self.moving, self.locked, &self.links);
        }
    }

    /// The rows of all links at those states and that time, s, as their modes have them. Limits that are open are left empty,
    /// where a link has no others.
    pub fn place_rows(&self, states: &[MemberState], time: f64, rows: &mut Vec<JointRow<f64>>) {
        rows.clear();
        for link in &self.links {
            let modes = self.modes.get(link.rows.clone()).unwrap_or_default();
            if link.only_limits && !modes.is_empty() && modes.iter().all(|mode| mode.is_at_bound()) {
                rows.resize(link.rows.end, JointRow { bound: Bound::Within(0.0, 0.0), ..JointRow::EMPTY });
                continue;
            }
            link.place_rows(states, time, rows);
            for (row, mode) in rows[link.rows.clone()].iter_mut().zip(modes) {
                mode.apply(row);
            }
        }
    }

    /// Rows of all links.
    pub fn rows(&self) -> usize {
        self.links.last().map_or(0, |link| link.rows.end)
    }
}
