//! Impacts, one pair or one limit of a joint at a time.
//!
//! Of those that touch and come together, the one that does so fastest bounces as if it were alone with what does not
//! bounce: its points get u⁺ = −e u⁻ along their normals (Newton's law, point by point), friction within its cone,
//! joints and the contacts that rest hold. That makes others come together; again, until none does. So an impact passes
//! through a row of balls from one to the next, as it does through real ones, whose contact times do not overlap if
//! there is any gap between them.
//!
//! With friction, or with joints that turn an impact aside, Newton's law may give more energy than there was (Kane 1984, *A
//! dynamics puzzle*). With e = 0 none does: there T⁺ − T⁻ = λ·u⁺ − ½ λᵀ(J M⁻¹ Jᵀ)λ, and λ·u⁺ ≤ 0. So where an impact would
//! give energy, it has as much of e as leaves what there was.
//!
//! An impact whose solve does not come to an end may leave its points coming together as they did. It would be due again at once,
//! and as often as a step may be cut. Such an impact passes without friction: that is a convex problem.

use nalgebra::Vector3;

use super::super::constants::{ENERGY_OF_IMPACT, IMPACTS_OF_A_PAIR, TOLERANCE, TOUCHING};
use super::super::mechanism::{MemberState, kinetic_energies};
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
    /// Before the impact at hand.
    start: Vec<MemberState>,
    /// After it, with all of e.
    bounced: Vec<MemberState>,
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
            self.row_gains.clear();
            self.row_gains.resize(self.solver.rows.len(), 0.0);
            let bounces = |limit: &&LimitRow| !ends && First::Limit(limit.row) == first;
            for limit in self.limits.list.iter().filter(bounces) {
                self.row_gains[limit.row] = -limit.side * rebound(limit.restitution, limit.approach(), 0.0);
            }
            self.bounce(view, states);
            self.failures += u32::from(!self.solver.is_solved);
            // Where nothing of it has passed it would be due again and again.
            if !self.solver.is_solved && !ends && self.approach_of(first, view, time, points, states) > least {
                states.clone_from_slice(&self.start);
                self.held.iter_mut().for_each(|point| point.friction = 0.0);
                self.solver.set(view, states, time, self.held.iter(), bounds);
                self.bounce(view, states);
            }
            note(&self.held, &self.solver);
            count += 1;
            if ends {
                return;
            }
            self.limits.find(view.links, states, time);
        }
    }

    /// How fast its points come together, m/s, or the limit is approached, m/s or rad/s; negative where it parts.
    fn approach_of(
        &mut self,
        first: First,
        view: GroupView,
        time: f64,
        points: &GapPoints,
        states: &[MemberState],
    ) -> f64 {
        match first {
            First::Pair(pair) => approach(points.of(pair), states),
            First::Limit(row) => {
                self.limits.find(view.links, states, time);
                let own = self.limits.list.iter().find(|limit| limit.row == row);
                own.map_or(0.0, LimitRow::approach)
            }
        }
    }

    /// Takes the velocities over an impact that is set, with as much of the gains as gives no energy.
    fn bounce(&mut self, view: GroupView, states: &mut [MemberState]) {
        self.start.clear();
        self.start.extend_from_slice(states);
        self.solve(1.0, states);
        // Motors have no part in it.
        let rows = self.solver.laws.iter().zip(&self.solver.rows);
        let is_moved = rows.filter(|(law, _)| !matches!(law, RowLaw::Boxed(..))).any(|(_, row)| row.time_rate != 0.0);
        if is_moved || !states[view.moving..].iter().all(MemberState::is_still) {
            return;
        }
        let energy = |states: &[MemberState]| kinetic_energies(&view.members[..view.moving], states).sum::<f64>();
        let most = energy(&self.start) * (1.0 + ENERGY_OF_IMPACT);
        let with_all = energy(states);
        if with_all <= most {
            return;
        }
        self.bounced.clear();
        self.bounced.extend_from_slice(states);
        self.restart(0.0, states);
        let with_none = energy(states);
        // Along the way from one to the other energy is a parabola.
        for (bounced, state) in self.bounced.iter_mut().zip(&*states) {
            (bounced.linear, bounced.angular) = (bounced.linear - state.linear, bounced.angular - state.angular);
        }
        let square = energy(&self.bounced);
        let slope = with_all - with_none - square;
        let left = (energy(&self.start) - with_none).max(0.0);
        let share = 2.0 * left / (slope + (slope * slope + 4.0 * square * left).sqrt());
        if share.is_finite() {
            self.restart(share.clamp(0.0, 1.0), states);
            if energy(states) > most {
                self.restart(0.0, states);
            }
        }
    }

    /// Does the impact again with that share of the gains.
    fn restart(&mut self, share: f64, states: &mut [MemberState]) {
        states.clone_from_slice(&self.start);
        self.solve(share, states);
    }

    fn solve(&mut self, share: f64, states: &mut [MemberState]) {
        let Self { solver, held, gains, row_gains, .. } = self;
        solver.impulses.contacts.clear();
        solver.impulses.contacts.resize(held.len(), Vector3::zeros());
        solver.row_impulses.clear();
        solver.row_impulses.resize(solver.rows.len(), 0.0);
        let biases = solver.laws.iter().zip(&solver.rows).map(|(law, told)| law.bias(told));
        let row_gains: Vec<f64> = biases.zip(&*row_gains).map(|(bias, gain)| bias + share * gain).collect();
        let gains: Vec<f64> = gains.iter().map(|gain| share * gain).collect();
        solver.solve(states, &gains, &row_gains, TOLERANCE, 0.0);
    }
}
