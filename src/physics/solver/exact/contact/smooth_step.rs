//! A step without impacts: RATTLE with contacts.
//!
//! v½ = v₀ + ½h M₀⁻¹F + M₀⁻¹J₀ᵀλ, q₁ = q₀ after free motion over h with v½, v₁ = v½ + ½h M₁⁻¹F + M₁⁻¹J₁ᵀμ.
//!
//! λ makes positions hold: joints are closed at q₁, gaps g(q₁) ≥ 0, with a normal impulse only where g(q₁) = 0. μ makes
//! velocities hold: J₁v₁ = 0, and where g(q₁) = 0 gaps do not close. Both are within the cone of friction, against the
//! slip of v½ and of v₁. A pair that neither bounces nor has landed is stopped where the surfaces meet. Both impulses are
//! the cone solver's problem: λ with a linear forecast ĝ of the gaps, whose error (g − ĝ)/h corrects the bias until the
//! forecast comes true. That takes secants ([`mixing`](super::mixing)), since errors fall by a factor as large as the turn of
//! the step, and points that are followed by their place ([`held_points`](super::held_points)). Where a pair touches at an
//! edge in one forecast and at a corner in the next, no forecast comes true to the last digits: of points an error of
//! [`FLICKERING_ERROR`] may be left.
//!
//! Limits of joints are gaps of their rows; rows whose λ is bounded both ways are brought to the speed that they want by
//! both impulses, each within half the step's bounds.
//!
//! Constant forces are followed exactly, sliding and rolling too; all else with an error of second order.

use std::ops::Range;

use nalgebra::Vector3;

use super::super::constants::{
    FLICKERING_ERROR, FLICKERING_STALLS, FORECAST_ERROR, FORECAST_PATIENCE, FORECAST_SHARE, FORECAST_TOLERANCE,
    FORESEEN_SPEED, FORESEEN_SPEEDS, LEAST_THROWN, MOST_FORECASTS, PROGRESS, SETTLED, SLOW_SPEED, STALLED_ERROR,
    STILL_SHARE, STILL_SPEED, THROWN, TOUCHING, UNFORESEEN, UNSOLVED,
};
use super::super::mechanism::{InverseMass, MemberState, RowSpring, place_rows};
use super::super::row_mode::RowLaw;
use super::gap_points::{GapPoint, GapPoints, PointSearch, ReachablePair};
use super::group_solver::{GroupSolver, GroupView};
use super::held_points::HeldPoints;
use super::joint_gaps::{is_apart, overlap};
use super::mixing::Mixing;
use crate::physics::body::Body;
use crate::physics::constraint::row::{RowPair, Wrench};
use crate::physics::joint::JointRow;
use crate::physics::solver::cone::PerPoint;

/// What stays the same in a step.
#[derive(Clone, Copy)]
pub(super) struct SmoothTerms<'a> {
    pub view: GroupView<'a>,
    /// Time at the start, s, and length, s.
    pub time: f64,
    pub h: f64,
    /// Loads of links, N and N·m, that the iteration starts from.
    pub loads: &'a [Wrench<f64>],
    /// Whether some link has springs.
    pub gives: bool,
    pub pairs: &'a [ReachablePair],
    /// Whether each pair is left free: it bounces and does not rest.
    pub free: &'a [bool],
    /// Whether each row of links is left free: a limit that bounces and does not rest.
    pub free_rows: &'a [bool],
    /// Fastest way out of an overlap, m/s.
    pub correction_speed: f64,
    /// Time over which errors of joints and overlaps are closed, s: a whole substep, for a step that is cut may be short.
    pub closing: f64,
    /// Whether one forecast has to do: the last resort where none comes true.
    pub is_rough: bool,
    /// Residual that solves are to come to, m/s.
    pub tolerance: f64,
}

