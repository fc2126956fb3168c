//! The angles of Andrews' squeezer at 0.03 s (Test Set for IVP Solvers, release 2.4).

use bevy::math::DVec3;

use crate::scene::SceneSpec;

use super::answer::{EnergyScale, Truth};
use super::bodies::turn;
use super::instant::TIME_TOLERANCE;
use crate::lab::angle::wrapped;
use crate::lab::simulation::Sample;

/// s.
const TIME: f64 = 0.03;

/// β, Θ, γ, Φ, δ, Ω, ε at the start and at that time, rad.
const ANGLES: [[f64; 2]; 7] = [
    [-0.0617138900142764, 15.81077119629904],
    [0.0, -15.75637105984298],
    [0.4552798191630704, 0.04082224013073101],
    [0.2226683901658859, -0.5347301163226948],
    [0.4873649795438426, 0.5244099658805304],
    [-0.2226683901658859, 0.5347301163226948],
    [1.230547444549821, 1.048080741042263],
];

/// Which angles of the bodies each is the difference of: that of the first, less that of the other.
const OF_BODIES: [(usize, Option<usize>); 7] =
    [(1, None), (2, Some(1)), (3, None), (4, Some(5)), (5, None), (6, Some(7)), (7, None)];

pub(super) fn truth(scene: &SceneSpec) -> Option<Truth> {
    let starts: Vec<_> = scene.bodies.iter().map(|body| body.rotation).collect();
    let mut before = None;
    let distance = move |sample: &Sample| {
        let turned = OF_BODIES.map(|(body, less)| {
            let of = |body: usize| turn(sample.bodies[body].rotation, starts[body], DVec3::Z);
            let rate = |body: usize| sample.bodies[body].angular.z;
            (of(body) - less.map_or(0.0, of), rate(body) - less.map_or(0.0, rate))
        });
        let earlier = before.replace((sample.time, turned)).filter(|(time, _)| *time < TIME - TIME_TOLERANCE);
        if sample.time < TIME - TIME_TOLERANCE {
            return None;
        }
        let (before, earlier) = earlier?;
        let step = sample.time - before;
        let error = |(place, [start, end]): (usize, &[f64; 2])| {
            let at = between(earlier[place], turned[place], step, (TIME - before) / step);
            wrapped(at - (end - start)).abs()
        };
        Some(ANGLES.iter().enumerate().map(error).fold(0.0, f64::max))
    };
    let truth = Truth::largest("seven angles at 0.03 s", "rad", distance).with_uncertainty(UNCERTAINTY);
    Some(truth.with_energy_scale(EnergyScale::NotKept))
}

/// Found again by another integration to that, rad.
const UNCERTAINTY: f64 = 1e-9;

/// An angle at a share of a step between two values with their rates, by cubic Hermite interpolation; the second but for
/// whole turns.
fn between((from, rate): (f64, f64), (to, rate_after): (f64, f64), step: f64, share: f64) -> f64 {
    let expected = 0.5 * step * (rate + rate_after);
    let gained = expected + wrapped(to - from - expected);
    let rest = 1.0 - share;
    from + share * share * (1.0 + 2.0 * rest) * gained + share * rest * step * (rest * rate - share * rate_after)
}
