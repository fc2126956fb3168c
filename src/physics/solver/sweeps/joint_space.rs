//! Contacts in joint space: joints are eliminated exactly, and what is swept are the rows that have bounds, each of
//! which moves everything that is joined to its two bodies.
//!
//! With E the rows that nothing bounds, those of joints, and C the others, A = J_E M⁻¹J_Eᵀ + Γ_E:
//!
//! λ_E = A⁻¹(η_E − J_E M⁻¹J_Cᵀ λ_C),  K = M⁻¹ − M⁻¹J_EᵀA⁻¹J_E M⁻¹,
//! (J_C K J_Cᵀ + Γ_C) λ_C = η_C − J_C M⁻¹J_EᵀA⁻¹η_E within the bounds,
//!
//! by projected Gauss–Seidel ([`crate::physics::solver::sweeps::pgs`]) with K J_iᵀ in place of M⁻¹J_iᵀ. K is M⁻¹ seen through the joints, the
//! inverse inertia in joint space (Featherstone, *Rigid Body Dynamics Algorithms*, 2008, section 11.5), here without
//! joint coordinates, so that loops need none. However few the sweeps, every joint holds to rounding, and a heavy
//! mechanism takes no more of them than a single body.
//!
//! A falls apart into mechanisms, bodies that joints connect; each is factored on its own ([`BlockLdl`]) in `f64`,
//! and solved by turns of the method of multipliers, so that redundant joints share their load. A row with bounds costs
//! a solve to begin with, and an update the bodies of up to two mechanisms.

use std::ops::Range;

use nalgebra::{Matrix3, Vector3};

use super::pgs;
use crate::physics::constraint::row::{Bounds, Row, Twist, bounded};
use crate::physics::disjoint_sets::DisjointSets;
use crate::physics::scalar::Scalar;
use crate::physics::solver::exact::{Coupling, Couplings, links_at};
use crate::physics::solver::linear::{BlockLdl, Elimination, Triangular};

/// Shift of A, as a share of each block's trace: where the joints of a tree are independent, and where some may follow
/// from others. What rounding in `f32`, or errors that no motion mends, ask along those must not grow to great forces.
const SHIFTS: [f64; 2] = [1e-12, 1e-4];
/// Turns of the method of multipliers at most.
const TURNS: usize = 6;
/// Share of the right-hand side that may be left.
const ROUNDING: f64 = 1e-14;
/// Share of a row's J M⁻¹Jᵀ under which what joints leave of it, J K Jᵀ, is rounding.
const HELD: f64 = 1e-9;
/// No body that moves, no mechanism.
const NONE: u32 = u32::MAX;

/// Mechanisms and the responses of rows with bounds, with their buffers.
#[derive(Clone, Default)]
pub(super) struct JointSpace<N> {
    /// First row of each joint that nothing bounds.
    firsts: Vec<usize>,
    /// Its bodies that move.
    ends: Vec<[u32; 2]>,
    /// Of the solve before: where they are the same, so are the mechanisms.
    ends_before: Vec<[u32; 2]>,
    mechanisms: Vec<Mechanism>,
    /// Of each body: its mechanism, and its place there.
    place: Vec<(u32, u32)>,
    swept: Vec<Swept<N>>,
    /// K Jᵀ of the swept rows, one after the other: body and acceleration.
    responses: Vec<(u32, Twist<N>)>,
}

/// A row with bounds.
#[derive(Clone)]
struct Swept<N> {
    row: usize,
    /// Where its responses end.
    end: usize,
    /// 1/(J K Jᵀ + γ); zero where joints let nothing move.
    inverse_diagonal: N,
}

/// Bodies that joints connect.
#[derive(Clone, Default)]
struct Mechanism {
    bodies: Vec<u32>,
    /// In the order of elimination.
    joints: Vec<Joint>,
    elimination: Elimination,
    factor: BlockLdl<f64, Triangular>,
    couplings: Vec<Coupling>,
    /// Blocks of A: on the diagonal, and of the couplings.
    diagonal: Vec<Matrix3<f64>>,
    coupled: Vec<Matrix3<f64>>,
    right: Vec<Vector3<f64>>,
    left: Vec<Vector3<f64>>,
    forces: Vec<Vector3<f64>>,
    motion: Vec<Twist<f64>>,
}

/// A joint of a mechanism.
#[derive(Clone, Copy)]
struct Joint {
    /// Among all joints.
    index: u32,
    first_row: usize,
    /// Of its bodies; NONE: does not move.
    places: [u32; 2],
}

