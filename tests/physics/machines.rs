//! Joints of all kinds with limits, motors, springs and friction, under every method.

use std::f64::consts::{FRAC_PI_2, TAU};

use bevy::math::{DQuat, DVec3};
use bevy::prelude::*;
use plumb::physics::QuarantineReason;
use plumb::prelude::*;

use crate::rig::*;

/// One of each engine: sweeps, impulses, direct, exact, at 240 Hz.
fn methods() -> Vec<SolverSettings> {
    let mut all = vec![SolverSettings::classic(), SolverSettings::steady(), awake_game(), SolverSettings::accurate()];
    all.extend([Method::SequentialImpulses, Method::Xpbd].map(|method| SolverSettings { method, ..awake_game() }));
    all.iter_mut().for_each(|settings| settings.hz = 240.0);
    all
}

/// A rod of 1 kg, 1 m long, at rest along x from the origin, on a hinge there about z.
fn rod(settings: SolverSettings, gravity: f64) -> (World, Entity, Entity) {
    let mut world = world_with(settings);
    world.insert_resource(Gravity(DVec3::Y * -gravity));
    let post = world.spawn((RigidBody::Static, Position(DVec3::ZERO))).id();
    let rod = body(&mut world, Collider::cuboid(1.0, 0.1, 0.1), DVec3::X * 0.5);
    world.entity_mut(rod).insert((Mass(1.0), CollisionLayers::NONE));
    let hinge = HingeJoint::new(post, rod).with_anchors(DVec3::ZERO, DVec3::X * -0.5).with_axis(DVec3::Z);
    let joint = world.spawn((hinge, JointLoad::default())).id();
    (world, rod, joint)
}

/// Of that rod about its hinge, kg·m².
const INERTIA: f64 = 1.01 / 12.0 + 0.25;

fn angle(world: &World, joint: Entity) -> f64 {
    world.get::<JointCoordinate>(joint).unwrap().value
}

fn rate(world: &World, joint: Entity) -> f64 {
    world.get::<JointCoordinate>(joint).unwrap().rate
}

#[test]
fn a_hinge_swings_about_its_axis_and_counts_its_turns() {
    for settings in methods() {
        let (mut world, rod, joint) = rod(settings, 0.0);
        // Ten radians a second, about the hinge.
        let moving = Velocity { linear: DVec3::Y * 5.0, angular: DVec3::Z * 10.0 };
        world.entity_mut(rod).insert(moving);
        run(&mut world, 2.0);
        let told = angle(&world, joint);
        assert!((told - 20.0).abs() < 1.0, "{:?}: {told} rad instead of 20", settings.method);
        let axis = world.get::<Rotation>(rod).unwrap().0 * DVec3::Z;
        assert!(axis.angle_between(DVec3::Z) < 1e-2, "{:?} tilts by {}", settings.method, axis.angle_between(DVec3::Z));
        let end = position(&world, rod) - world.get::<Rotation>(rod).unwrap().0 * (DVec3::X * 0.5);
        assert!(end.length() < 2e-2, "{:?} parts by {}", settings.method, end.length());
    }
}

#[test]
fn a_slider_lets_a_body_along_its_axis_and_nowhere_else() {
    let along = DVec3::new(1.0, 1.0, 0.0).normalize();
    for settings in methods() {
        let mut world = world_with(settings);
        let post = world.spawn((RigidBody::Static, Position(DVec3::ZERO))).id();
        let sled = body(&mut world, Collider::cuboid(0.4, 0.2, 0.3), DVec3::ZERO);
        world.entity_mut(sled).insert(CollisionLayers::NONE);
        world.spawn((SliderJoint::new(post, sled).with_axis(along), JointCoordinate::default()));
        run(&mut world, 0.5);
        let (at, expected) = (position(&world, sled), -0.5 * G * along.y * 0.25);
        assert!((at.dot(along) - expected).abs() < 0.03, "{:?}: {at} instead of {expected} along", settings.method);
        assert!(at.reject_from(along).length() < 3e-3, "{:?} leaves its axis: {at}", settings.method);
        let turned = world.get::<Rotation>(sled).unwrap().0.angle_between(DQuat::IDENTITY);
        assert!(turned < 5e-3, "{:?} turns by {turned}", settings.method);
    }
}

