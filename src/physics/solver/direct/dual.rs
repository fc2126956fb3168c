//! Islands of joints without contacts, in motion, by the impulses of their rows: SHAKE (Ryckaert, Ciccotti and Berendsen
//! 1977) for joints of any rows, with limits, springs, motors and friction among them.
//!
//! A substep from q₀ to q₁ = q₀ ⊕ h v, with v half a substep behind the poses, is
//!
//! v = D v₋ + h M⁻¹ f + W J₀ᵀ λ,  W = (M + stiffness)⁻¹,
//!
//! with λ such that at its end each row holds: C(q₁, t₁) = 0 where it is held, C(q₁) ≥ 0 and λ ≥ 0 where it is a limit,
//! J₀ v + ∂C/∂t = rate where it has a rate alone. It is found by Newton's method with A = J₀ W J₀ᵀ in place of
//! J₁ W J₀ᵀ, so that a substep takes one factorisation: A by blocks of joints that share a body, in the order of
//! [`Couplings`]. W has the geometric stiffness that the substep cannot resolve ([`StiffnessShares`]), D takes out what
//! that is to damp.
//!
//! *Springs* are Newmark's with β = ¼, of second order and stable whatever ωh: with y = J₀ v and y₋ = J₀ v₋,
//!
//! λ = −h k C₀ − ¼ h² k (y − y₋) − ½ h c (y + y₋).
//!
//! One that is too stiff for the substep to tell its motion would ring on from substep to substep, at any speed; it goes
//! over to Euler's implicit rule, λ = −h k (C₀ + h y) − h c y, which takes it to where it is at rest.
//!
//! A substep in which a body turns so far that no λ leads there is cut into halves. The velocities that somebody gave a
//! body are those of its poses: its first substep takes half the kick.
//!
//! *Bounds.* A row at its bound has that impulse and leaves the matrix; which rows are, is an active set that is mended
//! after each solve. A motion with a largest force that lags behind comes back as fast as that force can stop it again,
//! at √(2 a |C|) where it gives an acceleration a.
//!
//! *Trees* of points, hinges and rigid joints whose limits carried nothing last go by [`articulated`](super::articulated)
//! inertias, without rows; where a limit turns out to be passed at the end, the substep is done again by rows.

use bevy::platform::collections::HashMap;
use nalgebra::{Matrix3, Vector3};

use super::articulated::{ArticulatedTree, Piece, TreeJoint};
use super::constants::{
    DUAL_ACCEPTED, DUAL_ACTIVE_SETS, DUAL_ERRORS, DUAL_ITERATIONS, DUAL_LAG, DUAL_LEFT, DUAL_LOOSE, DUAL_PIECES,
    DUAL_PRODUCTS, DUAL_SHIFTS, DUAL_SOFTER, DUAL_START_ERROR, DUAL_STIFF, DUAL_THROWN,
};
use super::posture::Posture;
use super::world::{World, place_among, share_within, state_of, world_inertia};
use crate::physics::body::Body;
use crate::physics::body::free_rotation::turn_freely;
use crate::physics::constraint::row::{RowPair, Twist, Wrench, bounded};
use crate::physics::joint::{BodyState, Bound, Joint, JointRow};
use crate::physics::solver::exact::{Couplings, MemberState, links_at};
use crate::physics::solver::joint_tree::{StiffnessShares, add_stiffness};
use crate::physics::solver::linear::{BlockLdl, Triangular};

/// What a substep depends on beside the world.
#[derive(Clone, Copy, Debug)]
pub(super) struct DualTerms {
    /// Simulation time at its start, and its length, s.
    pub time: f64,
    pub h: f64,
    /// Fastest correction of errors that the island starts with, m/s.
    pub correction_speed: f64,
    /// Approach from which limits bounce, m/s or rad/s.
    pub least_bounce: f64,
}

/// What a row is to do in a substep.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Aim {
    /// C(q₁, t₁) = 0.
    Place,
    /// Its rate, ∂C/∂t included, is that one.
    Rate(f64),
    /// λ = −weight (y + bias).
    Spring { weight: f64, bias: f64 },
    /// λ is that impulse.
    Fixed(f64),
}

/// A joint of the island.
#[derive(Clone, Debug)]
struct DualLink {
    /// Global index.
    joint: u32,
    /// Places among the states; those of bodies that do not move come last.
    ends: [u32; 2],
    /// Its first row, and how many.
    first: usize,
    count: usize,
}

/// M⁻¹ of a body, with stiffness.
#[derive(Clone, Copy, Debug)]
struct Mobility {
    inverse_mass: f64,
    inverse_inertia: Matrix3<f64>,
}

impl Mobility {
    const NONE: Self =
        Self { inverse_mass: 0.0, inverse_inertia: Matrix3::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0) };

    fn of(&self, wrench: &Wrench<f64>) -> Twist<f64> {
        Twist { linear: wrench.linear * self.inverse_mass, angular: self.inverse_inertia * wrench.angular }
    }
}