/// The step and its buffers.
#[derive(Clone, Default)]
pub(super) struct SmoothStep {
    pub positions: GroupSolver,
    pub velocities: GroupSolver,
    /// The points held by positions, and by velocities.
    pub held: HeldPoints,
    pub held_at_end: Vec<GapPoint>,
    /// The states at the end, and the points there.
    pub end: Vec<MemberState>,
    pub points: GapPoints,
    kicked: Vec<MemberState>,
    gains: Vec<f64>,
    row_gains: Vec<f64>,
    /// How far the gains of points, and then of rows, are from what the forecast led to,
    errors: Vec<f64>,
    /// and whether that is an error: points that carry nothing and do not overlap may be anywhere.
    counts: Vec<bool>,
    mixing: Mixing,
    /// How fast gaps open and C of rows grows at the start, m/s: the linear part of the forecast.
    openings: Vec<f64>,
    rates: Vec<f64>,
    /// The limits that may close in the step, by row.
    foreseen: Vec<bool>,
    /// Whether the forecast came true.
    pub is_true: bool,
    /// Whether nothing moved at the start.
    pub is_still: bool,
    /// The gains of points and rows that were solved for last.
    flown: (Vec<f64>, Vec<f64>),
    kept: KeptForecast,
    /// Sliding points at the start that no rigid motion satisfies.
    pub jammed: u32,
    /// Rows of links with springs, at the pose of a kick.
    rows: Vec<JointRow<f64>>,
    /// Mean load of each link by its springs.
    pub spring_loads: Vec<Wrench<f64>>,
}

/// The best forecast so far, while a better one is tried.
#[derive(Clone, Default)]
struct KeptForecast {
    gains: Vec<f64>,
    row_gains: Vec<f64>,
    impulses: PerPoint,
    row_impulses: Vec<f64>,
    residual: f64,
    end: Vec<MemberState>,
    points: GapPoints,
}

/// How forecasts get on.
struct Progress {
    /// The least error since points were met last, m.
    least: f64,
    /// Whether the rows of that forecast came true, whatever its points did.
    has_rows: bool,
    /// Forecasts in a row that did not halve the least error.
    stalls: u32,
    /// The least of errors and residuals, m, and forecasts in a row that made no less of it.
    least_of_both: f64,
    waited: u32,
    /// The least error of rows, m, whatever was met.
    least_of_rows: f64,
}

impl Progress {
    const NONE: Self = Self {
        least: f64::INFINITY,
        has_rows: false,
        stalls: 0,
        least_of_both: f64::INFINITY,
        waited: 0,
        least_of_rows: f64::INFINITY,
    };

    /// Takes in an error, m, infinite where points were met, whether rows came true, and how far, m, the residual of its solve
    /// leads. True where it is the least.
    fn note(&mut self, error: f64, has_rows: bool, missed: f64) -> bool {
        if error.is_infinite() {
            *self = Self { least_of_rows: self.least_of_rows, ..Self::NONE };
            return false;
        }
        self.stalls = if error < 0.5 * self.least { 0 } else { self.stalls + 1 };
        // The forecast of a solve that is left as it is comes true, whatever that is worth.
        let both = error.max(missed);
        let is_better = both < PROGRESS * self.least_of_both;
        (self.least_of_both, self.waited) = if is_better { (both, 0) } else { (self.least_of_both, self.waited + 1) };
        let is_least = error < self.least;
        if is_least {
            (self.least, self.has_rows) = (error, has_rows);
        }
        is_least
    }

    /// Takes in the error of rows, m. Whether the forecast throws bodies away, as where joints come straight between two that
    /// hold them: what it meets there says nothing, and none comes true after it.
    fn is_thrown(&mut self, of_rows: f64) -> bool {
        let is_thrown = of_rows > (THROWN * self.least_of_rows).max(LEAST_THROWN);
        self.least_of_rows = self.least_of_rows.min(of_rows);
        is_thrown
    }

    /// Whether no better forecast than the least is to be had, and that is good enough.
    fn has_stalled(&self) -> bool {
        self.least < STALLED_ERROR && self.stalls > 0 || self.is_enough() && self.stalls > FLICKERING_STALLS
    }

    /// Whether the least error is one that may be left.
    fn is_enough(&self) -> bool {
        self.least < FLICKERING_ERROR && self.has_rows
    }
}