#[test]
fn a_fixed_joint_carries_force_and_torque() {
    for settings in methods() {
        let mut world = world_with(settings);
        let post = world.spawn((RigidBody::Static, Position(DVec3::ZERO))).id();
        let arm = body(&mut world, Collider::cuboid(1.0, 0.2, 0.2), DVec3::X * 0.5);
        world.entity_mut(arm).insert((Mass(2.0), CollisionLayers::NONE));
        let fixed = FixedJoint::new(post, arm).with_anchors(DVec3::ZERO, DVec3::X * -0.5);
        let joint = world.spawn((fixed, JointLoad::default())).id();
        run(&mut world, 2.0);
        let load = world.get::<JointLoad>(joint).unwrap();
        assert!((load.force - DVec3::Y * 2.0 * G).length() < 0.3, "{:?}: {:?}", settings.method, load.force);
        assert!((load.torque - DVec3::Z * G).length() < 0.3, "{:?}: {:?}", settings.method, load.torque);
    }
}

#[test]
fn a_limit_stops_a_rod_and_holds_its_weight() {
    for settings in methods() {
        let (mut world, rod, joint) = rod(settings, G);
        world.entity_mut(joint).insert(JointLimits::range(-0.5, 1.0));
        run(&mut world, 3.0);
        let told = angle(&world, joint);
        assert!((told + 0.5).abs() < 0.01, "{:?}: {told} instead of −0.5", settings.method);
        assert!(spin(&world, rod).length() < 0.05, "{:?} does not rest", settings.method);
        let torque = world.get::<JointLoad>(joint).unwrap().torque.z;
        let expected = 0.5 * G * 0.5_f64.cos();
        assert!((torque - expected).abs() < 0.1 * expected, "{:?}: {torque} instead of {expected}", settings.method);
    }
}

#[test]
fn a_limit_with_restitution_throws_a_rod_back() {
    // XPBD and sequential impulses leave an approach to the next substep; the 2009 engine knows no restitution.
    let bounces = |settings: &SolverSettings| {
        !matches!(settings.method, Method::Xpbd | Method::SequentialImpulses) && settings.restitution_speed.is_some()
    };
    for settings in methods().into_iter().filter(bounces) {
        let (mut world, rod, joint) = rod(settings, 0.0);
        world.entity_mut(joint).insert(JointLimits::range(-1.0, 0.5).with_restitution(0.6));
        world.entity_mut(rod).insert(Velocity { linear: DVec3::Y * 1.0, angular: DVec3::Z * 2.0 });
        run(&mut world, 0.4);
        let told = rate(&world, joint);
        assert!((told + 1.2).abs() < 0.12, "{:?}: {told} rad/s instead of −1.2", settings.method);
    }
}

#[test]
fn limits_tell_when_they_are_reached() {
    let (mut world, _, joint) = rod(SolverSettings { hz: 240.0, ..awake_game() }, G);
    world.entity_mut(joint).insert(JointLimits::range(-0.5, 1.0));
    // ½θ̇² I = m g ½ sin 0.5, after a fall from level; the time by a fine integration.
    let speed = (G * 0.5_f64.sin() / INERTIA).sqrt();
    let fall = |[angle, speed]: [f64; 2]| [speed, 0.5 * G * angle.cos() / INERTIA];
    let time = (1..).map(|k| f64::from(k) * 1e-3).find(|&t| runge_kutta([0.0, 0.0], t, 100, fall)[0] > 0.5).unwrap();
    let mut told = Vec::new();
    for _ in 0..480 {
        step(&mut world);
        told.extend(take::<LimitReached>(&mut world));
    }
    assert_eq!(told.len(), 1, "{told:?}");
    assert_eq!(told[0].joint, joint);
    assert!((told[0].time - time).abs() < 0.01, "{} s instead of {time}", told[0].time);
    // As of the start of the step in which it stops: 13 rad/s² for a 240th of a second.
    assert!((told[0].speed - speed).abs() < 0.06, "{} rad/s instead of {speed}", told[0].speed);
}