/// The joints of an island as one system, with its buffers.
#[derive(Clone, Default)]
pub(super) struct DualSystem {
    /// In the order of elimination.
    links: Vec<DualLink>,
    /// The place of each joint, by its global index.
    place_of: HashMap<u32, u32>,
    couplings: Couplings,
    pub has_loops: bool,
    /// Where what is held is a tree of points and hinges: takes the place of the rows as long as all limits are open.
    tree: Option<ArticulatedTree>,
    /// The place of each link among the joints of the tree; none of limits.
    in_tree: Vec<Option<u32>>,
    /// Whether the tree took the last piece.
    is_by_tree: bool,
    /// Scalar rows.
    pub row_count: usize,
    /// Where the bodies are when the substep begins: members, then partners.
    starts: Vec<MemberState>,
    /// Where they are at its end.
    pub ends: Vec<MemberState>,
    /// Velocities without the joints, and with them.
    free: Vec<Twist<f64>>,
    velocities: Vec<Twist<f64>>,
    mobilities: Vec<Mobility>,
    /// How far gaps would have each member move.
    moves: Vec<Twist<f64>>,
    /// By which its joints are put together in the poses, once that was needed.
    posture: Option<Posture>,
    /// Geometric stiffness of each member.
    stiffnesses: Vec<Matrix3<f64>>,
    rows: Vec<JointRow<f64>>,
    /// J₀ W of each row.
    responses: Vec<RowPair<f64>>,
    /// J₀ W J₀ᵀ of each row.
    diagonal: Vec<f64>,
    aims: Vec<Aim>,
    /// Errors at which rows that are to be at a place are held instead, m or rad.
    offsets: Vec<f64>,
    /// Those that are in the matrix as they were asked to, before bounds.
    asked: Vec<Aim>,
    impulses: Vec<f64>,
    /// With the least error so far.
    best: Vec<f64>,
    residual: Vec<f64>,
    /// Impulse on B and moment about its centre of mass of each link over the step so far, whose length is `spent`, s, and
    /// in its first piece and its last.
    loads: Vec<Wrench<f64>>,
    outer_loads: [Vec<Wrench<f64>>; 2],
    spent: f64,
    /// λ of each row in the last piece.
    forces: Vec<f64>,
    factor: BlockLdl<f64, Triangular>,
    scratch: Vec<JointRow<f64>>,
}

impl DualSystem {
    /// Of the joints of an island, by their global indices, between its members and partners; none where that takes more
    /// than so many products of blocks.
    pub fn new(world: &impl World, time: f64, [members, partners, joints]: [&[u32]; 3], most: usize) -> Option<Self> {
        let place = |body: u32| place_among([members, partners], body);
        let mut scratch = Vec::new();
        let mut count = |joint: &Joint| {
            let bodies = [joint.a, joint.b].map(|body| BodyState::of(world.body(body)));
            scratch.clear();
            joint.definition.rows_at(&bodies, time, &mut scratch);
            scratch.len()
        };
        let counted = joints.iter().map(|&joint| (joint, count(world.joint(joint))));
        let with_rows: Vec<(u32, usize)> = counted.filter(|&(_, rows)| rows > 0).collect();
        let ends = |joint: u32| [world.joint(joint).a, world.joint(joint).b].map(place);
        let all_ends: Vec<[u32; 2]> = with_rows.iter().map(|&(joint, _)| ends(joint)).collect();
        let rows: Vec<u8> = with_rows.iter().map(|&(_, rows)| rows as u8).collect();
        let at = links_at(members.len(), &all_ends);
        let couplings = Couplings::of(&at, &rows);
        if couplings.elimination.products() > most {
            return None;
        }
        let mut first = 0;
        let links: Vec<DualLink> = couplings
            .order
            .iter()
            .map(|&link| {
                let (joint, count) = with_rows[link as usize];
                first += count;
                DualLink { joint, ends: all_ends[link as usize], first: first - count, count }
            })
            .collect();
        let mut entities: Vec<_> = links.iter().map(|link| (world.joint(link.joint).entity, link.ends)).collect();
        entities.sort_unstable();
        entities.dedup();
        // A tree held at one point has as many joints as bodies.
        let held = entities.iter().filter(|(_, ends)| ends.iter().any(|&end| end as usize >= members.len())).count();
        let has_loops = entities.len() + usize::from(held == 0) > members.len();
        let definition = |link: &DualLink| &world.joint(link.joint).definition;
        let (mut joints, mut in_tree) = (Vec::new(), Vec::with_capacity(links.len()));
        for link in &links {
            let joint = TreeJoint::of(definition(link), link.ends);
            in_tree.push(joint.is_some().then_some(joints.len() as u32));
            joints.extend(joint);
        }
        let is_all = links.iter().zip(&in_tree).all(|(link, place)| place.is_some() || definition(link).only_limits());
        let tree = is_all.then(|| ArticulatedTree::new(&joints, members.len())).flatten();
        let loads = vec![Wrench::zero(); links.len()];
        let place_of = (0..).zip(&links).map(|(place, link)| (link.joint, place)).collect();
        Some(Self { links, place_of, couplings, has_loops, tree, in_tree, loads, row_count: first, ..Self::default() })
    }