impl SmoothTerms<'_> {
    /// What the impulse of a row may be in each half of the step, N·s; none of rows left free.
    fn bounds(&self, row: usize, law: RowLaw, told: &JointRow<f64>) -> Option<(f64, f64)> {
        let ((lower, upper), half) = (law.forces(told), 0.5 * self.h);
        (!self.free_rows[row]).then_some((lower * half, upper * half))
    }

    /// What velocities are to gain along the normal of a point by its gap at the start, m/s, where that share of overlaps is
    /// closed.
    fn point_gain(&self, point: &GapPoint, closed: f64) -> f64 {
        if point.gap > 0.0 {
            point.gap / self.h
        } else {
            (point.gap * closed / self.closing).max(-self.correction_speed)
        }
    }

    /// What velocities are to gain along a row by its C at the start, m/s, where that share of errors is closed.
    fn row_gain(&self, law: RowLaw, row: &JointRow<f64>, closed: f64) -> f64 {
        let share = closed / self.closing;
        match law {
            _ if is_apart(law, row) => 0.0,
            RowLaw::Unbounded => row.error * share,
            RowLaw::Limit(side) if row.error * side > 0.0 => row.error / self.h,
            RowLaw::Limit(side) => side * (row.error * side * share).max(-self.correction_speed),
            RowLaw::Boxed(..) => law.bias(row),
        }
    }
}

impl SmoothStep {
    /// From the states `start` to [`Self::end`]. `start_points` are the contact points there; `bodies` take the poses of
    /// the end. `start_force` is the force that the iteration starts from, N.
    pub fn step(
        &mut self,
        given: &SmoothTerms,
        start: &[MemberState],
        start_points: &GapPoints,
        bodies: &mut [Body],
        search: &mut PointSearch,
        start_force: impl Fn(&GapPoint) -> Vector3<f64>,
    ) {
        self.end.clear();
        self.end.extend_from_slice(start);
        self.spring_loads.clear();
        self.spring_loads.resize(given.view.links.len(), Wrench::zero());
        // Where no forecast is flown there are none: those found last may be of other pairs.
        self.points.clear(given.pairs.len());
        self.kick(given, given.time);
        self.kicked.clone_from(&self.end);
        self.foresee_limits(given);
        let held = &mut self.held;
        held.begin(start_points.list.iter().filter(|point| !given.free[point.pair as usize]));
        let held = &held.list;
        self.positions.set(given.view, &self.kicked, given.time, held.iter(), |row, law, told| {
            given.bounds(row, law, told).filter(|_| self.foreseen[row])
        });
        self.jammed = self.positions.jammed(held.iter().map(|point| (point, point.velocity(start))));
        self.positions.impulses.contacts.clear();
        self.positions.impulses.contacts.extend(held.iter().map(|point| start_force(point) * (0.5 * given.h)));
        self.positions.start_from(given.view, given.loads, 0.5 * given.h);
        let moving = start.iter().zip(&*bodies).take(given.view.moving);
        let speeds = moving.map(|(state, body)| state.linear.norm() + state.angular.norm() * body.radius);
        let fastest = speeds.fold(0.0, f64::max);
        self.is_still = fastest <= STILL_SPEED;
        // What is slow comes as foreseen, and no second forecast would bring what the first solve leaves.
        let share = if fastest <= SLOW_SPEED { fastest * fastest } else { 1.0 };
        let tolerance = share * FORECAST_TOLERANCE;
        self.hold_places(given, bodies, search, tolerance);
        self.kick(given, given.time + given.h);
        let share = if self.is_still { STILL_SHARE } else { 1.0 };
        self.hold_velocities(given, share * given.tolerance);
        self.is_true &= self.velocities.residual * given.closing <= UNSOLVED;
    }

    /// Whether the forecast came true and both impulses obey their laws, whatever was tried before.
    pub fn is_settled(&self) -> bool {
        let solvers = [&self.positions, &self.velocities];
        self.is_true && solvers.iter().all(|solver| solver.is_solved || solver.residual <= SETTLED)
    }