/// Solves from the λ that the rows hold, with `accelerations` as in [`pgs::solve`], in `iterations` sweeps over the
/// rows with bounds; `note` is told `accelerations` after each. Returns the sweeps.
pub(super) fn solve<N: Scalar>(
    rows: &mut [Row<N>],
    accelerations: &mut [Twist<N>],
    iterations: u32,
    space: &mut JointSpace<N>,
    mut note: impl FnMut(&[Twist<N>]),
) -> u32 {
    space.find_mechanisms(rows, accelerations.len());
    space.mechanisms.iter_mut().for_each(|mechanism| mechanism.factor(rows));
    space.hold(rows, accelerations);
    space.respond(rows);
    for _ in 0..iterations {
        space.sweep(rows, accelerations);
        note(accelerations);
    }
    space.gather(rows, accelerations);
    iterations
}

/// Whether nothing bounds the row.
fn is_free<N: Scalar>(row: &Row<N>) -> bool {
    matches!(row.bounds, Bounds::Fixed(lower, upper) if lower <= N::of(f64::MIN) && upper >= N::of(f64::MAX))
}

/// The row's part of one end (0: A, 1: B): body, J and M⁻¹Jᵀ.
fn end<N: Scalar>(row: &Row<N>, end: usize) -> (u32, Twist<f64>, Twist<f64>) {
    let [jacobian, response] = [&row.jacobian, &row.response].map(|pair| {
        let Twist { linear, angular } = pair.of(end);
        Twist { linear: linear.map(Scalar::to_f64), angular: angular.map(Scalar::to_f64) }
    });
    ([row.a, row.b][end], jacobian, response)
}

fn add<N: Scalar>(sum: &mut Twist<N>, more: &Twist<N>, times: N) {
    *sum = sum.plus(more, times);
}

impl<N: Scalar> JointSpace<N> {
    /// Joints, and what they connect if that has changed.
    fn find_mechanisms(&mut self, rows: &[Row<N>], bodies: usize) {
        std::mem::swap(&mut self.ends, &mut self.ends_before);
        self.firsts.clear();
        self.ends.clear();
        let mut first = 0;
        while let Some(row) = rows.get(first) {
            let is_of_pair = |other: &Row<N>| is_free(other) && [other.a, other.b] == [row.a, row.b];
            let is_joint = rows.len() >= first + 3 && rows[first..first + 3].iter().all(is_of_pair);
            if is_joint {
                let moves = |side: usize| {
                    rows[first..first + 3].iter().any(|row| Twist::dot(&end(row, side).1, &end(row, side).2) > 0.0)
                };
                let ends = [row.a, row.b];
                self.firsts.push(first);
                self.ends.push([0, 1].map(|side| if moves(side) { ends[side] } else { NONE }));
            }
            first += if is_joint { 3 } else { 1 };
        }
        if self.ends != self.ends_before || self.place.len() != bodies {
            self.connect(bodies);
        }
        for joint in self.mechanisms.iter_mut().flat_map(|mechanism| &mut mechanism.joints) {
            joint.first_row = self.firsts[joint.index as usize];
        }
    }

    /// The mechanisms of the joints.
    fn connect(&mut self, bodies: usize) {
        let mut sets = DisjointSets::new(bodies);
        for &[a, b] in self.ends.iter().filter(|ends| !ends.contains(&NONE)) {
            sets.union(a, b);
        }
        let mut of_root = vec![NONE; bodies];
        let mut joints: Vec<Vec<u32>> = Vec::new();
        for (joint, ends) in (0..).zip(&self.ends) {
            let Some(&body) = ends.iter().find(|&&body| body != NONE) else { continue };
            let of_root = &mut of_root[sets.root(body) as usize];
            if *of_root == NONE {
                *of_root = joints.len() as u32;
                joints.push(Vec::new());
            }
            joints[*of_root as usize].push(joint);
        }
        self.place.clear();
        self.place.resize(bodies, (NONE, NONE));
        self.mechanisms.clear();
        for (index, joints) in (0..).zip(&joints) {
            self.mechanisms.push(Mechanism::new(index, joints, &self.ends, &mut self.place));
        }
    }

    /// Brings joints to their targets: λ_E and what it does to the accelerations.
    fn hold(&mut self, rows: &mut [Row<N>], accelerations: &mut [Twist<N>]) {
        for mechanism in &mut self.mechanisms {
            for (right, joint) in mechanism.right.iter_mut().zip(&mechanism.joints) {
                let left = |axis| pgs::residual(&rows[joint.first_row + axis], accelerations).to_f64();
                *right = Vector3::from_fn(|axis, _| left(axis));
            }
            mechanism.solve();
            for (force, joint) in mechanism.forces.iter().zip(&mechanism.joints) {
                for (row, &force) in rows[joint.rows()].iter_mut().zip(force) {
                    row.lambda += N::of(force);
                    pgs::add_response(row, N::of(force), accelerations);
                }
            }
        }
    }