    /// Takes the island through a substep: where its members are at its end stands in [`Self::ends`].
    pub fn substep(
        &mut self,
        world: &impl World,
        members: &[u32],
        partners: &[u32],
        terms: &DualTerms,
        is_first: bool,
    ) {
        self.starts.clear();
        self.starts.extend(members.iter().chain(partners).map(|&body| state_of(world.body(body))));
        if is_first {
            self.begin(world);
        }
        // Velocities that somebody gave are those of the poses, half a substep before the ones sought for.
        let is_launch = is_first && members.iter().all(|&member| !world.body(member).has_stepped);
        let (mut done, mut pieces) = (0, 1);
        while done < pieces {
            let h = terms.h / f64::from(pieces);
            let kick = if is_launch && done == 0 { 0.5 * h } else { h };
            let terms = DualTerms { time: terms.time + h * f64::from(done), h, ..*terms };
            if !self.take_piece(world, members, &terms, kick) {
                // What turns too far for one is cut in two.
                if pieces < DUAL_PIECES {
                    (done, pieces) = (2 * done, 2 * pieces);
                    continue;
                }
                self.take_piece_by_velocities(world, [members, partners], &terms, kick);
            }
            done += 1;
            if done < pieces {
                self.starts.clone_from(&self.ends);
            }
        }
    }

    /// Takes the states from the starts to the ends, with forces that act for `kick`, s. Whether impulses were found.
    fn take_piece(&mut self, world: &impl World, members: &[u32], terms: &DualTerms, kick: f64) -> bool {
        if self.tree.is_some()
            && self.limits_are_open()
            && let Some(tree) = &mut self.tree
        {
            match tree.take_piece(world, members, &self.starts, &mut self.ends, [terms.h, kick]) {
                Piece::Done if self.passes_limits(world, terms) => self.resume_tree(),
                Piece::Done => {
                    self.note_tree(terms.h);
                    return true;
                }
                Piece::TooFar => return false,
                Piece::Apart => {}
            }
        }
        self.set_off(world, members, terms, kick);
        self.mend_start(world, members, terms);
        let is_solved =
            self.find_impulses(world, members, terms) <= DUAL_ACCEPTED && !self.throws(world, members, kick);
        if is_solved {
            self.note(terms.h, kick);
        }
        is_solved
    }

    /// Whether no limit carried anything in the last piece.
    fn limits_are_open(&self) -> bool {
        let mut limits = self.links.iter().zip(&self.in_tree).filter(|(_, in_tree)| in_tree.is_none());
        limits.all(|(link, _)| self.forces[link.first..link.first + link.count].iter().all(|force| *force == 0.0))
    }

    /// Whether some limit is passed at the end.
    fn passes_limits(&mut self, world: &impl World, terms: &DualTerms) -> bool {
        let Self { links, in_tree, ends, scratch, .. } = self;
        scratch.clear();
        for (link, _) in links.iter().zip(in_tree).filter(|(_, in_tree)| in_tree.is_none()) {
            let bodies = link.ends.map(|end| BodyState::from(&ends[end as usize]));
            world.joint(link.joint).definition.rows_at(&bodies, terms.time + terms.h, scratch);
        }
        scratch.iter().any(|row| (row.error - row.bound.open(row.error)).abs() > DUAL_LEFT)
    }

    /// Whether rows that only hold gave the bodies a good part of their energy: a piece in which a row turns far comes to
    /// places where it holds, but by pushing along where it was. Forces act for `kick`, s; the work of rows that do more than
    /// hold is ½ λ (y₀ + y₁) with their rates y at both ends. Bodies beside the members that move may give any energy.
    fn throws(&self, world: &impl World, members: &[u32], kick: f64) -> bool {
        let (mut fastest, mut driven) = (0.0_f64, 0.0);
        for link in &self.links {
            let old = link.ends.map(|end| self.starts[end as usize].twist());
            let now = link.ends.map(|end| self.velocities[end as usize]);
            for index in link.first..link.first + link.count {
                let row = &self.rows[index];
                let [before, after] = [old, now].map(|[a, b]| row.jacobian.dot(&a, &b));
                if matches!(self.aims[index], Aim::Place) && row.time_rate == 0.0 {
                    fastest = fastest.max(after.abs());
                } else {
                    driven += 0.5 * (before + after) * self.impulses[index];
                }
            }
        }
        let partners = &self.starts[members.len()..];
        if fastest <= DUAL_THROWN[0] || partners.iter().any(|state| state.twist() != Twist::zero()) {
            return false;
        }
        let (mut before, mut after) = (0.0, 0.0);
        for ((&member, state), velocity) in members.iter().zip(&self.starts).zip(&self.velocities) {
            let body = world.body(member);
            let inertia = world_inertia(body);
            let linear = state.linear + body.force * (kick / body.mass);
            let angular = state.angular + inertia.try_inverse().unwrap_or_else(Matrix3::zeros) * body.torque * kick;
            let energy = |linear: &Vector3<f64>, angular: &Vector3<f64>| {
                0.5 * (body.mass * linear.norm_squared() + angular.dot(&(inertia * angular)))
            };
            before += energy(&linear, &angular);
            after += energy(&velocity.linear, &velocity.angular);
        }
        after > (1.0 + DUAL_THROWN[1]) * (before + f64::max(driven, 0.0))
    }

