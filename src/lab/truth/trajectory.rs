//! Reference trajectories of `rods` and `chain`, computed once in high precision and kept in
//! `assets/reference/`: the tip of the last rod, the centre of the ball.

use bevy::math::DVec3;

use crate::scene::{SceneSpec, ShapeSpec};

use super::answer::Truth;
use super::bodies::{anchor_on, dynamic};
use super::instant::{Instant, Table};
use crate::lab::simulation::Sample;

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
    let (places, uncertainty) = parse(table);
    let mut table = Table::new(places);
    let distance =
        move |sample: &Sample| table.distance(vec![Instant::of_point(sample.time, &sample.bodies[last], tracked)]);
    Some(Truth::largest(name, "m", distance).with_uncertainty(uncertainty + LAST_DIGIT))
}

/// Places are given in 12 decimals: off by half of the last along two axes, m.
const LAST_DIGIT: f64 = 0.71e-12;

/// Places by time from `t_s,x_m,y_m,z_m,uncertainty_m` with a header, and the largest uncertainty.
fn parse(table: &str) -> (Vec<(f64, Vec<DVec3>)>, f64) {
    let mut uncertainty: f64 = 0.0;
    let number = |field: Option<&str>| field.and_then(|field| field.parse().ok()).expect("a table of this crate");
    let row = |line: &str| {
        let mut fields = line.split(',');
        let mut next = || number(fields.next());
        let place = (next(), vec![DVec3::new(next(), next(), next())]);
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
            for (n, (time, places)) in rows.iter().enumerate() {
                assert!((time - 0.1 * n as f64).abs() < 1e-12);
                assert!(places.iter().all(|place| place.is_finite() && place.z == 0.0));
            }
        }
    }
}