    /// K Jᵀ of all rows with bounds.
    fn respond(&mut self, rows: &[Row<N>]) {
        self.swept.clear();
        self.responses.clear();
        let mut joints = self.firsts.iter().peekable();
        let mut row = 0;
        while row < rows.len() {
            if joints.next_if_eq(&&row).is_some() {
                row += 3;
                continue;
            }
            let own = [0, 1].map(|side| end(&rows[row], side));
            let first = self.responses.len();
            for (side, (body, _, response)) in own.iter().enumerate() {
                let mechanism = self.place[*body as usize].0;
                if mechanism == NONE {
                    self.responses.push((*body, narrow(response)));
                } else if side == 0 || mechanism != self.place[own[0].0 as usize].0 {
                    let mechanism = &mut self.mechanisms[mechanism as usize];
                    mechanism.respond(rows, &own, &self.place);
                    let moved = mechanism.bodies.iter().zip(&mechanism.motion);
                    self.responses.extend(moved.map(|(&body, motion)| (body, narrow(motion))));
                }
            }
            let moved = |(body, jacobian, _): &(u32, Twist<f64>, Twist<f64>)| {
                let found = self.responses[first..].iter().find(|(other, _)| other == body);
                found.map_or(0.0, |(_, response)| jacobian.dot(&widen(response)))
            };
            let diagonal: f64 = own.iter().map(moved).sum();
            let alone: f64 = own.iter().map(|(_, jacobian, response)| jacobian.dot(response)).sum();
            let softness = rows[row].softness.to_f64();
            let inverse = if diagonal > HELD * alone { 1.0 / (diagonal + softness) } else { 0.0 };
            self.swept.push(Swept { row, end: self.responses.len(), inverse_diagonal: N::of(inverse) });
            row += 1;
        }
    }

    /// One sweep over the rows with bounds.
    fn sweep(&self, rows: &mut [Row<N>], accelerations: &mut [Twist<N>]) {
        let mut first = 0;
        for (at, swept) in self.swept.iter().enumerate() {
            let (lower, upper) = match rows[swept.row].bounds {
                Bounds::Norm { .. } => (N::of(f64::MIN), N::of(f64::MAX)),
                _ => pgs::limits(rows, swept.row),
            };
            let row = &mut rows[swept.row];
            let residual = pgs::residual(row, accelerations);
            let lambda = (row.lambda + residual * swept.inverse_diagonal).simd_clamp(lower, upper);
            let change = lambda - row.lambda;
            row.lambda = lambda;
            for (body, response) in &self.responses[first..swept.end] {
                add(&mut accelerations[*body as usize], response, change);
            }
            first = swept.end;
            if let Bounds::Norm { most, place: 2, .. } = rows[swept.row].bounds {
                let lambda = Vector3::from_fn(|place, _| rows[swept.row - 2 + place].lambda);
                let within = bounded(lambda, most);
                let change = within - lambda;
                for place in 0..3 {
                    let at = at - 2 + place;
                    let start = if at == 0 { 0 } else { self.swept[at - 1].end };
                    rows[swept.row - 2 + place].lambda = within[place];
                    for (body, response) in &self.responses[start..self.swept[at].end] {
                        add(&mut accelerations[*body as usize], response, change[place]);
                    }
                }
            }
        }
    }

    /// λ_E for the λ_C found, and a = M⁻¹Jᵀλ of both afresh.
    fn gather(&mut self, rows: &mut [Row<N>], accelerations: &mut [Twist<N>]) {
        accelerations.fill(Twist::zero());
        for swept in &self.swept {
            let row = &rows[swept.row];
            pgs::add_response(row, row.lambda, accelerations);
        }
        for &first in &self.firsts {
            rows[first..first + 3].iter_mut().for_each(|row| row.lambda = N::zero());
        }
        self.hold(rows, accelerations);
    }
}

fn narrow<N: Scalar>(twist: &Twist<f64>) -> Twist<N> {
    Twist { linear: twist.linear.map(N::of), angular: twist.angular.map(N::of) }
}

fn widen<N: Scalar>(twist: &Twist<N>) -> Twist<f64> {
    Twist { linear: twist.linear.map(Scalar::to_f64), angular: twist.angular.map(Scalar::to_f64) }
}

impl Joint {
    fn rows(&self) -> Range<usize> {
        self.first_row..self.first_row + 3
    }

    /// Its sides that move, with the place of the body.
    fn sides(&self) -> impl Iterator<Item = (usize, usize)> {
        let sides = self.places.into_iter().enumerate().filter(|(_, place)| *place != NONE);
        sides.map(|(side, place)| (side, place as usize))
    }
}