    /// The same where no impulses along the rows as they start lead to joints that hold, as the piece turns them too far:
    /// velocities that keep to the rows, with which energy does not grow, and poses that are put together after them.
    fn take_piece_by_velocities(
        &mut self,
        world: &impl World,
        [members, partners]: [&[u32]; 2],
        terms: &DualTerms,
        kick: f64,
    ) {
        self.set_off(world, members, terms, kick);
        for row in &mut self.rows {
            // Gaps alone may be closed; what is apart is put together in the poses.
            (row.velocity_term, row.error) = (0.0, row.bound.open(row.error));
        }
        for _ in 0..DUAL_ACTIVE_SETS {
            self.start_impulses();
            self.assemble(if self.has_loops { DUAL_SOFTER[0] } else { 0.0 });
            self.set_velocities();
            self.find_residual(terms.h, true);
            self.take_correction();
            self.set_velocities();
            if !self.mend_active_set(terms, false) {
                break;
            }
        }
        self.note(terms.h, kick);
        self.drift(world, members, terms.h);
        let most = terms.correction_speed * terms.h;
        if self.posture.is_none() {
            let joints: Vec<u32> = self.links.iter().map(|link| link.joint).collect();
            self.posture = Posture::new(world, [members, partners, &joints], DUAL_PRODUCTS);
        }
        if let Some(posture) = &mut self.posture {
            posture.project(world, members, self.ends.iter().cloned(), terms.time + terms.h, most);
            self.ends[..members.len()].clone_from_slice(posture.projected());
        }
    }

    /// The rows at the start, what they are to do, and the velocities without them.
    fn set_off(&mut self, world: &impl World, members: &[u32], terms: &DualTerms, kick: f64) {
        self.place_rows(world, terms.time, false);
        self.set_mobilities(world, members, kick);
        self.kick(world, members, kick);
        self.set_aims(terms);
        self.offsets.clear();
        self.offsets.resize(self.rows.len(), 0.0);
    }

    /// Takes in what joints carried in the step before.
    fn begin(&mut self, world: &impl World) {
        self.spent = 0.0;
        self.loads.fill(Wrench::zero());
        self.forces.clear();
        for link in &self.links {
            self.forces.extend(&world.joint(link.joint).multipliers[..link.count]);
        }
        self.impulses.clone_from(&self.forces);
        self.resume_tree();
    }

    /// Hands the tree what its joints carried last, where rows told it.
    fn resume_tree(&mut self) {
        let Self { tree, links, in_tree, forces, .. } = self;
        if let Some(tree) = tree {
            let held = links.iter().zip(in_tree).filter(|(_, in_tree)| in_tree.is_some());
            tree.resume(held.map(|(link, _)| Vector3::from_column_slice(&forces[link.first..link.first + 3])));
        }
    }

    /// The rows at the start or at the end of the substep.
    fn place_rows(&mut self, world: &impl World, time: f64, at_end: bool) {
        let Self { rows, links, starts, ends, scratch, .. } = self;
        let states = if at_end { ends } else { starts };
        if !at_end {
            rows.clear();
        }
        for link in links {
            let bodies = link.ends.map(|end| BodyState::from(&states[end as usize]));
            let rows = if at_end { &mut *scratch } else { &mut *rows };
            world.joint(link.joint).definition.rows_at(&bodies, time, rows);
            rows.resize(link.first + link.count, JointRow::EMPTY);
        }
    }

    /// W of each body, from the pull of the joints in the substep before.
    fn set_mobilities(&mut self, world: &impl World, members: &[u32], h: f64) {
        let Self { links, rows, forces, starts, mobilities, free, stiffnesses, .. } = self;
        stiffnesses.clear();
        stiffnesses.resize(members.len(), Matrix3::zeros());
        for link in &*links {
            let own = link.first..link.first + link.count;
            let pull: Vector3<f64> =
                rows[own.clone()].iter().zip(&forces[own]).map(|(row, &λ)| row.jacobian.linear_b * (λ * h)).sum();
            let frames = &world.joint(link.joint).definition.frames;
            for (end, pull) in [(0, -pull), (1, pull)] {
                if let Some(stiffness) = stiffnesses.get_mut(link.ends[end] as usize) {
                    let arm = starts[link.ends[end] as usize].rotation * frames[end].anchor;
                    add_stiffness(stiffness, &arm, &pull);
                }
            }
        }
        mobilities.clear();
        free.clear();
        for ((&member, stiffness), state) in members.iter().zip(&*stiffnesses).zip(&*starts) {
            let body = world.body(member);
            let stiffness = stiffness * h;
            let (mut inertia, mut kept) = (world_inertia(body), state.angular);
            let smallest = 1.0 / body.inverse_inertia_body.max();
            if let Some(shares) = StiffnessShares::of(0.5 * stiffness.trace() / smallest) {
                inertia += stiffness * (shares.added + shares.damped);
                let lost = stiffness * (shares.damped * state.angular);
                kept -= inertia.cholesky().map_or_else(Vector3::zeros, |factor| factor.solve(&lost));
            }
            let inverse_inertia = inertia.try_inverse().unwrap_or_else(Matrix3::zeros);
            mobilities.push(Mobility { inverse_mass: 1.0 / body.mass, inverse_inertia });
            free.push(Twist { linear: state.linear, angular: kept });
        }
        mobilities.resize(starts.len(), Mobility::NONE);
        free.extend(starts[members.len()..].iter().map(MemberState::twist));
    }

    /// Forces act.
    fn kick(&mut self, world: &impl World, members: &[u32], h: f64) {
        for ((&member, free), mobility) in members.iter().zip(&mut self.free).zip(&self.mobilities) {
            let body = world.body(member);
            *free = free.plus(&mobility.of(&Wrench { linear: body.force, angular: body.torque }), h);
        }
        self.velocities.clone_from(&self.free);
    }

