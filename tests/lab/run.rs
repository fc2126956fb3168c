//! Running scenes: planning, time, and the same states every time.

use std::convert::Infallible;

use plumb::lab::{MOST_STEPS, Plan, PlanError, Simulation, measure};
use plumb::physics::SolverSettings;
use plumb::scene::load;

fn plan(scene: &str, settings: SolverSettings, seconds: f64) -> Plan {
    Plan::new(scene, &[], settings, Some(seconds)).unwrap()
}

fn hash_after(scene: &str, n: Option<f64>, settings: SolverSettings, steps: u32) -> u64 {
    let parameters: Vec<(String, f64)> = n.map(|n| ("n".to_owned(), n)).into_iter().collect();
    let mut simulation = Simulation::new(load(scene, &parameters).unwrap(), settings);
    (0..steps).for_each(|_| simulation.step());
    simulation.state_hash()
}

#[test]
fn states_are_the_same_in_every_run_and_for_any_number_of_threads() {
    // The last two are one large group each, whose stages all threads walk together.
    for (scene, n, steps) in
        [("limbs", None, 90), ("pyramid", None, 90), ("pyramid", Some(45.0), 10), ("joint_grid", Some(30.0), 30)]
    {
        for (preset, settings) in SolverSettings::PRESETS {
            if n.is_some() && preset != "game" {
                continue;
            }
            let with_threads = |threads| hash_after(scene, n, SolverSettings { threads, ..settings() }, steps);
            let first = with_threads(1);
            for threads in [1, 2, 4] {
                assert_eq!(first, with_threads(threads), "{scene}, {preset}, {threads} threads");
            }
        }
    }
}

#[test]
fn the_state_hash_tells_the_last_bit_of_one_body() {
    let scene = load("limbs", &[]).unwrap();
    let hash = |edit: fn(&mut f64)| {
        let mut scene = scene.clone();
        edit(&mut scene.bodies.last_mut().unwrap().angular_velocity.z);
        let mut simulation = Simulation::new(scene, SolverSettings::default());
        simulation.step();
        simulation.state_hash()
    };
    assert_eq!(hash(|_| ()), hash(|_| ()));
    assert_ne!(hash(|_| ()), hash(|rate| *rate += 1e-9));
}

#[test]
fn a_run_takes_the_steps_nearest_to_its_length() {
    let settings = SolverSettings { hz: 7.0, ..SolverSettings::default() };
    for (seconds, steps) in [(1.0, 7), (1.08, 8), (0.01, 1)] {
        let mut times = Vec::new();
        let metrics = measure(&plan("pendulum", settings, seconds), |sample| {
            times.push((sample.step, sample.time));
            Ok::<(), Infallible>(())
        })
        .unwrap();
        assert_eq!(metrics.steps, steps);
        assert_eq!(metrics.seconds, steps as f64 / 7.0);
        assert_eq!(times, (0..=steps).map(|n| (n, n as f64 / 7.0)).collect::<Vec<_>>());
    }
}

#[test]
fn the_first_error_of_a_watcher_ends_the_run() {
    let mut seen = 0;
    let result = measure(&plan("pendulum", SolverSettings::default(), 1.0), |sample| {
        seen += 1;
        if sample.step == 5 { Err("enough") } else { Ok(()) }
    });
    assert_eq!((result, seen), (Err("enough"), 6));
}

#[test]
fn a_plan_without_length_takes_the_scenes_own() {
    let settings = SolverSettings::default();
    let plan = Plan::new("bounce", &[("e".into(), 0.25)], settings, None).unwrap();
    assert_eq!(plan.steps, 1200);
    assert_eq!(plan.parameters, [("e".to_owned(), 0.25), ("height".to_owned(), 5.0)]);
    assert_eq!(Plan::new("stack", &[], settings, None).unwrap().parameters.len(), 2, "defaults are listed too");
}

#[test]
fn a_plan_that_makes_no_sense_is_refused() {
    let settings = SolverSettings::default();
    let refusal = |settings, seconds| Plan::new("pendulum", &[], settings, seconds).unwrap_err();
    assert!(matches!(refusal(settings, Some(f64::NAN)), PlanError::Seconds(_)));
    assert!(matches!(refusal(settings, Some(0.0)), PlanError::Seconds(_)));
    let too_long = (MOST_STEPS + 1) as f64 / settings.hz;
    assert!(matches!(refusal(settings, Some(too_long)), PlanError::TooManySteps { .. }));
    let bad = SolverSettings { slop: -1.0, ..settings };
    assert!(matches!(refusal(bad, Some(1.0)), PlanError::Settings(_)));
    assert!(matches!(Plan::new("nothing", &[], settings, None).unwrap_err(), PlanError::Scene(_)));
}
