//! Anything that hands can do, at random: nothing breaks, and what does is recorded.

use std::path::PathBuf;

use plumb::lab::command::MonkeyRun;
use plumb::prelude::SolverSettings;
use plumb::sandbox::{Played, play};

/// Steps of all runs together.
const STEPS: u64 = 2_000;

fn monkey(scene: &str, seed: u64, steps: u64) -> Played {
    let (parameters, settings, out) = (Vec::new(), SolverSettings::default(), PathBuf::new());
    play(&MonkeyRun { scene: scene.into(), parameters, settings, seed, steps, out }, |_| ()).unwrap()
}

#[test]
fn a_monkey_breaks_nothing() {
    for (scene, seed) in [("limbs", 1), ("limbs", 2), ("car", 3)] {
        let played = monkey(scene, seed, STEPS / 3);
        if let Some(failure) = played.failure {
            panic!("{scene}, seed {seed}, {:?}: {}\n{}", failure.place, failure.problem, failure.deeds.join("\n"));
        }
        assert!(played.steps >= STEPS / 3 && played.checks >= 10, "{played:?}");
        assert!(played.deeds.len() > 8, "{played:?}");
    }
}
