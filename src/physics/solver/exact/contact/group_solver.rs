//! The cone solver on the contact points and joints of a group.

use nalgebra::Vector3;

use super::super::constants::{
    LATE_FACTORISATIONS, LATE_SOLVE, MOST_FACTORISATIONS, MOST_POINT_FACTORISATIONS, SETTLED, SLIDING, TOLERANCE,
    TOUCHING, WORTH_STALLING,
};
use super::super::mechanism::{InverseMass, MechanismLink, Member, MemberState, place_rows};
use super::super::row_mode::RowLaw;
use super::gap_points::{GapPoint, point_velocity};
use super::hardest_solve::HardestSolve;
use super::posed_rows::PosedRows;
use crate::physics::HardProblem;
use crate::physics::constraint::row::Wrench;
use crate::physics::joint::JointRow;
use crate::physics::solve_trace::Residuals;
use crate::physics::solver::cone::{
    ConeBody, ConeContact, ConeEnd, ConeJoint, ConeOutcome, ConeSolver, Deadline, PerPoint, PointJacobian,
};

/// Bodies and links; the first `moving` bodies move.
#[derive(Clone, Copy)]
pub(in super::super) struct GroupView<'a> {
    pub members: &'a [Member],
    pub moving: usize,
    pub links: &'a [MechanismLink],
}

/// The cone solver with its input and output.
#[derive(Clone, Default)]
pub(super) struct GroupSolver {
    solver: ConeSolver,
    /// What the solver is set to, and what was set before or is being made.
    posed: PosedRows,
    next: PosedRows,
    /// The rows of all links at the poses taken in; the solver has those that are no springs.
    pub rows: Vec<JointRow<f64>>,
    /// The laws of these.
    pub laws: Vec<RowLaw>,
    /// Which rows the axes of each of the solver's joints are, and −1 where the solver has them the other way round.
    axes: Vec<([Option<u32>; 3], f64)>,
    /// From B's centre of mass to its anchor, of each link.
    arms: Vec<Vector3<f64>>,
    velocities: Vec<[Vector3<f64>; 2]>,
    given: PerPoint,
    bias: PerPoint,
    /// λ, N·s, on B: where the iteration starts, then the solution.
    pub impulses: PerPoint,
    /// The same of all rows of links; zero of springs.
    pub row_impulses: Vec<f64>,
    /// Residual of the last solve, m/s.
    pub residual: f64,
    /// Residual, m/s, that solves lately could not get below: what stays as it is need not try again.
    pub stalled: f64,
    /// Whether it came to an end.
    pub is_solved: bool,
    pub steps: u32,
    /// Points times factorisations.
    pub work: u64,
    /// The step's hardest solve, while somebody wants it.
    hardest: Option<HardestSolve>,
    deadline: Deadline,
}

