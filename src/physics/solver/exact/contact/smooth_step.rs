//! A step without impacts: RATTLE with contacts.
//!
//! v½ = v₀ + ½h M₀⁻¹F + M₀⁻¹J₀ᵀλ, q₁ = q₀ after free motion over h with v½, v₁ = v½ + ½h M₁⁻¹F + M₁⁻¹J₁ᵀμ.
//!
//! λ makes positions hold: joints are closed at q₁, gaps g(q₁) ≥ 0, with a normal impulse only where g(q₁) = 0. μ makes
//! velocities hold: J₁v₁ = 0, and where g(q₁) = 0 gaps do not close. Both are within the cone of friction, against the
//! slip of v½ and of v₁. A pair that neither bounces nor has landed is stopped where the surfaces meet. Both impulses are
//! the cone solver's problem: λ with a linear forecast ĝ of the gaps, whose error (g − ĝ)/h corrects the bias until the
//! forecast comes true.
//!
//! Limits of joints are gaps of their rows; rows whose λ is bounded both ways are brought to the speed that they want by
//! both impulses, each within half the step's bounds.
//!
//! Constant forces are followed exactly, sliding and rolling too; all else with an error of second order.

use nalgebra::Vector3;

use super::super::constants::{
    FORECAST_ERROR, FORECAST_SHARE, FORECAST_TOLERANCE, FORESEEN_SPEED, FORESEEN_SPEEDS, MOST_FORECASTS, SETTLED,
    STALLED_ERROR, TOUCHING, UNFORESEEN, UNSOLVED,
};
use super::super::mechanism::{InverseMass, MemberState, RowSpring, place_rows};
use super::super::row_mode::RowLaw;
use super::gap_points::{GapPoint, GapPoints, PointSearch, ReachablePair};
use super::group_solver::{GroupSolver, GroupView};
use super::joint_gaps::{is_apart, overlap};
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
    /// The points held by each: by positions first those at the start, in their order, then those met on the way.
    pub held: [Vec<GapPoint>; 2],
    /// How many of the former are those at the start.
    known: usize,
    /// The states at the end, and the points there.
    pub end: Vec<MemberState>,
    pub points: GapPoints,
    kicked: Vec<MemberState>,
    gains: Vec<f64>,
    row_gains: Vec<f64>,
    /// How fast gaps open and C of rows grows at the start, m/s: the linear part of the forecast.
    openings: Vec<f64>,
    rates: Vec<f64>,
    /// The limits that may close in the step, by row.
    foreseen: Vec<bool>,
    /// Whether the forecast came true.
    pub is_true: bool,
    kept: KeptForecast,
    /// Sliding points at the start that no rigid motion satisfies.
    pub jammed: u32,
    /// Rows of links with springs, at the pose of a kick.
    rows: Vec<JointRow<f64>>,
    /// Mean load of each link by its springs.
    pub spring_loads: Vec<Wrench<f64>>,
}

/// A forecast that came true, while a better one is tried.
#[derive(Clone, Default)]
struct KeptForecast {
    impulses: PerPoint,
    row_impulses: Vec<f64>,
    residual: f64,
    end: Vec<MemberState>,
    points: GapPoints,
}

impl KeptForecast {
    fn keep(&mut self, positions: &GroupSolver, end: &[MemberState], points: &GapPoints) {
        self.impulses.clone_from(&positions.impulses);
        self.row_impulses.clone_from(&positions.row_impulses);
        self.residual = positions.residual;
        end.clone_into(&mut self.end);
        self.points.clone_from(points);
    }

    fn give_back(&mut self, positions: &mut GroupSolver, end: &mut Vec<MemberState>, points: &mut GapPoints) {
        std::mem::swap(&mut self.impulses, &mut positions.impulses);
        std::mem::swap(&mut self.row_impulses, &mut positions.row_impulses);
        positions.residual = self.residual;
        std::mem::swap(&mut self.end, end);
        std::mem::swap(&mut self.points, points);
    }
}

