//! The rod pendulum against its equation of motion.

use bevy::math::DVec3;
use bevy::prelude::*;
use plumb::prelude::*;

use crate::rig::*;

const LENGTH: f64 = 1.0;
const WIDTH: f64 = 0.1;

/// A rod of 1 kg released horizontal, its pivot at the origin.
fn pendulum(settings: SolverSettings) -> (World, Entity) {
    let mut world = world_with(settings);
    let post = world.spawn((RigidBody::Static, Transform::default())).id();
    let rod = body(&mut world, Collider::cuboid(LENGTH, WIDTH, WIDTH), DVec3::X * LENGTH / 2.0);
    world.entity_mut(rod).insert(Mass(1.0));
    world.spawn(BallJoint::new(post, rod).with_anchors(DVec3::ZERO, DVec3::X * -LENGTH / 2.0));
    (world, rod)
}

/// The rod's angle from the horizontal at time `t`, downwards, by the classic Runge–Kutta method
/// of fourth order at a step of t/4096 (error below 1e-12).
fn reference_angle(t: f64) -> f64 {
    let inertia = (LENGTH * LENGTH + WIDTH * WIDTH) / 12.0 + LENGTH * LENGTH / 4.0;
    let acceleration = |angle: f64| 9.81 * LENGTH / 2.0 * angle.cos() / inertia;
    let [angle, _] = runge_kutta([0.0, 0.0], t, 4096, |[angle, rate]| [rate, acceleration(angle)]);
    angle
}

/// How far the rod's angle is from the reference after a second, rad.
fn angle_error(settings: SolverSettings) -> f64 {
    let (mut world, rod) = pendulum(settings);
    let (mut angle, mut before) = (0.0, DVec3::X);
    for _ in 0..settings.hz as u32 {
        step(&mut world);
        let along = world.get::<Rotation>(rod).unwrap().0 * DVec3::X;
        angle += before.y.atan2(before.x) - along.y.atan2(along.x);
        before = along;
    }
    (angle - reference_angle(1.0)).abs()
}

#[test]
fn a_pendulum_swings_as_its_equation_says() {
    let fine = SolverSettings { hz: 1000.0, ..SolverSettings::classic() };
    for (name, settings, tolerance) in [
        ("game", SolverSettings::game(), 5e-4),
        ("game, full effort", with_effort(SolverSettings::game(), false), 5e-5),
        ("steady", SolverSettings::steady(), 0.02),
        ("classic", SolverSettings::classic(), 0.08),
        ("classic at 1000 Hz", fine, 0.005),
    ] {
        let error = angle_error(settings);
        assert!(error < tolerance, "{name}: {error} rad off after a second");
    }
}

#[test]
fn the_error_falls_with_the_step() {
    for precision in [Precision::F32, Precision::F64] {
        let at = |hz| angle_error(SolverSettings { hz, precision, ..SolverSettings::classic() });
        let order = (at(240.0) / at(480.0)).log2();
        assert!((order - 1.0).abs() < 0.2, "{precision:?}: order {order}");
    }
}

#[test]
fn a_pendulum_gains_no_energy_and_holds_its_pivot() {
    for (settings, separation) in [(SolverSettings::steady(), 2e-3), (SolverSettings::classic(), 4e-2)] {
        let (mut world, _) = pendulum(settings);
        world.init_resource::<plumb::physics::Diagnostics>();
        for _ in 0..600 {
            step(&mut world);
            let seen = world.resource::<plumb::physics::Diagnostics>();
            // Released at rest at height 0; m g L/2 = 4.9 J is the scale.
            assert!(seen.energy() < 0.05 * 4.9, "{} J", seen.energy());
            assert!(seen.joint_error < separation, "{} m", seen.joint_error);
        }
    }
}

/// It turns by 0.01 to 0.09 rad a step, so that `game` goes from half its substeps to all of them and back.
#[test]
fn a_pendulum_loses_no_height_where_its_substeps_change() {
    let (mut world, rod) = pendulum(SolverSettings::game());
    for _ in 0..1800 {
        step(&mut world);
    }
    let heights: Vec<f64> = (0..120)
        .map(|_| {
            step(&mut world);
            position(&world, rod).y
        })
        .collect();
    let highest = heights.into_iter().fold(f64::MIN, f64::max);
    assert!((-1e-3..1e-4).contains(&highest), "{highest} m, from 0 half a minute ago");
}