    /// What each row is to do, and its response.
    fn set_aims(&mut self, terms: &DualTerms) {
        let Self { links, rows, mobilities, responses, diagonal, asked, aims, free, forces, starts, .. } = self;
        responses.clear();
        diagonal.clear();
        asked.clear();
        aims.clear();
        for link in &*links {
            let [a, b] = link.ends.map(|end| &mobilities[end as usize]);
            let [free_a, free_b] = link.ends.map(|end| &free[end as usize]);
            let [old_a, old_b] = link.ends.map(|end| starts[end as usize].twist());
            for index in link.first..link.first + link.count {
                let row = &rows[index];
                let response = RowPair::new(a.of(&row.jacobian.of_a()), b.of(&row.jacobian.of_b()));
                let own = row.jacobian.diagonal(&response);
                let free_rate = row.jacobian.dot(free_a, free_b) + row.time_rate;
                let aim = aim_of(row, own, row.jacobian.dot(&old_a, &old_b), terms);
                responses.push(response);
                diagonal.push(own);
                asked.push(aim);
                aims.push(starting_aim(row, aim, forces[index], free_rate, terms.h));
            }
        }
    }

    /// Moves members out of what rows are apart when the substep begins, in their poses alone: somebody else left it, or a
    /// substep that did not converge. What would be moved faster than errors may be corrected stays apart in the substep:
    /// impulses that close gaps throw what they close.
    fn mend_start(&mut self, world: &impl World, members: &[u32], terms: &DualTerms) {
        let worst = self.find_gaps();
        if worst <= DUAL_START_ERROR {
            return;
        }
        let are_closed = self.close_gaps(world, members, DUAL_SOFTER[0], terms.correction_speed * terms.h);
        self.place_rows(world, terms.time, false);
        self.set_aims(terms);
        if !are_closed {
            self.find_gaps();
            self.offsets.iter_mut().zip(&self.residual).for_each(|(offset, gap)| *offset = -gap);
        }
    }

    /// What rows that are to be at a place are apart, which is left in the residual. The largest of it, m or rad.
    fn find_gaps(&mut self) -> f64 {
        let Self { rows, aims, residual, .. } = self;
        residual.clear();
        let error = |(row, aim): (&JointRow<f64>, &Aim)| match aim {
            Aim::Place => row.bound.open(row.error) - row.error,
            _ => 0.0,
        };
        residual.extend(rows.iter().zip(&*aims).map(error));
        residual.iter().fold(0.0, |worst: f64, error| worst.max(error.abs()))
    }

    /// Moves the starts towards where the gaps in the residual are closed, the nearest way by masses and no point of a body
    /// further than `most`, m; with at least so much of each row's mobility added. Near a pose in which rows are redundant
    /// that way may lead anywhere. Whether they went all the way.
    fn close_gaps(&mut self, world: &impl World, members: &[u32], softer: f64, most: f64) -> bool {
        self.assemble(softer);
        self.factor.solve(&self.couplings.elimination, &mut self.residual[..]);
        let Self { links, responses, residual, moves, starts, .. } = self;
        moves.clear();
        moves.resize(members.len(), Twist::zero());
        for link in &*links {
            for index in link.first..link.first + link.count {
                for (end, moved) in [(0, responses[index].of_a()), (1, responses[index].of_b())] {
                    if let Some(total) = moves.get_mut(link.ends[end] as usize) {
                        *total = total.plus(&moved, residual[index]);
                    }
                }
            }
        }
        let share = share_within(most, members.iter().map(|&member| world.body(member)).zip(moves.iter().copied()));
        if !share.is_finite() {
            return false;
        }
        for (place, moved) in moves.iter().enumerate() {
            let moved = Twist::zero().plus(moved, share);
            starts[place].position += moved.linear;
            starts[place].turn(&moved.angular);
        }
        share >= 1.0
    }

    /// Factors A of the rows that are in it, with at least that share of each row's mobility added to it.
    fn assemble(&mut self, softer: f64) {
        let Self { links, couplings, rows, responses, aims, factor, diagonal, has_loops, .. } = self;
        let shift = DUAL_SHIFTS[usize::from(*has_loops)].max(softer);
        factor.clear(&couplings.elimination);
        for (place, link) in links.iter().enumerate() {
            let n = link.count;
            let block = factor.diagonal_at(&couplings.elimination, place);
            for column in 0..n {
                let response = &responses[link.first + column];
                for row in column..n {
                    block[column * n + row] = rows[link.first + row].jacobian.diagonal(response);
                }
                let own = &mut block[column * n + column];
                *own += match aims[link.first + column] {
                    Aim::Place | Aim::Rate(_) => shift * diagonal[link.first + column],
                    Aim::Spring { weight, .. } if weight > 0.0 => 1.0 / weight,
                    Aim::Spring { .. } | Aim::Fixed(_) => DUAL_LOOSE,
                };
            }
        }
        for coupling in &couplings.list {
            let [row_link, column_link] = [coupling.row.0, coupling.column.0].map(|link| &links[link as usize]);
            let n = row_link.count;
            let block = factor.below_at(&couplings.elimination, coupling.block as usize);
            for (column, entries) in block.chunks_exact_mut(n).enumerate() {
                let response = responses[column_link.first + column].of(coupling.column.1);
                for (row, entry) in entries.iter_mut().enumerate() {
                    *entry += rows[row_link.first + row].jacobian.of(coupling.row.1).dot(&response);
                }
            }
        }
        factor.factor(&couplings.elimination);
    }

