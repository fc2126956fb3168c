//! The rows of a mechanism's joints at one pose: J, W = M̃⁻¹ and the factor of J W Jᵀ.
//!
//! Joints tell their rows ([`place_rows`](super::mechanism::place_rows)). The block of two joints is J₁ W J₂ᵀ over the
//! members that they share. Links all of whose λ are given, as of limits that are open, have no part in the factor
//! ([`HeldLinks`]).

use nalgebra::{Matrix3, Vector3};

use super::constants::{LOOSE, MULTIPLIER_ITERATIONS, MULTIPLIER_STALLED, SHIFTS};
use super::held_links::HeldLinks;
use super::mechanism::{InverseMass, Mechanism, MechanismLink, MemberState, RowSpring};
use crate::physics::constraint::row::{RowPair, Twist, Wrench};
use crate::physics::joint::JointRow;
use crate::physics::solver::linear::{BlockLdl, Triangular};

/// J, W and the factor.
#[derive(Clone, Debug, Default)]
pub(crate) struct MechanismRows {
    /// J; zero of rows whose λ is given.
    pub jacobians: Vec<RowPair<f64>>,
    /// The rows whose λ is given.
    pub given: Vec<usize>,
    /// W of each member.
    pub inverse_masses: Vec<InverseMass>,
    /// The springs with their softness, which is added to their part of the diagonal.
    pub springs: Vec<(RowSpring, Matrix3<f64>)>,
    /// W Jᵀ.
    responses: Vec<RowPair<f64>>,
    /// The diagonal of J W Jᵀ, 1/kg or 1/(kg m²).
    mobility: Vec<f64>,
    held: HeldLinks,
    factor: BlockLdl<f64, Triangular>,
    /// The unknowns of the links that hold.
    packed: Vec<f64>,
    residual: Vec<f64>,
    velocities: Vec<Twist<f64>>,
}

impl MechanismRows {
    /// Makes and factors J W Jᵀ for rigid rows at those states; springs do not hold.
    pub fn assemble_rigid(&mut self, mechanism: &Mechanism, states: &[MemberState], rows: &[JointRow<f64>], turn: f64) {
        self.inverse_masses.clear();
        self.inverse_masses
            .extend(mechanism.members.iter().zip(states).map(|(member, state)| member.inverse_mass_at(state)));
        self.assemble(mechanism, rows, turn, |_, _| Matrix3::from_diagonal_element(LOOSE));
    }

    /// Makes and factors J W Jᵀ for the inverse masses set; `soften` tells the softness of a spring, given its mobility.
    /// Where rows may be redundant, `turn` is the turn of the step, rad: levers that differ by less are not resolved.
    pub fn assemble(
        &mut self,
        mechanism: &Mechanism,
        rows: &[JointRow<f64>],
        turn: f64,
        soften: impl Fn(&RowSpring, &Vector3<f64>) -> Matrix3<f64>,
    ) {
        self.set_jacobians(rows);
        self.held.find(mechanism, rows);
        let Self { jacobians, given, inverse_masses, springs, responses, mobility, held, factor, .. } = self;
        let (elimination, couplings) = held.structure(mechanism);
        let share = (4.0 * turn * turn).clamp(SHIFTS[0], SHIFTS[1]);
        factor.clear(elimination);
        responses.clear();
        responses.resize(jacobians.len(), JointRow::EMPTY.jacobian);
        springs.clear();
        mobility.clear();
        mobility.resize(jacobians.len(), 0.0);
        for (place, index, link) in held.links(mechanism) {
            let [a, b] = link.ends().map(|member| &inverse_masses[member as usize]);
            let (n, own) = (link.rows.len(), &jacobians[link.rows.clone()]);
            let block = factor.diagonal_at(elimination, place);
            for (column, jacobian) in own.iter().enumerate() {
                let (of_a, of_b) = (a.of(&jacobian.of_a()), b.of(&jacobian.of_b()));
                for row in column..n {
                    block[column * n + row] = own[row].dot(&of_a, &of_b);
                }
                mobility[link.rows.start + column] = block[column * n + column];
                responses[link.rows.start + column] = RowPair::new(of_a, of_b);
            }
            if mechanism.gives {
                for spring in RowSpring::of((index, link), rows) {
                    let softness = soften(&spring, &spring.each(|row| mobility[row]));
                    let first = spring.rows.start - link.rows.start;
                    for column in 0..spring.rows.len() {
                        for row in column..spring.rows.len() {
                            block[(first + column) * n + first + row] += softness[(row, column)];
                        }
                    }
                    springs.push((spring, softness));
                }
            }
            if mechanism.may_be_singular {
                shift(&rows[link.rows.clone()], block, share);
            }
            for row in given.iter().filter(|row| link.rows.contains(row)).map(|row| row - link.rows.start) {
                block[row * n + row] += 1.0;
            }
        }
        for coupling in couplings {
            let [rows, columns] = [coupling.row, coupling.column].map(|(place, _)| held.rows(mechanism, place));
            let n = rows.len();
            let block = factor.below_at(elimination, coupling.block as usize);
            for (column, response) in block.chunks_exact_mut(n).zip(&responses[columns]) {
                let response = response.of(coupling.column.1);
                for (entry, jacobian) in column.iter_mut().zip(&jacobians[rows.clone()]) {
                    *entry += jacobian.of(coupling.row.1).dot(&response);
                }
            }
        }
        factor.factor(elimination);
    }