#[test]
fn swing_and_twist_of_a_ball_joint_stay_within_their_limits() {
    for settings in methods() {
        let mut world = world_with(settings);
        let post = world.spawn((RigidBody::Static, Position(DVec3::ZERO))).id();
        let bone = body(&mut world, Collider::cuboid(1.0, 0.2, 0.1), DVec3::X * 0.5);
        world.entity_mut(bone).insert((Mass(1.0), CollisionLayers::NONE));
        let ball = BallJoint::new(post, bone).with_anchors(DVec3::ZERO, DVec3::X * -0.5);
        let limits = JointLimits::swing_twist(0.4, [-0.2, 0.3], JointAxes::World(DVec3::X));
        world.spawn((ball, limits));
        world.entity_mut(bone).insert(ExternalForce { force: DVec3::ZERO, torque: DVec3::X * 0.5 });
        run(&mut world, 3.0);
        let rotation = world.get::<Rotation>(bone).unwrap().0;
        let swing = (rotation * DVec3::X).angle_between(DVec3::X);
        let twist = 2.0 * rotation.x.atan2(rotation.w);
        assert!((swing - 0.4).abs() < 0.02, "{:?}: swing {swing}", settings.method);
        assert!((twist - 0.3).abs() < 0.03, "{:?}: twist {twist}", settings.method);
    }
}

#[test]
fn a_motor_turns_at_its_speed_with_no_more_than_its_torque() {
    for settings in methods() {
        let (mut world, _, joint) = rod(settings, 0.0);
        let motor = JointMotor::new(MotorTarget::Speed(2.0)).with_max_force(0.5);
        world.entity_mut(joint).insert(motor);
        run(&mut world, 0.5);
        let expected = 0.5 / INERTIA * 0.5;
        let told = rate(&world, joint);
        assert!((told - expected).abs() < 0.05, "{:?}: {told} rad/s instead of {expected}", settings.method);
        run(&mut world, 2.0);
        assert!((rate(&world, joint) - 2.0).abs() < 0.02, "{:?}: {}", settings.method, rate(&world, joint));
    }
}

#[test]
fn a_servo_goes_to_its_angle_as_a_damped_oscillator() {
    for settings in methods() {
        let (mut world, _, joint) = rod(settings, 0.0);
        let (frequency, damping_ratio) = (1.0, 0.5);
        let target = MotorTarget::Position { target: 1.0, frequency, damping_ratio };
        world.entity_mut(joint).insert(JointMotor::new(target));
        run(&mut world, 0.6);
        let (omega, time) = (TAU * frequency, 0.6_f64);
        let damped = omega * (1.0 - damping_ratio * damping_ratio).sqrt();
        let decay = (-damping_ratio * omega * time).exp();
        let (sin, cos) = (damped * time).sin_cos();
        let expected = 1.0 - decay * (cos + damping_ratio * omega / damped * sin);
        let told = angle(&world, joint);
        let tolerance = if settings.method == Method::Exact { 1e-10 } else { 0.04 };
        assert!((told - expected).abs() < tolerance, "{:?}: {told} instead of {expected}", settings.method);
    }
}

#[test]
fn a_motion_in_time_is_followed_and_tells_its_torque() {
    let motion = PrescribedMotion::Sine { mean: 0.5, amplitude: 0.5, angular_frequency: 3.0, phase: -FRAC_PI_2 };
    for settings in methods() {
        let (mut world, _, joint) = rod(settings, 0.0);
        world.entity_mut(joint).insert(JointMotor::new(MotorTarget::Motion(motion)));
        run(&mut world, 1.0);
        let [expected, _, _] = motion.at_time(1.0);
        let told = angle(&world, joint);
        let tolerance = if settings.method == Method::Exact { 1e-9 } else { 0.02 };
        assert!((told - expected).abs() < tolerance, "{:?}: {told} instead of {expected}", settings.method);
        let [_, _, acceleration] = motion.at_time(1.0);
        let torque = world.get::<JointLoad>(joint).unwrap().torque.z;
        assert!((torque - INERTIA * acceleration).abs() < 0.1, "{:?}: {torque} N m", settings.method);
    }
}

