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
//!
//! What goes from link to link is done one by one ([`link`]), all else four at a time ([`fours`]).

mod fours;
mod inertia;
mod link;

use nalgebra::Vector3;
use simba::simd::{SimdComplexField, SimdPartialOrd, SimdValue};

use super::constants::{DUAL_ERRORS, DUAL_ITERATIONS, DUAL_START_ERROR};
use super::world::World;
use crate::physics::constraint::row::{Twist, Wrench};
use crate::physics::solver::exact::MemberState;
use crate::physics::solver::joint_tree::StiffnessShares;
use fours::{BodyFour, FOUR, LinkFour, MassFour, PoseFour, WorkFour, all, at, velocities};
use inertia::Articulated;
pub(super) use link::TreeJoint;
use link::{Link, NONE};

/// What became of a piece of a substep.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Piece {
    Done,
    /// Joints were apart when it began: that is for the rows.
    Apart,
    /// No impulses along the joints as they stand lead to joints that hold.
    TooFar,
}

/// A tree of joints, children before their parents. Bodies are in the order of the links whose child they are, and the one
/// that does not move after them.
#[derive(Clone, Debug, Default)]
pub(super) struct ArticulatedTree {
    links: Vec<Link>,
    fours: Vec<LinkFour>,
    /// The link of each joint.
    link_of: Vec<u32>,
    masses: Vec<MassFour>,
    works: Vec<WorkFour>,
    /// ω²h² of each body under the pull of its joints, and how much of that is added to its inertia and lost.
    phases: Vec<f64>,
    shares: Vec<[f64; 2]>,
    /// Bodies and links when the piece begins, and at its end, which are those at the start of the next.
    starts: Vec<BodyFour>,
    ends: Vec<BodyFour>,
    start_poses: Vec<PoseFour>,
    end_poses: Vec<PoseFour>,
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
        // Each with its joint, and the side of that which is nearer to the root.
        let mut links: Vec<(Link, Option<(u32, usize)>)> = Vec::with_capacity(moving);
        let mut link_of = vec![NONE; joints.len()];
        match joints.iter().position(is_pin) {
            Some(pin) => {
                let parent = usize::from(joints[pin].ends[1] as usize >= moving);
                link_of[pin] = 0;
                links.push((Link::of(&joints[pin], parent, NONE), Some((pin as u32, parent))));
            }
            None => links.push((Link::root(0), None)),
        }
        // From the root on, then the other way round.
        let mut next = 0;
        while next < links.len() {
            let body = links[next].0.child;
            for &(joint, parent) in &at[body as usize] {
                if link_of[joint as usize] == NONE {
                    link_of[joint as usize] = links.len() as u32;
                    let link = Link::of(&joints[joint as usize], parent, next as u32);
                    links.push((link, Some((joint, parent))));
                }
            }
            next += 1;
        }
        if links.len() != moving {
            return None;
        }
        links.reverse();
        let reversed = |link: &mut u32| *link = if *link == NONE { NONE } else { moving as u32 - 1 - *link };
        links.iter_mut().for_each(|(link, _)| reversed(&mut link.up));
        link_of.iter_mut().for_each(reversed);
        let fours = links_by_four(joints, &links);
        let links = links.into_iter().map(|(link, _)| link).collect();
        Some(Self { links, fours, link_of, ..Self::default() })
    }

    /// Takes in the forces, N, that the joints had on their B, and that their poses are not known.
    pub fn resume(&mut self, forces: impl Iterator<Item = Vector3<f64>>) {
        self.forget();
        let Self { links, link_of, .. } = self;
        for (&link, force) in link_of.iter().zip(forces) {
            let link = &mut links[link as usize];
            link.load.linear = if link.is_reversed { -force } else { force };
        }
    }

    /// What it knew of poses and of what was left to links.
    fn forget(&mut self) {
        self.has_poses = false;
        self.fours.iter_mut().for_each(LinkFour::forget);
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
        self.start_poses[link / FOUR].arms[usize::from(self.links[link].is_reversed)].extract(link % FOUR)
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
        if !self.place(world, members, starts) {
            return Piece::Apart;
        }
        ends.clear();
        ends.extend_from_slice(starts);
        for state in &mut ends[members.len()..] {
            state.drift(h);
        }
        if let Some(held) = self.held_by() {
            self.ends[self.fours.len()] = BodyFour::of([&ends[held]; FOUR], None);
        }
        self.begin([h, kick]);
        self.gather();
        let mut least = f64::INFINITY;
        for _ in 0..DUAL_ITERATIONS {
            let worst = self.advance(h);
            if worst <= DUAL_ERRORS[0] {
                self.finish(ends, kick);
                return Piece::Done;
            }
            if worst.is_nan() || worst >= least {
                break;
            }
            least = worst;
            self.pass_on();
        }
        self.forget();
        Piece::TooFar
    }

    /// The place among the states of what holds the tree.
    fn held_by(&self) -> Option<usize> {
        self.links.last().filter(|link| link.is_joint).map(|link| link.parent as usize)
    }

    /// Bodies and links when the piece begins. Whether all joints hold.
    fn place(&mut self, world: &impl World, members: &[u32], states: &[MemberState]) -> bool {
        let is_known = std::mem::replace(&mut self.has_poses, false);
        if is_known {
            std::mem::swap(&mut self.starts, &mut self.ends);
            std::mem::swap(&mut self.start_poses, &mut self.end_poses);
        } else {
            let body = |link: &Link| world.body(members[link.child as usize]);
            self.masses.clear();
            self.masses.extend(self.links.chunks(FOUR).map(|links| MassFour::new(by_four(links).map(body))));
            self.starts.clear();
        }
        for (place, links) in self.links.chunks(FOUR).enumerate() {
            let states = by_four(links).map(|link| &states[link.child as usize]);
            match self.starts.get_mut(place).filter(|_| is_known) {
                Some(start) => start.velocity = velocities(states.map(MemberState::twist)),
                None => self.starts.push(BodyFour::of(states, Some(&self.masses[place]))),
            }
        }
        self.starts.truncate(self.fours.len());
        self.starts.extend(self.held_by().map(|held| BodyFour::of([&states[held]; FOUR], None)));
        if is_known {
            return true;
        }
        let Self { fours, starts, start_poses, .. } = self;
        start_poses.clear();
        start_poses.extend(fours.iter().zip(&*starts).map(|(four, children)| four.look(children, starts)));
        self.ends.clone_from(&self.starts);
        self.end_poses.clone_from(&self.start_poses);
        let worst = self.start_poses.iter().fold(all(0.0), |worst, pose| worst.simd_max(pose.error()));
        worst.simd_horizontal_max() <= DUAL_START_ERROR
    }

    /// What needs no order: the inertias of bodies with stiffness, momenta of forces, and what joints are to change.
    fn begin(&mut self, [h, kick]: [f64; 2]) {
        let Self { links, fours, masses, works, phases, shares, starts, start_poses: poses, .. } = self;
        phases.clear();
        phases.resize(fours.len() * FOUR, 0.0);
        works.clear();
        for (place, (four, links)) in fours.iter_mut().zip(links.chunks(FOUR)).enumerate() {
            let pose = &poses[place];
            four.predict(pose, &starts[place], starts, h);
            let along = four.pull(pose, &Vector3::from(by_four(links).map(|link| link.load.linear)));
            for lane in 0..FOUR {
                phases[FOUR * place + lane] += along[0].extract(lane);
                if let Some(parent) = phases.get_mut(four.parents[lane] as usize) {
                    *parent += along[1].extract(lane);
                }
            }
            works.push(WorkFour::begin(&masses[place], &starts[place], kick));
        }
        let share = |(phase, masses): (&[f64], &MassFour)| {
            [0, 1, 2, 3].map(|lane| match StiffnessShares::of(phase[lane] * h * h * masses.greatest[lane]) {
                Some(StiffnessShares { added, damped }) => [(added + damped) * h * h, damped * h * h],
                None => [0.0; 2],
            })
        };
        shares.clear();
        shares.extend(phases.chunks(FOUR).zip(&*masses).flat_map(share));
        if shares.iter().any(|share| share[0] > 0.0) {
            stiffen(fours, poses, shares, starts, works);
        }
        for ((works, masses), pose) in works.iter_mut().zip(masses).zip(poses) {
            works.set_about(masses, &pose.arms[0]);
        }
    }

    /// From the leaves to the root: inertias and momenta, and all that moved on to the parents.
    fn gather(&mut self) {
        let Self { links, fours, masses, works, start_poses: poses, .. } = self;
        for link in &mut *links {
            (link.inertia, link.momentum) = (Articulated::default(), Wrench::zero());
        }
        for index in 0..links.len() {
            let (four, lane) = (index / FOUR, index % FOUR);
            let axis = at(&poses[four].axis, lane);
            let link = &mut links[index];
            let up = link.up as usize;
            link.lever = at(&poses[four].arms[1], lane);
            if let Some(pose) = poses.get(up / FOUR) {
                link.lever -= at(&pose.arms[0], up % FOUR);
            }
            works[four].add_to(&masses[four], lane, &mut link.inertia, &mut link.momentum);
            link.eliminate(&axis);
            if !link.is_joint {
                continue;
            }
            let passed = link.pass(&axis, &fours[four].bias_at(lane));
            // Children come before their parents.
            let (done, left) = links.split_at_mut(index + 1);
            let link = &done[index];
            if let Some(parent) = left.get_mut(up.wrapping_sub(index + 1)) {
                parent.inertia.add(&link.inertia, &link.lever);
                parent.take(&passed, &link.lever);
            }
        }
    }

    /// The same with the inertias at hand, of what joints are to change alone.
    fn pass_on(&mut self) {
        let Self { links, fours, start_poses: poses, .. } = self;
        for index in 0..links.len() {
            let (four, lane) = (index / FOUR, index % FOUR);
            let link = &mut links[index];
            if !link.is_joint {
                continue;
            }
            let (lever, up) = (link.lever, link.up);
            let passed = link.pass(&at(&poses[four].axis, lane), &fours[four].bias_at(lane));
            if let Some(parent) = links.get_mut(up as usize) {
                parent.take(&passed, &lever);
            }
        }
    }

    /// From the root to the leaves: the velocities, where they take the bodies, and what the joints are to change next. The
    /// largest error that is left, m or rad.
    fn advance(&mut self, h: f64) -> f64 {
        self.find_motions();
        let Self { links, fours, masses, works, starts, ends, start_poses, end_poses, .. } = self;
        for (place, links) in links.chunks(FOUR).enumerate() {
            let motion = velocities(by_four(links).map(|link| link.motion));
            let arm = &start_poses[place].arms[0];
            ends[place] = works[place].advance(&masses[place], &starts[place], arm, motion, h);
        }
        let (mut worst, mut sum) = (all(0.0), all(0.0));
        for ((four, children), pose) in fours.iter_mut().zip(&*ends).zip(end_poses) {
            *pose = four.look(children, ends);
            four.mend(pose, h);
            let error = pose.error();
            // The larger of a number and none may be the number.
            (worst, sum) = (worst.simd_max(error), sum + error);
        }
        let sum = sum.simd_horizontal_sum();
        if sum.is_nan() { sum } else { worst.simd_horizontal_max() }
    }

    /// From the root to the leaves: what the velocities change.
    fn find_motions(&mut self) {
        let Self { links, fours, start_poses: poses, .. } = self;
        for index in (0..links.len()).rev() {
            let (four, lane) = (index / FOUR, index % FOUR);
            let above = links.get(links[index].up as usize).map_or_else(Twist::zero, |up| up.motion);
            let link = &mut links[index];
            link.motion = if link.is_joint {
                let parent = Twist { linear: above.linear + above.angular.cross(&link.lever), angular: above.angular };
                link.moved(&parent, &at(&poses[four].axis, lane), &fours[four].bias_at(lane))
            } else {
                link.inertia.solve(&std::mem::take(&mut link.momentum))
            };
        }
    }

    /// Hands out where the bodies are, and finds what the joints carried while forces acted for `kick`, s.
    fn finish(&mut self, states: &mut [MemberState], kick: f64) {
        let Self { links, masses, works, starts, ends, start_poses, .. } = self;
        for (place, links) in links.chunks_mut(FOUR).enumerate() {
            let load = works[place].load(&masses[place], &starts[place], &start_poses[place].arms[0], kick);
            for (lane, link) in links.iter_mut().enumerate() {
                states[link.child as usize] = ends[place].state(lane);
                link.load = Wrench { linear: at(&load.linear, lane), angular: at(&load.angular, lane) };
            }
        }
        for index in 0..links.len() {
            // So far what its children take, about the point of its own link.
            let Link { load, lever, up, .. } = links[index];
            if let Some(parent) = links.get_mut(up as usize) {
                parent.load.linear += load.linear;
                parent.load.angular += load.angular + lever.cross(&load.linear);
            }
        }
        self.has_poses = true;
    }
}

