//! Machines at the edge of what joints bear: heavy wheels on a light shaft, a limit inside a loop, a range of no width, a
//! fast rotor on two hinges.

use bevy::math::{DQuat, DVec3};
use bevy::prelude::*;
use plumb::physics::Diagnostics;
use plumb::prelude::*;

use crate::rig::*;

/// The largest error of a joint in any step, m or rad, while it runs.
fn worst_error(world: &mut World, seconds: f64) -> f64 {
    world.init_resource::<Diagnostics>();
    let hz = world.resource::<SolverSettings>().hz;
    let mut worst: f64 = 0.0;
    for _ in 0..(seconds * hz).round() as u32 {
        step(world);
        worst = worst.max(world.resource::<Diagnostics>().joint_error);
    }
    worst
}

/// Two balls of 1000 kg on the ends of a shaft of five links of 1 kg. Motors at both ends turn them against each other,
/// 10 rad/s each way, in a single step if nothing bounds their torque.
#[test]
fn heavy_wheels_turn_against_each_other_through_a_light_shaft() {
    for (settings, gap, share) in [(awake_game(), 1e-3, 1e-2), (SolverSettings::accurate(), 1e-9, 1e-9)] {
        for torque in [f64::INFINITY, 5000.0] {
            let mut world = weightless(settings);
            let mut ends = vec![body(&mut world, Collider::sphere(0.5), DVec3::X * -1.0)];
            ends.extend((0..5).map(|link| {
                let at = DVec3::X * (-0.4 + 0.2 * f64::from(link));
                body(&mut world, Collider::cuboid(0.2, 0.1, 0.1), at)
            }));
            ends.push(body(&mut world, Collider::sphere(0.5), DVec3::X * 1.0));
            for (index, &end) in ends.iter().enumerate() {
                let mass = if (1..=5).contains(&index) { 1.0 } else { 1000.0 };
                world.entity_mut(end).insert((Mass(mass), CollisionLayers::NONE));
            }
            for (index, pair) in ends.windows(2).enumerate() {
                let point = DVec3::X * (-0.5 + 0.2 * index as f64);
                let anchors = [0, 1].map(|end| point - position(&world, pair[end]));
                if index == 0 || index == 5 {
                    let motor = JointMotor::new(MotorTarget::Speed(10.0)).with_max_force(torque);
                    let hinge = HingeJoint::new(pair[0], pair[1]).with_anchors(anchors[0], anchors[1]);
                    world.spawn((hinge.with_axis(DVec3::X), motor));
                } else {
                    world.spawn(FixedJoint::new(pair[0], pair[1]).with_anchors(anchors[0], anchors[1]));
                }
            }
            let worst = worst_error(&mut world, 2.0);
            let seen = *world.resource::<Diagnostics>();
            let case = format!("{:?}, at most {torque} N m", settings.method);
            assert!(worst <= gap, "{case}: joints part by {worst:e}");
            // Each wheel has I = 2/5 m r² = 100 kg m² and 1000 kg m²/s.
            let energy = 2.0 * 0.5 * 100.0 * 10.0 * 10.0;
            assert!((seen.kinetic_energy / energy - 1.0).abs() < share, "{case}: {} J", seen.kinetic_energy);
            assert!(seen.linear_momentum.length() < share * 1000.0, "{case}: {} kg m/s", seen.linear_momentum);
            assert!(seen.angular_momentum.length() < share * 1000.0, "{case}: {} kg m²/s", seen.angular_momentum);
            for (wheel, expected) in [(ends[0], -10.0), (ends[6], 10.0)] {
                let told = spin(&world, wheel);
                assert!((told - DVec3::X * expected).length() < share * 10.0, "{case}: {told} rad/s");
            }
        }
    }
}