#[test]
fn dry_friction_stops_a_rod_at_its_time_and_holds_it() {
    for settings in methods() {
        let (mut world, rod, joint) = rod(settings, 0.0);
        world.entity_mut(joint).insert(JointFriction(0.4));
        world.entity_mut(rod).insert(Velocity { linear: DVec3::Y * 0.5, angular: DVec3::Z });
        run(&mut world, 0.4);
        let expected = 1.0 - 0.4 / INERTIA * 0.4;
        let told = rate(&world, joint);
        assert!((told - expected).abs() < 0.02, "{:?}: {told} rad/s instead of {expected}", settings.method);
        run(&mut world, 1.6);
        let stop = 0.5 * INERTIA / 0.4;
        assert!((angle(&world, joint) - stop).abs() < 0.02, "{:?}: {}", settings.method, angle(&world, joint));
        assert!(rate(&world, joint).abs() < 1e-3, "{:?}: {}", settings.method, rate(&world, joint));
    }
}

#[test]
fn a_rope_is_slack_until_it_is_taut_and_a_rod_is_never() {
    for settings in methods() {
        let mut world = world_with(settings);
        let post = world.spawn((RigidBody::Static, Position(DVec3::ZERO))).id();
        let [roped, rodded] = [1.0, 2.0].map(|x| {
            let weight = body(&mut world, Collider::sphere(0.1), DVec3::new(x - 1.0, -0.5, x));
            world.entity_mut(weight).insert((Mass(1.0), CollisionLayers::NONE));
            weight
        });
        let rope = DistanceJoint::rope(post, roped, 2.0).with_anchors(DVec3::Z, DVec3::ZERO);
        let rope = world.spawn((rope, JointLoad::default())).id();
        let length = DVec3::new(1.0, -0.5, 0.0).length();
        world.spawn(DistanceJoint::rod(post, rodded, length).with_anchors(DVec3::Z * 2.0, DVec3::ZERO));
        run(&mut world, 0.3);
        let fallen = 0.5 + 0.5 * G * 0.09;
        assert!((position(&world, roped).y + fallen).abs() < 0.05, "{:?} is taut too soon", settings.method);
        run(&mut world, 5.0);
        let lengths = [position(&world, roped) - DVec3::Z, position(&world, rodded) - DVec3::Z * 2.0];
        assert!((lengths[0].length() - 2.0).abs() < 0.02, "{:?}: rope {}", settings.method, lengths[0].length());
        assert!((lengths[1].length() - length).abs() < 0.02, "{:?}: rod {}", settings.method, lengths[1].length());
        let load = world.get::<JointLoad>(rope).unwrap().force.y;
        assert!((load - G).abs() < 0.5, "{:?}: the rope carries {load} N", settings.method);
    }
}

#[test]
fn a_spring_between_two_points_has_its_period() {
    for settings in methods() {
        let mut world = weightless(settings);
        let post = world.spawn((RigidBody::Static, Position(DVec3::ZERO))).id();
        let bob = body(&mut world, Collider::sphere(0.1), DVec3::X * 1.2);
        world.entity_mut(bob).insert((Mass(2.0), CollisionLayers::NONE));
        // ω = 5 rad/s.
        world.spawn(DistanceJoint::spring(post, bob, 1.0, 50.0, 0.0));
        run(&mut world, 0.5);
        let expected = 1.0 + 0.2 * 2.5_f64.cos();
        let told = position(&world, bob).x;
        assert!((told - expected).abs() < 0.015, "{:?}: {told} instead of {expected}", settings.method);
    }
}

#[test]
fn a_generic_joint_holds_what_it_locks() {
    for settings in methods() {
        let mut world = world_with(settings);
        let post = world.spawn((RigidBody::Static, Position(DVec3::ZERO))).id();
        let plate = body(&mut world, Collider::cuboid(0.5, 0.1, 0.3), DVec3::ZERO);
        world.entity_mut(plate).insert(CollisionLayers::NONE);
        let moving = Velocity { linear: DVec3::new(0.3, 0.0, 0.2), angular: DVec3::Y * 0.7 };
        world.entity_mut(plate).insert(moving);
        // A plane: its height and its tilts are locked.
        let joint =
            GenericJoint::new(post, plate).with_axis(DVec3::Y).with_locked([true, false, false], [false, true, true]);
        world.spawn(joint);
        run(&mut world, 1.0);
        let at = position(&world, plate);
        assert!((at - DVec3::new(0.3, 0.0, 0.2)).length() < 0.01, "{:?}: {at}", settings.method);
        let turned = world.get::<Rotation>(plate).unwrap().0;
        assert!(turned.angle_between(DQuat::from_rotation_y(0.7)) < 0.02, "{:?}: {turned}", settings.method);
    }
}

