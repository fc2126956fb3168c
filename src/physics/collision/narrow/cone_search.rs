//! Cones of which the closed forms prove nothing, by search: those that overlap by about their size, or lie about
//! each other's axis. Any direction's depth bounds the least from above, so no overlap can be lost here.

use nalgebra::Vector3;

use super::Rim;
use super::placed_cone::PlacedCone;
use crate::physics::collision::constants::{CIRCLE_SAMPLES, GOLDEN_STEPS};

/// Unit vectors across a rim's axis, evenly around it.
pub(crate) fn around(rim: &Rim) -> [Vector3<f64>; CIRCLE_SAMPLES] {
    let ahead = rim.direction(&Vector3::zeros());
    let side = rim.axis.cross(&ahead);
    let (sin, cos) = SAMPLE_TURN.sin_cos();
    let mut toward = [1.0, 0.0];
    std::array::from_fn(|_| {
        let [c, s] = toward;
        toward = [c * cos - s * sin, s * cos + c * sin];
        ahead * c + side * s
    })
}

const SAMPLE_TURN: f64 = std::f64::consts::TAU / CIRCLE_SAMPLES as f64;

/// The normal of the flank of `one` along which it overlaps another shape least, of which `reach` is the support function, and
/// the depth.
pub(crate) fn least_of_flank(
    one: &PlacedCone,
    reach: impl Fn(&Vector3<f64>) -> f64,
    axes: &mut u32,
) -> (Vector3<f64>, f64) {
    let mut measure = |toward: &Vector3<f64>| {
        *axes += 1;
        let normal = one.flank_normal(toward);
        one.apex.dot(&normal) + reach(&-normal)
    };
    let directions = around(&one.rim);
    let samples = directions.map(|toward| measure(&toward));
    let mut best = (directions[0], samples[0]);
    for sample in 0..CIRCLE_SAMPLES {
        let (before, after) = ((sample + CIRCLE_SAMPLES - 1) % CIRCLE_SAMPLES, (sample + 1) % CIRCLE_SAMPLES);
        if samples[sample] <= samples[before] && samples[sample] < samples[after] {
            let (toward, side) = (directions[sample], one.rim.axis.cross(&directions[sample]));
            let place = |along: f64| (toward + side * along).normalize();
            let span = SAMPLE_TURN.tan();
            let along = golden_section([-span, span], |along| measure(&place(along)));
            let depth = measure(&place(along));
            if depth < best.1 {
                best = (place(along), depth);
            }
        }
    }
    (one.flank_normal(&best.0), best.1)
}

/// Where a function that has one minimum between the ends is least.
pub(crate) fn golden_section([mut low, mut high]: [f64; 2], mut function: impl FnMut(f64) -> f64) -> f64 {
    let share = 0.5 * (5_f64.sqrt() - 1.0);
    let mut inner = [high - share * (high - low), low + share * (high - low)];
    let mut values = inner.map(&mut function);
    for _ in 0..GOLDEN_STEPS {
        if values[0] <= values[1] {
            high = inner[1];
            inner = [high - share * (high - low), inner[0]];
            values = [function(inner[0]), values[0]];
        } else {
            low = inner[0];
            inner = [inner[1], low + share * (high - low)];
            values = [values[1], function(inner[1])];
        }
    }
    if values[0] <= values[1] { inner[0] } else { inner[1] }
}