    /// The impulses with which all rows do what they are to. The largest error that is left, m or rad.
    fn find_impulses(&mut self, world: &impl World, members: &[u32], terms: &DualTerms) -> f64 {
        // Near a pose in which rows are redundant a factor may ask for more than a substep can follow: then a softer one
        // does.
        let softer: &[f64] = if self.has_loops { &DUAL_SOFTER } else { &[] };
        let mut left = f64::INFINITY;
        for round in 0..DUAL_ACTIVE_SETS {
            let mut least = (f64::INFINITY, 0.0);
            let mut last = 0.0;
            for &share in [0.0].iter().chain(softer) {
                (left, last) = (self.solve(share, world, members, terms), share);
                if left < least.0 {
                    least = (left, share);
                }
                if left <= DUAL_ACCEPTED {
                    break;
                }
            }
            if left > least.0 && last != least.1 {
                left = self.solve(least.1, world, members, terms);
            }
            if !left.is_finite() {
                break;
            }
            // In the last rounds rows only leave: so it ends.
            if !self.mend_active_set(terms, 2 * round <= DUAL_ACTIVE_SETS) {
                break;
            }
        }
        left.max(self.find_passed())
    }

    /// How far limits that have no impulse are passed at the end, m or rad.
    fn find_passed(&self) -> f64 {
        let Self { rows, scratch, aims, offsets, .. } = self;
        let ends = scratch.iter().zip(offsets).map(|(end, offset)| end.error - offset);
        let passed = rows.iter().zip(ends).zip(aims).map(|((row, error), aim)| match (aim, row.bound) {
            (Aim::Fixed(_), Bound::Within(..)) if !row.bound.is_boxed() => (error - row.bound.open(error)).abs(),
            _ => 0.0,
        });
        passed.fold(0.0, f64::max)
    }

    /// Starts from impulses of rows that are fixed alone: the others are found from velocities.
    fn start_impulses(&mut self) {
        for (impulse, aim) in self.impulses.iter_mut().zip(&self.aims) {
            *impulse = if let Aim::Fixed(fixed) = aim { *fixed } else { 0.0 };
        }
    }

    /// With at least that share of mobility added. The largest error that is left, m or rad.
    fn solve(&mut self, softer: f64, world: &impl World, members: &[u32], terms: &DualTerms) -> f64 {
        self.start_impulses();
        self.assemble(softer);
        self.iterate(world, members, terms)
    }

    /// Newton's iterations with the factor at hand. The largest error that is left, m or rad.
    fn iterate(&mut self, world: &impl World, members: &[u32], terms: &DualTerms) -> f64 {
        let mut least = f64::INFINITY;
        for iteration in 0..DUAL_ITERATIONS {
            self.set_velocities();
            // At first from the rows alone: they tell where the ends will be to second order.
            let is_linear = iteration == 0;
            if !is_linear {
                self.drift(world, members, terms.h);
                self.place_ends(world, terms);
            }
            let worst = self.find_residual(terms.h, is_linear);
            if !is_linear {
                if worst <= DUAL_ERRORS[usize::from(self.has_loops)] {
                    return worst;
                }
                // Or else the last that was better.
                if worst.is_nan() || worst >= least {
                    break;
                }
                least = worst;
                self.best.clone_from(&self.impulses);
            }
            self.take_correction();
        }
        if least.is_finite() {
            self.impulses.clone_from(&self.best);
        }
        self.set_velocities();
        self.drift(world, members, terms.h);
        self.place_ends(world, terms);
        least
    }

    /// Newton's step from the residual.
    fn take_correction(&mut self) {
        self.factor.solve(&self.couplings.elimination, &mut self.residual[..]);
        for ((impulse, more), aim) in self.impulses.iter_mut().zip(&self.residual).zip(&self.aims) {
            if !matches!(aim, Aim::Fixed(_)) {
                *impulse += more;
            }
        }
    }

    fn place_ends(&mut self, world: &impl World, terms: &DualTerms) {
        self.scratch.clear();
        self.place_rows(world, terms.time + terms.h, true);
    }

    /// v = v_free + W J₀ᵀ λ.
    fn set_velocities(&mut self) {
        self.velocities.clone_from(&self.free);
        for link in &self.links {
            let [mut a, mut b] = link.ends.map(|end| self.velocities[end as usize]);
            for index in link.first..link.first + link.count {
                a = a.plus(&self.responses[index].of_a(), self.impulses[index]);
                b = b.plus(&self.responses[index].of_b(), self.impulses[index]);
            }
            let [place_a, place_b] = link.ends.map(|end| end as usize);
            (self.velocities[place_a], self.velocities[place_b]) = (a, b);
        }
    }

    /// q₁ = q₀ ⊕ h v.
    fn drift(&mut self, world: &impl World, members: &[u32], h: f64) {
        self.ends.clone_from(&self.starts);
        for (index, (state, velocity)) in self.ends.iter_mut().zip(&self.velocities).enumerate() {
            (state.linear, state.angular) = (velocity.linear, velocity.angular);
            state.position += velocity.linear * h;
            match members.get(index) {
                Some(&member) => {
                    let Body { inverse_inertia_body, rotation_freedom, .. } = world.body(member);
                    let MemberState { rotation, angular, .. } = state;
                    turn_freely(rotation, angular, inverse_inertia_body, rotation_freedom, h);
                    rotation.renormalize_fast();
                }
                None => state.turn(&(velocity.angular * h)),
            }
        }
    }