#[test]
fn what_makes_no_sense_is_quarantined_with_its_reason() {
    let reason = |what: &dyn Fn(&mut World, Entity)| {
        let (mut world, _, joint) = rod(awake_game(), G);
        what(&mut world, joint);
        step(&mut world);
        world.get::<Quarantined>(joint).map(|quarantined| quarantined.reason)
    };
    let limits = |min: f64, max: f64| {
        move |world: &mut World, joint: Entity| _ = world.entity_mut(joint).insert(JointLimits::range(min, max))
    };
    assert_eq!(reason(&limits(1.0, -1.0)), Some(QuarantineReason::BadJointLaw));
    assert_eq!(reason(&limits(f64::NAN, 1.0)), Some(QuarantineReason::BadJointLaw));
    assert_eq!(reason(&limits(-1.0, 1.0)), None);
    let swing = |world: &mut World, joint: Entity| {
        let limits = JointLimits::swing_twist(1.0, [-1.0, 1.0], JointAxes::World(DVec3::X));
        world.entity_mut(joint).insert(limits);
    };
    assert_eq!(reason(&swing), Some(QuarantineReason::NoSuchAxis));
    let negative = |world: &mut World, joint: Entity| {
        let motor = JointMotor::new(MotorTarget::Speed(1.0)).with_max_force(-1.0);
        world.entity_mut(joint).insert(motor);
    };
    assert_eq!(reason(&negative), Some(QuarantineReason::BadJointLaw));
    let no_axis = |world: &mut World, joint: Entity| {
        let mut hinge = world.get_mut::<HingeJoint>(joint).unwrap();
        *hinge = hinge.with_axis(DVec3::ZERO);
    };
    assert_eq!(reason(&no_axis), Some(QuarantineReason::NotFinite));
    let weak = |world: &mut World, joint: Entity| _ = world.entity_mut(joint).insert(Breakable::at_force(0.0));
    assert_eq!(reason(&weak), Some(QuarantineReason::BadJointLaw));
}

#[test]
fn a_motor_that_is_set_anew_turns_the_other_way_without_a_new_joint() {
    let (mut world, _, joint) = rod(awake_game(), 0.0);
    world.entity_mut(joint).insert(JointMotor::new(MotorTarget::Speed(1.0)).with_max_force(10.0));
    run(&mut world, 1.0);
    assert!((rate(&world, joint) - 1.0).abs() < 1e-3);
    world.get_mut::<JointMotor>(joint).unwrap().target = MotorTarget::Speed(-2.0);
    run(&mut world, 1.0);
    assert!((rate(&world, joint) + 2.0).abs() < 1e-3, "{}", rate(&world, joint));
}

#[test]
fn a_motor_keeps_its_island_awake_and_a_motor_that_rests_does_not() {
    for (speed, sleeps) in [(0.02, false), (0.0, true)] {
        let (mut world, rod, joint) = rod(SolverSettings::game(), 0.0);
        world.entity_mut(joint).insert(JointMotor::new(MotorTarget::Speed(speed)).with_max_force(10.0));
        run(&mut world, 3.0);
        assert_eq!(world.get::<Sleeping>(rod).is_some(), sleeps, "at {speed} rad/s");
    }
}

#[test]
fn joints_with_laws_are_the_same_for_any_number_of_threads() {
    let hash = |threads| {
        let (mut world, rod, joint) = rod(SolverSettings { threads, ..awake_game() }, G);
        world.entity_mut(joint).insert((JointLimits::range(-0.7, 0.7).with_restitution(0.5), JointFriction(0.1)));
        let other = body(&mut world, Collider::cuboid(0.5, 0.1, 0.1), DVec3::X * 1.25);
        let hinge = HingeJoint::new(rod, other).with_anchors(DVec3::X * 0.5, DVec3::X * -0.25).with_axis(DVec3::Z);
        let motor = MotorTarget::Position { target: 0.5, frequency: 2.0, damping_ratio: 0.3 };
        world.spawn((hinge, JointMotor::new(motor).with_max_force(3.0)));
        run(&mut world, 1.0);
        state_hash(&world)
    };
    assert_eq!(hash(1), hash(2));
    assert_eq!(hash(1), hash(4));
}
