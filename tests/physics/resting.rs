//! What should come to rest does, and what is joined stays joined.

use bevy::math::{DQuat, DVec3};
use bevy::prelude::*;
use plumb::physics::Diagnostics;
use plumb::prelude::*;

use crate::rig::*;

/// A figure of ten limbs with its feet `height` above the ground, leaning by `lean` rad; returns
/// its limbs.
fn figure(world: &mut World, at: DVec3, lean: f64) -> Vec<Entity> {
    let turn = DQuat::from_rotation_z(lean) * DQuat::from_rotation_y(3.0 * lean);
    let mut limbs = Vec::new();
    let mut limb = |world: &mut World, collider: Collider, x: f64, y: f64| {
        let place = at + turn * DVec3::new(x, y, 0.0);
        // Damped like those of the scene `limbs`: free limbs on ball joints swing for long.
        let damping = Damping { linear: 0.2, angular: 1.0 };
        let limb = world.spawn((RigidBody::Dynamic, collider, Position(place), Rotation(turn), damping)).id();
        limbs.push(limb);
        limb
    };
    let join = |world: &mut World, a, b, anchor_a: (f64, f64), anchor_b: (f64, f64)| {
        let anchors = [anchor_a, anchor_b].map(|(x, y)| DVec3::new(x, y, 0.0));
        world.spawn(BallJoint::new(a, b).with_anchors(anchors[0], anchors[1]));
    };
    let torso = limb(world, Collider::cuboid(0.4, 0.6, 0.2), 0.0, 1.2);
    let head = limb(world, Collider::sphere(0.14), 0.0, 1.66);
    join(world, torso, head, (0.0, 0.32), (0.0, -0.14));
    for side in [-1.0, 1.0] {
        let upper_arm = limb(world, Collider::cuboid(0.1, 0.32, 0.1), side * 0.27, 1.32);
        let forearm = limb(world, Collider::cone(0.06, 0.3), side * 0.27, 0.965);
        join(world, torso, upper_arm, (side * 0.23, 0.28), (side * -0.04, 0.16));
        join(world, upper_arm, forearm, (0.0, -0.13), (0.0, 0.225));
        let thigh = limb(world, Collider::cuboid(0.14, 0.42, 0.14), side * 0.12, 0.67);
        let shank = limb(world, Collider::cuboid(0.12, 0.42, 0.12), side * 0.12, 0.23);
        join(world, torso, thigh, (side * 0.12, -0.31), (0.0, 0.22));
        join(world, thigh, shank, (0.0, -0.22), (0.0, 0.22));
    }
    limbs
}

#[test]
fn figures_fall_and_come_to_rest_with_their_joints_held() {
    let mut world = world_with(SolverSettings::steady());
    world.init_resource::<Diagnostics>();
    ground(&mut world);
    let mut limbs = figure(&mut world, DVec3::new(0.0, 0.5, 0.0), 0.3);
    limbs.extend(figure(&mut world, DVec3::new(0.4, 2.6, 0.1), -0.8));
    let mut worst: f64 = 0.0;
    // A forearm that comes to lie on its side rolls for long.
    for _ in 0..900 {
        step(&mut world);
        worst = worst.max(world.resource::<Diagnostics>().joint_error);
    }
    assert!(worst < 0.02, "a joint parted by {worst} m on the way");
    let parted = world.resource::<Diagnostics>().joint_error;
    assert!(parted < 2e-3, "a joint is {parted} m apart at rest");
    for limb in limbs {
        let (speed, turning) = (velocity(&world, limb).length(), spin(&world, limb).length());
        assert!(speed < 0.05 && turning < 0.5, "{limb} still moves: {speed} m/s, {turning} rad/s");
        assert!(clearance(&world, limb) > -0.01, "{limb} is {} m in the ground", -clearance(&world, limb));
    }
}

#[test]
fn a_column_of_ten_boxes_stands_still() {
    let mut world = world_with(SolverSettings::steady());
    ground(&mut world);
    let boxes: Vec<_> = (0..10)
        .map(|level| body(&mut world, Collider::cuboid(1.0, 1.0, 1.0), DVec3::Y * (0.5 + f64::from(level))))
        .collect();
    run(&mut world, 5.0);
    for (level, &block) in (0_u32..).zip(&boxes) {
        // Each interface may sink by the slop, and sideways the column settles by a centimetre.
        assert_near(position(&world, block), DVec3::Y * (0.5 + f64::from(level)), 0.04);
        let speed = velocity(&world, block).length();
        assert!(speed < 0.01, "box {level} trembles at {speed} m/s");
    }
}

#[test]
fn every_shape_comes_to_rest_on_the_ground() {
    let mut world = world_with(SolverSettings::steady());
    ground(&mut world);
    let shapes = [Collider::sphere(0.4), Collider::cuboid(0.5, 0.8, 1.1), Collider::cone(0.4, 0.9)];
    let bodies: Vec<_> = shapes
        .into_iter()
        .enumerate()
        .map(|(index, shape)| {
            let dropped = body(&mut world, shape, DVec3::new(index as f64 * 3.0, 1.5, 0.0));
            let turn = Rotation(DQuat::from_euler(bevy::math::EulerRot::XYZ, 0.7, 0.2, 0.4));
            // A ball rolls for ever, and a cone on its side for long.
            world.entity_mut(dropped).insert((turn, Damping { linear: 0.2, angular: 0.5 }));
            dropped
        })
        .collect();
    run(&mut world, 10.0);
    for dropped in bodies {
        assert!(velocity(&world, dropped).length() < 0.02, "{}", velocity(&world, dropped));
        assert_close(clearance(&world, dropped), 0.0, 0.005);
    }
}

/// A box of 1 × 4 m on edge tips over where its centre is beyond the edge, at atan ¼, and falls back where it is not.
#[test]
fn what_leans_falls_to_the_side_where_its_centre_is() {
    let tipping = 0.25_f64.atan();
    for fitted_effort in [true, false] {
        for (lean, falls) in [(tipping - 0.01, false), (tipping + 0.01, true)] {
            let mut world = world_with(with_effort(SolverSettings::game(), fitted_effort));
            ground(&mut world);
            let turn = DQuat::from_rotation_z(-lean);
            // Its lower right edge is on the ground.
            let centre = turn * DVec3::new(-0.5, 2.0, 0.0);
            let tower = body(&mut world, Collider::cuboid(1.0, 4.0, 1.0), centre);
            world.entity_mut(tower).insert(Rotation(turn));
            run(&mut world, 6.0);
            let height = position(&world, tower).y;
            assert_eq!(height < 1.0, falls, "fitted {fitted_effort}, leaning by {lean}: {height} m");
        }
    }
}
