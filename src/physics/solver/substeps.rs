//! How many substeps a step is cut into for what is solved exactly in each of them.
//!
//! Nothing has to be passed on from row to row there, so that what is left to resolve is the motion. Its error goes
//! with the square of how far bodies turn in a substep.

use crate::physics::body::Body;
use crate::physics::settings::SolverSettings;

/// How many substeps are made one where no body turns far: joints end as near to each other, and what turns
/// slowly has no more error than what turns fast.
const SLOWER: u32 = 2;

/// What the settings say of a step and its substeps.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Substeps {
    /// Length of the step, s.
    pub step: f64,
    /// As the settings say; impulses of contacts are kept for as many.
    pub most: u32,
    /// Whether fewer will do where little turns.
    fitted: bool,
}

/// The equal intervals that a step is cut into.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Intervals {
    pub count: u32,
    /// Length of each, s.
    pub h: f64,
    /// How many of the settings' substeps each stands for.
    pub replaces: f64,
    /// Whether a body turns so far that rotations count in each of them.
    pub turns_far: bool,
}

impl Substeps {
    /// As the settings want it.
    pub fn of(settings: &SolverSettings) -> Self {
        Self { step: settings.step(), most: settings.substeps, fitted: settings.impulse.fitted_effort }
    }

    /// For a step of these bodies. Where one turns by over `far`, rad, in a step, rotations are taken into account in each
    /// substep; where one turns by over `fast`, rad, all substeps are taken.
    pub fn for_bodies<'w>(&self, bodies: impl Iterator<Item = &'w Body>, far: f64, fast: f64) -> Intervals {
        let turn = bodies.map(|body| body.angular.norm()).fold(0.0, f64::max) * self.step;
        let count = if turn > fast || !self.fitted { self.most } else { self.most.div_ceil(SLOWER) };
        let replaces = f64::from(self.most) / f64::from(count);
        Intervals { count, h: self.step / f64::from(count), replaces, turns_far: turn > far }
    }
}

#[cfg(test)]
mod tests {
    use bevy::prelude::Entity;
    use nalgebra::Vector3;

    use super::*;

    #[test]
    fn the_fastest_body_tells_how_many_substeps_and_whether_rotations_count() {
        let substeps = Substeps { step: 0.1, most: 5, fitted: true };
        let intervals = |turn: f64| {
            let bodies = [0.0, turn, 0.01].map(|turn| Body {
                angular: Vector3::new(0.0, -turn / substeps.step, 0.0),
                ..Body::new(Entity::PLACEHOLDER)
            });
            substeps.for_bodies(bodies.iter(), 0.03, 0.2)
        };
        for (turn, count, turns_far) in [(0.02, 3, false), (0.04, 3, true), (0.19, 3, true), (0.21, 5, true)] {
            let told = intervals(turn);
            assert_eq!((told.count, told.turns_far), (count, turns_far), "{turn} rad");
            assert!((told.h * f64::from(count) - 0.1).abs() < 1e-15 && told.replaces * f64::from(count) == 5.0);
        }
        let full = Substeps { fitted: false, ..substeps };
        assert_eq!(full.for_bodies([].iter(), 0.03, 0.2).count, 5);
    }
}
