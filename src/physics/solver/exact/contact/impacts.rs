//! Impacts, one pair at a time.
//!
//! Of the pairs that touch and come together, the one that does so fastest bounces as if it were alone with what does
//! not bounce: its points get u⁺ = −e u⁻ along their normals (Newton's law, point by point), friction within its cone,
//! joints and the contacts that rest hold. That makes others come together; again, until none does. So an impact passes
//! through a row of balls from one to the next, as it does through real ones, whose contact times do not overlap if
//! there is any gap between them.

use nalgebra::Vector3;

use super::super::constants::{IMPACTS_OF_A_PAIR, TOUCHING};
use super::super::mechanism::MemberState;
use super::gap_points::{GapPoint, GapPoints, ReachablePair};
use super::group_solver::{GroupSolver, GroupView};
use crate::physics::contact::rebound;

/// The impacts at one time.
#[derive(Default)]
pub(super) struct Impacts {
    pub solver: GroupSolver,
    held: Vec<GapPoint>,
    gains: Vec<f64>,
    row_gains: Vec<f64>,
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
        let most = if may_bounce { IMPACTS_OF_A_PAIR * pairs.len() } else { 0 };
        loop {
            let bouncing = pairs.iter().enumerate().filter(|(_, pair)| pair.surface.restitution > 0.0);
            let approaches = bouncing.map(|(index, _)| (index, approach(points.of(index), states)));
            let first = approaches.filter(|(_, speed)| *speed > least).max_by(|a, b| a.1.total_cmp(&b.1));
            let Some((first, _)) = first else { return };
            let ends = count >= most;
            let is_held = |point: &&GapPoint| {
                let pair = point.pair as usize;
                point.gap <= TOUCHING && (ends || pair == first || pairs[pair].surface.restitution == 0.0)
            };
            self.held.clear();
            self.held.extend(points.list.iter().filter(is_held).cloned());
            self.solver.set(view, states, time, self.held.iter());
            self.gains.clear();
            let restitution = pairs[first].surface.restitution;
            let gain = |point: &GapPoint| {
                let bounces = !ends && point.pair as usize == first;
                if bounces { -rebound(restitution, -point.opening(states), 0.0) } else { 0.0 }
            };
            self.gains.extend(self.held.iter().map(gain));
            self.row_gains.clear();
            self.row_gains.resize(self.solver.rows.len(), 0.0);
            self.solver.impulses.contacts.clear();
            self.solver.impulses.contacts.resize(self.held.len(), Vector3::zeros());
            self.solver.row_impulses.clone_from(&self.row_gains);
            self.solver.solve(states, &self.gains, &self.row_gains);
            note(&self.held, &self.solver);
            count += 1;
            if ends {
                return;
            }
        }
    }
}
