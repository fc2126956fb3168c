//! Semismooth Newton steps on the natural map.
//!
//! F(λ) = λ − P_K(λ − ρ û) = 0, with A = P_K' where it lands and S = ∂û/∂u = 1 + μ n tᵀ, t = u_t/|u_t|:
//!
//! (1 − A) dλ + ρ A S Ĵ dz = −F,  dz = Ĵᵀdλ.
//!
//! Points that stick or slip may be redundant: they get a compliance ε/ρ about the present λ, u + (ε/ρ) dλ for u, so
//! that 1 − A + ε A can be inverted: dλ = h − D Ĵ dz, with h = −(1 − A + εA)⁻¹F, D = ρ (1 − A + εA)⁻¹A S. The
//! compliance acts on dλ alone and so is no error of the solution. A sticking point aims at u = 0, where û is not
//! smooth.

use nalgebra::{Matrix3, Vector3};

use super::law::{Law, Mode};
use super::point::Point;
use super::{ConeSolver, Outcome};

/// ε: small against the smallest share 1/ρ that mass ratios of 10⁶ leave, large against rounding.
const SOFTNESS: f64 = 1e-8;
/// Most steps; from a near guess it takes two or three.
const STEPS: u32 = 12;
/// From the second step on, each has to bring the norm of the residual down to this share; the first may raise it by
/// no more than the other.
const LEAST_GAIN: f64 = 0.7;
const MOST_LOSS: f64 = 1e3;

impl ConeSolver {
    /// Steps as long as they help. True once within the tolerance; else λ is again what it was unless the last is
    /// better.
    pub(super) fn polish(&mut self, tolerance: f64, outcome: &mut Outcome) -> bool {
        let start = self.residual();
        self.note(start, outcome);
        if start.largest <= tolerance {
            return true;
        }
        self.kept.clone_from(&self.impulses);
        let mut before = start.norm;
        for step in 0..STEPS {
            outcome.steps += 1;
            if !self.newton_step() {
                break;
            }
            let residual = self.residual();
            self.note(residual, outcome);
            if residual.largest <= tolerance {
                return true;
            }
            let most = if step == 0 { MOST_LOSS } else { LEAST_GAIN };
            if residual.norm >= most * before || residual.norm.is_nan() {
                break;
            }
            before = residual.norm;
        }
        if self.residual().norm >= start.norm {
            self.impulses.clone_from(&self.kept);
            self.refresh();
        }
        false
    }

    /// λ += dλ. False where the linear system is singular.
    fn newton_step(&mut self) -> bool {
        let Self { points, linear, elimination, impulses, velocities, .. } = self;
        linear.clear();
        let mut is_symmetric = true;
        for ((point, impulse), velocity) in points.iter().zip(&*impulses).zip(&*velocities) {
            let (stiffness, push, slips) = if point.is_movable() {
                linearised(point, impulse, velocity)
            } else {
                (Matrix3::zeros(), Vector3::zeros(), false)
            };
            is_symmetric &= !slips;
            linear.stiffness.push(stiffness);
            linear.push.push(push);
        }
        if !linear.factor(points, elimination, is_symmetric) {
            return false;
        }
        linear.push_all(points, elimination);
        linear.solve(points, elimination);
        let terms = linear.push.iter().zip(&linear.stiffness);
        for ((point, impulse), (push, stiffness)) in points.iter().zip(impulses).zip(terms) {
            *impulse += push - stiffness * point.across(&linear.solution);
        }
        self.refresh();
        true
    }
}

/// D, h, and whether D is not symmetric.
fn linearised(point: &Point, impulse: &Vector3<f64>, velocity: &Vector3<f64>) -> (Matrix3<f64>, Vector3<f64>, bool) {
    let Point { law, mass, .. } = *point;
    let wanted = impulse - mass * law.shifted(velocity);
    let mode = law.mode(&wanted);
    match mode {
        Mode::Open => (Matrix3::zeros(), -impulse, false),
        Mode::Stick => {
            let stiffness = mode.function(law, |along| along * mass / SOFTNESS);
            (stiffness, -(stiffness * velocity), false)
        }
        Mode::Slip { .. } => {
            let regular = |along: f64| 1.0 / (1.0 - along + SOFTNESS * along);
            let push = -(mode.function(law, regular) * (impulse - law.project(&wanted)));
            let stiffness = mode.function(law, |along| mass * along * regular(along));
            (with_shift(law, stiffness, velocity), push, true)
        }
    }
}

/// Q (1 + μ n tᵀ).
pub(super) fn with_shift(law: Law, stiffness: Matrix3<f64>, velocity: &Vector3<f64>) -> Matrix3<f64> {
    let speed = velocity.y.hypot(velocity.z);
    if speed == 0.0 {
        return stiffness;
    }
    let along = Vector3::new(0.0, velocity.y, velocity.z) * (law.friction() / speed);
    stiffness + stiffness.column(0) * along.transpose()
}
