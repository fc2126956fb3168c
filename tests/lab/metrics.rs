//! Measurements against cases worked out by hand.

use std::convert::Infallible;

use bevy::math::DVec3;
use plumb::lab::verdict::{Verdict, judge};
use plumb::lab::{Metrics, Plan, Sample, measure};
use plumb::physics::{FrictionModel, ImpulseSettings, Integrator, Precision, SolverSettings, SweepSettings};
use plumb::scene::SceneSpec;

/// Runs a user's scene at 100 Hz.
fn run(text: &str, steps: u64) -> Metrics {
    let scene = SceneSpec::from_ron(text, "test.ron").unwrap_or_else(|error| panic!("{error}"));
    let settings = SolverSettings { hz: 100.0, precision: Precision::F64, ..SolverSettings::classic() };
    let plan = Plan { scene, built_in: false, converge: false, parameters: Vec::new(), settings, steps };
    measure(&plan, |_| Ok::<(), Infallible>(())).unwrap()
}

#[track_caller]
fn close(value: f64, expected: f64) {
    assert!((value - expected).abs() <= 1e-11 * expected.abs().max(1.0), "{value}, not {expected}");
}

#[test]
fn free_fall_has_the_energy_sink_and_drift_of_symplectic_euler() {
    let body = r#"(name: "ball", shape: Sphere(radius: 0.5), mass: 2, position: (0, 9, 0), velocity: (3, 0, 4))"#;
    let metrics = run(&format!("(gravity: (0, -9.81, 0), bodies: [{body}])"), 100);
    let (mass, gravity, step, steps) = (2.0, 9.81_f64, 0.01, 100.0);
    let fallen = gravity * step * step * steps * (steps + 1.0) / 2.0;
    let kinetic_start = 0.5 * mass * 25.0;
    let kinetic_end = kinetic_start + 0.5 * mass * (gravity * step * steps).powi(2);
    let lost = mass * gravity * fallen - (kinetic_end - kinetic_start);
    close(metrics.energy.start, kinetic_start);
    close(metrics.energy.end, kinetic_start - lost);
    close(metrics.energy.max_relative_drift.unwrap(), lost / kinetic_end);
    close(metrics.sink_max_m, fallen);
    close(metrics.drift_max_m, 5.0);
    assert_eq!((metrics.bodies, metrics.joints, metrics.contacts), (1, 0, 0));
    assert_eq!((metrics.joint_error_max_m, metrics.penetration_max_m), (0.0, 0.0));
    assert_eq!(metrics.truth, None);
}

#[test]
fn energy_counts_spin_and_each_bodys_own_gravity() {
    let text = r#"(gravity: (0, -10, 0), bodies: [
        (name: "spinner", shape: Sphere(radius: 0.5), mass: 10, angular_velocity: (0, 3, 0), gravity_scale: 0),
        (name: "riser", shape: Sphere(radius: 0.5), mass: 1, position: (5, 0, 0), gravity_scale: -1),
        (name: "post", kind: Static, shape: Sphere(radius: 0.5), position: (9, 0, 0)),
    ])"#;
    let metrics = run(text, 1);
    // 2/5 m r² = 1 kg m².
    close(metrics.energy.start, 4.5);
    // Rises by g h² = 1 mm at g h = 0.1 m/s.
    close(metrics.energy.end, 4.5 + 0.5 * 0.01 - 10.0 * 0.001);
    assert_eq!(metrics.sink_max_m, 0.0);
}

/// What a force of the scene puts in is no energy gained: a slab pushed over the ground only loses some to friction.
#[test]
fn the_work_of_a_scenes_forces_is_no_gain() {
    let settings = SolverSettings { hz: 1000.0, ..SolverSettings::accurate() };
    let plan = Plan::new("rolling", &[], settings, Some(0.5)).unwrap();
    let metrics = measure(&plan, |_| Ok::<(), Infallible>(())).unwrap();
    // What friction takes: 0.4 times the weight over the way of 10 kg and the balls' 2/7 of 25 kg.
    let friction = 0.4 * 35.0 * 9.81;
    let way = 0.5 * (150.0 - friction) / (10.0 + 25.0 * 2.0 / 7.0) * 0.5 * 0.5;
    let lost = friction * way;
    assert!((metrics.energy.end + lost).abs() < 1e-8 * lost, "{} J, not {}", metrics.energy.end, -lost);
    assert!(metrics.shares.energy_rise.unwrap() < 1e-9, "{:?}", metrics.shares.energy_rise);
}