impl GroupSolver {
    /// Takes in the poses at that time, s, the points to hold, and by `bounds` what the impulse of a row may be, N·s: none
    /// of rows that have no part. Bodies that constraints do not move have the velocities of `states`.
    pub fn set<'s>(
        &mut self,
        view: GroupView,
        states: &[MemberState],
        time: f64,
        points: impl Iterator<Item = &'s GapPoint>,
        bounds: impl Fn(usize, RowLaw, &JointRow<f64>) -> Option<(f64, f64)>,
    ) {
        let moves = |end: u32| ((end as usize) < view.moving).then_some(end);
        let still = |ends: [u32; 2], arms: &[Vector3<f64>; 2]| {
            let of = |end: usize| match moves(ends[end]) {
                Some(_) => Vector3::zeros(),
                None => point_velocity(&states[ends[end] as usize], &arms[end]),
            };
            of(1) - of(0)
        };
        self.next.clear();
        self.next.bodies.extend(view.members.iter().zip(states).take(view.moving).map(|(member, state)| {
            let InverseMass { linear, angular } = member.inverse_mass_at(state);
            ConeBody { inverse_mass: linear, inverse_inertia: angular }
        }));
        self.given.contacts.clear();
        for point in points {
            let GapPoint { ends, arms, normal, friction, .. } = point;
            let bodies = ends.map(moves);
            self.next.contacts.push(ConeContact { bodies, arms: *arms, normal: *normal, friction: *friction });
            self.given.contacts.push(still(*ends, arms));
        }
        place_rows(view.links, states, time, &mut self.rows);
        self.laws.clear();
        self.laws.extend(self.rows.iter().map(RowLaw::of));
        self.given.joints.clear();
        self.axes.clear();
        self.arms.clear();
        for link in view.links {
            self.arms.push(link.arm_b(states));
            self.add_joints(link, link.ends().map(moves), states, &bounds);
        }
        // What rests has the rows that it had.
        if !self.next.are_as(&self.posed) {
            std::mem::swap(&mut self.posed, &mut self.next);
            let PosedRows { bodies, contacts, joints } = &self.posed;
            self.solver.set(bodies, contacts, joints);
        }
    }

    /// Adds the joints that a link is to the solver: up to three rows each, of one unit, or one that has bounds.
    fn add_joints(
        &mut self,
        link: &MechanismLink,
        bodies: [Option<u32>; 2],
        states: &[MemberState],
        bounds: impl Fn(usize, RowLaw, &JointRow<f64>) -> Option<(f64, f64)>,
    ) {
        let (mut count, mut unit) = (0, None);
        for index in link.rows.clone().filter(|&row| self.rows[row].spring.is_none()) {
            let (row, law) = (self.rows[index], self.laws[index]);
            let Some((lower, upper)) = bounds(index, law, &row) else { continue };
            let (is_rigid, only_turns) = (law == RowLaw::Unbounded, Some(row.only_turns()));
            // What pushes one way only is a row that pushes forwards.
            let (sign, bounds) =
                if upper == 0.0 && lower < 0.0 { (-1.0, (0.0, -lower)) } else { (1.0, (lower, upper)) };
            if count % 3 == 0 || unit != only_turns || !is_rigid {
                (count, unit) = (0, only_turns);
                self.next.joints.push(ConeJoint { bodies, jacobians: [PointJacobian::zeros(); 2], bounds });
                self.axes.push(([None; 3], sign));
                self.given.joints.push(Vector3::zeros());
            }
            let last = self.next.joints.len() - 1;
            self.axes[last].0[count] = Some(index as u32);
            self.given.joints[last][count] = row.time_rate * sign;
            for end in 0..2 {
                let own = row.jacobian.of(end);
                let mut jacobian = self.next.joints[last].jacobians[end].row_mut(count);
                jacobian.fixed_columns_mut::<3>(0).tr_copy_from(&(own.linear * sign));
                jacobian.fixed_columns_mut::<3>(3).tr_copy_from(&(own.angular * sign));
                if bodies[end].is_none() {
                    let state = &states[link.ends()[end] as usize];
                    self.given.joints[last][count] += own.dot(&state.twist()) * sign;
                }
            }
            count = if is_rigid { count + 1 } else { 0 };
        }
    }

    /// Starts the rows from those loads of links over a time, s.
    pub fn start_from(&mut self, view: GroupView, loads: &[Wrench<f64>], time: f64) {
        self.row_impulses.clear();
        for ((link, arm), load) in view.links.iter().zip(&self.arms).zip(loads) {
            let own = self.rows[link.rows.clone()].iter().zip(link.multipliers(arm, &self.rows, load));
            self.row_impulses.extend(own.map(|(row, force)| if row.spring.is_none() { force * time } else { 0.0 }));
        }
    }

    /// What the rows of each link gave in the last solve: the impulse on B, and its moment about B's anchor.
    pub fn loads(&self, links: &[MechanismLink]) -> impl Iterator<Item = Wrench<f64>> {
        links.iter().zip(&self.arms).map(|(link, arm)| link.load(arm, &self.rows, &self.row_impulses))
    }

    /// How many of those points slide such that no rigid motion exists: n·W(n − μ t̂) ≤ 0, W the mobility of the point
    /// and t̂ the direction in which it slides (Painlevé 1895): pressing harder pulls its bodies further into each other.
    pub fn jammed<'s>(&self, points: impl Iterator<Item = (&'s GapPoint, Vector3<f64>)>) -> u32 {
        let mut count = 0;
        for ((point, velocity), contact) in points.zip(&self.posed.contacts) {
            let slip = velocity - point.normal * velocity.dot(&point.normal);
            if point.gap > TOUCHING || slip.norm() < SLIDING {
                continue;
            }
            let push = point.normal - slip.normalize() * point.friction;
            let moved = (0..2).filter_map(|end| {
                let body = &self.posed.bodies[contact.bodies[end]? as usize];
                let arm = &contact.arms[end];
                let turned = body.inverse_inertia * arm.cross(&push);
                Some(body.inverse_mass.component_mul(&push) + turned.cross(arm))
            });
            count += u32::from(moved.sum::<Vector3<f64>>().dot(&point.normal) <= 0.0);
        }
        count
    }

    /// Has the residuals of the iterations to come noted, or not.
    pub fn trace(&mut self, traces: bool) {
        self.solver.trace(traces);
    }

    /// Those noted since, if any are.
    pub fn residuals(&self) -> Option<&Residuals> {
        self.solver.residuals()
    }

    /// Has the hardest of the solves to come kept, or not.
    pub fn keep_hardest(&mut self, keeps: bool) {
        self.hardest = keeps.then(HardestSolve::default);
    }

    /// The hardest since, if it is kept and any took an iteration.
    pub fn hardest(&self) -> Option<&HardProblem> {
        self.hardest.as_ref()?.problem.as_ref()
    }

    /// Has solves end soon after that.
    pub fn end_by(&mut self, deadline: Deadline) {
        self.deadline = deadline;
    }

    /// Whether that time is over, and more than a few iterations were made here in the step.
    pub fn is_late(&self) -> bool {
        self.steps >= LATE_FACTORISATIONS && self.deadline.is_over()
    }

    /// Whether a step has taken its share of work here, or of time.
    pub fn is_spent(&self) -> bool {
        self.steps >= MOST_FACTORISATIONS && self.work >= MOST_POINT_FACTORISATIONS || self.is_late()
    }

    /// Whether there is nothing to solve.
    pub fn is_empty(&self) -> bool {
        self.posed.contacts.is_empty() && self.posed.joints.is_empty()
    }

    /// Solves for the velocities to be gained along normals and by rows of links, m/s, from [`Self::impulses`] and
    /// [`Self::row_impulses`], to a residual of `tolerance`, m/s, at 1 m/s or less, and above as [`ConeSolver::solve`] says,
    /// or to one of `enough`, m/s; velocities of `states` are those without impulses, and with them on return.
    pub fn solve(&mut self, states: &mut [MemberState], gains: &[f64], row_gains: &[f64], tolerance: f64, enough: f64) {
        (self.residual, self.is_solved) = (0.0, true);
        if self.is_empty() {
            self.row_impulses.fill(0.0);
            return;
        }
        self.bias.clone_from(&self.given);
        for ((bias, contact), gain) in self.bias.contacts.iter_mut().zip(&self.posed.contacts).zip(gains) {
            *bias += contact.normal * *gain;
        }
        self.impulses.joints.clear();
        for (bias, (rows, sign)) in self.bias.joints.iter_mut().zip(&self.axes) {
            *bias += of_rows(rows, row_gains) * *sign;
            self.impulses.joints.push(of_rows(rows, &self.row_impulses) * *sign);
        }
        self.row_impulses.fill(0.0);
        self.velocities.clear();
        self.velocities.extend(states.iter().take(self.posed.bodies.len()).map(|state| [state.linear, state.angular]));
        let is_relaxed = self.stalled > tolerance.max(SETTLED);
        // Both are speeds, whatever the bodies' are.
        let enough = enough.max(self.stalled);
        if let Some(hardest) = &mut self.hardest {
            hardest.begin(&self.velocities, &self.impulses);
        }
        self.solver.end_by(self.deadline, LATE_FACTORISATIONS.saturating_sub(self.steps).max(LATE_SOLVE));
        let outcome = self.solver.solve(&mut self.velocities, &self.bias, &mut self.impulses, tolerance, enough);
        if let Some(hardest) = &mut self.hardest {
            let ConeOutcome { steps: iterations, tolerance, residual, .. } = outcome;
            let told = HardProblem { iterations, tolerance, residual, ..HardProblem::default() };
            hardest.end(&self.posed.bodies, &self.posed.contacts, &self.posed.joints, &self.bias, told);
        }
        match outcome.end {
            ConeEnd::Enough if outcome.residual > TOLERANCE => self.stalled = SETTLED,
            ConeEnd::Bounded if outcome.residual < WORTH_STALLING => self.stalled = outcome.residual,
            _ if outcome.steps > 0 => self.stalled *= 0.5,
            _ => {}
        }
        for ((rows, sign), impulses) in self.axes.iter().zip(&self.impulses.joints) {
            for (row, impulse) in rows.iter().zip(impulses) {
                row.iter().for_each(|&row| self.row_impulses[row as usize] = *impulse * sign);
            }
        }
        self.residual = outcome.residual;
        self.steps += outcome.steps;
        self.work += u64::from(outcome.steps) * (self.posed.contacts.len() + self.posed.joints.len()) as u64;
        let is_ended = !matches!(outcome.end, ConeEnd::Bounded | ConeEnd::Late | ConeEnd::NoRigidSolution);
        self.is_solved = is_ended && !(is_relaxed && outcome.residual > SETTLED);
        for (state, [linear, angular]) in states.iter_mut().zip(&self.velocities) {
            (state.linear, state.angular) = (*linear, *angular);
        }
    }
}

/// The numbers of those rows.
fn of_rows(rows: &[Option<u32>; 3], numbers: &[f64]) -> Vector3<f64> {
    rows.map(|row| row.map_or(0.0, |row| numbers[row as usize])).into()
}
