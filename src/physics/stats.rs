//! What the last step did: counts and times.

use bevy::prelude::*;

use super::SolverSettings;

/// Counts and times of the last step.
#[derive(Resource, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Resource, Debug, Default)]
pub struct StepStats {
    /// Steps since the world was made.
    pub steps: u64,
    /// Simulation time, s: steps × h.
    pub time: f64,
    /// Wall-clock time of the last step, s, without what was spent on measuring it.
    pub step_seconds: f64,
    /// Bodies, all kinds.
    pub bodies: u32,
    /// Joints.
    pub joints: u32,
    /// Pairs that the broad phase handed to the narrow phase.
    pub pairs: u32,
    /// Axes along which the separating axis test measured how far two shapes overlap.
    pub axes_tested: u64,
    /// Pairs that touch, sleeping ones included.
    pub manifolds: u32,
    /// Contact points, sleeping ones included.
    pub contact_points: u32,
    /// Scalar rows solved, in one substep.
    pub rows: u32,
    /// Row updates: rows × iterations × solves, over all substeps.
    pub row_updates: u64,
    /// Groups of bodies that touch or are joined, sleeping ones left out.
    pub islands: u32,
    /// Bodies of islands at rest, which were solved directly or had nothing to solve.
    pub resting: u32,
    /// Factorisations of islands that were solved directly with contacts, over all substeps.
    pub factorisations: u32,
    /// Parts into which the exact method cut steps that were too long for it, beyond those asked for.
    pub cuts: u32,
    /// Parts of the last step that it could not solve however short it cut them: what they held is not exact.
    pub unsettled: u32,
    /// Sliding points at which it found no rigid motion to exist (Painlevé), once for each part of the last step: an
    /// impulse stops them.
    pub jammed: u32,
    /// Bodies quarantined now.
    pub quarantined: u32,
    /// Bodies asleep now.
    pub sleeping: u32,
    /// Where `time` was when the step last changed, and the step.
    since: (u64, f64, f64),
}

impl StepStats {
    /// Steps × h, without the drift of a running sum; a change of the step starts a new product.
    pub(super) fn count_step(&mut self, settings: &SolverSettings) {
        let h = settings.step();
        if self.since.2 != h {
            self.since = (self.steps, self.time, h);
        }
        self.steps += 1;
        self.time = self.since.1 + (self.steps - self.since.0) as f64 * h;
    }
}
