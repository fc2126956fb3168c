//! The clock and the judge of one solver on one problem.

use std::time::{Duration, Instant};

use plumb::physics::ContactProblem;

use crate::natural_map::{Impulses, residual};

/// Residuals, m/s, whose times are told.
pub const WANTED: [f64; 3] = [1e-4, 1e-8, 1e-10];

/// Measures a solver by the residual of what it has, with the clock stopped.
pub struct Watch<'a> {
    problem: &'a ContactProblem,
    limit: Duration,
    running: Instant,
    spent: Duration,
    iterations: u64,
    next: u64,
    reached: [Option<f64>; WANTED.len()],
    /// The least residual seen, m/s.
    least: f64,
}

/// What a watch saw.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// Time to each of [`WANTED`], s, where it was met within the limit.
    pub times: [Option<f64>; WANTED.len()],
    /// The least residual, m/s.
    pub least: f64,
}

impl<'a> Watch<'a> {
    /// Starts the clock.
    pub fn start(problem: &'a ContactProblem, limit: Duration) -> Self {
        let reached = [None; WANTED.len()];
        Self {
            problem,
            limit,
            running: Instant::now(),
            spent: Duration::ZERO,
            iterations: 0,
            next: 0,
            reached,
            least: f64::INFINITY,
        }
    }

    /// Counts an iteration. It looks at what there is after each of the first 16, then ever more rarely: a time is at most a
    /// sixteenth too long. False once the last of [`WANTED`] is met, or time is up.
    pub fn goes_on(&mut self, impulses: impl FnOnce() -> Impulses) -> bool {
        let iteration = self.iterations;
        self.iterations += 1;
        let is_over = self.running.elapsed() + self.spent > self.limit;
        if iteration < self.next && !is_over {
            return true;
        }
        self.next = iteration + 1 + iteration / 16;
        self.look(&impulses());
        !is_over && self.reached.iter().any(Option::is_none)
    }

    /// Notes which of [`WANTED`] those impulses meet.
    pub fn look(&mut self, impulses: &Impulses) {
        self.spent += self.running.elapsed();
        if self.spent <= self.limit {
            let residual = residual(self.problem, impulses);
            self.least = self.least.min(residual);
            for (reached, wanted) in self.reached.iter_mut().zip(WANTED) {
                if reached.is_none() && residual <= wanted {
                    *reached = Some(self.spent.as_secs_f64());
                }
            }
        }
        self.running = Instant::now();
    }

    /// What it saw.
    pub fn seen(&self) -> Seen {
        Seen { times: self.reached, least: self.least }
    }
}