    /// Sets J alone: the factor stays.
    pub fn set_jacobians(&mut self, rows: &[JointRow<f64>]) {
        self.jacobians.clear();
        self.jacobians.extend(rows.iter().map(|row| row.jacobian));
        self.given.clear();
        self.given.extend((0..rows.len()).filter(|&row| rows[row].given().is_some()));
        self.given.iter().for_each(|&row| self.jacobians[row] = JointRow::EMPTY.jacobian);
    }

    /// Mobility of a spring's rows.
    pub fn mobility(&self, spring: &RowSpring) -> Vector3<f64> {
        spring.each(|row| self.mobility[row])
    }

    /// J W Jᵀ of one row.
    pub fn mobility_of(&self, row: usize) -> f64 {
        self.mobility[row]
    }

    /// Accelerations that forces and springs alone make at those states. `pulls` are λ of springs and of rows where it is
    /// given.
    pub fn free_accelerations(
        &self,
        mechanism: &Mechanism,
        states: &[MemberState],
        rows: &[JointRow<f64>],
        pulls: &mut Vec<f64>,
        accelerations: &mut Vec<Twist<f64>>,
    ) {
        accelerations.clear();
        accelerations.extend(mechanism.members.iter().zip(states).map(|(member, state)| {
            member.wrench(state, &state.rotation.to_rotation_matrix().into_inner(), &Twist::zero())
        }));
        self.pulls(rows, |spring, mobility| spring.pull(rows, mobility), pulls);
        add_wrenches(&mechanism.links, rows.iter().map(|row| &row.jacobian), pulls, accelerations);
        for (wrench, inverse_mass) in accelerations.iter_mut().zip(&self.inverse_masses) {
            *wrench = inverse_mass.of(wrench);
        }
    }

    /// λ of the springs, which `pull` tells of one and its mobility; and of rows where it is given; zero of other rows.
    pub fn pulls(
        &self,
        rows: &[JointRow<f64>],
        pull: impl Fn(&RowSpring, &Vector3<f64>) -> Vector3<f64>,
        pulls: &mut Vec<f64>,
    ) {
        pulls.clear();
        pulls.resize(rows.len(), 0.0);
        self.given.iter().for_each(|&row| pulls[row] = rows[row].given().unwrap_or(0.0));
        for (spring, _) in &self.springs {
            let given = pull(spring, &self.mobility(spring));
            pulls[spring.rows.clone()].iter_mut().zip(&given).for_each(|(pull, given)| *pull = *given);
        }
    }

    /// x ← (A + E)⁻¹ x, once: for iterations that come back with the residual.
    #[inline]
    pub fn solve_once(&mut self, mechanism: &Mechanism, x: &mut [f64]) {
        let Self { held, factor, packed, .. } = self;
        let (elimination, _) = held.structure(mechanism);
        if held.are_all() {
            factor.solve(elimination, x);
            return;
        }
        packed.clear();
        held.links(mechanism).for_each(|(.., link)| packed.extend_from_slice(&x[link.rows.clone()]));
        factor.solve(elimination, &mut packed[..]);
        let mut rest = &packed[..];
        for (.., link) in held.links(mechanism) {
            let own;
            (own, rest) = rest.split_at(link.rows.len());
            x[link.rows.clone()].copy_from_slice(own);
        }
    }

