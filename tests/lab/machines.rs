//! Machines of joints against their answers: linkages, motors, limits, bridges, towers, cars and figures.

use std::convert::Infallible;
use std::f64::consts::FRAC_PI_2;

use bevy::math::DQuat;
use plumb::lab::{Metrics, Plan, Simulation, measure};
use plumb::physics::{BrokenJoint, SolverSettings, Velocity};
use plumb::scene::{ShapeSpec, load};

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
    assert!(angle < 1e-9 && tilt < 1e-12, "{angle:e} rad, axes {tilt:e} rad");
    assert!(metrics.energy.max_relative_drift.unwrap() < 1e-11, "{:?}", metrics.energy);
    assert!(metrics.joint_error_max_m < 1e-12, "{:e} m", metrics.joint_error_max_m);
}

#[test]
fn forty_four_bars_in_a_row_move_as_one() {
    let metrics = run("four_bar", &[], accurate(1000.0), Some(1.0));
    let angle = errors(&metrics)[0];
    assert!(angle < 1e-4, "{angle:e} rad");
    assert!(metrics.joint_error_max_m < 1e-7, "{:e} m", metrics.joint_error_max_m);
}

/// Overconstrained: one of its thirty rows follows from the others. Where solves end before their residual does, the
/// rods are off by 0.2 mm.
#[test]
fn bricards_rods_follow_their_reference() {
    let metrics = run("bricard", &[], accurate(240.0), None);
    let [centres, tilt] = errors(&metrics)[..] else { panic!("two answers") };
    assert!(centres < 1e-9 && tilt < 1e-12, "{centres:e} m, axes {tilt:e} rad");
    assert!(metrics.energy.max_relative_drift.unwrap() < 1e-11, "{:?}", metrics.energy);
}

/// The published angles are met to 1.4e-9 rad at 10 kHz and at any rate above.
#[test]
fn andrews_squeezer_comes_to_the_published_angles() {
    let error = errors(&run("andrews", &[], accurate(10_000.0), None))[0];
    assert!(error < 1e-8, "{error:e} rad");
}

#[test]
fn an_arm_follows_what_is_prescribed_to_it() {
    let [tip, torques, _] = errors(&run("arm", &[], accurate(240.0), None))[..] else { panic!("three answers") };
    assert!(tip < 1e-8 && torques < 1e-6, "{tip:e} m, {torques:e} N·m");
    let [tip, _, torques] = errors(&run("arm", &[], game(), None))[..] else { panic!("three answers") };
    // Its impulses are those of half a substep before: 2.1 % where a torque changes fastest.
    assert!(tip < 1e-3 && torques < 0.025, "{tip:e} m, {torques} of the torques' peaks");
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
    let rates = [100.0, 1e4];
    for (settings, frequencies) in
        [(game(), &rates[..1]), (accurate(240.0), &rates), (SolverSettings::steady(), &rates)]
    {
        for &frequency in frequencies {
            let error = errors(&run("servo", &[("f", frequency), ("zeta", 0.7)], settings, None))[0];
            assert!(error < 1.0 + 1e-9, "{frequency} Hz: {error:e} rad");
        }
    }
}