#[test]
fn a_scene_where_nothing_moves_has_no_relative_drift() {
    let metrics = run(r#"(bodies: [(name: "post", kind: Static, shape: Sphere(radius: 0.5))])"#, 3);
    assert_eq!(metrics.energy.max_relative_drift, None);
    assert_eq!((metrics.drift_max_m, metrics.sink_max_m), (0.0, 0.0));
}

#[test]
fn a_buried_box_shows_its_depth_and_its_contacts() {
    let text = r#"(bodies: [
        (name: "ground", kind: Static, shape: HalfSpace),
        (name: "box", shape: Cuboid(size: (1, 1, 1)), position: (0, 0.46, 0)),
    ])"#;
    let metrics = run(text, 1);
    close(metrics.penetration_max_m, 0.04);
    assert_eq!(metrics.contacts, 4);
}

#[test]
fn joint_error_is_the_largest_gap_between_the_anchors() {
    let settings = SolverSettings::classic();
    let plan = Plan::new("pendulum", &[], settings, Some(1.0)).unwrap();
    let anchor = plan.scene.joints[0].anchor_b;
    let mut gap: f64 = 0.0;
    let metrics = measure(&plan, |sample: &Sample| {
        let rod = sample.bodies[1];
        gap = gap.max((rod.position + rod.rotation * anchor - DVec3::ZERO).length());
        Ok::<(), Infallible>(())
    })
    .unwrap();
    assert!(gap > 1e-4, "classic lets joints give way");
    close(metrics.joint_error_max_m, gap);
}

#[test]
fn a_scene_at_rest_measures_its_energy_against_weight_times_height() {
    // With springs that give way.
    let settings = SolverSettings {
        precision: Precision::F64,
        impulse: ImpulseSettings { fitted_effort: false, sleep_speed: Some(0.02) },
        ..SolverSettings::default()
    };
    let plan = Plan::new("stack", &[("n".into(), 2.0)], settings, Some(0.5)).unwrap();
    let mut lowest = [0.0_f64; 2];
    let metrics = measure(&plan, |sample| {
        for (lowest, (state, start)) in lowest.iter_mut().zip(sample.bodies[1..].iter().zip([0.5, 1.5])) {
            *lowest = state.position.y - start;
        }
        Ok::<(), Infallible>(())
    })
    .unwrap();
    // Two cubes of 1000 kg under g = 10, 2 m high; kinetic energy is next to nothing.
    let drift = metrics.energy.max_relative_drift.unwrap();
    let sunk = -(lowest[0] + lowest[1]) / 4.0;
    assert!(sunk > 1e-5 && (drift - sunk).abs() < 0.2 * sunk, "{drift} {sunk}");
}

