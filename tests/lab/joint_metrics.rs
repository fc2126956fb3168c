//! What a run tells of its joints: gaps by kind, limits, loads and what broke, against cases worked out by hand.

use std::convert::Infallible;
use std::f64::consts::TAU;
use std::slice::from_ref;

use bevy::math::{DQuat, DVec3};
use plumb::lab::verdict::judge;
use plumb::lab::{BodyState, JointGap, Metrics, Plan, Simulation, measure};
use plumb::physics::{BrokenJoint, SolverSettings};
use plumb::scene::{SceneSpec, load};

/// Runs a user's scene, and has every state after a step looked at.
fn run(text: &str, settings: SolverSettings, steps: u64, mut look: impl FnMut(&[BodyState])) -> Metrics {
    let scene = SceneSpec::from_ron(text, "test.ron").unwrap_or_else(|error| panic!("{error}"));
    let plan = Plan { scene, built_in: false, converge: false, parameters: Vec::new(), settings, steps };
    let metrics = measure(&plan, |sample| {
        if sample.step > 0 {
            look(sample.bodies);
        }
        Ok::<(), Infallible>(())
    });
    metrics.unwrap()
}

#[track_caller]
fn close(value: f64, expected: f64) {
    assert!((value - expected).abs() <= 1e-9 * expected.abs().max(1.0), "{value}, not {expected}");
}

/// A body of its own for a joint of each kind, whose frame A is at the origin of the world. Along the hinge's axis is y.
const KINDS: [(&str, &str); 6] = [
    ("ball", ""),
    ("hinge", "kind: Hinge, frames: ((0, 0, 1, 1), (0, 0, 1, 1))"),
    ("slider", "kind: Slider, frames: ((0, 0, 0, 1), (0, 0, 0, 1))"),
    ("fixed", "kind: Fixed, frames: ((0, 0, 0, 1), (0, 0, 0, 1))"),
    ("distance", "kind: Rod(length: 0.75)"),
    (
        "generic",
        "kind: Generic(translations: (true, false, false), rotations: (false, true, false)), frames: ((0, 0, 0, 1), \
         (0, 0, 0, 1))",
    ),
];

/// What that kind is off by: m, and rad where it holds an angle.
fn expected(kind: &str, body: &BodyState) -> (f64, Option<f64>) {
    let anchor = body.position + body.rotation * DVec3::new(-0.5, 0.0, 0.0);
    let turned = body.rotation.angle_between(DQuat::IDENTITY);
    match kind {
        "ball" => (anchor.length(), None),
        "hinge" => (anchor.length(), Some((body.rotation * DVec3::Y).angle_between(DVec3::Y))),
        "slider" => (anchor.y.hypot(anchor.z), Some(turned)),
        "fixed" => (anchor.length(), Some(turned)),
        "distance" => ((body.position.length() - 0.75).abs(), None),
        // A right angle between A's z and B's x.
        _ => (anchor.x.abs(), Some((body.rotation * DVec3::X).dot(DVec3::Z).asin().abs())),
    }
}

#[test]
fn gaps_are_told_by_kind_in_metres_and_radians() {
    let mut text = String::from("(gravity: (0, -9.81, 0), bodies: [");
    for (kind, _) in KINDS {
        let at = if kind == "distance" { 0.75 } else { 0.5 };
        text += &format!(
            r#"(name: "{kind}", shape: Cuboid(size: (1, 0.2, 0.3)), position: ({at}, 0, 0), velocity: (1, 2, 3),
            angular_velocity: (2, 4, -3), rotation_degrees: (5, 10, -8), layers: (memberships: 0, filters: 0)),"#
        );
    }
    text += "], joints: [";
    for (kind, form) in KINDS {
        let anchor = if kind == "distance" { 0.0 } else { -0.5 };
        text += &format!(
            r#"(body_a: "world", body_b: "{kind}", anchor_a: (0, 0, 0), anchor_b: ({anchor}, 0, 0), {form}),"#
        );
    }
    let mut largest = [(0.0_f64, None::<f64>); 6];
    // All start off what they hold, and come to it by and by.
    let metrics = run(&format!("{text}])"), SolverSettings::classic(), 30, |bodies| {
        for (index, (kind, _)) in KINDS.iter().enumerate() {
            let (gap, tilt) = expected(kind, &bodies[index]);
            largest[index].0 = largest[index].0.max(gap);
            largest[index].1 = tilt.map(|tilt| tilt.max(largest[index].1.unwrap_or(0.0)));
        }
    });
    assert_eq!(metrics.joint_gaps.len(), KINDS.len());
    for ((kind, _), (gap, tilt)) in KINDS.into_iter().zip(largest) {
        let JointGap { gap_m, tilt_rad } = metrics.joint_gaps[kind];
        assert!(gap > 1e-6 && tilt.is_none_or(|tilt| tilt > 1e-4), "{kind} is off: {gap:e} m, {tilt:?} rad");
        close(gap_m, gap);
        assert_eq!(tilt_rad.is_some(), tilt.is_some(), "{kind}");
        // Angles of unit vectors and quaternions are good to the root of rounding.
        assert!((tilt_rad.unwrap_or(0.0) - tilt.unwrap_or(0.0)).abs() < 1e-7, "{kind}: {tilt_rad:?}, not {tilt:?}");
    }
    let worst = largest.into_iter().map(|(gap, _)| gap).fold(0.0, f64::max);
    close(metrics.joint_error_max_m, worst);
    assert_eq!((metrics.limit_overshoot_max, metrics.broken_joints), (None, 0));
}

