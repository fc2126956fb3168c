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

use super::super::linear::BodyVector as Part;
use super::law::{Law, Mode};
use super::newton::with_shift;
use super::{ConeSolver, End, Outcome};

/// Most steps for one point; more than that and a softer problem is the cheaper way.
const STEPS: u32 = 15;
/// Most halvings of a step.
const HALVINGS: u32 = 5;
/// A point is reached when what is left of G moves no contact by more than this share of the residual.
const REACHED: f64 = 0.05;
/// ε of joints over that of contacts: they neither part nor slide, so that no step is too long for them, and redundant
/// ones need the less points the smaller it is.
const OF_JOINTS: f64 = 0.01;
/// What ε is multiplied by after a point that was reached, and after one that was not.
const HARDEN: f64 = 0.3;
const SOFTEN: f64 = 5.0;
/// The least ε, and how fast that which failed is tried again.
const LEAST: f64 = 1e-6;
const FORGET: f64 = 0.8;
/// Above this the compliance is so large that any step is good.
const MOST: f64 = 10.0;
/// A point may raise the residual by this much, no more.
const MOST_LOSS: f64 = 10.0;
/// So many points without a residual less by a tenth, and it ends.
const PATIENCE: u32 = 60;
/// Below this ε, Newton steps on the rigid problem may do.
const NEAR: f64 = 0.02;

/// So many steps of all kinds, and it ends, too.
const MOST_STEPS: u32 = 600;
/// After so many steps of all kinds a residual, m/s, is enough: in heaps with loops of joints each further digit
/// may take a hundred.
const ENOUGH_STEPS: u32 = 150;
const ENOUGH: f64 = 1e-8;

/// Kept from solve to solve.
#[derive(Clone, Debug, Default)]
pub(super) struct Buffers {
    change: Vec<Part>,
    start: Vec<Part>,
    direction: Vec<Part>,
    /// G.
    defect: Vec<Part>,
    /// λ⁺.
    impulses: Vec<Vector3<f64>>,
}

impl ConeSolver {
    /// Proximal points from the best λ so far, with Newton steps between. True once within the tolerance.
    pub(super) fn approach(&mut self, softness: f64, stages: u32, tolerance: f64, outcome: &mut Outcome) -> bool {
        if outcome.end == End::NoRigidSolution {
            return false;
        }
        self.impulses.clone_from(&self.best);
        self.refresh();
        let (mut softness, mut floor) = (softness, LEAST);
        let (mut goal, mut waited) = (0.9 * outcome.residual, 0);
        for _ in 0..stages {
            outcome.stages += 1;
            let before = self.residual();
            let is_reached = self.proximal_point(softness, REACHED * before.largest, outcome);
            std::mem::swap(&mut self.impulses, &mut self.proximal.impulses);
            self.refresh();
            let residual = self.residual();
            self.note(residual, outcome);
            if residual.largest <= tolerance {
                return true;
            }
            let is_kept = (is_reached && residual.norm <= MOST_LOSS * before.norm) || softness >= MOST;
            if is_kept {
                if self.is_jammed() {
                    outcome.end = End::NoRigidSolution;
                    return false;
                }
                if softness < NEAR && residual.norm < before.norm && self.polish(tolerance, outcome) {
                    return true;
                }
                softness = (HARDEN * softness).max(floor);
                floor = (FORGET * floor).max(LEAST);
            } else {
                std::mem::swap(&mut self.impulses, &mut self.proximal.impulses);
                self.refresh();
                softness *= SOFTEN;
                floor = softness;
            }
            waited = if outcome.residual < goal { 0 } else { waited + 1 };
            goal = goal.min(0.9 * outcome.residual);
            let is_enough = outcome.steps > ENOUGH_STEPS && outcome.residual <= ENOUGH;
            if waited > PATIENCE || outcome.steps > MOST_STEPS || is_enough || outcome.residual <= self.rounding() {
                break;
            }
        }
        false
    }

    /// One: λ⁺ is left in the buffers. True if it is reached.
    fn proximal_point(&mut self, softness: f64, wanted: f64, outcome: &mut Outcome) -> bool {
        let mut buffers = std::mem::take(&mut self.proximal);
        buffers.change.clear();
        buffers.change.resize(self.elimination.count(), Part::zeros());
        let mut is_reached = false;
        for step in 0..=STEPS {
            let is_symmetric = self.evaluate(&mut buffers, softness, true);
            let effects = self.points.iter().map(|point| point.across(&buffers.defect).norm_squared());
            is_reached = effects.fold(0.0, f64::max) <= wanted * wanted;
            if is_reached || step == STEPS || !self.linear.factor(&self.points, &self.elimination, is_symmetric) {
                break;
            }
            outcome.steps += 1;
            self.linear.solution.clear();
            self.linear.solution.extend(buffers.defect.iter().map(|defect| -defect));
            self.linear.solve(&self.points, &self.elimination);
            buffers.direction.clone_from(&self.linear.solution);
            self.search(&mut buffers, softness);
        }
        self.proximal = buffers;
        is_reached
    }

    /// Goes along the direction as far as |G| falls, or where it is least of what is tried.
    fn search(&mut self, buffers: &mut Buffers, softness: f64) {
        let size = |defect: &[Part]| defect.iter().map(Part::norm_squared).sum::<f64>().sqrt();
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
    fn evaluate(&mut self, buffers: &mut Buffers, softness: f64, with_derivative: bool) -> bool {
        let Buffers { change, defect, impulses, .. } = buffers;
        defect.clone_from(change);
        impulses.clear();
        if with_derivative {
            self.linear.clear();
        }
        let mut is_symmetric = true;
        for ((point, impulse), velocity) in self.points.iter().zip(&self.impulses).zip(&self.velocities) {
            let velocity = velocity + point.across(change);
            let softness = if point.law == Law::Joint { OF_JOINTS * softness } else { softness };
            let weight = if point.is_movable() { point.mass / softness } else { 0.0 };
            let wanted = impulse - weight * point.law.shifted(&velocity);
            let next = point.law.project(&wanted);
            point.push(defect, &(impulse - next));
            impulses.push(next);
            if with_derivative {
                let mode = point.law.mode(&wanted);
                let mut stiffness = mode.function(point.law, |along| weight * along);
                if mode != Mode::Open && point.law.shift(&velocity) > 0.0 {
                    stiffness = with_shift(point.law, stiffness, &velocity);
                    is_symmetric = false;
                }
                self.linear.stiffness.push(stiffness);
            }
        }
        is_symmetric
    }
}

impl Buffers {
    /// y = start + share × direction.
    fn go(&mut self, share: f64) {
        for ((change, start), direction) in self.change.iter_mut().zip(&self.start).zip(&self.direction) {
            *change = start + share * direction;
        }
    }
}
