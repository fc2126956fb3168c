//! The rows of a mechanism whose λ is bounded: which of them hold from a time on, and what happens when that changes.
//!
//! Between events each row has one mode ([`RowMode`]). At an event, and at the start of a step,
//! 1. limits that are overshot are put back ([`JointProjection`]);
//! 2. limits that touch and come nearer bounce, the fastest first, each as if it were alone with what does not bounce
//!    (Newton's law); in the end all that still come nearer are stopped;
//! 3. of limits that rest and of boxed rows whose speed is zero, the accelerations tell which hold ([`ActiveSet`]).
//!
//! In between, [`BoundedRows::read`] tells how far each row is from the end of its mode: a limit from its stop, one that
//! holds from pulling, a boxed row that holds from its bounds, one at a bound from the speed that it wants.

use super::active_set::ActiveSet;
use super::constants::{
    IMPACTS_OF_A_PAIR, LEAST_BOUNCE, MOST_PUT_BACK, RESTING_SPEED, STOPPED_OVERLAP, STOPPED_SPEED, TOUCHING,
};
use super::mechanism::{Mechanism, place_rows};
use super::projection::JointProjection;
use super::row_mode::{RowLaw, RowMode};
use crate::physics::constraint::row::Wrench;
use crate::physics::contact::rebound;
use crate::physics::joint::{Bound, JointRow};

/// How far a row is from the end of its mode, at one time.
#[derive(Clone, Copy, Debug)]
pub(super) struct ModeReading {
    pub row: usize,
    /// m, m/s or N, or of rotations; negative: beyond it.
    pub value: f64,
    /// How far beyond counts as not.
    pub tolerance: f64,
    /// Change of it with time, of limits that are open.
    pub rate: Option<f64>,
}

impl ModeReading {
    /// Whether it is beyond the end.
    pub fn is_over(&self) -> bool {
        self.value < -self.tolerance
    }

    /// Whether it has come to the end.
    pub fn is_at_end(&self) -> bool {
        self.value <= self.tolerance && self.rate.is_none_or(|rate| rate <= 0.0)
    }
}

/// What the impacts at one time may be.
#[derive(Clone, Copy, Debug)]
pub(super) struct ImpactTerms {
    /// Approach up to which nothing bounces, m/s or rad/s.
    pub least: f64,
    pub may_bounce: bool,
    /// Whether limits that are slow may be knocked off by the impact of others.
    pub may_leave: bool,
}

/// What was done at an event.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct EventOutcome {
    /// Whether velocities, poses or modes are others than before.
    pub changed: bool,
    /// Solves that did not come to an end.
    pub unsettled: u32,
    /// Evaluations of all rows.
    pub solves: u32,
}

/// The laws of all rows, their speeds, and the buffers.
#[derive(Clone, Debug, Default)]
pub(super) struct BoundedRows {
    set: ActiveSet,
    laws: Vec<RowLaw>,
    /// Ċ.
    rates: Vec<f64>,
    pulls: Vec<f64>,
    wrenches: Vec<Wrench<f64>>,
    before: Vec<RowMode>,
}

impl BoundedRows {
    /// Whether some row has a bounded λ at the mechanism's states and that time, s.
    pub fn are_there(&mut self, mechanism: &Mechanism, time: f64) -> bool {
        if !mechanism.links.iter().any(|link| link.may_be_bounded) {
            return false;
        }
        place_rows(&mechanism.links, &mechanism.states, time, &mut self.set.rows);
        self.set.rows.iter().any(|row| matches!(row.bound, Bound::Within(..)))
    }

    /// Rows, laws and speeds at the mechanism's states.
    fn place(&mut self, mechanism: &mut Mechanism, time: f64) {
        let Self { set, laws, rates, .. } = self;
        place_rows(&mechanism.links, &mechanism.states, time, &mut set.rows);
        laws.clear();
        laws.extend(set.rows.iter().map(RowLaw::of));
        rates.clear();
        for link in &mechanism.links {
            rates.extend(link.rates(&set.rows, &mechanism.states));
        }
        let known = mechanism.modes.len() == laws.len();
        mechanism.modes.resize(laws.len(), RowMode::Rigid);
        for (mode, law) in mechanism.modes.iter_mut().zip(&*laws) {
            if !known || (*law == RowLaw::Unbounded) != (*mode == RowMode::Rigid) {
                *mode = law.open();
            }
        }
    }

