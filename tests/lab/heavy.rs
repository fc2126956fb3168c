//! What is heavy comes down on what is light, and stays on it: by the reference, which the maps of these scenes are
//! judged by.

use std::convert::Infallible;

use plumb::lab::{Metrics, Plan, measure};
use plumb::physics::SolverSettings;

fn run(scene: &str, parameters: &[(&str, f64)]) -> Metrics {
    let parameters: Vec<_> = parameters.iter().map(|&(name, value)| (name.to_owned(), value)).collect();
    let plan = Plan::new(scene, &parameters, SolverSettings::accurate(), Some(2.0)).unwrap();
    measure(&plan, |_| Ok::<(), Infallible>(())).unwrap()
}

#[test]
fn by_accurate_what_is_heavy_lands_on_what_is_light_and_stays() {
    let slab: &[(&str, f64)] = &[("n", 2.0), ("r", 1e3), ("drop", 0.05)];
    let column: &[(&str, f64)] = &[("n", 6.0), ("r", 100.0), ("gap", 0.01)];
    let boulder: &[(&str, f64)] = &[("n", 3.0), ("r", 1e4), ("drop", 0.2)];
    for (scene, parameters) in [("slab", slab), ("column", column), ("boulder", boulder)] {
        let metrics = run(scene, parameters);
        let moved = metrics.truth.as_ref().expect("an answer").error;
        let sunk = metrics.further_truths[0].error;
        assert!(moved < 1e-3 && sunk < 1e-6, "{scene}: moved by {moved} m, sank by {sunk} m");
    }
}