    /// Half a step of forces, springs and drag, at that time, s.
    fn kick(&mut self, given: &SmoothTerms, time: f64) {
        let (GroupView { members, links, .. }, half) = (given.view, 0.5 * given.h);
        let Self { end, rows, spring_loads, .. } = self;
        if given.gives {
            place_rows(links, end, time, rows);
        }
        for (index, link) in links.iter().enumerate().filter(|(_, link)| link.gives()) {
            for spring in RowSpring::of((index, link), rows) {
                let masses = link.ends().map(|member| members[member as usize].inverse_mass_at(&end[member as usize]));
                let [a, b] = link.ends().map(|member| end[member as usize].twist());
                let jacobian = |row: usize| &rows[row].jacobian;
                let rate = spring.each(|row| jacobian(row).dot(&a, &b) + rows[row].time_rate);
                let mobility = spring.each(|row| mobility(jacobian(row), &masses));
                let pull = spring.pull_in_kick(rows, &rate, &mobility, half);
                for (row, &pull) in spring.rows.clone().zip(&pull) {
                    let ends = [jacobian(row).of_a(), jacobian(row).of_b()];
                    for ((member, inverse_mass), wrench) in link.ends().into_iter().zip(&masses).zip(ends) {
                        let state = &mut end[member as usize];
                        let gained = state.twist().plus(&inverse_mass.of(&wrench), pull * half);
                        (state.linear, state.angular) = (gained.linear, gained.angular);
                    }
                    spring_loads[index] =
                        spring_loads[index].plus(&rows[row].wrench_about(&link.arm_b(end)), 0.5 * pull);
                }
            }
        }
        for (member, state) in members.iter().zip(&mut *end) {
            member.kick(state, &Wrench::zero(), &member.inverse_mass_at(state), half);
        }
    }

    /// Finds the limits that may close in the step; all other rows are foreseen.
    fn foresee_limits(&mut self, given: &SmoothTerms) {
        let Self { foreseen, kicked, rows, .. } = self;
        foreseen.clear();
        if !given.view.links.iter().any(|link| link.may_be_bounded) {
            foreseen.resize(given.free_rows.len(), true);
            return;
        }
        place_rows(given.view.links, kicked, given.time, rows);
        foreseen.extend(rows.iter().map(|row| match RowLaw::of(row) {
            RowLaw::Limit(side) => row.error * side <= given.h * (FORESEEN_SPEEDS * row.rate.abs()).max(FORESEEN_SPEED),
            RowLaw::Unbounded | RowLaw::Boxed(..) => true,
        }));
    }

    fn hold_places(&mut self, given: &SmoothTerms, bodies: &mut [Body], search: &mut PointSearch, tolerance: f64) {
        // An error that cannot be closed, as of a chain that is stretched too far, is left as it is.
        let is_open = self.held.list.iter().any(|point| point.gap < -STALLED_ERROR)
            || rigid(&self.positions.rows).any(|(row, told)| overlap(self.positions.laws[row], told) > STALLED_ERROR);
        self.is_true = self.forecast(given, bodies, search, (1.0, tolerance))
            || is_open && !given.is_rough && self.forecast(given, bodies, search, (0.0, tolerance));
    }