/// A parallelogram that falls to one side until the angle between a post and the beam is at its limit, which then bears
/// it, through the loop.
#[test]
fn a_limit_that_closes_inside_a_loop_holds_it() {
    for (settings, tolerance) in [(awake_game(), 1e-3), (SolverSettings::accurate(), 1e-9)] {
        let mut world = world_with(settings);
        let ground = world.spawn((RigidBody::Static, Position(DVec3::ZERO))).id();
        let lean = 10.0_f64.to_radians();
        let post = DVec3::new(lean.sin(), lean.cos(), 0.0);
        let rotation = Rotation(DQuat::from_rotation_z(-lean));
        let [left, right] = [0.0, 1.0].map(|foot| {
            let post = body(&mut world, Collider::cuboid(0.1, 1.0, 0.1), DVec3::X * foot + 0.5 * post);
            world.entity_mut(post).insert((Mass(1.0), rotation, CollisionLayers::NONE));
            post
        });
        let beam = body(&mut world, Collider::cuboid(1.0, 0.1, 0.1), DVec3::X * 0.5 + post);
        world.entity_mut(beam).insert((Mass(1.0), CollisionLayers::NONE));
        let half = DVec3::Y * 0.5;
        for (foot, post) in [(0.0, left), (1.0, right)] {
            world.spawn(HingeJoint::new(ground, post).with_anchors(DVec3::X * foot, -half).with_axis(DVec3::Z));
        }
        let top = |post, end: f64| HingeJoint::new(post, beam).with_anchors(half, DVec3::X * end).with_axis(DVec3::Z);
        // The beam stays level as the posts fall to the right, which turns it to the left against them.
        let room = 30.0_f64.to_radians();
        let stopped = world.spawn((top(left, -0.5), JointLimits::range(-0.2, room))).id();
        world.spawn(top(right, 0.5));
        let worst = worst_error(&mut world, 3.0);
        assert!(worst <= tolerance, "{:?}: joints are off by {worst:e}", settings.method);
        let JointCoordinate { value, rate } = *world.get::<JointCoordinate>(stopped).unwrap();
        assert!((value - room).abs() < tolerance && rate.abs() < tolerance, "{:?}: {value}, {rate}", settings.method);
    }
}

/// A rod on a hinge that swings until its range is closed about the angle that it then has. Its two limits are rows of one
/// coordinate, of which one more would be redundant.
#[test]
fn a_range_of_no_width_holds() {
    for (settings, tolerance) in [(awake_game(), 1e-3), (SolverSettings::accurate(), 1e-9)] {
        let mut world = world_with(settings);
        let ground = world.spawn((RigidBody::Static, Position(DVec3::ZERO))).id();
        let rod = body(&mut world, Collider::cuboid(1.0, 0.1, 0.1), DVec3::X * 0.5);
        world.entity_mut(rod).insert((Mass(1.0), CollisionLayers::NONE));
        let joint = HingeJoint::new(ground, rod).with_anchors(DVec3::ZERO, DVec3::X * -0.5).with_axis(DVec3::Z);
        let hinge = world.spawn((joint, JointLimits::range(-3.0, 3.0))).id();
        let mut worst = worst_error(&mut world, 0.2);
        let there = world.get::<JointCoordinate>(hinge).unwrap().value;
        assert!(there < -0.1, "{:?}: it has not fallen: {there} rad", settings.method);
        world.entity_mut(hinge).insert(JointLimits::range(there, there));
        worst = worst.max(worst_error(&mut world, 1.0));
        assert!(worst <= tolerance, "{:?}: the joint is off by {worst:e}", settings.method);
        let JointCoordinate { value, rate } = *world.get::<JointCoordinate>(hinge).unwrap();
        assert!((value - there).abs() < tolerance && rate.abs() < tolerance, "{:?}: {value}, {rate}", settings.method);
    }
}

/// Ten radians a step: turns are counted, and what both hinges hold is held once.
#[test]
fn a_fast_rotor_spins_on_two_hinges_of_one_shaft() {
    for (settings, gap, share) in [(awake_game(), 1e-3, 1e-3), (SolverSettings::accurate(), 1e-9, 1e-9)] {
        let mut world = world_with(settings);
        let stand = world.spawn((RigidBody::Static, Position(DVec3::ZERO))).id();
        let rotor = body(&mut world, Collider::cuboid(0.6, 0.3, 0.2), DVec3::ZERO);
        let velocity = Velocity { linear: DVec3::ZERO, angular: DVec3::X * 600.0 };
        world.entity_mut(rotor).insert((Mass(10.0), velocity, CollisionLayers::NONE));
        let hinges = [-0.3, 0.3].map(|end| {
            let hinge = HingeJoint::new(stand, rotor).with_anchors(DVec3::X * end, DVec3::X * end);
            world.spawn((hinge.with_axis(DVec3::X), JointLoad::default())).id()
        });
        // Turns are counted by the rate of the step before: a new joint has none.
        step(&mut world);
        let first = world.get::<JointCoordinate>(hinges[0]).unwrap().value;
        let worst = worst_error(&mut world, 2.0);
        assert!(worst <= gap, "{:?}: {worst:e}", settings.method);
        let told = spin(&world, rotor);
        assert!((told - DVec3::X * 600.0).length() < share * 600.0, "{:?}: {told} rad/s", settings.method);
        for hinge in hinges {
            // Other methods turn a body by 2 atan(ωh/2) in a substep.
            if settings.method == Method::Exact {
                let turned = world.get::<JointCoordinate>(hinge).unwrap().value - first;
                assert!((turned / 1200.0 - 1.0).abs() < share, "{turned} rad");
            }
            // Half its weight each.
            let force = world.get::<JointLoad>(hinge).unwrap().force;
            let expected = DVec3::Y * 5.0 * G;
            assert!((force - expected).length() < 0.01 * expected.length(), "{:?}: {force} N", settings.method);
        }
    }
}

