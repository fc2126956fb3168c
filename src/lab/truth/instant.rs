//! Where a point is between two steps.

use bevy::math::DVec3;

use crate::physics::BodyState;

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
    /// Of a point of a body, from its centre of mass in body axes.
    pub fn of_point(time: f64, body: &BodyState, point: DVec3) -> Self {
        let arm = body.rotation * point;
        Self { time, position: body.position + arm, velocity: body.linear + body.angular.cross(arm) }
    }

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

/// Places at some times, the earliest first, and how many of them have been compared.
pub(super) struct Table {
    rows: Vec<(f64, Vec<DVec3>)>,
    next: usize,
    before: Vec<Instant>,
}

impl Table {
    /// Times, s, each with one place for each of the points compared.
    pub fn new(rows: Vec<(f64, Vec<DVec3>)>) -> Self {
        Self { rows, next: 0, before: Vec::new() }
    }

    /// The largest distance of the points from their places at the times since the last call; none where there are none.
    /// The start is the scene's own, not an answer.
    pub fn distance(&mut self, now: Vec<Instant>) -> Option<f64> {
        self.largest(now, |found, places| found.iter().zip(places).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max))
    }

    /// The same by another measure of how far the points are from their places.
    pub fn largest(&mut self, now: Vec<Instant>, apart: impl Fn(&[DVec3], &[DVec3]) -> f64) -> Option<f64> {
        let mut largest: Option<f64> = None;
        while let Some((time, places)) = self.rows.get(self.next)
            && now.first().is_some_and(|instant| *time <= instant.time + TIME_TOLERANCE)
        {
            if *time > 0.0 {
                let now = now.iter().enumerate();
                let found: Vec<_> =
                    now.map(|(point, now)| Instant::between(self.before.get(point), now, *time)).collect();
                largest = Some(largest.unwrap_or(0.0).max(apart(&found, places)));
            }
            self.next += 1;
        }
        self.before = now;
        largest
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
