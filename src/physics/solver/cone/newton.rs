//! Semismooth Newton iterations on the natural map.
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

use super::constants::{NEWTON_FIRST_LOSS, NEWTON_GAIN, NEWTON_ITERATIONS, SOFTNESS};
use super::{ConePoint, Iterate, Law, Mode};

impl Iterate {
    /// Iterates as long as that helps. True once within the tolerance; else λ is again what it was unless the last is
    /// better.
    pub(super) fn newton(&mut self) -> bool {
        let start = self.note();
        if start.largest <= self.tolerance {
            return true;
        }
        self.kept.clone_from(&self.impulses);
        let mut before = start.norm;
        for step in 0..NEWTON_ITERATIONS {
            self.outcome.steps += 1;
            if !self.newton_iteration() {
                break;
            }
            let residual = self.note();
            if residual.largest <= self.tolerance {
                return true;
            }
            let most = if step == 0 { NEWTON_FIRST_LOSS } else { NEWTON_GAIN };
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
    fn newton_iteration(&mut self) -> bool {
        let Self { points, linear, elimination, impulses, velocities, .. } = self;
        linear.clear();
        let mut is_symmetric = true;
        for ((point, impulse), velocity) in points.iter().zip(&*impulses).zip(&*velocities) {
            let (stiffness, offset, slips) = if point.is_movable() {
                linearised(point, impulse, velocity)
            } else {
                (Matrix3::zeros(), Vector3::zeros(), false)
            };
            is_symmetric &= !slips;
            linear.stiffness.push(stiffness);
            linear.offset.push(offset);
        }
        if !linear.factor(points, elimination, is_symmetric) {
            return false;
        }
        linear.apply_offsets(points, elimination);
        linear.solve(points, elimination);
        let terms = linear.offset.iter().zip(&linear.stiffness);
        for ((point, impulse), (offset, stiffness)) in points.iter().zip(impulses).zip(terms) {
            *impulse += offset - stiffness * point.relative(&linear.solution);
        }
        self.refresh();
        true
    }
}

/// D, h, and whether D is not symmetric.
fn linearised(
    point: &ConePoint,
    impulse: &Vector3<f64>,
    velocity: &Vector3<f64>,
) -> (Matrix3<f64>, Vector3<f64>, bool) {
    let ConePoint { law, mass, .. } = *point;
    let wanted = impulse - mass * law.shifted(velocity);
    let mode = law.mode(&wanted);
    match mode {
        Mode::Open if matches!(law, Law::Within(..)) => (Matrix3::zeros(), law.project(&wanted) - impulse, false),
        Mode::Open => (Matrix3::zeros(), -impulse, false),
        Mode::Stick => {
            let stiffness = mode.function(law, |along| along * mass / SOFTNESS);
            (stiffness, -(stiffness * velocity), false)
        }
        Mode::Slip { .. } => {
            let regular = |along: f64| 1.0 / (1.0 - along + SOFTNESS * along);
            let offset = -(mode.function(law, regular) * (impulse - law.project(&wanted)));
            let stiffness = mode.function(law, |along| mass * along * regular(along));
            (law.with_shift(stiffness, velocity), offset, true)
        }
    }
}
