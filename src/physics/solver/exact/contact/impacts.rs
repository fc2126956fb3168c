//! Impacts, one pair or one limit of a joint at a time.
//!
//! Of those that touch and come together, the one that does so fastest bounces as if it were alone with what does not
//! bounce: its points get u⁺ = −e u⁻ along their normals (Newton's law, point by point), friction within its cone,
//! joints and the contacts that rest hold. That makes others come together; again, until none does. So an impact passes
//! through a row of balls from one to the next, as it does through real ones, whose contact times do not overlap if
//! there is any gap between them.

use nalgebra::Vector3;

use super::super::constants::{IMPACTS_OF_A_PAIR, TOLERANCE, TOUCHING};
use super::super::mechanism::MemberState;
use super::super::row_mode::RowLaw;
use super::gap_points::{GapPoint, GapPoints, ReachablePair};
use super::group_solver::{GroupSolver, GroupView};
use super::limit_rows::{LimitRow, LimitRows};
use crate::physics::contact::rebound;
use crate::physics::joint::JointRow;

/// The impacts at one time.
#[derive(Clone, Default)]
pub(super) struct Impacts {
    pub solver: GroupSolver,
    /// Solves that did not come to an end.
    pub failures: u32,
    held: Vec<GapPoint>,
    gains: Vec<f64>,
    row_gains: Vec<f64>,
    limits: LimitRows,
}

/// What bounces.
#[derive(Clone, Copy, PartialEq)]
enum First {
    Pair(usize),
    Limit(usize),
}

/// Fastest approach of a pair's points that touch, m/s; negative if all part.
pub(super) fn approach(points: &[GapPoint], states: &[MemberState]) -> f64 {
    let touching = points.iter().filter(|point| point.gap <= TOUCHING);
    touching.map(|point| -point.opening(states)).fold(f64::NEG_INFINITY, f64::max)
}

impl Impacts {
    /// Takes the velocities over all impacts that are due at that time, s; if nothing may bounce, all is stopped.
    /// `note` is told what each solve pushed, N·s.
    pub fn pass(
        &mut self,
        view: GroupView,
        time: f64,
        pairs: &[ReachablePair],
        points: &GapPoints,
        least: f64,
        may_bounce: bool,
        states: &mut [MemberState],
        mut note: impl FnMut(&[GapPoint], &GroupSolver),
    ) {
        let mut count = 0;
        self.limits.find(view.links, states, time);
        let most = if may_bounce { IMPACTS_OF_A_PAIR * (pairs.len() + self.limits.list.len()) } else { 0 };
        loop {
            let bouncing = pairs.iter().enumerate().filter(|(_, pair)| pair.surface.restitution > 0.0);
            let approaches = bouncing.map(|(index, _)| (First::Pair(index), approach(points.of(index), states)));
            let limits = self.limits.list.iter().filter(|limit| limit.restitution > 0.0);
            let approaches = approaches.chain(limits.map(|limit| (First::Limit(limit.row), limit.approach())));
            let first = approaches.filter(|(_, speed)| *speed > least).max_by(|a, b| a.1.total_cmp(&b.1));
            let Some((first, _)) = first else { return };
            let ends = count >= most;
            let is_held = |point: &&GapPoint| {
                let pair = point.pair as usize;
                point.gap <= TOUCHING && (ends || First::Pair(pair) == first || pairs[pair].surface.restitution == 0.0)
            };
            let bounds = |row: usize, law: RowLaw, told: &JointRow<f64>| match law {
                RowLaw::Limit(side) => {
                    let has_part = ends || First::Limit(row) == first || told.restitution == 0.0;
                    (has_part && told.error * side <= TOUCHING).then(|| law.impulses(told))
                }
                RowLaw::Unbounded | RowLaw::Boxed(..) => {
                    Some(law.impulses(told)).filter(|bounds| *bounds != (0.0, 0.0))
                }
            };
            self.held.clear();
            self.held.extend(points.list.iter().filter(is_held).cloned());
            self.solver.set(view, states, time, self.held.iter(), bounds);
            self.gains.clear();
            let gain = |point: &GapPoint| {
                let (pair, approach) = (point.pair as usize, -point.opening(states));
                let bounces = !ends && First::Pair(pair) == first;
                if bounces { -rebound(pairs[pair].surface.restitution, approach, 0.0) } else { 0.0 }
            };
            self.gains.extend(self.held.iter().map(gain));
            self.solver.impulses.contacts.clear();
            self.solver.impulses.contacts.resize(self.held.len(), Vector3::zeros());
            self.solver.row_impulses.clear();
            self.solver.row_impulses.resize(self.solver.rows.len(), 0.0);
            self.row_gains.clear();
            self.row_gains.extend(self.solver.laws.iter().zip(&self.solver.rows).map(|(law, told)| law.bias(told)));
            let bounces = |limit: &&LimitRow| !ends && First::Limit(limit.row) == first;
            for limit in self.limits.list.iter().filter(bounces) {
                self.row_gains[limit.row] = -limit.side * rebound(limit.restitution, limit.approach(), 0.0);
            }
            self.solver.solve(states, &self.gains, &self.row_gains, TOLERANCE, 0.0);
            self.failures += u32::from(!self.solver.is_solved);
            note(&self.held, &self.solver);
            count += 1;
            if ends {
                return;
            }
            self.limits.find(view.links, states, time);
        }
    }
}
