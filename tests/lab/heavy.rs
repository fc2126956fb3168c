//! What is heavy comes down on what is light, and stays on it: by the preset `game`, in motion as at rest.

use std::convert::Infallible;

use plumb::lab::{Metrics, Plan, measure};
use plumb::physics::SolverSettings;

fn run(scene: &str, parameters: &[(&str, f64)], seconds: f64) -> Metrics {
    let parameters: Vec<_> = parameters.iter().map(|&(name, value)| (name.to_owned(), value)).collect();
    let plan = Plan::new(scene, &parameters, SolverSettings::game(), Some(seconds)).unwrap();
    measure(&plan, |_| Ok::<(), Infallible>(())).unwrap()
}

/// How far bodies are from where they should rest a second after the last landing, and how deep they were under it at
/// most, m.
fn landing(scene: &str, parameters: &[(&str, f64)]) -> [f64; 2] {
    let metrics = run(scene, parameters, 3.0);
    [metrics.truth.as_ref().expect("an answer").error, metrics.further_truths[0].error]
}

#[test]
fn a_heavy_slab_that_falls_lies_still_on_light_cubes() {
    for (n, r, drop) in [(2.0, 1e3, 0.05), (2.0, 10.0, 0.01), (2.0, 1e5, 2.0), (20.0, 1e3, 0.5), (7.0, 1e4, 1.0)] {
        let [moved, sunk] = landing("slab", &[("n", n), ("r", r), ("drop", drop)]);
        assert!(moved < 0.01 && sunk < 0.01, "{n} cubes, {r} kg from {drop} m: moved by {moved} m, sank by {sunk} m");
    }
}

#[test]
fn a_column_of_light_and_heavy_cubes_lands_and_stands() {
    for (n, r, gap) in [(15.0, 100.0, 0.01), (20.0, 1.0, 0.01), (20.0, 1e3, 0.02), (6.0, 1e5, 0.1)] {
        let [moved, sunk] = landing("column", &[("n", n), ("r", r), ("gap", gap)]);
        assert!(moved < 0.02, "{n} cubes, 1 and {r} kg, gaps of {gap} m: moved by {moved} m, sank by {sunk} m");
    }
}

#[test]
fn a_boulder_that_falls_on_a_wall_of_light_cubes_stays_on_it() {
    for (n, r, drop) in [(10.0, 1e4, 1.0), (4.0, 1e5, 0.1), (7.0, 1e3, 2.0)] {
        let [_, sunk] = landing("boulder", &[("n", n), ("r", r), ("drop", drop)]);
        assert!(sunk < 0.01, "{r} kg from {drop} m on {n} rows: sank by {sunk} m");
    }
}

#[test]
fn a_boulder_thrown_at_a_wall_of_light_cubes_goes_through() {
    for (n, v) in [(10.0, 10.0), (6.0, 20.0)] {
        let metrics = run("wrecking_ball", &[("n", n), ("v", v)], 1.5);
        let lacks = metrics.truth.as_ref().expect("an answer").error;
        assert!(lacks == 0.0, "{n} rows: at {v} m/s it is slower by {lacks} m/s than with all cubes along");
        assert!(metrics.shares.sunk_of_size < 0.1, "{n} rows: {} of a cube overlaps", metrics.shares.sunk_of_size);
    }
}

#[test]
fn balls_that_bounce_without_loss_keep_their_energy() {
    let metrics = run("spheres", &[("e", 1.0)], 3.0);
    let rise = metrics.shares.energy_rise.expect("a scale");
    assert!(rise < 0.01, "energy rises by {rise} of its scale");
    let drift = metrics.energy.max_relative_drift.expect("a scale");
    assert!(drift < 0.05, "energy is off by {drift} of its scale");
}
