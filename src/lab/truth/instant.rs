//! Where a point is between two steps.

use bevy::math::DVec3;

/// A reference time this close to a step is at that step: steps × h is rounded.
pub(super) const TIME_TOLERANCE: f64 = 1e-9;

/// A point at one time.
#[derive(Clone, Copy, Debug)]
pub(super) struct Instant {
    pub time: f64,
    pub position: DVec3,
    pub velocity: DVec3,
}

impl Instant {
    /// The point at a time between two steps, by cubic Hermite interpolation: fourth order in
    /// the step, so that steps that miss the reference times cost no method its order.
    pub fn between(before: Option<&Self>, after: &Self, time: f64) -> DVec3 {
        let Some(before) = before.filter(|_| time < after.time - TIME_TOLERANCE) else { return after.position };
        let step = after.time - before.time;
        let s = (time - before.time) / step;
        let r = 1.0 - s;
        r * r * ((1.0 + 2.0 * s) * before.position + s * step * before.velocity)
            + s * s * ((1.0 + 2.0 * r) * after.position - r * step * after.velocity)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn interpolation_is_exact_for_cubics() {
        let at = |time: f64| Instant {
            time,
            position: DVec3::new(time.powi(3) - time, 2.0 * time * time, 1.0),
            velocity: DVec3::new(3.0 * time * time - 1.0, 4.0 * time, 0.0),
        };
        let (before, after) = (at(0.3), at(0.5));
        for time in [0.3, 0.35, 0.41, 0.4999, 0.5] {
            let error = Instant::between(Some(&before), &after, time).distance(at(time).position);
            assert!(error < 1e-14, "at {time}: {error:e}");
        }
    }
}
