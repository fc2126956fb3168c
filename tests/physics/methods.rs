//! What every method on the impulse engine must do besides what the matrix asks of all: carry weight, bounce, hold what
//! moves by itself. Each test runs all of them.

use bevy::math::{DQuat, DVec3};
use bevy::prelude::*;
use bevy::reflect::enums::DynamicEnum;
use bevy::reflect::{GetPath, ReflectMut};
use plumb::physics::{ContactForces, Diagnostics, SETTINGS};
use plumb::prelude::*;

use crate::matrix::{ENGINES, Engine};
use crate::rig::*;

fn methods() -> [SolverSettings; 3] {
    [SolverSettings::game(), SolverSettings::sequential_impulses(), SolverSettings::xpbd()]
}

fn column(settings: SolverSettings, count: u32) -> (World, Vec<Entity>) {
    let mut world = world_with(settings);
    ground(&mut world);
    let at = |level: u32| DVec3::Y * (0.5 + f64::from(level));
    let boxes = (0..count).map(|level| body(&mut world, Collider::cuboid(1.0, 1.0, 1.0), at(level))).collect();
    (world, boxes)
}

#[test]
fn contact_forces_carry_the_weight_above() {
    for settings in methods() {
        let (mut world, boxes) = column(settings, 3);
        world.init_resource::<ContactForces>();
        run(&mut world, 3.0);
        for (level, &block) in boxes.iter().enumerate() {
            // Forces are told on B; the ground or the box below may be either.
            let forces = world.resource::<ContactForces>().0.iter();
            let below = |other: Entity| !boxes[level..].contains(&other);
            let lift: f64 = forces
                .filter(|force| (force.a == block && below(force.b)) || (force.b == block && below(force.a)))
                .map(|force| if force.b == block { force.force.y } else { -force.force.y })
                .sum();
            let weight = 1000.0 * G * (3 - level) as f64;
            assert_close(lift, weight, 0.01 * weight);
        }
    }
}

#[test]
fn a_column_of_ten_stands_for_ten_seconds() {
    for settings in methods() {
        let (mut world, boxes) = column(settings, 10);
        run(&mut world, 10.0);
        for (level, &block) in (0_u32..).zip(&boxes) {
            assert_near(position(&world, block), DVec3::Y * (0.5 + f64::from(level)), 0.02);
            let speed = velocity(&world, block).length();
            assert!(speed < 0.01, "{:?}: box {level} trembles at {speed} m/s", settings.method);
        }
    }
}

#[test]
fn a_ball_bounces_to_e_squared_of_its_height() {
    for settings in methods() {
        let mut world = world_with(SolverSettings { hz: 960.0, ..settings });
        ground(&mut world);
        let ball = body(&mut world, Collider::sphere(0.1), DVec3::Y * 5.0);
        world.entity_mut(ball).insert(SurfaceMaterial { friction: 0.0, restitution: 0.8 });
        let (mut bounced, mut apex) = (false, 0.0);
        while !(bounced && velocity(&world, ball).y < 0.0) {
            step(&mut world);
            bounced |= velocity(&world, ball).y > 0.0;
            apex = position(&world, ball).y;
            assert!(world.resource::<StepStats>().time < 5.0, "it does not come back");
        }
        // It leaves up to a step, 1 cm of way, late.
        assert_close(apex, 0.1 + 4.9 * 0.64, 0.02);
    }
}

#[test]
fn what_comes_slowly_stays() {
    for settings in methods() {
        let mut world = weightless(settings);
        ground(&mut world);
        let ball = body(&mut world, Collider::sphere(0.1), DVec3::Y * 0.1);
        let slow = Velocity { linear: DVec3::Y * -0.4, ..default() };
        world.entity_mut(ball).insert((slow, SurfaceMaterial { friction: 0.0, restitution: 1.0 }));
        run(&mut world, 0.2);
        assert_close(velocity(&world, ball).y, 0.0, 1e-3);
    }
}

#[test]
fn a_gap_is_fallen_through() {
    // 12 cm above the ground at 10 m/s: seen in the step before it is there, and there at its end.
    for settings in methods() {
        let mut world = world_with(settings);
        ground(&mut world);
        let dropped = body(&mut world, Collider::sphere(0.5), DVec3::Y * 0.62);
        world.entity_mut(dropped).insert(Velocity { linear: DVec3::Y * -10.0, ..default() });
        step(&mut world);
        assert_close(position(&world, dropped).y, 0.5, 1e-3);
    }
}

/// A wheel on a kinematic hub that moves: where rows are made anew within a step, they must see the hub where it is
/// by then.
#[test]
fn joints_to_what_moves_by_itself_hold() {
    for settings in methods() {
        let mut world = weightless(SolverSettings { substeps: 4, ..settings });
        world.init_resource::<Diagnostics>();
        let hub = world.spawn((RigidBody::Kinematic, Position(DVec3::ZERO))).id();
        world.entity_mut(hub).insert(Velocity { linear: DVec3::X * 6.0, ..default() });
        // Two joints to the hub's axis and a spring make it a loop: solved by sweeps.
        let wheel = body(&mut world, Collider::cuboid(1.0, 1.0, 0.2), DVec3::ZERO);
        let spin = Velocity { linear: DVec3::X * 6.0, angular: DVec3::Z * 8.0 };
        world.entity_mut(wheel).insert(spin);
        world.spawn(BallJoint::new(hub, wheel));
        let post = world.spawn((RigidBody::Static, Position(DVec3::Y * 3.0))).id();
        let loose = Softness { frequency: 0.01, damping_ratio: 0.0, max_force: 1e-3 };
        world.spawn(BallJoint::new(post, wheel).with_softness(loose));
        run(&mut world, 1.0);
        let parted = world.resource::<Diagnostics>().joint_error;
        assert!(parted < 1e-3, "{:?}: parted by {parted} m", settings.method);
        assert_near(velocity(&world, wheel), DVec3::X * 6.0, 0.01);
    }
}

