//! A mechanism some of whose rows have a bounded λ through one step, from event to event.
//!
//! Between events the [`Stepper`]'s integrators take it along with the rows that hold ([`RowMode`](super::row_mode)).
//! Where a row comes to the end of its mode within that time ([`BoundedRows::read`] at its end says so), the time is
//! shortened until it is there, by Illinois' rule on the length, each trial from the state at the start. Then the event
//! passes ([`BoundedRows::pass`]), and the rest of the step follows. A limit that is left and reached again within the
//! time is seen by the cubic through its C and Ċ at both ends: the time is cut at its least value.
//!
//! Limits may knock each other off in turn, at speeds that fall by a little each time and in times that are nothing: after
//! [`MOST_CHATTERS`] such motions in a row those that touch and are slow stay together, until forces part them.
//!
//! A time for which the iterations do not converge is halved, as in the [`Stepper`]; so many events or evaluations in a
//! step are the end of it: the rest goes by Euler's steps, where nothing bounces, and is reported.

use super::bounded_rows::{BoundedRows, ImpactTerms, ModeReading};
use super::constants::{
    CHATTER_TIME, CONVERGED_BEFORE_LONGER, EULER_DIVISIONS, LEAST_BOUNCE, MOST_CHATTERS, MOST_DIVISIONS,
    MOST_EVENT_EVALUATIONS, MOST_EVENTS, MOST_TRIALS, NO_TIME, PARTED, SHORTEST_EVENT,
};
use super::event_search::EventSearch;
use super::mechanism::{Mechanism, MemberState};
use super::stepper::{StepEffort, Stepper};
use crate::physics::constraint::row::Wrench;
use crate::physics::settings::ExactIntegrator;

/// What the steps are to be like.
#[derive(Clone, Copy, Debug)]
pub(super) struct EventTerms {
    pub integrator: ExactIntegrator,
    /// At the start, s.
    pub time: f64,
    /// Length of a substep, s.
    pub h: f64,
    pub substeps: u32,
    /// Approach up to which no limit bounces, m/s or rad/s.
    pub restitution_speed: f64,
    /// Whether somebody reads what joints carry.
    pub reads_loads: bool,
}

/// A stepper, with what events need.
#[derive(Clone, Debug, Default)]
pub(crate) struct EventStepper {
    stepper: Stepper,
    bounded: BoundedRows,
    /// The state that trials start from.
    start: Vec<MemberState>,
    /// At the start and at the end of a trial.
    first: Vec<ModeReading>,
    last: Vec<ModeReading>,
    /// Each link's load at the end of the step; none where nobody reads it, or only the mean can be told.
    loads_at_end: Vec<Wrench<f64>>,
    /// Whether a limit gave an impulse at once in the step.
    has_hit: bool,
    /// Error of joints that the last trial left, m or rad.
    left: f64,
    /// Times are 2 to this power shorter than substeps.
    divisions: u32,
    /// Times in a row that converged.
    converged: u32,
}

/// A substep on its way.
#[derive(Debug)]
struct Progress<'a> {
    terms: &'a EventTerms,
    /// Of the substep at hand, s.
    start: f64,
    /// s.
    left: f64,
    events: u32,
    /// Smooth motions in a row that were too short for anything to fly.
    chatters: u32,
    effort: StepEffort,
}

impl Progress<'_> {
    fn now(&self) -> f64 {
        self.start + (self.terms.h - self.left)
    }

    fn note_motion(&mut self, length: f64) {
        self.chatters = if length < CHATTER_TIME * self.terms.h { self.chatters + 1 } else { 0 };
    }
}

impl EventStepper {
    /// Forgets the steps before: the mechanism was moved by somebody else.
    pub fn forget(&mut self) {
        self.stepper.forget();
        (self.divisions, self.converged) = (0, 0);
    }