/// Adds the stiffness of the pull of links, of which each body takes so many times h², s², and loses so many.
fn stiffen(fours: &[LinkFour], poses: &[PoseFour], shares: &[[f64; 2]], starts: &[BodyFour], works: &mut [WorkFour]) {
    // Bodies have one link to a child, mostly: four of them at a time, and one by one what others are left.
    let pull_of = |link: usize| fours[link / FOUR].pull_on_parent(&poses[link / FOUR], link % FOUR);
    for (place, (four, pose)) in fours.iter().zip(poses).enumerate() {
        let (shares, omega) = (&shares[FOUR * place..], &starts[place].velocity.angular);
        works[place].stiffen(&pose.arms[0], shares, four.pulls[0], omega);
        let pulls = four.first_children.map(|link| match link {
            NONE => (Vector3::zeros(), 0.0),
            link => pull_of(link as usize),
        });
        works[place].stiffen(
            &Vector3::from(pulls.map(|(arm, _)| arm)),
            shares,
            pulls.map(|(_, pull)| pull).into(),
            omega,
        );
    }
    for (place, four) in fours.iter().enumerate() {
        for &(lane, link) in &four.later_children {
            let ((arm, pull), omega) = (pull_of(link as usize), at(&starts[place].velocity.angular, lane));
            works[place].stiffen_one(lane, &arm, shares[FOUR * place + lane].map(|share| share * pull), &omega);
        }
    }
}

