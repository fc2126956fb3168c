//! Measurements against cases worked out by hand.

use std::convert::Infallible;

use bevy::math::DVec3;
use plumb::lab::{Metrics, Plan, Sample, measure};
use plumb::physics::{Precision, SolverSettings};
use plumb::scene::SceneSpec;

/// Runs a user's scene at 100 Hz.
fn run(text: &str, steps: u64) -> Metrics {
    let scene = SceneSpec::from_ron(text, "test.ron").unwrap_or_else(|error| panic!("{error}"));
    let settings = SolverSettings { hz: 100.0, precision: Precision::F64, ..SolverSettings::classic() };
    let plan = Plan { scene, built_in: false, parameters: Vec::new(), settings, steps };
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
    let settings = SolverSettings { precision: Precision::F64, ..SolverSettings::default() };
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