    /// The limits, with the side that each is on.
    fn limits(&self) -> impl Iterator<Item = (usize, f64)> + '_ {
        self.laws.iter().enumerate().filter_map(|(row, law)| match law {
            RowLaw::Limit(side) => Some((row, *side)),
            _ => None,
        })
    }

    fn touches(&self, row: usize, side: f64) -> bool {
        self.set.rows[row].error * side <= TOUCHING
    }

    /// Takes a mechanism over the events of that time, s. `note` is told the impulse on B and its moment about B's
    /// anchor of each link.
    pub fn pass(
        &mut self,
        mechanism: &mut Mechanism,
        projection: &mut JointProjection,
        time: f64,
        terms: &ImpactTerms,
        mut note: impl FnMut(usize, Wrench<f64>),
    ) -> EventOutcome {
        let mut outcome = EventOutcome::default();
        self.place(mechanism, time);
        self.before.clone_from(&mechanism.modes);
        outcome.solves += self.put_placed_back(mechanism, projection, time);
        outcome.changed |= outcome.solves > 0;
        self.pass_impacts(mechanism, time, terms, &mut outcome, &mut note);
        self.find_modes(mechanism, &mut outcome);
        outcome.changed |= mechanism.modes != self.before;
        outcome
    }

    /// Puts limits that are overshot back to their stops. How many projections that took.
    pub fn put_back(&mut self, mechanism: &mut Mechanism, projection: &mut JointProjection, time: f64) -> u32 {
        self.place(mechanism, time);
        self.put_placed_back(mechanism, projection, time)
    }

    /// The same with the rows of [`Self::place`].
    fn put_placed_back(&mut self, mechanism: &mut Mechanism, projection: &mut JointProjection, time: f64) -> u32 {
        for count in 0..MOST_PUT_BACK {
            let is_over = |&(row, side): &(usize, f64)| self.set.rows[row].error * side < -STOPPED_OVERLAP;
            let overshot: Vec<usize> = self.limits().filter(is_over).map(|(row, _)| row).collect();
            if overshot.is_empty() {
                return count;
            }
            overshot.into_iter().for_each(|row| mechanism.modes[row] = RowMode::Held);
            projection.assemble(mechanism, time);
            projection.project_positions(mechanism, time);
            self.place(mechanism, time);
        }
        MOST_PUT_BACK
    }

    /// The approach of a limit that touches, m/s or rad/s.
    fn approach(&self, row: usize, side: f64) -> f64 {
        if self.touches(row, side) { -side * self.rates[row] } else { f64::NEG_INFINITY }
    }

    fn pass_impacts(
        &mut self,
        mechanism: &mut Mechanism,
        time: f64,
        terms: &ImpactTerms,
        outcome: &mut EventOutcome,
        note: &mut impl FnMut(usize, Wrench<f64>),
    ) {
        let most = if terms.may_bounce { IMPACTS_OF_A_PAIR * mechanism.rows() } else { 0 };
        for _ in 0..most {
            let bouncing = self.limits().filter(|&(row, _)| self.set.rows[row].restitution > 0.0);
            let approaches = bouncing.map(|(row, side)| (row, self.approach(row, side)));
            let first = approaches.filter(|(_, speed)| *speed > terms.least).max_by(|a, b| a.1.total_cmp(&b.1));
            let Some((first, _)) = first else { break };
            self.impact(mechanism, Some(first), true, outcome, note);
            self.place(mechanism, time);
        }
        let comes = self.limits().any(|(row, side)| self.approach(row, side) > STOPPED_SPEED);
        if comes || self.is_pushed_over() || self.parts() {
            self.impact(mechanism, None, terms.may_leave, outcome, note);
            self.place(mechanism, time);
        }
    }

    /// Whether a rigid row has a speed: its joint holds what moved freely until now.
    fn parts(&self) -> bool {
        let mut rows = self.laws.iter().zip(&self.set.rows).zip(&self.rates);
        rows.any(|((law, row), rate)| *law == RowLaw::Unbounded && row.spring.is_none() && rate.abs() > RESTING_SPEED)
    }

    /// Whether a boxed row has a speed that an unbounded force would not let it have.
    fn is_pushed_over(&self) -> bool {
        self.laws.iter().enumerate().any(|(row, law)| {
            let (lower, upper) = law.impulses(&self.set.rows[row]);
            let speed = law.speed(self.set.rows[row].error, self.rates[row]);
            matches!(law, RowLaw::Boxed(..))
                && (upper > 0.0 && speed < -STOPPED_SPEED || lower < 0.0 && speed > STOPPED_SPEED)
        })
    }

    /// One impact: of that limit, or of all that touch, which are stopped then. Where they may not leave, those that are
    /// slow are stopped both ways.
    fn impact(
        &mut self,
        mechanism: &mut Mechanism,
        first: Option<usize>,
        may_leave: bool,
        outcome: &mut EventOutcome,
        note: &mut impl FnMut(usize, Wrench<f64>),
    ) {
        self.begin_problem(|law, row| law.impulses(row));
        for row in 0..self.laws.len() {
            let (law, told) = (self.laws[row], &self.set.rows[row]);
            let mut free = law.speed(told.error, self.rates[row]);
            let mut mode = law.open();
            if let RowLaw::Limit(side) = law {
                let has_part = match first {
                    Some(first) => row == first || told.restitution == 0.0,
                    None => true,
                };
                if !may_leave && self.touches(row, side) && free.abs() <= LEAST_BOUNCE {
                    self.set.bounds[row] = (f64::NEG_INFINITY, f64::INFINITY);
                    mode = RowMode::Held;
                } else if has_part && self.touches(row, side) {
                    if free * side < 0.0 {
                        mode = RowMode::Held;
                    }
                    if first == Some(row) {
                        free -= side * rebound(told.restitution, -side * free, 0.0);
                    }
                    self.set.candidates.push(row);
                } else {
                    self.set.bounds[row] = (0.0, 0.0);
                }
            } else if matches!(law, RowLaw::Boxed(..)) {
                self.set.candidates.push(row);
            }
            self.set.free.push(free);
            self.set.modes.push(mode);
        }
        outcome.unsettled += u32::from(!self.set.find(mechanism));
        outcome.solves += 1;
        outcome.changed = true;
        self.set.push(mechanism);
        for (index, link) in mechanism.links.iter().enumerate() {
            note(index, link.load(&link.arm_b(&mechanism.states), &self.set.rows, &self.set.lambda));
        }
    }

    /// Empties the problem, and sets what λ may be.
    fn begin_problem(&mut self, bounds: impl Fn(RowLaw, &JointRow<f64>) -> (f64, f64)) {
        let ActiveSet { rows, bounds: all, free, modes, candidates, .. } = &mut self.set;
        all.clear();
        all.extend(self.laws.iter().zip(rows).map(|(law, row)| bounds(*law, row)));
        free.clear();
        modes.clear();
        candidates.clear();
    }

    /// The modes from here on.
    fn find_modes(&mut self, mechanism: &mut Mechanism, outcome: &mut EventOutcome) {
        self.begin_problem(RowLaw::forces);
        for (row, (law, mode)) in self.laws.iter().zip(&mut mechanism.modes).enumerate() {
            let told = &self.set.rows[row];
            let speed = law.speed(told.error, self.rates[row]);
            let is_candidate = match law {
                RowLaw::Unbounded => false,
                RowLaw::Limit(side) => self.set.rows[row].error * side <= TOUCHING && speed.abs() <= RESTING_SPEED,
                RowLaw::Boxed(lower, upper) => lower < upper && speed.abs() <= RESTING_SPEED,
            };
            if is_candidate {
                self.set.candidates.push(row);
                continue;
            }
            *mode = match law {
                RowLaw::Boxed(lower, upper) if lower == upper || speed > 0.0 => RowMode::Lower,
                RowLaw::Boxed(..) => RowMode::Upper,
                _ => law.open(),
            };
        }
        if self.set.candidates.is_empty() {
            return;
        }
        self.set.modes.clone_from(&mechanism.modes);
        self.set.assemble(mechanism);
        self.find_accelerations(mechanism);
        outcome.unsettled += u32::from(!self.set.find(mechanism));
        outcome.solves += 1;
        mechanism.modes.clone_from(&self.set.modes);
    }

    /// C̈ without joints, springs included, and Ċ/τ of boxed rows.
    fn find_accelerations(&mut self, mechanism: &Mechanism) {
        let Self { set, laws, rates, pulls, wrenches, .. } = self;
        set.system.free_accelerations(mechanism, &mechanism.states, &set.rows, pulls, wrenches);
        set.free.clear();
        for link in &mechanism.links {
            let [a, b] = link.ends().map(|member| &wrenches[member as usize]);
            for row in link.rows.clone() {
                let told = &set.rows[row];
                set.free.push(laws[row].speed(rates[row], told.jacobian.dot(a, b) + told.velocity_term));
            }
        }
    }

    /// How far rows are from the ends of their modes at the mechanism's states and that time, s.
    pub fn read(&mut self, mechanism: &mut Mechanism, time: f64, readings: &mut Vec<ModeReading>) {
        self.place(mechanism, time);
        let holds = |(law, mode): (&RowLaw, &RowMode)| *law != RowLaw::Unbounded && *mode == RowMode::Held;
        let some_hold = self.laws.iter().zip(&mechanism.modes).any(holds);
        self.begin_problem(RowLaw::forces);
        self.set.modes.clone_from(&mechanism.modes);
        if some_hold {
            self.set.assemble(mechanism);
            self.find_accelerations(mechanism);
            self.set.solve(mechanism);
        }
        readings.clear();
        for (row, (law, mode)) in self.laws.iter().zip(&mechanism.modes).enumerate() {
            let told = &self.set.rows[row];
            let speed = law.speed(told.error, self.rates[row]);
            let (value, tolerance, rate) = match (law, mode) {
                (RowLaw::Unbounded, _) => continue,
                (RowLaw::Boxed(lower, upper), _) if lower == upper => (f64::INFINITY, 0.0, None),
                (RowLaw::Limit(side), RowMode::Held) => (self.set.lambda[row] * side, self.set.tolerance(row), None),
                (RowLaw::Limit(side), _) => (told.error * side, STOPPED_OVERLAP, Some(speed * side)),
                (RowLaw::Boxed(..), RowMode::Lower) => (speed, STOPPED_SPEED, None),
                (RowLaw::Boxed(..), RowMode::Upper) => (-speed, STOPPED_SPEED, None),
                (RowLaw::Boxed(lower, upper), _) => {
                    let lambda = self.set.lambda[row];
                    ((lambda - lower).min(upper - lambda), self.set.tolerance(row), None)
                }
            };
            readings.push(ModeReading { row, value, tolerance, rate });
        }
    }

    /// Ends the mode of a row that [`Self::read`] was told of last.
    pub fn end_mode(&self, mechanism: &mut Mechanism, row: usize) {
        let mode = &mut mechanism.modes[row];
        *mode = match (self.laws[row], *mode) {
            (law @ RowLaw::Limit(_), RowMode::Held) => law.open(),
            (RowLaw::Boxed(lower, upper), RowMode::Held) => {
                let lambda = self.set.lambda[row];
                if lambda - lower < upper - lambda { RowMode::Lower } else { RowMode::Upper }
            }
            (RowLaw::Unbounded, mode) => mode,
            _ => RowMode::Held,
        };
    }
}