/// A body with its centre half a metre over the ground, g = 10.
fn on_the_ground(body: &str, settings: SolverSettings, steps: u64) -> Metrics {
    let ground = r#"(name: "ground", kind: Static, shape: HalfSpace, friction: 0.5)"#;
    measured(&format!(r#"{ground}, (name: "body", position: (0, 0.5, 0), friction: 0.5, {body})"#), settings, steps)
}

fn measured(bodies: &str, settings: SolverSettings, steps: u64) -> Metrics {
    let text = format!("(gravity: (0, -10, 0), bodies: [{bodies}])");
    let scene = SceneSpec::from_ron(&text, "test.ron").unwrap_or_else(|error| panic!("{error}"));
    let plan = Plan { scene, built_in: false, converge: false, parameters: Vec::new(), settings, steps };
    measure(&plan, |_| Ok::<(), Infallible>(())).unwrap()
}

/// One contact point.
const BALL: &str = "shape: Sphere(radius: 0.5)";
/// Four.
const CUBE: &str = "shape: Cuboid(size: (1, 1, 1))";

/// Contacts without what keeps them from the plain laws.
fn plain(substeps: u32, integrator: Integrator) -> SolverSettings {
    let steady = SolverSettings::steady();
    SolverSettings {
        precision: Precision::F64,
        iterations: 200,
        substeps,
        sweeps: SweepSettings { integrator, ..steady.sweeps },
        slop: 0.0,
        restitution_speed: Some(0.0),
        ..steady
    }
}

#[test]
fn converged_contacts_obey_their_laws() {
    let variants = [(1, Integrator::Euler), (4, Integrator::Euler), (1, Integrator::VelocityVerlet)];
    for (substeps, integrator) in variants {
        let check = |what: &str, metrics: Metrics| {
            let residual = metrics.contact_residual.expect("it touches the ground");
            assert!(residual.last < 1e-6, "{what}, {substeps} {integrator:?}: {residual:?}");
            assert!(residual.worst >= residual.last);
        };
        const UPRIGHT: &str = "locked: (rotation: (true, true, true))";
        for (what, more) in [
            ("rests", ""),
            ("slides", &*format!("velocity: (2, 0, 1), {UPRIGHT}")),
            ("is pushed and sticks", &*format!("force: (2000, 0, 0), {UPRIGHT}")),
            ("is pushed and slides", &*format!("force: (4000, 0, 0), {UPRIGHT}")),
            ("slides and rolls", "velocity: (2, 0, 1)"),
            ("is pushed and rolls", "force: (4000, 0, 0)"),
            ("is pushed and spins", "force: (20000, 0, 0)"),
        ] {
            // Within a step, the point that touched turns with the ball, off the ground: a second
            // solve finds a gap there.
            let solves = if integrator == Integrator::VelocityVerlet { 2 } else { substeps };
            let turns = solves > 1 && !more.is_empty() && !more.contains(UPRIGHT);
            if !turns {
                check(what, on_the_ground(&format!("{BALL}, {more}"), plain(substeps, integrator), 20));
            }
        }
        // Four points, which with friction could brace themselves against each other.
        let frictionless = SolverSettings { friction: FrictionModel::Off, ..plain(substeps, integrator) };
        let cube = r#"(name: "ground", kind: Static, shape: HalfSpace, friction: 0),
                      (name: "cube", shape: Cuboid(size: (1, 1, 1)), position: (0, 0.5, 0))"#;
        check("cube rests", measured(cube, frictionless, 20));
    }
}

#[test]
fn a_contact_that_bounces_by_its_restitution_obeys_the_law_too() {
    let bounce = |restitution_speed| {
        let settings = SolverSettings { restitution_speed, ..plain(1, Integrator::Euler) };
        let metrics = on_the_ground(&format!("{BALL}, velocity: (0, -3, 0), restitution: 0.5"), settings, 1);
        metrics.contact_residual.unwrap().worst
    };
    assert!(bounce(Some(0.0)) < 1e-6, "{}", bounce(Some(0.0)));
    assert!((bounce(None) - 0.5).abs() < 1e-6, "it should have left at 1.5 m/s: {}", bounce(None));
}

#[test]
fn what_a_solve_leaves_undone_shows_in_the_contacts_laws() {
    let heavy_on_light = r#"(name: "ground", kind: Static, shape: HalfSpace, friction: 0),
        (name: "light", shape: Sphere(radius: 0.5), position: (0, 0.5, 0)),
        (name: "heavy", shape: Sphere(radius: 0.5), mass: 50000, position: (0, 1.5, 0))"#;
    let residual = |iterations| {
        let mut settings = SolverSettings { iterations, ..plain(1, Integrator::Euler) };
        settings.sweeps.warm_starting = false;
        measured(heavy_on_light, settings, 1).contact_residual.unwrap().worst
    };
    let (few, many) = (residual(2), residual(20_000));
    assert!(few > 0.1 && many < 1e-6, "{few} {many}");
    // The 2009 friction does not know how hard a contact presses: each of the four points that slide
    // is slowed as if it carried all.
    let classic = SolverSettings { iterations: 200, precision: Precision::F64, ..SolverSettings::classic() };
    let flawed = on_the_ground(&format!("{CUBE}, velocity: (2, 0, 0)"), classic, 5).contact_residual.unwrap();
    assert!(flawed.worst > 0.02, "{flawed:?}");
}

#[test]
fn forces_of_scenes_at_rest_are_held_against_statics() {
    let settings = |iterations| SolverSettings { iterations, precision: Precision::F64, ..SolverSettings::default() };
    let force_error = |scene: &str, n: f64, iterations: u32| {
        let plan = Plan::new(scene, &[("n".into(), n)], settings(iterations), Some(3.0)).unwrap();
        measure(&plan, |_| Ok::<(), Infallible>(())).unwrap().force_error.expect("statics says")
    };
    for (scene, n) in [("stack", 3.0), ("pyramid", 3.0), ("hanging", 4.0), ("joint_grid", 3.0)] {
        let error = force_error(scene, n, 200);
        assert!(error < 0.01, "{scene}: {error}");
    }
    let few = SolverSettings { iterations: 1, ..SolverSettings::steady() };
    let plan = Plan::new("hanging", &[("n".into(), 30.0)], few, Some(3.0)).unwrap();
    let error = measure(&plan, |_| Ok::<(), Infallible>(())).unwrap().force_error.unwrap();
    assert!(error > 0.01, "one sweep is not enough for a chain of 30: {error}");
    let slide = Plan::new("slide_roll", &[], settings(10), Some(0.1)).unwrap();
    assert_eq!(measure(&slide, |_| Ok::<(), Infallible>(())).unwrap().force_error, None);
}

#[test]
fn jitter_is_measured_where_all_should_rest() {
    let jitter = |scene: &str| {
        let plan = Plan::new(scene, &[], SolverSettings::default(), Some(0.5)).unwrap();
        measure(&plan, |_| Ok::<(), Infallible>(())).unwrap().jitter_m_per_s
    };
    assert_eq!(jitter("slide_roll"), None);
    assert!(jitter("sandwich").is_some_and(|speed| speed > 0.0 && speed < 0.1), "{:?}", jitter("sandwich"));
}

#[test]
fn momentum_drifts_only_where_nothing_outside_takes_part() {
    let spheres = r#"(gravity: (0, -9.81, 0), bodies: [
        (name: "a", shape: Sphere(radius: 0.5), velocity: (2, 0, 0), angular_velocity: (0, 0, 5)),
        (name: "b", shape: Sphere(radius: 0.5), position: (1.5, 0.3, 0)),
    ])"#;
    let metrics = run(spheres, 60);
    let momentum = metrics.momentum;
    // They collide: without friction rows' rounding nothing is left. Single steps round at 1e-16.
    assert!(momentum.linear_max_relative_drift.unwrap() < 1e-6, "{momentum:?}");
    assert!(momentum.angular_max_relative_drift.is_some(), "{momentum:?}");
    let on_ground = on_the_ground(CUBE, SolverSettings::default(), 2).momentum;
    assert_eq!((on_ground.linear_max_relative_drift, on_ground.angular_max_relative_drift), (None, None));
}