/// Six rods on hinges with limits, as a chain or as a ring, that fly with 6 J.
fn flying_rods(settings: SolverSettings, is_ring: bool) -> (World, Vec<Entity>) {
    let mut world = weightless(settings);
    let rods: Vec<Entity> = (0..6)
        .map(|side| {
            let turned = DQuat::from_rotation_z(f64::from(side) * std::f64::consts::FRAC_PI_3);
            let rod = body(&mut world, Collider::cuboid(1.0, 0.1, 0.1), turned * DVec3::NEG_Y * 0.75_f64.sqrt());
            let flies = Velocity { linear: DVec3::Y, ..default() };
            world.entity_mut(rod).insert((Rotation(turned), flies, Mass(2.0), CollisionLayers::NONE));
            rod
        })
        .collect();
    for side in 0..if is_ring { 6 } else { 5 } {
        let hinge = HingeJoint::new(rods[side], rods[(side + 1) % 6]).with_axis(DVec3::Z);
        let hinge = hinge.with_anchors(DVec3::X * 0.5, DVec3::X * -0.5);
        world.spawn((hinge, JointLimits::range(-0.5, 0.5)));
    }
    world.init_resource::<Diagnostics>();
    (world, rods)
}

/// Moves a body to where its joints are far apart, and past a limit. The most kinetic energy in the second after, J, and the
/// largest gap of a joint at its end, m or rad.
fn tear(world: &mut World, rod: Entity) -> (f64, f64) {
    world.get_mut::<Position>(rod).unwrap().0 += DVec3::new(0.3, 0.3, 0.2);
    world.get_mut::<Rotation>(rod).unwrap().0 *= DQuat::from_rotation_z(0.8);
    let mut energy: f64 = 0.0;
    for _ in 0..60 {
        step(world);
        energy = energy.max(world.resource::<Diagnostics>().kinetic_energy);
    }
    (energy, world.resource::<Diagnostics>().joint_error)
}

/// Somebody moves a rod to where its joints are far apart: they come together as fast as errors are corrected, and are not
/// thrown for it.
#[test]
fn what_is_far_apart_comes_together_and_is_not_thrown() {
    for is_ring in [false, true] {
        let (mut world, rods) = flying_rods(awake_game(), is_ring);
        steps(&mut world, 10);
        let (energy, gap) = tear(&mut world, rods[2]);
        assert!(energy < 6.5, "ring {is_ring}: it gains energy: {energy} J");
        assert!(gap < 1e-4, "ring {is_ring}: joints are apart by {gap} m");
    }
}

/// The same by the exact method while something touches a rod, which is solved together with the joints.
#[test]
fn what_is_far_apart_and_touched_comes_together_exactly_and_is_not_thrown() {
    for is_ring in [false, true] {
        let (mut world, rods) = flying_rods(SolverSettings::accurate(), is_ring);
        world.entity_mut(rods[0]).insert(CollisionLayers::default());
        let top = world.get::<Position>(rods[0]).unwrap().0 + DVec3::Y * 0.15;
        let rider = body(&mut world, Collider::sphere(0.1), top);
        let flies = Velocity { linear: DVec3::Y, ..default() };
        world.entity_mut(rider).insert((flies, Mass(0.1), SurfaceMaterial { restitution: 0.0, ..default() }));
        steps(&mut world, 2);
        let (energy, gap) = tear(&mut world, rods[2]);
        // With the rider's 0.05 J, and what lifts it off the rod that comes under it.
        assert!(energy < 6.5, "ring {is_ring}: it gains energy: {energy} J");
        assert!(gap < 1e-5, "ring {is_ring}: joints are apart by {gap} m");
    }
}