    /// Solves for positions until the forecast is what free motion makes of it. `closed` is the share of the errors at
    /// the start that is closed, and the first solve is to a residual of `tolerance`, m/s. Whether the forecast came true.
    fn forecast(
        &mut self,
        given: &SmoothTerms,
        bodies: &mut [Body],
        search: &mut PointSearch,
        (closed, tolerance): (f64, f64),
    ) -> bool {
        let h = given.h;
        self.gains.clear();
        self.gains.extend(self.held.list.iter().map(|point| given.point_gain(point, closed)));
        self.row_gains.clear();
        let rows = self.positions.laws.iter().zip(&self.positions.rows);
        self.row_gains.extend(rows.map(|(&law, row)| given.row_gain(law, row, closed)));
        self.mixing.forget();
        // No solve need be better than its forecast: of points that are redundant, a forecast that is wrong makes points that
        // contradict each other, which only hundreds of iterations bring to the last digits.
        let mut tolerance = if given.is_rough { given.tolerance } else { given.tolerance.max(tolerance) };
        let (mut progress, mut is_last) = (Progress::NONE, false);
        let mut enough = 0.0;
        for count in 1..=MOST_FORECASTS {
            self.flown.0.clone_from(&self.gains);
            self.flown.1.clone_from(&self.row_gains);
            if !self.fly(given, bodies, search, tolerance, enough) {
                return false;
            }
            if self.positions.is_empty() && self.foreseen.iter().all(|is_foreseen| *is_foreseen) {
                return true;
            }
            let is_met = self.mend(given, bodies, closed);
            let [of_points, of_rows] = self.largest_errors().map(|error| error * h);
            if progress.is_thrown(of_rows) && !given.is_rough {
                return false;
            }
            let worst = if is_met { f64::INFINITY } else { of_points.max(of_rows) };
            let has_rows = of_rows < STALLED_ERROR;
            let residual = self.positions.residual;
            // What came as foreseen at once was solved for no better than a first forecast is: that is done again.
            let is_final = tolerance <= given.tolerance || residual <= given.tolerance;
            let is_as_foreseen = worst <= FORECAST_ERROR;
            // Where the solver has come to its end, none better is to be had.
            if is_as_foreseen && residual <= SETTLED && is_final || !self.positions.is_solved && worst <= residual * h {
                return true;
            }
            if is_last {
                if residual <= SETTLED && has_rows && worst < FLICKERING_ERROR {
                    return true;
                }
                progress.least = f64::INFINITY;
            }
            if progress.note(worst, has_rows, residual * h) {
                self.keep();
            }
            tolerance = if is_as_foreseen {
                given.tolerance
            } else {
                (FORECAST_SHARE * (worst / h).max(tolerance)).clamp(given.tolerance, tolerance)
            };
            is_last = progress.has_stalled();
            let has_ended = if given.is_rough { !is_met } else { self.positions.is_spent() };
            let is_over = has_ended || count == MOST_FORECASTS;
            if is_last || is_over && progress.is_enough() {
                // No better one is to be had: the best so far, with its impulses to the end.
                self.give_back();
                if self.positions.residual <= SETTLED {
                    return true;
                }
                (tolerance, enough) = (given.tolerance, SETTLED);
            }
            if is_over || !is_last && progress.waited > FORECAST_PATIENCE || worst.is_nan() {
                return false;
            }
        }
        false
    }

    /// Keeps the forecast that was flown last.
    fn keep(&mut self) {
        let Self { kept, positions, end, points, flown, .. } = self;
        kept.gains.clone_from(&flown.0);
        kept.row_gains.clone_from(&flown.1);
        kept.impulses.clone_from(&positions.impulses);
        kept.row_impulses.clone_from(&positions.row_impulses);
        kept.residual = positions.residual;
        kept.end.clone_from(end);
        kept.points.clone_from(points);
    }

    /// Takes up the forecast that was kept.
    fn give_back(&mut self) {
        let Self { kept, positions, end, points, gains, row_gains, .. } = self;
        std::mem::swap(&mut kept.gains, gains);
        std::mem::swap(&mut kept.row_gains, row_gains);
        std::mem::swap(&mut kept.impulses, &mut positions.impulses);
        std::mem::swap(&mut kept.row_impulses, &mut positions.row_impulses);
        positions.residual = kept.residual;
        std::mem::swap(&mut kept.end, end);
        std::mem::swap(&mut kept.points, points);
    }

    /// Solves for the present gains, and moves to the end with what comes of it. False where no solution is near.
    fn fly(
        &mut self,
        given: &SmoothTerms,
        bodies: &mut [Body],
        search: &mut PointSearch,
        tolerance: f64,
        enough: f64,
    ) -> bool {
        let Self { positions, held, end, points, kicked, gains, row_gains, mixing, openings, rates, .. } = self;
        end.clone_from(kicked);
        let steps = positions.steps;
        positions.solve(end, gains, row_gains, tolerance, enough);
        if positions.steps == steps {
            // What a solve that is left as it is comes to says nothing of the next.
            mixing.forget();
        }
        if !positions.is_solved && positions.residual * given.h > UNSOLVED && !given.is_rough {
            return false;
        }
        openings.clear();
        openings.extend(held.list.iter().map(|point| point.opening(end)));
        rates.clear();
        given.view.links.iter().for_each(|link| rates.extend(link.rates(&positions.rows, end)));
        for (member, state) in given.view.members.iter().zip(&mut *end) {
            member.move_freely(state, given.h);
        }
        place(bodies, end);
        let carrying =
            |pair: u32| held.of(pair).filter(|&point| positions.impulses.contacts[point] != Vector3::zeros()).count();
        points.find(given.pairs, bodies, |pair| margin(pair, bodies), carrying, search);
        true
    }

