//! Reference trajectories of `rods` and `chain`, computed once in high precision and kept in
//! `assets/reference/`: the tip of the last rod, the centre of the ball.

use bevy::math::DVec3;

use crate::scene::{SceneSpec, ShapeSpec};

use super::super::run::{BodyState, Sample};
use super::{Truth, anchor_on, dynamic};

const RODS: [(usize, &str); 3] = [
    (1, include_str!("../../../assets/reference/rods-1.csv")),
    (2, include_str!("../../../assets/reference/rods-2.csv")),
    (5, include_str!("../../../assets/reference/rods-5.csv")),
];

/// By mass of the ball, kg.
const CHAIN: [(f64, &str); 4] = [
    (1.0, include_str!("../../../assets/reference/chain-1.csv")),
    (100.0, include_str!("../../../assets/reference/chain-100.csv")),
    (1000.0, include_str!("../../../assets/reference/chain-1000.csv")),
    (1e6, include_str!("../../../assets/reference/chain-1000000.csv")),
];

pub(super) fn truth(scene: &SceneSpec) -> Option<Truth> {
    let moving = dynamic(scene);
    let last = *moving.last()?;
    let is_ball = matches!(scene.bodies[last].shape, Some(ShapeSpec::Sphere { .. }));
    let (name, table, tracked) = if is_ball {
        let mass = scene.bodies[last].mass?;
        ("centre of the ball", CHAIN.iter().find(|(known, _)| *known == mass)?.1, DVec3::ZERO)
    } else {
        ("tip of the last rod", RODS.iter().find(|(known, _)| *known == moving.len())?.1, -anchor_on(scene, last)?)
    };
    let (reference, uncertainty) = parse(table);
    let mut previous: Option<Instant> = None;
    let mut next = 0;
    let distance = move |sample: &Sample| {
        let instant = Instant::of(sample, last, tracked);
        let mut largest: Option<f64> = None;
        while let Some((time, point)) = reference.get(next)
            && *time <= instant.time + TIME_TOLERANCE
        {
            let distance = Instant::between(previous.as_ref(), &instant, *time).distance(*point);
            // The start is the scene's own, not an answer.
            if *time > 0.0 {
                largest = Some(largest.unwrap_or(0.0).max(distance));
            }
            next += 1;
        }
        previous = Some(instant);
        largest
    };
    Some(Truth::largest(name, "m", distance).with_uncertainty(uncertainty))
}

/// A reference time this close to a step is at that step: steps × h is rounded.
const TIME_TOLERANCE: f64 = 1e-9;

/// The tracked point at one time.
struct Instant {
    time: f64,
    position: DVec3,
    velocity: DVec3,
}

impl Instant {
    fn of(sample: &Sample, body: usize, tracked: DVec3) -> Self {
        let BodyState { position, rotation, linear, angular } = sample.bodies[body];
        let arm = rotation * tracked;
        Self { time: sample.time, position: position + arm, velocity: linear + angular.cross(arm) }
    }

    /// The point at a time between two steps, by cubic Hermite interpolation: fourth order in
    /// the step, so that steps that miss the reference times cost no method its order.
    fn between(before: Option<&Self>, after: &Self, time: f64) -> DVec3 {
        let Some(before) = before.filter(|_| time < after.time - TIME_TOLERANCE) else { return after.position };
        let step = after.time - before.time;
        let s = (time - before.time) / step;
        let r = 1.0 - s;
        r * r * ((1.0 + 2.0 * s) * before.position + s * step * before.velocity)
            + s * s * ((1.0 + 2.0 * r) * after.position - r * step * after.velocity)
    }
}

/// Places by time from `t_s,x_m,y_m,z_m,uncertainty_m` with a header, and the largest uncertainty.
fn parse(table: &str) -> (Vec<(f64, DVec3)>, f64) {
    let mut uncertainty: f64 = 0.0;
    let number = |field: Option<&str>| field.and_then(|field| field.parse().ok()).expect("a table of this crate");
    let row = |line: &str| {
        let mut fields = line.split(',');
        let mut next = || number(fields.next());
        let place = (next(), DVec3::new(next(), next(), next()));
        uncertainty = uncertainty.max(next());
        place
    };
    let places = table.lines().skip(1).map(row).collect();
    (places, uncertainty)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_run_to_two_seconds_in_tenths() {
        for table in RODS.iter().map(|(_, table)| table).chain(CHAIN.iter().map(|(_, table)| table)) {
            let (rows, uncertainty) = parse(table);
            assert!(uncertainty > 0.0 && uncertainty < 1e-9);
            assert_eq!(rows.len(), 21);
            for (n, (time, point)) in rows.iter().enumerate() {
                assert!((time - 0.1 * n as f64).abs() < 1e-12);
                assert!(point.is_finite() && point.z == 0.0);
            }
        }
    }

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
