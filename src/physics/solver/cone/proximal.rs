//! Proximal points: the problem with a compliance ε/ρ at each point about the present λ_k, a hundredth of it at joints
//! (where levers are long, of what it is with shorter ones), solved; its solution is λ_{k+1}. (Rockafellar 1976 for monotone
//! maps; Coulomb's law is none.)
//!
//! Where ε is large, the compliant problem is nearly one for each point by itself, and solved in any case. ε falls with each
//! point that is reached, the faster the fewer iterations that took, and grows after one that is not; from there it falls
//! slowly at first, since what was too stiff just now mostly still is. A point that is reached is taken whatever its residual:
//! λ_{k+1} is nearer to the solution, but what moves is ε/ρ (λ_k − λ_{k+1}), which is much where bodies that turn easily
//! are held by others.

use super::constants::{
    ENOUGH_RESIDUAL, FAR, FAR_PATIENCE, FIRST_SOFTNESS, GUESSED_SOFTNESS, LEAST_SOFTNESS, MISSED_FADES,
    MISSED_SOFTNESS, MOST_SOFTNESS, MOST_STEPS, PATIENCE, PROXIMAL_ACCURACY, PROXIMAL_ITERATIONS, PROXIMAL_POINTS,
    SOFTNESS_FALLS, SOFTNESS_RISE, STALLED,
};
use super::newton::NewtonBuffers;
use super::{ConeEnd, Iterate};

impl Iterate {
    /// Proximal points from the present λ, which is a guess or none. True once within the tolerance.
    pub(super) fn proximal_points(&mut self, buffers: &mut NewtonBuffers, is_guessed: bool) -> bool {
        let mut softness = if is_guessed { GUESSED_SOFTNESS } else { FIRST_SOFTNESS };
        // What ε is not to fall below for now.
        let mut least = LEAST_SOFTNESS;
        let (first, mut goal, mut waited) = (self.outcome.stages, 0.9 * self.outcome.residual, 0);
        let most = self.outcome.steps + MOST_STEPS;
        for _ in 0..PROXIMAL_POINTS {
            self.outcome.stages += 1;
            let (before, steps) = (self.residual(), self.outcome.steps);
            let is_reached = self.reach(buffers, softness, PROXIMAL_ACCURACY * before.largest, PROXIMAL_ITERATIONS);
            let residual = self.note();
            if residual.largest <= self.tolerance {
                return true;
            }
            if is_reached || residual.norm <= before.norm || softness >= MOST_SOFTNESS {
                if self.is_jammed() {
                    self.outcome.end = ConeEnd::NoRigidSolution;
                    return false;
                }
                let steps = self.outcome.steps - steps;
                let fall = SOFTNESS_FALLS.iter().find(|(most, _)| steps <= *most).filter(|_| is_reached);
                softness = (softness * fall.map_or(1.0, |(_, share)| *share)).max(softness.min(least));
                least = (MISSED_FADES * least).max(LEAST_SOFTNESS);
            } else {
                self.go_back();
                least = (MISSED_SOFTNESS * softness).max(LEAST_SOFTNESS);
                softness = if is_guessed && self.outcome.stages == first + 1 {
                    FIRST_SOFTNESS
                } else {
                    softness * SOFTNESS_RISE
                };
            }
            waited = if self.outcome.residual < goal { 0 } else { waited + 1 };
            goal = goal.min(0.9 * self.outcome.residual);
            let enough = ENOUGH_RESIDUAL.max(self.rounding());
            let is_enough = waited >= STALLED && self.outcome.residual <= enough;
            if self.is_late() {
                self.outcome.end = ConeEnd::Late;
                return false;
            }
            let patience = if self.outcome.residual > FAR { FAR_PATIENCE } else { PATIENCE };
            if waited > patience || self.outcome.steps > most || is_enough {
                break;
            }
        }
        false
    }

    /// λ is again what it was before the last proximal point.
    fn go_back(&mut self) {
        std::mem::swap(&mut self.impulses, &mut self.kept);
        self.refresh();
    }
}