    /// Takes the gains to those of the next forecast by what the last one missed. Whether it met points or limits that it
    /// did not hold.
    fn mend(&mut self, given: &SmoothTerms, bodies: &[Body], closed: f64) -> bool {
        let h = given.h;
        self.held.follow(&self.points, &self.kicked, &self.end, |body| bodies[body as usize].radius);
        place_rows(given.view.links, &self.end, given.time + h, &mut self.rows);
        let mut is_met = false;
        for (row, told) in self.rows.iter().enumerate().filter(|(row, _)| !given.free_rows[*row]) {
            if !self.foreseen[row] && overlap(self.positions.laws[row], told) > UNFORESEEN {
                (self.foreseen[row], is_met) = (true, true);
            }
        }
        self.find_errors(given, closed);
        let Self { positions, held, end, points, kicked, gains, row_gains, errors, counts, mixing, foreseen, .. } =
            self;
        if !given.is_rough {
            mixing.mix(gains.iter_mut().chain(&mut *row_gains), errors, counts);
        }
        let count = held.list.len();
        held.meet(points, kicked, end, h, |pair| given.free[pair as usize]);
        is_met |= held.list.len() > count;
        if is_met {
            mixing.forget();
            positions.set(given.view, kicked, given.time, held.list.iter(), |row, law, told| {
                given.bounds(row, law, told).filter(|_| foreseen[row])
            });
            gains.extend(held.list[count..].iter().map(|point| given.point_gain(point, closed)));
            positions.impulses.contacts.resize(held.list.len(), Vector3::zeros());
        }
        is_met
    }

    /// How far gains of points and of rows are from those with which the last forecast would have come true.
    fn find_errors(&mut self, given: &SmoothTerms, closed: f64) {
        let h = given.h;
        let Self { positions, held, points, gains, row_gains, errors, openings, rates, rows, foreseen, counts, .. } =
            self;
        errors.clear();
        counts.clear();
        let terms = gains.iter().zip(&*openings).zip(&positions.impulses.contacts).zip(&held.at_end);
        errors.extend(held.list.iter().zip(terms).map(|(point, (((gain, opening), impulse), found))| {
            let found = found.map(|found| points.list[found].gap);
            let is_held = |gap: f64| *impulse != Vector3::zeros() || gap < -FORECAST_ERROR;
            counts.push(found.is_some_and(is_held));
            let Some(gap) = found else { return 0.0 };
            let bent = gap - (point.gap + opening * h);
            given.point_gain(point, closed) + bent / h - gain
        }));
        let is_bent = |row: usize| match positions.laws[row] {
            RowLaw::Unbounded => true,
            RowLaw::Limit(side) if foreseen[row] && !given.free_rows[row] => {
                positions.row_impulses[row] != 0.0 || rows[row].error * side < -FORECAST_ERROR
            }
            RowLaw::Limit(_) | RowLaw::Boxed(..) => false,
        };
        errors.resize(held.list.len() + row_gains.len(), 0.0);
        counts.resize(errors.len(), true);
        for (row, start) in rigid(&positions.rows).filter(|(row, _)| is_bent(*row)) {
            let bent = rows[row].error - (start.error + rates[row] * h);
            errors[held.list.len() + row] =
                given.row_gain(positions.laws[row], start, closed) + bent / h - row_gains[row];
        }
    }

    /// Of the last forecast, m/s: of points, and of rows.
    fn largest_errors(&self) -> [f64; 2] {
        let known = self.counts.len() - self.row_gains.len();
        let largest = |range: Range<usize>| {
            let errors = self.errors[range.clone()].iter().zip(&self.counts[range]).filter(|(_, counts)| **counts);
            // A NaN stays.
            errors.fold(0.0, |most: f64, (error, _)| if error.abs() <= most { most } else { error.abs() })
        };
        [largest(0..known), largest(known..self.counts.len())]
    }