/// An error of the time of a stop shows in the angle with twice the speed, 5 rad/s, and adds up.
#[test]
fn a_rod_meets_its_limit_at_its_time_and_rests_there_or_keeps_its_energy() {
    let [angle, overshoot, torque] = errors(&run("stop", &[], accurate(240.0), None))[..] else { panic!("three") };
    assert!(angle < 1e-10 && overshoot < 1e-10 && torque < 1e-10, "{angle:e} {overshoot:e} rad, {torque:e}");
    // A hundred stops.
    let metrics = run("stop", &[("e", 1.0)], accurate(240.0), Some(100.0));
    let [angle, overshoot] = errors(&metrics)[..] else { panic!("two answers") };
    assert!(angle < 1e-8 && overshoot < 1e-10, "{angle:e} {overshoot:e} rad");
    assert!(metrics.energy.max_relative_drift.unwrap() < 1e-9, "{:?}", metrics.energy);
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

/// Where a solve leaves rows of joints unsatisfied as limits hit, the light boxes tilt by hundredths of a radian.
#[test]
fn limits_that_a_heavy_ball_hits_do_not_part_a_chain_of_hinges() {
    for (n, ratio, limit, seconds) in [(1.0, 1e4, 30.0, 1.0), (2.0, 1e4, 30.0, 2.0), (100.0, 1e3, 45.0, 0.25)] {
        let parameters = [("n", n), ("r", ratio), ("limit", limit)];
        let metrics = run("hinge_chain", &parameters, SolverSettings::accurate(), Some(seconds));
        let [tilt, overshoot] = errors(&metrics)[..] else { panic!("two answers") };
        assert!(tilt < 1e-9 && overshoot < 1e-8, "{n}, {ratio} kg: {tilt:e} rad, {overshoot:e} rad over");
        assert!(metrics.joint_error_max_m < 1e-9, "{n}, {ratio} kg: {:e} m", metrics.joint_error_max_m);
        assert_eq!(metrics.exact.unwrap().unsettled, 0, "{n}, {ratio} kg");
    }
}

/// Where two hinges near their limits knock each other off, each time by less, thousands of impacts follow each other within
/// a microsecond.
#[test]
fn limits_that_knock_each_other_off_come_to_rest() {
    let parameters = [("n", 10.0), ("r", 1.0), ("limit", 30.0)];
    let metrics = run("hinge_chain", &parameters, SolverSettings::accurate(), Some(5.0));
    let [tilt, overshoot] = errors(&metrics)[..] else { panic!("two answers") };
    assert!(tilt < 1e-9 && overshoot < 1e-8, "{tilt:e} rad, {overshoot:e} rad over");
    assert_eq!(metrics.exact.unwrap().unsettled, 0);
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

/// What breaks after a second and a half, when strength has counted for half a second, of a tower at that share of its
/// lowest rods' load.
fn broken(settings: SolverSettings, share: f64) -> usize {
    let weight = (5.0 * 100.0 + 20.0) * 9.81;
    let strength = ("f".to_owned(), share * 0.25 * weight);
    let mut simulation = Simulation::new(load("tower", &[strength]).unwrap(), settings);
    (0..(1.5 * settings.hz) as u32).for_each(|_| simulation.step());
    let joints = simulation.entities().joints.iter();
    joints.filter(|&&joint| simulation.world().get::<BrokenJoint>(joint).is_some()).count()
}

#[test]
fn a_tower_snaps_at_the_load_of_its_lowest_rods() {
    for (settings, margin) in [(accurate(240.0), 1e-3), (game(), 0.02)] {
        assert_eq!(broken(settings, 1.0 + margin), 0, "it stands");
        assert!(broken(settings, 1.0 - margin) >= 4, "it snaps");
    }
}

/// Later the ground may bear it on two wheels across from each other: how four rigid wheels share its weight is not
/// unique, and a wheel that bears nothing spins.
#[test]
fn a_car_accelerates_to_rounding_by_its_motors_torques() {
    let error = errors(&run("car", &[("sprung", 0.0), ("speed", 1000.0)], accurate(240.0), Some(1.0)))[0];
    assert!(error < 1e-8, "{error:e} m/s");
}

#[test]
fn a_car_accelerates_by_its_motors_torques_over_its_inertia() {
    // Each motor could bring its own wheel to the slower of these at once, were it not on the ground.
    for speed in [1000.0, 10.0, 0.0] {
        let parameters = [("sprung", 0.0), ("speed", speed)];
        let metrics = run("car", &parameters, game(), Some(3.0));
        let error = errors(&metrics)[0];
        assert!(error < 1e-3, "{speed} rad/s: {error} m/s");
        assert!(metrics.sink_max_m < 1e-3, "{speed} rad/s: it sinks by {} m", metrics.sink_max_m);
    }
}

/// From 22 rad/s on, the steps of a wheel 0.25 m wide are such that it may reach the chassis 0.275 m beside it: a gap ahead
/// is no brake.
#[test]
fn a_car_on_cylinders_goes_faster_with_each_step() {
    let mut scene = load("car", &[("speed".to_owned(), 60.0)]).unwrap();
    for wheel in scene.bodies.iter_mut().filter(|body| body.name.ends_with("wheel")) {
        wheel.shape = Some(ShapeSpec::Cylinder { radius: 0.35, height: 0.25 });
        wheel.rotation = DQuat::from_rotation_x(FRAC_PI_2);
    }
    let index = scene.bodies.iter().position(|body| body.name == "chassis").unwrap();
    let mut simulation = Simulation::new(scene, game());
    let chassis = simulation.entities().bodies[index];
    let mut speed = 0.0;
    for step in 0..480 {
        simulation.step();
        let now = simulation.world().get::<Velocity>(chassis).unwrap().linear.x;
        assert!(now > speed - 1e-3, "from {speed} to {now} m/s in step {step}");
        speed = now;
    }
    assert!(speed > 9.0, "{speed} m/s");
}

#[test]
fn a_row_of_hinges_keeps_to_its_plane_and_limits_at_speed() {
    for limit in [0.0, 45.0] {
        let metrics = run("hinge_chain", &[("limit", limit)], game(), Some(3.0));
        assert!(metrics.joint_error_max_m < 1e-6, "{limit}°: {:e} m", metrics.joint_error_max_m);
        let (tilt, overshoot) = (errors(&metrics)[0], errors(&metrics).get(1).copied().unwrap_or(0.0));
        assert!(tilt < 1e-5 && overshoot < 0.1_f64.to_radians(), "{limit}°: {tilt:e} rad, {overshoot:e} rad");
    }
}

/// Its light end turns by more than a right angle in a substep.
#[test]
fn a_whip_of_hinges_holds_through_its_crack() {
    for limit in [0.0, 45.0] {
        let metrics = run("hinge_chain", &[("n", 50.0), ("r", 1.0), ("limit", limit)], game(), Some(7.0));
        assert!(metrics.joint_error_max_m < 1e-3, "{limit}°: {:e} m", metrics.joint_error_max_m);
        assert!(errors(&metrics).iter().all(|&error| error < 1e-3), "{limit}°: {:?} rad", errors(&metrics));
    }
}

/// Until it lies, a second after it is dropped.
#[test]
fn a_ragdoll_keeps_its_joints_and_limits_to_rounding() {
    let metrics = run("ragdolls", &[], accurate(240.0), Some(1.0));
    let worst = errors(&metrics).into_iter().fold(metrics.joint_error_max_m, f64::max);
    assert!(worst < 1e-8, "{worst:e} m or rad");
}

#[test]
fn ragdolls_keep_their_joints_and_limits_on_stairs() {
    for (n, seconds) in [(1.0, 5.0), (10.0, 2.0)] {
        let metrics = run("ragdolls", &[("n", n)], game(), Some(seconds));
        let [overshoot, _] = errors(&metrics)[..] else { panic!("two answers") };
        assert!(overshoot < 0.5_f64.to_radians(), "{n}: {overshoot} rad");
        assert!(metrics.joint_error_max_m < 1e-3, "{n}: {} m", metrics.joint_error_max_m);
    }
}