#[test]
fn kinds_that_a_scene_lacks_and_springs_have_no_gap() {
    let text = r#"(bodies: [(name: "a", shape: Sphere(radius: 0.1))], joints: [
        (body_a: "world", body_b: "a", at: (0, 1, 0), kind: Spring(rest: 0.5, stiffness: 10)),
    ])"#;
    let metrics = run(text, SolverSettings::game(), 30, |_| {});
    assert!(metrics.joint_gaps.is_empty(), "{:?}", metrics.joint_gaps);
    assert_eq!(metrics.joint_error_max_m, 0.0);
    let alone = run(r#"(bodies: [(name: "a", shape: Sphere(radius: 0.1))])"#, SolverSettings::game(), 1, |_| {});
    assert_eq!((alone.joint_load_max, alone.limit_overshoot_max), (None, None));
}

#[test]
fn overshoot_of_angles_and_of_lengths_are_kept_apart() {
    // A wheel a turn ahead of where it looks, and a sled: both start beyond their limits, and come back.
    let text = r#"(gravity: (0, 0, 0), bodies: [
        (name: "wheel", shape: Sphere(radius: 0.5), angular_velocity: (0, 0, 1)),
        (name: "sled", shape: Sphere(radius: 0.5), position: (5, 0, 0), velocity: (2, 0, 0)),
    ], joints: [
        (body_a: "world", body_b: "wheel", at: (0, 0, 0), kind: Hinge, axis: (0, 0, 1), limits: (max: 6), coordinate: 6.3),
        (body_a: "world", body_b: "sled", anchor_a: (0, 0, 0), anchor_b: (0, 0, 0), kind: Slider, limits: (max: 4.9)),
    ])"#;
    let mut beyond = [0.0_f64; 2];
    let metrics = run(text, SolverSettings::classic(), 20, |bodies| {
        let angle = TAU + 2.0 * bodies[0].rotation.z.atan2(bodies[0].rotation.w);
        beyond = [beyond[0].max(angle - 6.0), beyond[1].max(bodies[1].position.x - 4.9)];
    });
    let told = metrics.limit_overshoot_max.expect("there are limits");
    assert!(beyond[0] > 0.1 && beyond[1] > 0.05, "{beyond:?}");
    close(told.angle_rad.unwrap(), beyond[0]);
    close(told.length_m.unwrap(), beyond[1]);
}

#[test]
fn within_its_limits_a_joint_overshoots_by_nothing() {
    let text = r#"(gravity: (0, 0, 0), bodies: [(name: "sled", shape: Sphere(radius: 0.5))], joints: [
        (body_a: "world", body_b: "sled", at: (0, 0, 0), kind: Slider, limits: (min: -1, max: 1)),
    ])"#;
    let told = run(text, SolverSettings::game(), 3, |_| {}).limit_overshoot_max.expect("there are limits");
    assert_eq!((told.angle_rad, told.length_m), (None, Some(0.0)));
}

#[test]
fn loads_are_those_of_statics() {
    let text = r#"(gravity: (0, -10, 0), bodies: [
        (name: "beam", shape: Cuboid(size: (1, 0.2, 0.2)), mass: 2, position: (0.5, 0, 0)),
        (name: "lamp", shape: Sphere(radius: 0.1), mass: 3, position: (0, 0, 9)),
    ], joints: [
        (body_a: "world", body_b: "beam", at: (0, 0, 0), kind: Fixed),
        (body_a: "world", body_b: "lamp", at: (0, 1, 9)),
    ])"#;
    for (settings, tolerance) in [(SolverSettings::accurate(), 1e-9), (SolverSettings::game(), 1e-3)] {
        let load = run(text, settings, 60, |_| {}).joint_load_max.expect("there are joints");
        // The lamp's joint bears the larger force, the beam's a torque: two joints.
        let within = |value: f64, expected: f64| (value / expected - 1.0).abs() < tolerance;
        assert!(within(load.force_n, 30.0) && within(load.torque_n_m, 10.0), "{:?}: {load:?}", settings.method);
    }
}

/// What is broken parts without being an error.
#[test]
fn broken_joints_are_counted_and_hold_nothing() {
    let settings = SolverSettings::game();
    let strength = ("f".to_owned(), 1000.0);
    let plan = Plan::new("tower", from_ref(&strength), settings, Some(2.0)).unwrap();
    let metrics = measure(&plan, |_| Ok::<(), Infallible>(())).unwrap();
    let mut simulation = Simulation::new(load("tower", &[strength]).unwrap(), settings);
    (0..plan.steps).for_each(|_| simulation.step());
    let is_broken = |joint| simulation.world().get::<BrokenJoint>(joint).is_some();
    let broken = simulation.entities().joints.iter().filter(|&&joint| is_broken(joint)).count();
    assert!(broken > 0);
    assert_eq!(metrics.broken_joints as usize, broken);
    assert!(metrics.joint_error_max_m < 0.01, "{} m", metrics.joint_error_max_m);
    // What falls may sink into what it falls on; but nothing of what broke counts as parted.
    assert!(!judge(&metrics).reason.contains("joint"), "{}", judge(&metrics).reason);
}
