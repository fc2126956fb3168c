//! What bodies do that should stay where they are: sink, drift, tremble.

use super::moving::Moving;
use crate::physics::BodyState;

/// Watches how bodies leave their places.
#[derive(Default)]
pub(super) struct RestMeter {
    /// Largest fall of any body below its start, m.
    pub sink: f64,
    /// Largest horizontal move of any body from its start, m.
    pub drift: f64,
    /// Largest move of a body over its size.
    pub of_size: f64,
    /// Sum of the squared speed of the fastest body, and how many steps it is over.
    squared_speeds: (f64, u64),
}

impl RestMeter {
    /// `settled`: whether the step is one of those that jitter is measured over.
    pub fn observe(&mut self, bodies: &[Moving], start: &[BodyState], states: &[BodyState], settled: bool) {
        for (state, start) in states.iter().zip(start) {
            let moved = state.position - start.position;
            self.sink = self.sink.max(-moved.y);
            self.drift = self.drift.max(moved.x.hypot(moved.z));
        }
        let mut fastest: f64 = 0.0;
        for body in bodies {
            let BodyState { position, linear, angular, .. } = states[body.index];
            self.of_size = self.of_size.max(position.distance(start[body.index].position) / body.size);
            fastest = fastest.max(linear.length() + angular.length() * body.radius);
        }
        if settled {
            self.squared_speeds.0 += fastest * fastest;
            self.squared_speeds.1 += 1;
        }
    }

    /// Root mean square of the fastest body's speed, m/s: its centre's plus what its spin adds at
    /// its farthest point.
    pub fn jitter(&self) -> f64 {
        let (sum, steps) = self.squared_speeds;
        (sum / steps.max(1) as f64).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use bevy::math::DVec3;

    use super::*;

    #[test]
    fn jitter_is_the_mean_of_the_fastest_once_settled() {
        let body = |index| Moving {
            index,
            mass: 1.0,
            inertia: DVec3::ONE,
            gravity: DVec3::ZERO,
            force: DVec3::ZERO,
            size: 0.5,
            radius: 2.0,
        };
        let bodies = [body(0), body(1)];
        let start = [BodyState::default(); 2];
        let with = |linear: f64, spin: f64| {
            let mut states = start;
            states[0].linear.x = linear;
            states[1].angular.z = spin;
            states
        };
        let mut rest = RestMeter::default();
        rest.observe(&bodies, &start, &with(9.0, 0.0), false);
        rest.observe(&bodies, &start, &with(3.0, 0.5), true);
        rest.observe(&bodies, &start, &with(3.0, 2.0), true);
        assert!((rest.jitter() - 12.5_f64.sqrt()).abs() < 1e-15, "{}", rest.jitter());
    }

    #[test]
    fn moves_are_told_down_sideways_and_by_size() {
        let bodies = [Moving {
            index: 0,
            mass: 1.0,
            inertia: DVec3::ONE,
            gravity: DVec3::ZERO,
            force: DVec3::ZERO,
            size: 0.5,
            radius: 1.0,
        }];
        let start = [BodyState::default()];
        let mut rest = RestMeter::default();
        for position in [DVec3::new(3.0, 1.0, 4.0), DVec3::new(0.0, -2.0, 0.0)] {
            rest.observe(&bodies, &start, &[BodyState { position, ..start[0] }], false);
        }
        assert_eq!((rest.sink, rest.drift), (2.0, 5.0));
        assert!((rest.of_size - 2.0 * 26.0_f64.sqrt()).abs() < 1e-15);
        assert_eq!(rest.jitter(), 0.0, "nothing has settled");
    }
}