    /// All that the next step depends on beside the mechanism.
    pub fn memory(&self) -> impl Iterator<Item = f64> + '_ {
        let own = [f64::from(self.divisions), f64::from(self.converged)];
        self.stepper.memory().chain(own.into_iter().filter(|number| *number != 0.0))
    }

    /// Mean of each link's load over the step, force on B and torque about B's anchor; and that at its end where somebody
    /// reads it, but of a step with an impact or with parts that did not converge.
    pub fn loads(&self) -> impl Iterator<Item = (&Wrench<f64>, Option<Wrench<f64>>)> {
        self.stepper.loads.iter().enumerate().map(|(link, mean)| (mean, self.loads_at_end.get(link).copied()))
    }

    /// Takes the mechanism through a step.
    pub fn advance(&mut self, mechanism: &mut Mechanism, terms: &EventTerms) -> StepEffort {
        self.has_hit = false;
        let effort = self.advance_smoothly(mechanism, terms);
        self.loads_at_end.clear();
        if terms.reads_loads && !self.has_hit && effort.unsettled == 0 {
            let end = terms.time + terms.h * f64::from(terms.substeps);
            self.stepper.find_loads(mechanism, end, &mut self.loads_at_end);
        }
        effort
    }

    /// The same, with the mean of each link's load.
    fn advance_smoothly(&mut self, mechanism: &mut Mechanism, terms: &EventTerms) -> StepEffort {
        let EventTerms { integrator, time, h, substeps, .. } = *terms;
        if !self.bounded.are_there(mechanism, time) {
            mechanism.modes.clear();
            return self.stepper.advance(mechanism, integrator, time, h, substeps);
        }
        self.stepper.loads.clear();
        self.stepper.loads.resize(mechanism.links.len(), Wrench::zero());
        let mut progress =
            Progress { terms, start: time, left: h, events: 0, chatters: 0, effort: StepEffort::default() };
        for substep in 0..substeps {
            (progress.start, progress.left) = (time + h * f64::from(substep), h);
            self.advance_substep(mechanism, &mut progress);
        }
        progress.effort
    }

    fn advance_substep(&mut self, mechanism: &mut Mechanism, progress: &mut Progress) {
        let h = progress.terms.h;
        (progress.events, progress.chatters, progress.left) = (0, 0, h);
        let mut pieces = 0;
        while progress.left > NO_TIME * h {
            let is_spent = self.is_spent(mechanism, progress);
            self.pass_event(mechanism, progress, !is_spent);
            let length = if is_spent { None } else { self.step_to_event(mechanism, progress) };
            let length = length.unwrap_or_else(|| self.euler_step(mechanism, progress));
            progress.left -= length;
            pieces += 1;
        }
        progress.effort.cuts += pieces - 1;
    }

    fn is_spent(&self, mechanism: &Mechanism, progress: &Progress) -> bool {
        progress.events >= MOST_EVENTS || progress.effort.is_spent(mechanism.links.len(), MOST_EVENT_EVALUATIONS)
    }

    fn pass_event(&mut self, mechanism: &mut Mechanism, progress: &mut Progress, may_bounce: bool) {
        let Self { stepper: Stepper { projection, loads, .. }, bounded, has_hit, .. } = self;
        let EventTerms { h, substeps, restitution_speed, .. } = *progress.terms;
        let step = h * f64::from(substeps);
        let terms = ImpactTerms {
            least: restitution_speed.max(LEAST_BOUNCE),
            may_bounce,
            may_leave: progress.chatters < MOST_CHATTERS,
        };
        let outcome = bounded.pass(mechanism, projection, progress.now(), &terms, |link, impulse| {
            loads[link] = loads[link].plus(&impulse, 1.0 / step);
            *has_hit |= impulse != Wrench::zero();
        });
        if outcome.changed {
            self.stepper.forget_history();
        }
        progress.effort.solves += outcome.solves;
        progress.effort.unsettled += outcome.unsettled;
    }

    /// One smooth motion: over the time left, as far as iterations converge, or until an event. Its length, s; none
    /// where the shortest does not converge.
    fn step_to_event(&mut self, mechanism: &mut Mechanism, progress: &mut Progress) -> Option<f64> {
        self.start.clone_from(&mechanism.states);
        self.bounded.read(mechanism, progress.now(), &mut self.first);
        let length = loop {
            let longest = self.longest(progress)?;
            if let Some(length) = self.try_to_event(mechanism, progress, longest) {
                break length;
            }
            mechanism.states.clone_from(&self.start);
            self.divisions += 1;
            self.converged = 0;
        };
        self.converged += 1;
        if self.converged >= CONVERGED_BEFORE_LONGER && self.divisions > 0 {
            (self.divisions, self.converged) = (self.divisions - 1, 0);
        }
        let share = length / (progress.terms.h * f64::from(progress.terms.substeps));
        for link in 0..mechanism.links.len() {
            let load = self.stepper.load(mechanism, progress.terms.integrator, link, length);
            self.stepper.loads[link] = self.stepper.loads[link].plus(&load, share);
        }
        progress.effort.unsettled += u32::from(self.left > PARTED);
        progress.note_motion(length);
        Some(length)
    }

    /// A smooth motion of that length, s, or until the first event within it. Its length; none where a trial does not
    /// converge.
    fn try_to_event(&mut self, mechanism: &mut Mechanism, progress: &mut Progress, longest: f64) -> Option<f64> {
        let mut length = longest;
        if !self.run(mechanism, progress, length) {
            return None;
        }
        if let Some(dip) = self.dip(length) {
            self.retry(mechanism, progress, dip)?;
            length = dip;
        }
        if self.last.iter().any(ModeReading::is_over) {
            length = self.find_event(mechanism, progress, length)?;
            progress.events += 1;
        }
        Some(length)
    }

    /// A step of Euler's where nothing else is to be had. Its length, s.
    fn euler_step(&mut self, mechanism: &mut Mechanism, progress: &mut Progress) -> f64 {
        let EventTerms { h, substeps, .. } = *progress.terms;
        let (now, length) = (progress.now(), progress.left.min(h / f64::from(1_u32 << EULER_DIVISIONS)));
        self.stepper.euler_step(mechanism, now, length, h * f64::from(substeps));
        let left = self.stepper.projection.project(mechanism, now + length);
        progress.effort.solves += self.bounded.put_back(mechanism, &mut self.stepper.projection, now + length);
        progress.effort.unsettled += 1 + u32::from(left > PARTED);
        (self.divisions, self.converged) = (EULER_DIVISIONS, 0);
        length
    }

    /// How long the next smooth motion may be, s; none where that is no more to be had.
    fn longest(&self, progress: &Progress) -> Option<f64> {
        let share = 1.0 / f64::from(1_u32 << self.divisions.min(MOST_DIVISIONS));
        (self.divisions <= MOST_DIVISIONS).then(|| progress.left.min(progress.terms.h * share))
    }

    /// Takes the mechanism along for so long, s, and reads its modes. Whether that converged.
    fn run(&mut self, mechanism: &mut Mechanism, progress: &mut Progress, length: f64) -> bool {
        let (now, integrator) = (progress.now(), progress.terms.integrator);
        let iterations = self.stepper.step(mechanism, integrator, now, length);
        progress.effort.solves += iterations.count;
        if iterations.converged {
            self.left = self.stepper.projection.project(mechanism, now + length);
            self.bounded.read(mechanism, now + length, &mut self.last);
            progress.effort.solves += 1;
        }
        iterations.converged
    }

    /// The same again from the start, for another time. None where it does not converge.
    fn retry(&mut self, mechanism: &mut Mechanism, progress: &mut Progress, length: f64) -> Option<()> {
        mechanism.states.clone_from(&self.start);
        self.stepper.rewind();
        self.run(mechanism, progress, length).then_some(())
    }

    /// The time until a limit is nearest that comes and goes within a time, s, if that overshoots it.
    fn dip(&self, length: f64) -> Option<f64> {
        let dips = self.first.iter().zip(&self.last).filter_map(|(first, last)| {
            let (start, end) = (first.rate?, last.rate?);
            if start >= 0.0 || end <= 0.0 || last.is_over() {
                return None;
            }
            // g = g₀ + ġ₀ t + b t² + c t³ through both ends.
            let mean = (last.value - first.value) / length;
            let c = (start + end - 2.0 * mean) / (length * length);
            let b = (3.0 * mean - 2.0 * start - end) / length;
            let root = (b * b - 3.0 * c * start).max(0.0).sqrt();
            let time = -start / (b + root);
            let least = first.value + time * (start + time * (b + time * c));
            (least < -last.tolerance && time > 0.0 && time < length).then_some(time)
        });
        dips.min_by(f64::total_cmp)
    }

    /// The time until the first row comes to the end of its mode, s, where the last trial was of `length` and went beyond
    /// it. The mechanism is left there, with that mode ended. None where a trial does not converge.
    fn find_event(&mut self, mechanism: &mut Mechanism, progress: &mut Progress, length: f64) -> Option<f64> {
        let mut search = EventSearch::new(&self.first, length);
        search.note(&self.first, &self.last, length);
        for trial in 0..MOST_TRIALS {
            let Some(tried) = search.next(trial, SHORTEST_EVENT * progress.terms.h) else { break };
            self.retry(mechanism, progress, tried)?;
            if search.note(&self.first, &self.last, tried) {
                self.end_modes(mechanism, &search);
                return Some(tried);
            }
        }
        let high = search.high;
        self.retry(mechanism, progress, high)?;
        self.end_modes(mechanism, &search);
        Some(high)
    }

    /// Ends the modes whose end the last trial has come to.
    fn end_modes(&mut self, mechanism: &mut Mechanism, search: &EventSearch) {
        for (last, scale) in self.last.iter().zip(&search.scales) {
            if *scale > 0.0 && last.is_at_end() {
                self.bounded.end_mode(mechanism, last.row);
            }
        }
    }
}
