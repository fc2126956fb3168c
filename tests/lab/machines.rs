//! Machines of joints against their answers: linkages, motors, limits, bridges, towers, cars and figures.

use std::convert::Infallible;

use plumb::lab::{Metrics, Plan, measure};
use plumb::physics::SolverSettings;

fn run(name: &str, parameters: &[(&str, f64)], settings: SolverSettings, seconds: Option<f64>) -> Metrics {
    let parameters: Vec<_> = parameters.iter().map(|&(name, value)| (name.to_owned(), value)).collect();
    let plan = Plan::new(name, &parameters, settings, seconds).unwrap();
    let metrics = measure(&plan, |_| Ok::<(), Infallible>(())).unwrap();
    assert!(metrics.quarantined.is_empty(), "{name}: {:?}", metrics.quarantined);
    metrics
}

fn accurate(hz: f64) -> SolverSettings {
    SolverSettings { hz, ..SolverSettings::accurate() }
}

fn game() -> SolverSettings {
    SolverSettings::game()
}

/// The error of the scene's answer, and those of its further ones.
fn errors(metrics: &Metrics) -> Vec<f64> {
    metrics.truth.iter().chain(&metrics.further_truths).map(|truth| truth.error).collect()
}

/// 20 s are some ten turns, each of which passes the flat poses twice.
#[test]
fn a_four_bar_stays_a_parallelogram_through_its_flat_poses() {
    let metrics = run("four_bar", &[("n", 1.0)], accurate(240.0), Some(20.0));
    let [angle, tilt] = errors(&metrics)[..] else { panic!("two answers") };
    assert!(angle < 1e-6 && tilt < 1e-12, "{angle:e} rad, axes {tilt:e} rad");
    assert!(metrics.energy.max_relative_drift.unwrap() < 1e-9, "{:?}", metrics.energy);
    assert!(metrics.joint_error_max_m < 1e-12, "{:e} m", metrics.joint_error_max_m);
}

#[test]
fn forty_four_bars_in_a_row_move_as_one() {
    let metrics = run("four_bar", &[], accurate(1000.0), Some(1.0));
    let angle = errors(&metrics)[0];
    assert!(angle < 1e-4, "{angle:e} rad");
    assert!(metrics.joint_error_max_m < 1e-7, "{:e} m", metrics.joint_error_max_m);
}

/// Overconstrained: one of its thirty rows follows from the others.
#[test]
fn bricards_rods_follow_their_reference() {
    let metrics = run("bricard", &[], accurate(960.0), None);
    let [centres, tilt] = errors(&metrics)[..] else { panic!("two answers") };
    assert!(centres < 1e-9 && tilt < 1e-12, "{centres:e} m, axes {tilt:e} rad");
}

#[test]
fn andrews_squeezer_comes_to_the_published_angles() {
    let error = errors(&run("andrews", &[], accurate(10_000.0), None))[0];
    assert!(error < 2e-5, "{error:e} rad");
}

#[test]
fn an_arm_follows_what_is_prescribed_to_it() {
    let tip = errors(&run("arm", &[], accurate(240.0), None))[0];
    assert!(tip < 1e-8, "{tip:e} m");
    let [tip, _, torques] = errors(&run("arm", &[], game(), None))[..] else { panic!("three answers") };
    assert!(tip < 1e-3 && torques < 0.02, "{tip:e} m, {torques} of the torques' peaks");
}

#[test]
fn a_servo_is_the_damped_oscillator() {
    for (frequency, hz, tolerance) in [(1.0, 240.0, 1e-8), (5.0, 960.0, 1e-8)] {
        for zeta in [0.05, 0.3, 0.7, 1.0] {
            let error = errors(&run("servo", &[("f", frequency), ("zeta", zeta)], accurate(hz), None))[0];
            assert!(error < tolerance, "{frequency} Hz, ζ = {zeta}: {error:e} rad");
        }
    }
}

#[test]
fn a_servo_faster_than_the_steps_does_not_grow() {
    for settings in [game(), accurate(240.0), SolverSettings::steady()] {
        for frequency in [100.0, 1e4] {
            let error = errors(&run("servo", &[("f", frequency), ("zeta", 0.7)], settings, None))[0];
            assert!(error < 1.0 + 1e-9, "{frequency} Hz: {error:e} rad");
        }
    }
}

#[test]
fn a_limit_holds_a_rod_that_falls_on_it() {
    let [angle, overshoot, torque] = errors(&run("stop", &[], game(), None))[..] else { panic!("three answers") };
    // It comes up to a step late or early, at 4 rad/s.
    assert!(angle < 0.05 && overshoot < 1e-3 && torque < 0.01, "{angle} rad, {overshoot:e} rad, {torque}");
}

#[test]
fn a_chain_of_hinges_does_not_tilt() {
    let metrics = run("hinge_chain", &[("n", 30.0), ("r", 300.0)], accurate(240.0), Some(2.0));
    assert!(errors(&metrics)[0] < 1e-9, "{:e} rad", errors(&metrics)[0]);
    assert!(metrics.joint_error_max_m < 1e-9, "{:e} m", metrics.joint_error_max_m);
}

#[test]
fn a_bridge_hangs_in_its_catenary() {
    for (settings, moves, share) in [(accurate(240.0), 1e-8, 1e-6), (game(), 1e-3, 0.02)] {
        let [moved, tension] = errors(&run("bridge", &[], settings, Some(2.0)))[..] else { panic!("two answers") };
        assert!(moved < moves && tension < share, "{moved:e} m, tensions off by {tension:e}");
    }
}

#[test]
fn a_towers_rods_carry_a_quarter_each() {
    for (settings, share) in [(accurate(240.0), 1e-6), (game(), 0.01)] {
        let [moved, loads] = errors(&run("tower", &[], settings, Some(0.5)))[..] else { panic!("two answers") };
        assert!(moved < 1e-3 && loads < share, "{moved:e} m, loads off by {loads:e}");
    }
}

#[test]
fn a_car_accelerates_by_its_motors_torques_over_its_inertia() {
    for speed in [1000.0, 10.0, 0.0] {
        let parameters = [("sprung", 0.0), ("speed", speed)];
        let metrics = run("car", &parameters, game(), None);
        let error = errors(&metrics)[0];
        assert!(error < 0.06, "{speed} rad/s: {error} m/s");
    }
}

#[test]
fn ragdolls_keep_their_joints_and_limits_on_stairs() {
    let metrics = run("ragdolls", &[], game(), None);
    let [overshoot, _] = errors(&metrics)[..] else { panic!("two answers") };
    assert!(overshoot < 0.05, "{overshoot} rad");
    assert!(metrics.joint_error_max_m < 0.01, "{} m", metrics.joint_error_max_m);
}