#[test]
fn a_run_fails_where_the_scenes_own_condition_breaks() {
    let judged = |scene: &str, parameters: &[(&str, f64)], settings: SolverSettings, seconds: f64| {
        let parameters: Vec<_> = parameters.iter().map(|&(name, value)| (name.to_owned(), value)).collect();
        let plan = Plan::new(scene, &parameters, settings, Some(seconds)).unwrap();
        judge(&measure(&plan, |_| Ok::<(), Infallible>(())).unwrap())
    };
    // A step of 1.7 m takes the ball through 1 cm of wall, and nothing else is amiss.
    let passes = judged("wall", &[("v", 100.0), ("t", 0.01)], SolverSettings::classic(), 0.5);
    assert_eq!(passes.verdict, Verdict::Fails, "{passes:?}");
    assert!(passes.reason.contains("beyond the wall's face") && passes.reason.contains(" m"), "{passes:?}");
    let stops = judged("wall", &[("v", 0.5), ("t", 1.0)], SolverSettings::default(), 1.0);
    assert!(stops.verdict <= Verdict::Degrades, "{stops:?}");
    let near = judged("far", &[("d", 1024.0)], SolverSettings::default(), 0.1);
    assert_ne!(near.verdict, Verdict::Fails, "{near:?}");
}
