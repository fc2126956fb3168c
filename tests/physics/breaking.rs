//! Joints that break: once, where and when they should, and what becomes of the rest.

use bevy::math::DVec3;
use bevy::prelude::*;
use plumb::prelude::*;

use crate::rig::*;

/// A slab of 40 kg that hangs on four rods of no weight to speak of, each of which bears so much, N.
fn hung(settings: SolverSettings, strengths: [f64; 4]) -> (World, Entity, Vec<Entity>) {
    let mut world = world_with(settings);
    let slab = body(&mut world, Collider::cuboid(2.0, 0.2, 2.0), DVec3::Y * -1.0);
    world.entity_mut(slab).insert((Mass(40.0), CollisionLayers::NONE));
    let corners = [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)];
    let rods = corners.into_iter().zip(strengths).map(|((x, z), strength)| {
        let post = world.spawn((RigidBody::Static, Position(DVec3::new(x, 0.0, z)))).id();
        let rod = DistanceJoint::rod(post, slab, 1.0).with_anchors(DVec3::ZERO, DVec3::new(x, 0.0, z));
        world.spawn((rod, Breakable::at_force(strength), JointLoad::default())).id()
    });
    let rods = rods.collect::<Vec<_>>();
    (world, slab, rods)
}

fn broken(world: &World, joints: &[Entity]) -> Vec<bool> {
    joints.iter().map(|&joint| world.get::<BrokenJoint>(joint).is_some()).collect()
}

#[test]
fn one_of_four_rods_snaps_and_then_the_other_three() {
    // Each carries a quarter of 392 N; of three, two carry half each.
    for threads in [1, 4] {
        let (mut world, slab, rods) = hung(SolverSettings { threads, ..awake_game() }, [90.0, 150.0, 150.0, 150.0]);
        run(&mut world, 0.9);
        assert_eq!(broken(&world, &rods), [false; 4], "no strength counts in the first second");
        let mut told = Vec::new();
        let mut first = Vec::new();
        for step_index in 0..120 {
            step(&mut world);
            let now = take::<JointBroke>(&mut world);
            if first.is_empty() && !now.is_empty() {
                first = now.clone();
                assert!((5..=8).contains(&step_index), "after {step_index} steps");
            }
            told.extend(now);
        }
        assert_eq!(first.len(), 1);
        assert_eq!(first[0].joint, rods[0]);
        assert!((first[0].force - 98.1).abs() < 2.0, "{}", first[0].force);
        assert_eq!(told.len(), 4, "each told once");
        assert_eq!(broken(&world, &rods), [true; 4]);
        assert!(position(&world, slab).y < -3.0, "it falls: {}", position(&world, slab).y);
    }
}

#[test]
fn a_hanging_chain_parts_at_its_one_weak_link_and_nowhere_else() {
    for settings in [awake_game(), SolverSettings::steady(), SolverSettings::accurate()] {
        let mut world = world_with(settings);
        let mut above = world.spawn((RigidBody::Static, Position(DVec3::ZERO))).id();
        let mut joints = Vec::new();
        for link in 0..8 {
            let y = -0.25 - 0.5 * f64::from(link);
            let rod = body(&mut world, Collider::cuboid(0.1, 0.5, 0.1), DVec3::Y * y);
            world.entity_mut(rod).insert((Mass(1.0), CollisionLayers::NONE));
            let upper = if link == 0 { DVec3::ZERO } else { DVec3::Y * -0.25 };
            let ball = BallJoint::new(above, rod).with_anchors(upper, DVec3::Y * 0.25);
            // Link k carries 8 − k kg.
            let strength = if link == 3 { 40.0 } else { 100.0 };
            joints.push(world.spawn((ball, Breakable::at_force(strength).at_once())).id());
            above = rod;
        }
        run(&mut world, 1.0);
        let expected: Vec<bool> = (0..8).map(|link| link == 3).collect();
        assert_eq!(broken(&world, &joints), expected, "{:?}", settings.method);
    }
}

#[test]
fn what_broke_is_mended_by_taking_its_mark_off() {
    let (mut world, slab, rods) = hung(awake_game(), [90.0, 300.0, 300.0, 300.0]);
    run(&mut world, 1.5);
    assert_eq!(broken(&world, &rods), [true, false, false, false]);
    world.entity_mut(rods[0]).remove::<(BrokenJoint, Breakable)>();
    run(&mut world, 4.0);
    let load = world.get::<JointLoad>(rods[0]).unwrap().force.length();
    assert!(load > 50.0, "it carries {load} N again");
    assert!((position(&world, slab).y + 1.0).abs() < 0.3);
}

#[test]
fn bodies_of_a_broken_joint_collide_once_they_are_apart() {
    let mut world = weightless(awake_game());
    let [a, b] = [0.0, 0.8].map(|x| body(&mut world, Collider::cuboid(1.0, 1.0, 1.0), DVec3::X * x));
    let ball = BallJoint::new(a, b).with_anchors(DVec3::X * 0.4, DVec3::X * -0.4);
    let joint = world.spawn((ball, BrokenJoint::default())).id();
    run(&mut world, 0.5);
    assert!(!world.get::<BrokenJoint>(joint).unwrap().apart);
    assert!((position(&world, b).x - 0.8).abs() < 1e-9, "they overlap and do not push: {}", position(&world, b).x);
    world.get_mut::<Position>(b).unwrap().0.x = 1.5;
    run(&mut world, 0.1);
    assert!(world.get::<BrokenJoint>(joint).unwrap().apart);
    world.get_mut::<Velocity>(b).unwrap().linear = DVec3::X * -1.0;
    run(&mut world, 2.0);
    let gap = position(&world, b).x - position(&world, a).x;
    assert!(gap > 0.98, "they collide: {gap} m between the centres");
}

#[test]
fn a_torque_breaks_what_bears_the_force() {
    for (torque, breaks) in [(9.0, true), (11.0, false)] {
        let mut world = world_with(awake_game());
        let post = world.spawn((RigidBody::Static, Position(DVec3::ZERO))).id();
        let arm = body(&mut world, Collider::cuboid(1.0, 0.2, 0.2), DVec3::X * 0.5);
        world.entity_mut(arm).insert((Mass(2.0), CollisionLayers::NONE));
        let fixed = FixedJoint::new(post, arm).with_anchors(DVec3::ZERO, DVec3::X * -0.5);
        // It carries 2 kg at half a metre: 9.81 N·m.
        let joint = world.spawn((fixed, Breakable::at_force(1e3).with_torque(torque))).id();
        run(&mut world, 1.5);
        assert_eq!(world.get::<BrokenJoint>(joint).is_some(), breaks, "at {torque} N m");
    }
}