    /// λ ← A⁻¹ b; where A may be singular, by iterations of the method of multipliers from zero, for as long as they get
    /// nearer.
    pub fn solve(&mut self, mechanism: &Mechanism, b: &[f64], lambda: &mut Vec<f64>) {
        self.solve_to(0.0, mechanism, b, lambda);
    }

    /// The same, until that share of b is left. The share that was left.
    pub fn solve_to(&mut self, enough: f64, mechanism: &Mechanism, b: &[f64], lambda: &mut Vec<f64>) -> f64 {
        lambda.clear();
        lambda.extend_from_slice(b);
        self.solve_once(mechanism, lambda);
        if !mechanism.may_be_singular {
            return 0.0;
        }
        let mut residual = std::mem::take(&mut self.residual);
        let mut before = f64::INFINITY;
        let all = self.size(b);
        for count in 1..MULTIPLIER_ITERATIONS[1] {
            self.find_residual(mechanism, b, lambda, &mut residual);
            let left = self.size(&residual);
            let is_stalled = left.is_nan() || left > MULTIPLIER_STALLED * before;
            if count >= MULTIPLIER_ITERATIONS[0] && is_stalled {
                break;
            }
            before = before.min(left);
            if left <= enough * all {
                break;
            }
            self.solve_once(mechanism, &mut residual);
            for (lambda, more) in lambda.iter_mut().zip(&residual) {
                *lambda += more;
            }
        }
        self.residual = residual;
        if all > 0.0 { before / all } else { 0.0 }
    }

    /// The norm of a residual, each row by its mobility: units differ.
    fn size(&self, residual: &[f64]) -> f64 {
        let rows = residual.iter().zip(&self.mobility).filter(|(_, mobility)| **mobility > 0.0);
        rows.map(|(left, mobility)| left * left / mobility).sum::<f64>().sqrt()
    }

    /// b − A λ.
    fn find_residual(&mut self, mechanism: &Mechanism, b: &[f64], lambda: &[f64], residual: &mut Vec<f64>) {
        let mut velocities = std::mem::take(&mut self.velocities);
        self.respond(mechanism, lambda, &mut velocities);
        residual.clear();
        residual.extend_from_slice(b);
        for (.., link) in self.held.links(mechanism) {
            let [a, b] = link.ends().map(|member| &velocities[member as usize]);
            for (left, jacobian) in residual[link.rows.clone()].iter_mut().zip(&self.jacobians[link.rows.clone()]) {
                *left -= jacobian.dot(a, b);
            }
        }
        for (spring, softness) in &self.springs {
            let given = softness * spring.each(|row| lambda[row]);
            residual[spring.rows.clone()].iter_mut().zip(&given).for_each(|(left, given)| *left -= given);
        }
        self.velocities = velocities;
    }

    /// W Jᵀ λ of all members.
    pub fn respond(&self, mechanism: &Mechanism, lambda: &[f64], velocities: &mut Vec<Twist<f64>>) {
        velocities.clear();
        velocities.resize(mechanism.members.len(), Twist::zero());
        add_wrenches(&mechanism.links, self.jacobians.iter(), lambda, velocities);
        for (velocity, inverse_mass) in velocities.iter_mut().zip(&self.inverse_masses) {
            *velocity = inverse_mass.of(velocity);
        }
    }
}

/// Adds that share of the trace to the diagonal: of the rows that only turn, and of the others, whose unit is another.
fn shift(rows: &[JointRow<f64>], block: &mut [f64], share: f64) {
    let n = rows.len();
    let mut traces = [0.0; 2];
    let kind = |row: usize| usize::from(rows[row].only_turns());
    (0..n).for_each(|row| traces[kind(row)] += block[row * n + row]);
    (0..n).for_each(|row| block[row * n + row] += share * traces[kind(row)]);
}

/// wrenches += Jᵀ λ.
#[inline]
pub(super) fn add_wrenches<'r>(
    links: &[MechanismLink],
    mut jacobians: impl Iterator<Item = &'r RowPair<f64>>,
    lambda: &[f64],
    wrenches: &mut [Wrench<f64>],
) {
    for link in links {
        let (mut a, mut b) = (wrenches[link.a as usize], wrenches[link.b as usize]);
        for (&lambda, jacobian) in lambda[link.rows.clone()].iter().zip(&mut jacobians) {
            a = a.plus(&jacobian.of_a(), lambda);
            b = b.plus(&jacobian.of_b(), lambda);
        }
        (wrenches[link.a as usize], wrenches[link.b as usize]) = (a, b);
    }
}
