//! The reference trajectories of Bricard's rods, computed once in high precision and kept in `assets/reference/`: the
//! centres of the rods.

use bevy::math::DVec3;

use crate::scene::SceneSpec;

use super::answer::Truth;
use super::bodies::dynamic;
use super::hinges;
use super::instant::{Instant, Table};
use super::table::rows;
use crate::lab::simulation::Sample;

pub(super) fn truth(scene: &SceneSpec) -> Option<Truth> {
    let rods = dynamic(scene);
    let place = |row: Vec<f64>| {
        let places = row[1..].chunks_exact(3).map(DVec3::from_slice).collect();
        (row[0], places)
    };
    let mut table = Table::new(rows(include_str!("../../../assets/reference/bricard.csv")).map(place).collect());
    let distance = move |sample: &Sample| {
        let centre = |&rod: &usize| Instant::of_point(sample.time, &sample.bodies[rod], DVec3::ZERO);
        table.distance(rods.iter().map(centre).collect())
    };
    let truth = Truth::largest("centres of the rods", "m", distance).with_uncertainty(UNCERTAINTY);
    Some(truth.and(hinges::tilt(scene)))
}

/// Fine runs agree to 5e-11 m with the table, m.
const UNCERTAINTY: f64 = 1e-10;
