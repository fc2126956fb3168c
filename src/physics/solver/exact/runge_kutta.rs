//! The classic Runge–Kutta method of order 4, on the group of rotations by Munthe-Kaas's construction (1998,
//! "Runge–Kutta methods on Lie groups"; Hairer, Lubich and Wanner 2006, IV.8), with exact joint forces in each of the
//! four stages.
//!
//! R = exp φ R₀ with φ̇ = dexp⁻¹_φ ω is an equation for vectors, to which the method is applied. It is explicit: where
//! joint forces make bodies swing by more than [`REACH`] rad a step, the step is too long.

use nalgebra::Vector3;

use super::evaluation::Evaluation;
use super::gauss::Sweeps;
use super::group::{exponential, inverse_dexp};
use super::mechanism::{Mechanism, Motion};
use super::rows::Screw;

/// ωh up to which a step is taken: the method is stable to 2.8.
const REACH: f64 = 1.4;

/// Share of the step at which each stage is, from the one before, and each stage's weight.
const NODES: [f64; 4] = [0.0, 0.5, 0.5, 1.0];
const WEIGHTS: [f64; 4] = [1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0];

/// What changes: ẋ, φ̇, v̇, ω̇.
#[derive(Clone, Copy, Debug)]
struct Rate {
    linear: Vector3<f64>,
    turn: Vector3<f64>,
    gain: Screw,
}

/// Buffers.
#[derive(Clone, Debug, Default)]
pub(crate) struct RungeKutta {
    evaluation: Evaluation,
    stage: Vec<Motion>,
    rates: Vec<Rate>,
    sums: Vec<Rate>,
    /// Mean force of each link over the step, N.
    pub forces: Vec<Vector3<f64>>,
}

impl RungeKutta {
    /// Takes the mechanism through a step of h, s, or leaves it where the step is too long.
    pub fn step(&mut self, mechanism: &mut Mechanism, h: f64) -> Sweeps {
        self.forces.clear();
        self.forces.resize(mechanism.links.len(), Vector3::zeros());
        let zero = Rate { linear: Vector3::zeros(), turn: Vector3::zeros(), gain: Screw::ZERO };
        for rates in [&mut self.rates, &mut self.sums] {
            rates.clear();
            rates.resize(mechanism.members.len(), zero);
        }
        for (stage, (node, weight)) in NODES.into_iter().zip(WEIGHTS).enumerate() {
            self.stage.clear();
            self.stage.extend(mechanism.motion.iter().zip(&self.rates).map(|(start, rate)| at(start, rate, node * h)));
            self.evaluation.evaluate(mechanism, &self.stage, h);
            let swing = self.evaluation.swing(mechanism) * h * h;
            if swing.is_nan() || swing > REACH * REACH {
                return Sweeps { count: stage as u32 + 1, converged: false };
            }
            for (index, gain) in self.evaluation.accelerations.iter().enumerate() {
                let Motion { linear, angular, .. } = self.stage[index];
                let turn = inverse_dexp(&(self.rates[index].turn * (node * h)), &angular);
                self.rates[index] = Rate { linear, turn, gain: *gain };
                let sum = &mut self.sums[index];
                sum.linear += linear * weight;
                sum.turn += turn * weight;
                sum.gain.linear += gain.linear * weight;
                sum.gain.angular += gain.angular * weight;
            }
            for (mean, force) in self.forces.iter_mut().zip(&self.evaluation.forces) {
                *mean += force * weight;
            }
        }
        for (motion, sum) in mechanism.motion.iter_mut().zip(&self.sums) {
            *motion = at(motion, sum, h);
            motion.rotation.renormalize();
        }
        Sweeps { count: 4, converged: true }
    }
}

/// A time h on from a start, at constant rates.
fn at(start: &Motion, rate: &Rate, h: f64) -> Motion {
    Motion {
        position: start.position + rate.linear * h,
        rotation: exponential(&(rate.turn * h)) * start.rotation,
        linear: start.linear + rate.gain.linear * h,
        angular: start.angular + rate.gain.angular * h,
    }
}
