//! Proximal points: the problem with a compliance ε/ρ at each point about the present λ_k, a hundredth of it at joints,
//! solved; its solution is λ_{k+1}.
//!
//! λ⁺(y) = P_K(λ_k − (ρ/ε) û(u_k + Ĵ y)),  G(y) = y − Ĵᵀ(λ⁺(y) − λ_k) = 0
//!
//! in the change y of z alone, so that what is summed gets small as λ_k nears a solution. G' = 1 + ĴᵀD Ĵ with D =
//! (ρ/ε) A S. Newton steps with halving where |G| does not fall.
//! (Rockafellar 1976 for monotone maps; here De Saxcé's shift is taken along in every step, and the map is not
//! monotone.)
//!
//! ε falls with each point that is reached and grows after one that is not, which is given up. Where ε is large, the
//! compliant problem is nearly a projection at each point, and solved in any case.

use nalgebra::Vector3;

use super::constants::{
    ENOUGH_RESIDUAL, ENOUGH_STEPS, FIRST_SOFTNESS, FLOOR_DECAY, HALVINGS, JOINT_SOFTNESS, LEAST_SOFTNESS,
    MOST_SOFTNESS, MOST_STEPS, NEARLY_RIGID, PATIENCE, PROXIMAL_ACCURACY, PROXIMAL_ITERATIONS, PROXIMAL_LOSS,
    SOFTNESS_FALL, SOFTNESS_RISE,
};
use super::{BodyVector, ConeEnd, Iterate, Law, Mode};
use crate::physics::Refill;

/// Kept from solve to solve.
#[derive(Clone, Debug, Default)]
pub(super) struct ProximalBuffers {
    change: Vec<BodyVector>,
    start: Vec<BodyVector>,
    direction: Vec<BodyVector>,
    /// G.
    defect: Vec<BodyVector>,
    /// λ⁺.
    impulses: Vec<Vector3<f64>>,
}

impl Iterate {
    /// Proximal points from the best λ so far, with Newton steps between. True once within the tolerance.
    pub(super) fn proximal_points(&mut self, buffers: &mut ProximalBuffers, most: u32) -> bool {
        if self.outcome.end == ConeEnd::NoRigidSolution {
            return false;
        }
        self.impulses.clone_from(&self.best);
        self.refresh();
        let (mut softness, mut floor) = (FIRST_SOFTNESS, LEAST_SOFTNESS);
        let (mut goal, mut waited) = (0.9 * self.outcome.residual, 0);
        for _ in 0..most {
            self.outcome.stages += 1;
            let before = self.residual();
            let is_reached = self.proximal_point(buffers, softness, PROXIMAL_ACCURACY * before.largest);
            std::mem::swap(&mut self.impulses, &mut buffers.impulses);
            self.refresh();
            let residual = self.note();
            if residual.largest <= self.tolerance {
                return true;
            }
            let is_kept = (is_reached && residual.norm <= PROXIMAL_LOSS * before.norm) || softness >= MOST_SOFTNESS;
            if is_kept {
                if self.is_jammed() {
                    self.outcome.end = ConeEnd::NoRigidSolution;
                    return false;
                }
                if softness < NEARLY_RIGID && residual.norm < before.norm && self.newton() {
                    return true;
                }
                softness = (SOFTNESS_FALL * softness).max(floor);
                floor = (FLOOR_DECAY * floor).max(LEAST_SOFTNESS);
            } else {
                std::mem::swap(&mut self.impulses, &mut buffers.impulses);
                self.refresh();
                softness *= SOFTNESS_RISE;
                floor = softness;
            }
            waited = if self.outcome.residual < goal { 0 } else { waited + 1 };
            goal = goal.min(0.9 * self.outcome.residual);
            let is_enough = self.outcome.steps > ENOUGH_STEPS && self.outcome.residual <= ENOUGH_RESIDUAL;
            if waited > PATIENCE
                || self.outcome.steps > MOST_STEPS
                || is_enough
                || self.outcome.residual <= self.rounding()
            {
                break;
            }
        }
        false
    }

    /// One: λ⁺ is left in the buffers. True if it is reached.
    fn proximal_point(&mut self, buffers: &mut ProximalBuffers, softness: f64, wanted: f64) -> bool {
        buffers.change.reset(self.elimination.count(), BodyVector::zeros());
        let mut is_reached = false;
        for step in 0..=PROXIMAL_ITERATIONS {
            let is_symmetric = self.evaluate(buffers, softness, true);
            let effects = self.points.iter().map(|point| point.relative(&buffers.defect).norm_squared());
            is_reached = effects.fold(0.0, f64::max) <= wanted * wanted;
            if is_reached
                || step == PROXIMAL_ITERATIONS
                || !self.linear.factor(&self.points, &self.elimination, is_symmetric)
            {
                break;
            }
            self.outcome.steps += 1;
            self.linear.solution.refill(buffers.defect.iter().map(|defect| -defect));
            self.linear.solve(&self.points, &self.elimination);
            buffers.direction.clone_from(&self.linear.solution);
            self.line_search(buffers, softness);
        }
        is_reached
    }

    /// Goes along the direction as far as |G| falls, or where it is least of what is tried.
    fn line_search(&mut self, buffers: &mut ProximalBuffers, softness: f64) {
        let size = |defect: &[BodyVector]| defect.iter().map(BodyVector::norm_squared).sum::<f64>().sqrt();
        let before = size(&buffers.defect);
        buffers.start.clone_from(&buffers.change);
        let (mut share, mut best) = (1.0, (f64::INFINITY, 0.0));
        for _ in 0..=HALVINGS {
            buffers.go(share);
            self.evaluate(buffers, softness, false);
            let now = size(&buffers.defect);
            if now < best.0 {
                best = (now, share);
            }
            if now <= (1.0 - 0.1 * share) * before {
                return;
            }
            share *= 0.5;
        }
        buffers.go(best.1);
    }

    /// λ⁺ and G at y, and, if asked, D; whether all of these are symmetric.
    fn evaluate(&mut self, buffers: &mut ProximalBuffers, softness: f64, with_derivative: bool) -> bool {
        let ProximalBuffers { change, defect, impulses, .. } = buffers;
        defect.clone_from(change);
        impulses.clear();
        if with_derivative {
            self.linear.clear();
        }
        let mut is_symmetric = true;
        for ((point, impulse), velocity) in self.points.iter().zip(&self.impulses).zip(&self.velocities) {
            let velocity = velocity + point.relative(change);
            let softness = if point.law == Law::Joint { JOINT_SOFTNESS * softness } else { softness };
            let weight = if point.is_movable() { point.mass / softness } else { 0.0 };
            let wanted = impulse - weight * point.law.shifted(&velocity);
            let next = point.law.project(&wanted);
            point.apply(defect, &(impulse - next));
            impulses.push(next);
            if with_derivative {
                let mode = point.law.mode(&wanted);
                let mut stiffness = mode.function(point.law, |along| weight * along);
                if mode != Mode::Open && point.law.shift(&velocity) > 0.0 {
                    stiffness = point.law.with_shift(stiffness, &velocity);
                    is_symmetric = false;
                }
                self.linear.stiffness.push(stiffness);
            }
        }
        is_symmetric
    }
}

impl ProximalBuffers {
    /// y = start + share × direction.
    fn go(&mut self, share: f64) {
        for ((change, start), direction) in self.change.iter_mut().zip(&self.start).zip(&self.direction) {
            *change = start + share * direction;
        }
    }
}