    fn hold_velocities(&mut self, given: &SmoothTerms, tolerance: f64) {
        let Self { velocities, positions, held: before, held_at_end: held, end, points, gains, row_gains, .. } = self;
        held.clear();
        let is_held = |point: &&GapPoint| !given.free[point.pair as usize] && point.gap <= TOUCHING;
        held.extend(points.list.iter().filter(is_held).cloned());
        velocities.set(given.view, end, given.time + given.h, held.iter(), |row, law, told| {
            given.bounds(row, law, told).filter(|_| overlap(law, told) >= -TOUCHING)
        });
        gains.clear();
        gains.resize(held.len(), 0.0);
        row_gains.clear();
        row_gains.extend(velocities.laws.iter().zip(&velocities.rows).map(|(law, row)| law.bias(row)));
        let start_force = |point: &GapPoint| {
            before.position(point).map_or_else(Vector3::zeros, |known| positions.impulses.contacts[known])
        };
        velocities.impulses.contacts.clear();
        velocities.impulses.contacts.extend(held.iter().map(start_force));
        velocities.row_impulses.clone_from(&positions.row_impulses);
        velocities.solve(end, gains, row_gains, tolerance, 0.0);
    }
}

/// Gap up to which points are searched for at the end of a step, m.
fn margin(pair: &ReachablePair, bodies: &[Body]) -> f64 {
    let smaller = pair.ends.map(|end| bodies[end as usize].radius);
    1e-2 * smaller[0].min(smaller[1])
}

/// Writes the poses to the bodies.
pub(super) fn place(bodies: &mut [Body], states: &[MemberState]) {
    for (body, state) in bodies.iter_mut().zip(states) {
        body.position = state.position;
        body.rotation = state.rotation;
    }
}

/// J M⁻¹ Jᵀ of one row.
fn mobility(row: &RowPair<f64>, [a, b]: &[InverseMass; 2]) -> f64 {
    row.dot(&a.of(&row.of_a()), &b.of(&row.of_b()))
}

/// The rows that are no springs, with their indices.
fn rigid(rows: &[JointRow<f64>]) -> impl Iterator<Item = (usize, &JointRow<f64>)> {
    rows.iter().enumerate().filter(|(_, row)| row.spring.is_none())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whether forecasts with these errors of points, m, end with each.
    fn ends(errors: &[f64], has_rows: bool) -> Vec<bool> {
        let mut progress = Progress::NONE;
        let mut ends_with = |error: &f64| {
            progress.note(*error, has_rows, 0.0);
            progress.has_stalled()
        };
        errors.iter().map(&mut ends_with).collect()
    }

    #[test]
    fn a_forecast_that_throws_bodies_away_is_told_whatever_it_meets() {
        let thrown = |errors: &[f64], meets: bool| -> Vec<bool> {
            let mut progress = Progress::NONE;
            let mut throws = |error: &f64| {
                let is_thrown = progress.is_thrown(*error);
                progress.note(if meets { f64::INFINITY } else { *error }, false, 0.0);
                is_thrown
            };
            errors.iter().map(&mut throws).collect()
        };
        for meets in [false, true] {
            assert_eq!(thrown(&[1e-3, 1e-2, 2.4], meets), [false, false, true]);
            assert_eq!(thrown(&[2.0, 1e-13, 5e-4, 0.1], meets), [false, false, false, true]);
        }
    }

    #[test]
    fn forecasts_end_where_they_flicker_but_not_while_they_get_better_or_rows_are_wrong() {
        let falls: Vec<f64> = (4..16).map(|power| 10_f64.powi(-power)).collect();
        assert_eq!(ends(&falls, true), vec![false; falls.len()]);
        let flickers = [1e-5, 4e-7, 6e-7, 5e-7];
        assert_eq!(ends(&flickers, true), [false, false, false, true]);
        assert_eq!(ends(&flickers, false), [false; 4]);
        assert_eq!(ends(&[1e-5, 5e-10, 4e-10], false), [false, false, true]);
        assert_eq!(ends(&[1e-5, 4e-7, f64::INFINITY, 6e-7, 5e-7], true), [false; 5], "points were met");
    }
}
