//! How the solves of a step came to their ends, sweep by sweep: for whoever wants to see it.

use bevy::prelude::*;

/// Residuals of the last step's solves, the largest of all islands. Filled in while present.
///
/// Of sweeps (over forces, and of impulses) it is the largest change that the sweep made to the velocity of a point of a
/// body, m/s: |Δv| + R |Δω|, R the bounding radius. Of `exact` it is how far contacts, and joints beside them, are from
/// their laws (the natural map), m/s. What is solved directly has none.
#[derive(Resource, Reflect, Clone, Debug, Default, PartialEq)]
#[reflect(Resource, Debug, Default, PartialEq)]
pub struct SolveTrace {
    /// Which step of the world it is of; 0: of none yet.
    pub step: u64,
    /// What was measured.
    pub residuals: Residuals,
}

/// The residual after each sweep or iteration of each solve.
#[derive(Reflect, Clone, Debug, Default, PartialEq)]
#[reflect(Debug, Default, PartialEq)]
pub struct Residuals {
    /// Solve by solve.
    pub solves: Vec<Vec<f64>>,
    /// Numbers in all of them.
    count: usize,
}

impl SolveTrace {
    /// Forgets the step before.
    pub(crate) fn begin_step(&mut self, step: u64) {
        self.step = step;
        self.residuals.clear();
    }
}

impl Residuals {
    /// Numbers kept of a step: what is beyond is not noted.
    const MOST: usize = 4096;

    pub(crate) fn clear(&mut self) {
        self.solves.clear();
        self.count = 0;
    }

    /// Another solve begins.
    pub(crate) fn begin_solve(&mut self) {
        if self.count < Self::MOST {
            self.solves.push(Vec::new());
        }
    }

    /// The residual after another sweep of the last solve.
    pub(crate) fn note(&mut self, residual: f64) {
        if let Some(solve) = self.solves.last_mut().filter(|_| self.count < Self::MOST) {
            solve.push(residual);
            self.count += 1;
        }
    }

    /// Adds the solves of another, after its own.
    pub(crate) fn append(&mut self, other: &Self) {
        for solve in &other.solves {
            self.begin_solve();
            solve.iter().for_each(|residual| self.note(*residual));
        }
    }

    /// Solves side by side with those of another: the larger residual of each sweep.
    pub(crate) fn take_in(&mut self, other: &Self) {
        if self.solves.len() < other.solves.len() {
            self.solves.resize_with(other.solves.len(), Vec::new);
        }
        for (own, other) in self.solves.iter_mut().zip(&other.solves) {
            for (own, other) in own.iter_mut().zip(other) {
                *own = own.max(*other);
            }
            if let Some(more) = other.get(own.len()..) {
                own.extend_from_slice(more);
            }
        }
        self.count = self.solves.iter().map(Vec::len).sum();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(solves: &[&[f64]]) -> Residuals {
        let mut residuals = Residuals::default();
        for solve in solves {
            residuals.begin_solve();
            solve.iter().for_each(|residual| residuals.note(*residual));
        }
        residuals
    }

    #[test]
    fn of_islands_side_by_side_the_larger_residual_is_kept() {
        let mut all = of(&[&[3.0, 1.0], &[2.0]]);
        all.take_in(&of(&[&[1.0, 2.0, 0.5], &[], &[7.0]]));
        assert_eq!(all, of(&[&[3.0, 2.0, 0.5], &[2.0], &[7.0]]));
    }

    #[test]
    fn a_step_of_very_many_sweeps_takes_bounded_memory() {
        let mut residuals = Residuals::default();
        for _ in 0..3 * Residuals::MOST {
            residuals.begin_solve();
            residuals.note(1.0);
        }
        assert_eq!(residuals.solves.len(), Residuals::MOST);
    }
}