/// Overlapping balls are moved apart by projection alone: their velocities never learn of it.
#[test]
fn sequential_impulses_mend_overlaps_without_speed() {
    let settings = SolverSettings::sequential_impulses();
    let mut world = weightless(settings);
    let balls = [-0.4, 0.4].map(|x| body(&mut world, Collider::sphere(0.5), DVec3::X * x));
    run(&mut world, 3.0);
    let [left, right] = balls.map(|ball| position(&world, ball).x);
    assert_close(right - left, 1.0 - settings.slop, 1e-3);
    assert_eq!(balls.map(|ball| velocity(&world, ball)), [DVec3::ZERO; 2]);
}

/// All of an overlap is gone after a step or as fast as the settings let it, and the balls rest.
#[test]
fn position_based_dynamics_mends_overlaps_and_settles() {
    let mut world = weightless(SolverSettings { correction_speed: Some(0.5), ..SolverSettings::xpbd() });
    let balls = [-0.4, 0.4].map(|x| body(&mut world, Collider::sphere(0.5), DVec3::X * x));
    run(&mut world, 0.2);
    let [left, right] = balls.map(|ball| position(&world, ball).x);
    assert_close(right - left, 0.8 + 0.5 * 0.2, 0.01);
    run(&mut world, 0.5);
    let [left, right] = balls.map(|ball| position(&world, ball).x);
    assert_close(right - left, 1.0, 1e-3);
    assert_near(velocity(&world, balls[1]), DVec3::ZERO, 1e-3);
}

/// Substeps carry a spring: a soft joint stretches by g/ω² under the weight, whatever the method.
#[test]
fn soft_joints_stretch_by_their_compliance() {
    for settings in methods() {
        let mut world = world_with(settings);
        let post = world.spawn((RigidBody::Static, Position(DVec3::ZERO))).id();
        let bob = body(&mut world, Collider::sphere(0.2), DVec3::ZERO);
        let spring = Softness { frequency: 2.0, damping_ratio: 1.0, max_force: 1e9 };
        world.spawn(BallJoint::new(post, bob).with_softness(spring));
        run(&mut world, 5.0);
        let stretch = -position(&world, bob).y;
        let expected = G / (std::f64::consts::TAU * 2.0).powi(2);
        assert_close(stretch, expected, 0.01 * expected);
        assert_eq!(world.get::<Rotation>(bob).unwrap().0, DQuat::IDENTITY);
    }
}

/// Another value of a setting, in its range.
fn vary(settings: &mut SolverSettings, path: &str) {
    let value = settings.reflect_path_mut(path).expect("the table has paths of the type");
    if let Some(value) = value.try_downcast_mut::<f64>() {
        *value = 0.5 * *value + 0.01;
    } else if let Some(value) = value.try_downcast_mut::<u32>() {
        *value = 1 - (*value).min(1) + *value / 2;
    } else if let Some(value) = value.try_downcast_mut::<bool>() {
        *value = !*value;
    } else if let Some(value) = value.try_downcast_mut::<Option<f64>>() {
        *value = if value.is_none() { Some(0.05) } else { None };
    } else if let ReflectMut::Enum(value) = value.reflect_mut() {
        let names = value.get_represented_enum_info().unwrap().variant_names();
        value.apply(&DynamicEnum::new(names[(value.variant_index() + 1) % names.len()], ()));
    }
}

#[test]
fn no_method_reads_what_the_table_says_it_does_not() {
    let ends = |settings: SolverSettings| {
        let mut world = world_with(settings);
        ground(&mut world);
        let tilted = body(&mut world, Collider::cuboid(1.0, 0.5, 0.8), DVec3::new(0.0, 0.6, 0.0));
        world.get_mut::<Rotation>(tilted).unwrap().0 = DQuat::from_rotation_z(0.3);
        world.get_mut::<Velocity>(tilted).unwrap().linear = DVec3::new(1.0, -1.0, 0.5);
        let cubes = [0.5, 1.499].map(|y| body(&mut world, Collider::cuboid(1.0, 1.0, 1.0), DVec3::new(4.0, y, 0.0)));
        let rods = [2.0, 3.2].map(|y| body(&mut world, Collider::sphere(0.4), DVec3::new(-3.0, y, 0.0)));
        world.spawn(BallJoint::new(rods[0], rods[1]).with_anchors(DVec3::Y * 0.6, -DVec3::Y * 0.6));
        run(&mut world, 1.0);
        [tilted, cubes[0], cubes[1], rods[0], rods[1]]
            .map(|body| (world.get::<Position>(body).unwrap().0, world.get::<Velocity>(body).unwrap().linear))
    };
    let mut unread = 0;
    for settings in ENGINES.map(Engine::settings) {
        let before = ends(settings);
        for setting in SETTINGS.iter().filter(|setting| !setting.is_read(&settings)) {
            let mut varied = settings;
            vary(&mut varied, setting.path);
            assert_ne!(varied, settings, "{} did not vary", setting.path);
            assert_eq!(varied.validate(), Ok(()), "{}", setting.path);
            assert_eq!(ends(varied), before, "{:?} reads {}", settings.method, setting.path);
            unread += 1;
        }
        let differs = |path| {
            let mut varied = settings;
            vary(&mut varied, path);
            ends(varied) != before
        };
        assert!(differs("restitution_speed") || differs("drag"), "{:?}: the scene shows nothing", settings.method);
    }
    assert!(unread > 50, "{unread} are next to none");
}