/// Four of a list that has up to four, the last one again where it has less.
fn by_four<T>(list: &[T]) -> [&T; FOUR] {
    [0, 1, 2, 3].map(|lane: usize| &list[lane.min(list.len() - 1)])
}

/// Links with the index of their joint and the side of it that is nearer to the root.
fn links_by_four(joints: &[TreeJoint], links: &[(Link, Option<(u32, usize)>)]) -> Vec<LinkFour> {
    let fours = links.len().div_ceil(FOUR);
    let four = |first: usize| {
        let of = |lane: usize| links.get(first + lane).and_then(|(link, joint)| joint.map(|joint| (link, joint)));
        let joint = |lane: usize| of(lane).map(|(_, (joint, parent))| (&joints[joint as usize], parent));
        let parent = |lane: usize| match of(lane) {
            Some((link, _)) if link.up == NONE => (fours * FOUR) as u32,
            Some((link, _)) => link.up,
            // Itself.
            None => (first + lane) as u32,
        };
        LinkFour::new([0, 1, 2, 3].map(joint), [0, 1, 2, 3].map(parent))
    };
    let mut fours: Vec<LinkFour> = (0..links.len()).step_by(FOUR).map(four).collect();
    for (index, (link, _)) in (0..).zip(links).filter(|(_, (link, _))| link.up != NONE) {
        fours[link.up as usize / FOUR].add_child(link.up as usize % FOUR, index);
    }
    fours
}