impl SmoothTerms<'_> {
    /// What the impulse of a row may be in each half of the step, N·s; none of rows left free.
    fn bounds(&self, row: usize, law: RowLaw, told: &JointRow<f64>) -> Option<(f64, f64)> {
        let ((lower, upper), half) = (law.forces(told), 0.5 * self.h);
        (!self.free_rows[row]).then_some((lower * half, upper * half))
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
        self.kick(given, given.time);
        self.kicked.clone_from(&self.end);
        self.foresee_limits(given);
        let [held, _] = &mut self.held;
        held.clear();
        held.extend(start_points.list.iter().filter(|point| !given.free[point.pair as usize]).cloned());
        self.known = held.len();
        self.positions.set(given.view, &self.kicked, given.time, held.iter(), |row, law, told| {
            given.bounds(row, law, told).filter(|_| self.foreseen[row])
        });
        self.jammed = self.positions.jammed(held.iter().map(|point| (point, point.velocity(start))));
        self.positions.impulses.contacts.clear();
        self.positions.impulses.contacts.extend(held.iter().map(|point| start_force(point) * (0.5 * given.h)));
        self.positions.start_from(given.view, given.loads, 0.5 * given.h);
        self.hold_places(given, bodies, search);
        self.kick(given, given.time + given.h);
        self.hold_velocities(given);
        self.is_true &= self.velocities.residual * given.closing <= UNSOLVED;
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

    fn hold_places(&mut self, given: &SmoothTerms, bodies: &mut [Body], search: &mut PointSearch) {
        // An error that cannot be closed, as of a chain that is stretched too far, is left as it is.
        let is_open = self.held[0].iter().any(|point| point.gap < -STALLED_ERROR)
            || rigid(&self.positions.rows).any(|(row, told)| overlap(self.positions.laws[row], told) > STALLED_ERROR);
        self.is_true = self.forecast(given, bodies, search, 1.0)
            || is_open && !given.is_rough && self.forecast(given, bodies, search, 0.0);
    }

    /// Solves for positions until the forecast is what free motion makes of it. `closed` is the share of the errors at
    /// the start that is closed. Whether the forecast came true.
    fn forecast(&mut self, given: &SmoothTerms, bodies: &mut [Body], search: &mut PointSearch, closed: f64) -> bool {
        let h = given.h;
        let Self {
            positions,
            held: [held, _],
            known,
            end,
            points,
            kicked,
            gains,
            row_gains,
            openings,
            rates,
            rows,
            foreseen,
            kept,
            ..
        } = self;
        let first_gain = |point: &GapPoint| {
            if point.gap > 0.0 {
                point.gap / h
            } else {
                (point.gap * closed / given.closing).max(-given.correction_speed)
            }
        };
        gains.clear();
        gains.extend(held.iter().map(first_gain));
        row_gains.clear();
        row_gains
            .extend(positions.laws.iter().zip(&positions.rows).map(|(&law, row)| given.row_gain(law, row, closed)));
        // No solve need be better than its forecast: of points that are redundant, a forecast that is wrong makes points that
        // contradict each other, which only hundreds of iterations bring to the last digits.
        let (mut before, mut tolerance) = (f64::INFINITY, given.tolerance.max(FORECAST_TOLERANCE));
        let mut is_kept = false;
        for _ in 0..MOST_FORECASTS {
            end.clone_from(kicked);
            positions.solve(end, gains, row_gains, tolerance);
            if !positions.is_solved && positions.residual * h > UNSOLVED && !given.is_rough {
                return false;
            }
            openings.clear();
            openings.extend(held.iter().map(|point| point.opening(end)));
            rates.clear();
            given.view.links.iter().for_each(|link| rates.extend(link.rates(&positions.rows, end)));
            for (member, state) in given.view.members.iter().zip(&mut *end) {
                member.move_freely(state, h);
            }
            place(bodies, end);
            points.find(given.pairs, bodies, |pair| margin(pair, bodies), search);
            if positions.is_empty() && foreseen.iter().all(|is_foreseen| *is_foreseen) {
                return true;
            }
            let mut worst: f64 = 0.0;
            for (((point, gain), opening), impulse) in
                held.iter().zip(&mut *gains).zip(&*openings).zip(&positions.impulses.contacts)
            {
                let Some(found) = points.position(point.pair, point.feature) else { continue };
                let bent = points.list[found].gap - (point.gap + opening * h);
                let mended = first_gain(point) + bent / h;
                if *impulse != Vector3::zeros() || points.list[found].gap < -FORECAST_ERROR {
                    worst = worst.max((mended - *gain).abs() * h);
                    *gain = mended;
                }
            }
            // A contact that no forecast had is held from where it came from.
            let count = held.len();
            for point in &points.list {
                if point.gap < -UNFORESEEN && !given.free[point.pair as usize] && find(held, *known, point).is_none() {
                    // No deeper than the pair was, whatever the curvature of the way makes of it.
                    let gap = (point.gap - point.opening(end) * h).max(least_gap(&held[..*known], point.pair));
                    held.push(GapPoint { gap, ..point.clone() });
                }
            }
            place_rows(given.view.links, end, given.time + h, rows);
            let mut is_met = held.len() > count;
            for (row, told) in rows.iter().enumerate().filter(|(row, _)| !given.free_rows[*row]) {
                if !foreseen[row] && overlap(positions.laws[row], told) > UNFORESEEN {
                    (foreseen[row], is_met) = (true, true);
                }
            }
            if is_met {
                worst = f64::INFINITY;
                positions.set(given.view, kicked, given.time, held.iter(), |row, law, told| {
                    given.bounds(row, law, told).filter(|_| foreseen[row])
                });
                gains.extend(held[count..].iter().map(first_gain));
                positions.impulses.contacts.resize(held.len(), Vector3::zeros());
            }
            let mended = |row: usize, start: &JointRow<f64>| {
                let bent = rows[row].error - (start.error + rates[row] * h);
                given.row_gain(positions.laws[row], start, closed) + bent / h
            };
            let is_bent = |row: &usize| match positions.laws[*row] {
                RowLaw::Unbounded => true,
                RowLaw::Limit(side) if foreseen[*row] && !given.free_rows[*row] => {
                    positions.row_impulses[*row] != 0.0 || rows[*row].error * side < -FORECAST_ERROR
                }
                RowLaw::Limit(_) | RowLaw::Boxed(..) => false,
            };
            for (row, start) in rigid(&positions.rows).filter(|(row, _)| is_bent(row)) {
                let mended = mended(row, start);
                worst = worst.max((mended - row_gains[row]).abs() * h);
                row_gains[row] = mended;
            }
            let has_solved = positions.residual <= SETTLED;
            if worst <= FORECAST_ERROR && has_solved {
                return true;
            }
            if has_solved && worst < if is_kept { 0.5 * before } else { STALLED_ERROR } {
                // As good as it gets if the next is worse.
                kept.keep(positions, end, points);
                is_kept = true;
            } else if is_kept {
                break;
            }
            if worst.is_finite() && worst > 2.0 * before.max(STALLED_ERROR) || worst.is_nan() {
                return false;
            }
            tolerance = (FORECAST_SHARE * worst / h).clamp(given.tolerance, tolerance);
            before = if worst.is_finite() { before.min(worst) } else { f64::INFINITY };
            if given.is_rough || positions.is_spent() {
                break;
            }
        }
        if is_kept {
            kept.give_back(positions, end, points);
        }
        is_kept
    }

    fn hold_velocities(&mut self, given: &SmoothTerms) {
        let Self { velocities, positions, held: [before, held], known, end, points, gains, row_gains, .. } = self;
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
            find(before, *known, point).map_or_else(Vector3::zeros, |known| positions.impulses.contacts[known])
        };
        velocities.impulses.contacts.clear();
        velocities.impulses.contacts.extend(held.iter().map(start_force));
        velocities.row_impulses.clone_from(&positions.row_impulses);
        velocities.solve(end, gains, row_gains, given.tolerance);
    }
}

/// The index of the same features' point among those held: the first `known` are in the order of pairs.
fn find(held: &[GapPoint], known: usize, point: &GapPoint) -> Option<usize> {
    let (ordered, met) = held.split_at(known);
    let first = ordered.partition_point(|other| other.pair < point.pair);
    let own = ordered[first..].iter().take_while(|other| other.pair == point.pair);
    let is_same = |other: &GapPoint| other.pair == point.pair && other.feature == point.feature;
    let among_known = own.clone().position(is_same).map(|at| first + at);
    among_known.or_else(|| met.iter().position(is_same).map(|at| known + at))
}

/// The least gap of a pair's points among those in the order of pairs; 0 if none is less.
fn least_gap(ordered: &[GapPoint], pair: u32) -> f64 {
    let first = ordered.partition_point(|point| point.pair < pair);
    let own = ordered[first..].iter().take_while(|point| point.pair == pair);
    own.map(|point| point.gap).fold(0.0, f64::min)
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
