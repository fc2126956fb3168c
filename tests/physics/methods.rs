//! What every method on the impulse engine must do: carry weight, rub by Coulomb's law, bounce, keep momentum and
//! joints. Each test runs all of them.

use bevy::math::{DQuat, DVec3};
use bevy::prelude::*;
use bevy::reflect::enums::DynamicEnum;
use bevy::reflect::{GetPath, ReflectMut};
use plumb::physics::{ContactForces, Diagnostics, SETTINGS};
use plumb::prelude::*;

use crate::rig::*;

const G: f64 = 9.81;

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

/// Level ground under gravity turned by an angle, and a box at rest on it.
fn incline(settings: SolverSettings, degrees: f64) -> (World, Entity) {
    let mut world = world_with(settings);
    let (sin, cos) = degrees.to_radians().sin_cos();
    world.insert_resource(Gravity(DVec3::new(sin, -cos, 0.0) * G));
    ground(&mut world);
    let slider = body(&mut world, Collider::cuboid(2.0, 0.5, 1.0), DVec3::Y * 0.25);
    (world, slider)
}

#[test]
fn friction_holds_up_to_its_cone_and_no_further() {
    for settings in methods() {
        // μ = 0.6: tan 30° = 0.577, tan 32° = 0.625.
        for degrees in [10.0, 30.0] {
            let (mut world, slider) = incline(settings, degrees);
            run(&mut world, 2.0);
            let slid = position(&world, slider).x;
            // Nothing carries over from substep to substep in XPBD: it creeps.
            let creep = if settings.method == Method::Xpbd { 4e-3 } else { 1e-4 };
            assert!(slid.abs() < creep, "{:?} at {degrees}°: {slid}", settings.method);
        }
        for degrees in [32.0_f64, 40.0] {
            let (mut world, slider) = incline(settings, degrees);
            run(&mut world, 1.0);
            let (sin, cos) = degrees.to_radians().sin_cos();
            let acceleration = G * (sin - 0.6 * cos);
            // Euler is ½ a t h early; another 1 % of m g sin θ for the solver.
            let tolerance = 0.5 * acceleration / 60.0 + 0.01 * 0.5 * G * sin;
            assert_close(position(&world, slider).x, 0.5 * acceleration, tolerance);
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

#[test]
fn free_collisions_keep_momentum_and_gain_no_energy() {
    let [soft, sequential, xpbd] = methods();
    // What pushes after bodies have moved, in later substeps or to bounce, has the arms of the start of the step:
    // the bodies move by 8 cm of 2 m in it. One substep without bounces is exact.
    for (settings, restitution, tolerance) in [
        (soft, 0.0, 2e-2),
        (soft, 0.5, 3e-2),
        (sequential, 0.0, 1e-12),
        (sequential, 0.5, 3e-2),
        (xpbd, 0.0, 2e-2),
        (xpbd, 0.5, 3e-2),
    ] {
        let mut world = weightless(SolverSettings { precision: Precision::F64, ..settings });
        world.init_resource::<Diagnostics>();
        let velocities = [
            Velocity { linear: DVec3::new(3.0, 0.2, 0.0), angular: DVec3::new(1.0, 2.0, -4.0) },
            Velocity { linear: DVec3::new(-2.0, 0.0, 0.1), angular: DVec3::new(0.0, -3.0, 1.0) },
        ];
        for (at, velocity) in [DVec3::new(-1.0, 2.0, 0.0), DVec3::new(1.0, 2.3, 0.2)].into_iter().zip(velocities) {
            let cube = body(&mut world, Collider::cuboid(1.0, 1.0, 1.0), at);
            world.entity_mut(cube).insert((velocity, SurfaceMaterial { friction: 0.6, restitution }));
        }
        step(&mut world);
        let before = *world.resource::<Diagnostics>();
        run(&mut world, 1.0);
        let after = *world.resource::<Diagnostics>();
        assert_near(after.linear_momentum, before.linear_momentum, 1e-9 * before.linear_momentum.length());
        let scale = before.angular_momentum.length();
        assert_near(after.angular_momentum, before.angular_momentum, tolerance * scale);
        let (now, then) = (after.kinetic_energy, before.kinetic_energy);
        assert!(now < 0.99 * then, "some of the approach is lost: {then} J became {now} J");
    }
}

#[test]
fn joints_hold_and_tell_their_load() {
    for settings in methods() {
        let mut world = world_with(settings);
        world.init_resource::<Diagnostics>();
        let post = world.spawn((RigidBody::Static, Position(DVec3::ZERO))).id();
        let (mut last, mut reach) = (post, DVec3::ZERO);
        let mut first = None;
        for link in 0..3 {
            let rod = body(&mut world, Collider::cuboid(1.0, 0.2, 0.2), DVec3::X * (f64::from(link) + 0.5));
            world.entity_mut(rod).insert((Mass(1.0), Damping { linear: 1.0, angular: 1.0 }));
            let joint = BallJoint::new(last, rod).with_anchors(reach, DVec3::X * -0.5);
            let joint = world.spawn((joint, JointLoad::default())).id();
            first.get_or_insert(joint);
            (last, reach) = (rod, DVec3::X * 0.5);
        }
        let mut worst: f64 = 0.0;
        for _ in 0..1200 {
            step(&mut world);
            worst = worst.max(world.resource::<Diagnostics>().joint_error);
        }
        assert!(worst < 0.01, "{:?}: parted by {worst} m", settings.method);
        let load = world.get::<JointLoad>(first.unwrap()).unwrap().force;
        assert_near(load, DVec3::Y * 3.0 * G, 0.3);
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
    for settings in every_method() {
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

/// A soft joint from an immovable point to a body's anchor.
fn pull(world: &mut World, from: DVec3, body: Entity, anchor: DVec3, max_force: f64) -> Entity {
    let hand = world.spawn((RigidBody::Static, Position(from))).id();
    let softness = Softness { frequency: 4.0, damping_ratio: 1.0, max_force };
    let joint = BallJoint::new(hand, body).with_anchors(DVec3::ZERO, anchor).with_softness(softness);
    world.spawn((joint, JointLoad::default())).id()
}

/// A spring far beyond its largest force pulls with that, as a vector: along its stretch, no harder aslant than along
/// an axis.
#[test]
fn the_largest_force_of_a_spring_bounds_its_norm() {
    for settings in every_method() {
        for along in [DVec3::ONE, DVec3::new(3.0, -2.0, 1.0), DVec3::Y] {
            let along = along.normalize();
            let mut world = weightless(settings);
            let ball = body(&mut world, Collider::sphere(0.5), DVec3::ZERO);
            world.entity_mut(ball).insert(Mass(2.0));
            let joint = pull(&mut world, along * 1e3, ball, DVec3::ZERO, 5.0);
            run(&mut world, 0.2);
            let load = world.get::<JointLoad>(joint).unwrap();
            // The ball moves along the stretch: nothing but rounding in `f32`, 6e-8 in each of some dozen products.
            let message = format!("{:?}, {:?}: {} N", settings.method, settings.exact, load.force);
            assert!((load.force - along * 5.0).length() < 5.0 * 1e-5, "{message}");
            assert!((load.lambda - 5.0).abs() < 5.0 * 1e-5, "{message}");
            // v = F t/m; methods that kick by halves are one of them behind: h/2 of 0.2 s.
            let speed = 5.0 * 0.2 / 2.0;
            assert_near(velocity(&world, ball), along * speed, speed * (1e-4 + 0.5 / 60.0 / 0.2));
        }
    }
}

/// So does one that hangs on a body's end and turns it, and one on what rests on the ground.
#[test]
fn the_largest_force_bounds_springs_on_what_turns_and_on_what_rests() {
    for settings in every_method() {
        let mut world = weightless(settings);
        let rod = body(&mut world, Collider::cuboid(1.0, 0.2, 0.1), DVec3::ZERO);
        world.entity_mut(rod).insert(Mass(1.0));
        let turning = pull(&mut world, DVec3::new(400.0, 500.0, -300.0), rod, DVec3::X * 0.5, 2.0);
        let mut least = f64::INFINITY;
        for _ in 0..30 {
            step(&mut world);
            let lambda = world.get::<JointLoad>(turning).unwrap().lambda;
            // A mean over a step in which the direction turns a little is a little less.
            assert!(lambda < 2.0 * (1.0 + 1e-5), "{:?}, {:?}: {lambda} N", settings.method, settings.exact);
            least = least.min(lambda);
        }
        assert!(least > 1.98, "{:?}, {:?}: {least} N", settings.method, settings.exact);

        let impulse = ImpulseSettings { sleep_speed: None, ..settings.impulse };
        let mut world = world_with(SolverSettings { impulse, ..settings });
        ground(&mut world);
        let cube = body(&mut world, Collider::cuboid(1.0, 1.0, 1.0), DVec3::Y * 0.5);
        world.entity_mut(cube).insert(Mass(2.0));
        let along = DVec3::new(2.0, 1.0, -2.0) / 3.0;
        // 3 N aslant: friction holds with 0.6 (19.6 N − 1 N).
        let resting = pull(&mut world, along * 1e3, cube, DVec3::ZERO, 3.0);
        run(&mut world, 1.0);
        let load = world.get::<JointLoad>(resting).unwrap().force;
        // The cube has its centre half a metre of a kilometre above where the spring was laid out.
        assert!((load - along * 3.0).length() < 3e-3, "{:?}: {load} N", settings.method);
    }
}