    /// What of each row is to be made good by impulses. The largest error of a place, m or rad, or of a rate in the
    /// substep.
    fn find_residual(&mut self, h: f64, is_linear: bool) -> f64 {
        let Self { links, rows, scratch, velocities, aims, offsets, residual, impulses, .. } = self;
        residual.clear();
        let mut worst: f64 = 0.0;
        for link in &*links {
            let [a, b] = link.ends.map(|end| &velocities[end as usize]);
            for index in link.first..link.first + link.count {
                let row = &rows[index];
                let speed = row.jacobian.dot(a, b);
                let left = match aims[index] {
                    Aim::Place if is_linear => {
                        let error = row.error - offsets[index];
                        -(speed + row.time_rate + error / h + 0.5 * h * row.velocity_term)
                    }
                    Aim::Place => -(scratch[index].error - offsets[index]) / h,
                    Aim::Rate(rate) => rate - speed - row.time_rate,
                    Aim::Spring { weight, bias } if weight > 0.0 => -(speed + bias + impulses[index] / weight),
                    Aim::Spring { .. } | Aim::Fixed(_) => 0.0,
                };
                worst = worst.max(left.abs() * h);
                residual.push(left);
            }
        }
        worst
    }

    /// Whether some row is not as it was assumed to be.
    fn mend_active_set(&mut self, &DualTerms { h, .. }: &DualTerms, may_return: bool) -> bool {
        let Self { links, rows, scratch, velocities, aims, asked, offsets, impulses, .. } = self;
        let mut changed = false;
        for link in &*links {
            let [a, b] = link.ends.map(|end| &velocities[end as usize]);
            let speed = |index: usize| rows[index].jacobian.dot(a, b);
            for index in link.first..link.first + link.count {
                match rows[index].bound {
                    Bound::Norm { most, place: 0, count } if most.is_finite() => {
                        let group = index..index + count as usize;
                        changed |= mend_spring(&asked[group.clone()], &mut aims[group], most * h, |k| speed(index + k));
                    }
                    Bound::Within(lower, upper) => {
                        // How far it is from what it is to do: by its rate, or by its error at the end.
                        let left = match asked[index] {
                            Aim::Rate(rate) => speed(index) + rows[index].time_rate - rate,
                            _ => (scratch[index].error - offsets[index]) / h,
                        };
                        let now =
                            bounded_aim(aims[index], asked[index], impulses[index], [lower * h, upper * h], left * h);
                        if now != aims[index] && (may_return || matches!(now, Aim::Fixed(_))) {
                            (aims[index], changed) = (now, true);
                        }
                    }
                    Bound::None | Bound::Norm { .. } => {}
                }
            }
        }
        changed
    }

    /// Adds forces that acted for `kick`, s, to those of the step, as of a piece of length `h`, s.
    fn note(&mut self, h: f64, kick: f64) {
        self.forces.clear();
        self.forces.extend(self.impulses.iter().map(|impulse| impulse / kick));
        let Self { links, rows, forces, outer_loads: [_, last], .. } = self;
        last.clear();
        last.extend(links.iter().map(|link| {
            let own = link.first..link.first + link.count;
            own.fold(Wrench::zero(), |sum, row| sum.plus(&rows[row].jacobian.of_b(), forces[row] * h))
        }));
        self.add_loads(h);
        self.is_by_tree = false;
        self.resume_tree();
    }

    /// The same of what the tree found.
    fn note_tree(&mut self, h: f64) {
        let Self { links, tree: Some(tree), in_tree, forces, outer_loads: [_, last], .. } = self else { return };
        last.clear();
        forces.fill(0.0);
        for (link, joint) in links.iter().zip(in_tree) {
            let Some(joint) = joint.map(|joint| joint as usize) else {
                last.push(Wrench::zero());
                continue;
            };
            let Wrench { linear, angular } = tree.load(joint);
            forces[link.first..link.first + 3].copy_from_slice(linear.as_slice());
            last.push(Wrench { linear: linear * h, angular: (angular + tree.arm(joint).cross(&linear)) * h });
        }
        self.add_loads(h);
        self.is_by_tree = true;
    }

    /// Adds the loads of the last piece, of length `h`, s, to those of the step.
    fn add_loads(&mut self, h: f64) {
        self.spent += h;
        let Self { loads, outer_loads: [first, last], .. } = self;
        if self.spent == h {
            first.clone_from(last);
        }
        for (load, more) in loads.iter_mut().zip(&*last) {
            *load = load.plus(more, 1.0);
        }
    }

    /// The state of a member at the end of the substep, written to it.
    pub fn move_on(&self, local: usize, body: &mut Body, h: f64) {
        move_to(&self.ends[local], body, h);
    }