impl Mechanism {
    /// Of these joints, with the bodies at the ends of all; writes down the places of its bodies.
    fn new(index: u32, joints: &[u32], ends: &[[u32; 2]], place: &mut [(u32, u32)]) -> Self {
        let mut bodies = Vec::new();
        let mut place_of = |body: u32| {
            if body == NONE {
                return NONE;
            }
            let place = &mut place[body as usize];
            if place.0 != index {
                *place = (index, bodies.len() as u32);
                bodies.push(body);
            }
            place.1
        };
        let links: Vec<[u32; 2]> = joints.iter().map(|&joint| ends[joint as usize].map(&mut place_of)).collect();
        let Couplings { order, elimination, list } =
            Couplings::of(&links_at(bodies.len(), &links), &vec![3; links.len()]);
        let joint = |&link: &u32| Joint { index: joints[link as usize], first_row: 0, places: links[link as usize] };
        let joints = order.iter().map(joint).collect();
        let right = vec![Vector3::zeros(); links.len()];
        Self { bodies, joints, elimination, couplings: list, right, ..Self::default() }
    }

    /// A and its factor.
    fn factor<N: Scalar>(&mut self, rows: &[Row<N>]) {
        let block = |one: usize, side: usize, other: usize, other_side: usize| {
            Matrix3::from_fn(|i, j| Twist::dot(&end(&rows[one + i], side).1, &end(&rows[other + j], other_side).2))
        };
        self.factor.clear(&self.elimination);
        self.diagonal.clear();
        for joint in &self.joints {
            let first = joint.first_row;
            let softness = Vector3::from_fn(|axis, _| rows[first + axis].softness.to_f64());
            let own = block(first, 0, first, 0) + block(first, 1, first, 1);
            self.diagonal.push(own + Matrix3::from_diagonal(&softness));
        }
        for (place, block) in self.diagonal.iter().enumerate() {
            self.factor.diagonal_mut::<3>(place).copy_from(block);
        }
        self.coupled.clear();
        for coupling in &self.couplings {
            let ((row, row_side), (column, column_side)) = (coupling.row, coupling.column);
            let first = |joint: u32| self.joints[joint as usize].first_row;
            let block = block(first(row), row_side, first(column), column_side);
            self.coupled.push(block);
            let mut below = self.factor.below_mut::<3>(coupling.block as usize);
            below += block;
        }
        // A tree of so many bodies with one fixed point has as many joints; any more close a loop.
        let may_be_singular = self.joints.len() > self.bodies.len();
        self.factor.shift(&self.elimination, SHIFTS[usize::from(may_be_singular)]);
        self.factor.factor(&self.elimination);
    }

    /// `forces` ← A⁻¹ `right`.
    fn solve(&mut self) {
        let size = |vectors: &[Vector3<f64>]| vectors.iter().fold(0.0_f64, |most, vector| most.max(vector.amax()));
        self.forces.clear();
        self.forces.resize(self.joints.len(), Vector3::zeros());
        self.left.clone_from(&self.right);
        let enough = ROUNDING * size(&self.right);
        for _ in 0..TURNS {
            if size(&self.left) <= enough {
                break;
            }
            self.factor.solve(&self.elimination, &mut self.left[..]);
            self.forces.iter_mut().zip(&self.left).for_each(|(force, more)| *force += more);
            for (joint, left) in self.left.iter_mut().enumerate() {
                *left = self.right[joint] - self.diagonal[joint] * self.forces[joint];
            }
            for (coupling, block) in self.couplings.iter().zip(&self.coupled) {
                let (row, column) = (coupling.row.0 as usize, coupling.column.0 as usize);
                self.left[row] -= block * self.forces[column];
                self.left[column] -= block.tr_mul(&self.forces[row]);
            }
        }
    }

    /// `motion` ← K Jᵀ of a row, by its ends.
    fn respond<N: Scalar>(&mut self, rows: &[Row<N>], own: &[(u32, Twist<f64>, Twist<f64>); 2], place: &[(u32, u32)]) {
        self.motion.clear();
        self.motion.resize(self.bodies.len(), Twist::zero());
        for (body, _, response) in own {
            let place = place[*body as usize].1;
            if self.bodies.get(place as usize) == Some(body) {
                add(&mut self.motion[place as usize], response, 1.0);
            }
        }
        for (right, joint) in self.right.iter_mut().zip(&self.joints) {
            *right = Vector3::zeros();
            for (side, place) in joint.sides() {
                let motion = &self.motion[place];
                if motion.linear != Vector3::zeros() || motion.angular != Vector3::zeros() {
                    *right -=
                        Vector3::from_fn(|axis, _| Twist::dot(&end(&rows[joint.first_row + axis], side).1, motion));
                }
            }
        }
        self.solve();
        for (force, joint) in self.forces.iter().zip(&self.joints) {
            for (side, place) in joint.sides() {
                for (row, &force) in rows[joint.rows()].iter().zip(force) {
                    add(&mut self.motion[place], &end(row, side).2, force);
                }
            }
        }
    }
}
