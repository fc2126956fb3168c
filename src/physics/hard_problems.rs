//! The contact problems of a run that were hardest to solve: for whoever wants to have them.

use bevy::prelude::*;

use super::ContactProblem;

/// A contact problem, and what the step made of it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct HardProblem {
    /// Which step of the world it is of.
    pub step: u64,
    /// Newton iterations of its solve.
    pub iterations: u32,
    /// The residual that was asked for, m/s: the natural map's at contacts, |u| at joints.
    pub tolerance: f64,
    /// The one that was reached, m/s.
    pub residual: f64,
    /// What the solve was given.
    pub problem: ContactProblem,
}

/// The hardest problem of each of the steps in which that took the most iterations. Filled in by the exact method while
/// present, at the cost of a copy of each problem's velocities and impulses.
#[derive(Resource, Clone, Debug)]
pub struct HardProblems {
    most: usize,
    list: Vec<HardProblem>,
}

impl HardProblems {
    /// Of so many steps.
    pub fn new(most: usize) -> Self {
        Self { most, list: Vec::new() }
    }

    /// The hardest first.
    pub fn list(&self) -> &[HardProblem] {
        &self.list
    }

    /// Takes in the hardest of those of a step, if it is one of the hardest of the run.
    pub(crate) fn take_in<'p>(&mut self, step: u64, solved: impl Iterator<Item = &'p HardProblem>) {
        // The first of several that are as hard.
        let Some(hardest) = solved.reduce(|a, b| if b.iterations > a.iterations { b } else { a }) else { return };
        let place = self.list.partition_point(|other| other.iterations >= hardest.iterations);
        if place < self.most {
            self.list.insert(place, HardProblem { step, ..hardest.clone() });
            self.list.truncate(self.most);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hardest_of_each_of_the_hardest_steps_are_kept() {
        let mut problems = HardProblems::new(2);
        let solved = |iterations: u32| HardProblem { iterations, ..HardProblem::default() };
        for (step, all) in (1..).zip([&[3, 9, 1][..], &[5], &[], &[9], &[2, 7]]) {
            let all: Vec<_> = all.iter().copied().map(solved).collect();
            problems.take_in(step, all.iter());
        }
        let kept: Vec<_> = problems.list().iter().map(|problem| (problem.step, problem.iterations)).collect();
        assert_eq!(kept, [(1, 9), (4, 9)]);
    }
}