    /// Writes what a joint carried: the mean over the step so far, and of each row in the last substep. As velocities are
    /// half a substep behind the poses, half of what the first piece gave is of the step before; for what the next gives
    /// of this one, the last stands.
    pub fn store(&self, index: u32, joint: &mut Joint) {
        let Some(&place) = self.place_of.get(&index) else { return };
        let link = &self.links[place as usize];
        let [first, last] = self.outer_loads.each_ref().map(|loads| &loads[place as usize]);
        let load = self.loads[place as usize].plus(first, -0.5).plus(last, 0.5);
        let arm = self.starts[link.ends[1] as usize].rotation * joint.definition.frames[1].anchor;
        joint.force = load.linear / self.spent;
        joint.torque = (load.angular - arm.cross(&load.linear)) / self.spent;
        joint.multipliers[..link.count].copy_from_slice(&self.forces[link.first..][..link.count]);
        if let (Some(tree), Some(in_tree), true) = (&self.tree, self.in_tree[place as usize], self.is_by_tree) {
            // Rows of rotations act along A's axes, or are that nearly.
            let torque = tree.load(in_tree as usize).angular;
            let turned = self.starts[link.ends[0] as usize].rotation * joint.definition.frames[0].rotation;
            let along = turned.inverse() * torque;
            let skipped = 6 - link.count;
            joint.multipliers[3..link.count].copy_from_slice(&along.as_slice()[skipped..]);
        }
    }
}

/// Writes where a substep of length `h`, s, took a body, which drag slows down there.
pub(super) fn move_to(state: &MemberState, body: &mut Body, h: f64) {
    let MemberState { position, rotation, linear, angular } = *state;
    (body.position, body.rotation) = (position, rotation);
    body.linear = linear / (1.0 + body.drag.0 * h);
    body.angular = angular / (1.0 + body.drag.1 * h);
    body.has_stepped = true;
}

/// What a row is to do, whatever its bound; `old` is J of the velocities before.
fn aim_of(row: &JointRow<f64>, mobility: f64, old: f64, terms: &DualTerms) -> Aim {
    let h = terms.h;
    if let Some(constants) = row.spring {
        let mass = if mobility > 0.0 { 1.0 / mobility } else { 0.0 };
        let [stiffness, damping] = constants.per_mass(mass).map(|constant| constant * mass);
        let (damper, spring) = (h * damping, h * h * stiffness);
        // ω h and, of a damper alone, c h/m.
        let pace = (spring * mobility).sqrt().max(damper * mobility);
        let [fine, coarse] = DUAL_STIFF;
        let share = ((pace - fine) / (coarse - fine)).clamp(0.0, 1.0);
        let after = 0.5 * (1.0 + share) * damper + 0.25 * (1.0 + 3.0 * share) * spring;
        let before = (0.5 * damper - 0.25 * spring) * (1.0 - share);
        let bias = if after > 0.0 { (h * stiffness * row.error + before * old) / after } else { 0.0 };
        return Aim::Spring { weight: after, bias };
    }
    if let Some(rate) = row.rebound(h, terms.least_bounce) {
        return Aim::Rate(rate);
    }
    if row.is_rate {
        return Aim::Rate(0.0);
    }
    match row.bound {
        // A motion that lags behind.
        Bound::Within(lower, upper) if row.bound.is_boxed() => {
            if row.error.abs() < DUAL_LAG {
                return Aim::Place;
            }
            let most = (2.0 * upper.min(-lower) * mobility * row.error.abs()).sqrt();
            Aim::Rate(-row.error.signum() * most.min(row.error.abs() / h))
        }
        _ => Aim::Place,
    }
}

/// Where the active set starts from: limits that are open and stay so have no impulse, rows with a largest force are
/// within it.
fn starting_aim(row: &JointRow<f64>, aim: Aim, force: f64, free_rate: f64, h: f64) -> Aim {
    let ahead = row.error + h * free_rate;
    let is_open = match row.bound {
        Bound::Within(0.0, upper) if upper > 0.0 => ahead > 0.0 && force <= 0.0,
        Bound::Within(lower, 0.0) if lower < 0.0 => ahead < 0.0 && force >= 0.0,
        Bound::Within(lower, upper) => lower == upper,
        _ => false,
    };
    if is_open { Aim::Fixed(0.0) } else { aim }
}

/// A row with bounds for its impulse, after a solve that left it so far, m or rad, from what it is asked for.
fn bounded_aim(aim: Aim, asked: Aim, impulse: f64, [lower, upper]: [f64; 2], left: f64) -> Aim {
    match aim {
        Aim::Fixed(fixed) if fixed <= lower && left < -DUAL_LEFT && upper > lower => asked,
        Aim::Fixed(fixed) if fixed >= upper && left > DUAL_LEFT && upper > lower => asked,
        Aim::Fixed(_) => aim,
        _ if impulse < lower => Aim::Fixed(lower),
        _ if impulse > upper => Aim::Fixed(upper),
        _ => aim,
    }
}

/// Rows of a spring, the norm of whose impulse is bounded. Whether that is at its bound and was assumed not to be, or the
/// other way round, or in another direction.
fn mend_spring(asked: &[Aim], aims: &mut [Aim], most: f64, speed: impl Fn(usize) -> f64) -> bool {
    let trial = Vector3::from_fn(|row, _| match asked.get(row) {
        Some(Aim::Spring { weight, bias }) => -weight * (speed(row) + bias),
        _ => 0.0,
    });
    let exceeds = trial.norm() > most;
    let given = bounded(trial, most);
    let mut changed = false;
    for (row, (aim, &asked)) in aims.iter_mut().zip(asked).enumerate() {
        let now = if exceeds { Aim::Fixed(given[row]) } else { asked };
        let differs = match (*aim, now) {
            (Aim::Fixed(before), Aim::Fixed(now)) => (before - now).abs() > 1e-6 * most,
            (before, now) => before != now,
        };
        changed |= differs;
        *aim = now;
    }
    changed
}
