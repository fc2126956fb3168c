//! The same bits from run to run, however entities are made, and a hash that sees each of them. Threads are in the
//! matrix.

use bevy::math::{DQuat, DVec3};
use bevy::prelude::*;
use plumb::prelude::*;

use crate::rig::*;

/// A heap of mixed shapes with every third one joined to the next, and loose ones around it: many
/// islands, one of them large.
pub fn heap(settings: SolverSettings) -> World {
    let mut world = world_with(settings);
    ground(&mut world);
    let mut before: Option<Entity> = None;
    for index in 0..60_u32 {
        let turn = f64::from(index);
        let at = DVec3::new((turn * 2.4).sin() * 1.6, 0.6 + 0.22 * turn, (turn * 2.4).cos() * 1.6);
        let shape = match index % 7 {
            0 | 2 | 4 => Collider::cuboid(0.5, 0.6, 0.7),
            1 | 3 | 5 => Collider::sphere(0.35),
            _ => Collider::cone(0.4, 0.7),
        };
        let next = body(&mut world, shape, at);
        world.entity_mut(next).insert(Rotation(DQuat::from_rotation_z(turn)));
        if let Some(before) = before.filter(|_| index % 3 == 1) {
            let from = position(&world, before);
            let reach = (at - from) / 2.0;
            let turned = |body: Entity| world.get::<Rotation>(body).unwrap().0.inverse();
            let anchors = (turned(before) * reach, turned(next) * -reach);
            world.spawn(BallJoint::new(before, next).with_anchors(anchors.0, anchors.1));
        }
        before = Some(next);
    }
    for index in 0..105 {
        let at = DVec3::new(10.0 + f64::from(index % 15) * 1.5, 0.7, f64::from(index / 15) * 1.5);
        body(&mut world, Collider::cuboid(1.0, 1.0, 1.0), at);
    }
    world
}

#[test]
fn components_added_in_between_change_no_order() {
    // Moving an entity to another archetype reorders queries, and must not reorder the solver.
    let run_with = |disturb: bool| {
        let mut world = heap(SolverSettings::classic());
        for index in 0..3 {
            steps(&mut world, 10);
            if disturb {
                let mut bodies = world.query_filtered::<Entity, With<RigidBody>>();
                let some: Vec<Entity> = bodies.iter(&world).skip(index).step_by(3).collect();
                for entity in some {
                    world.entity_mut(entity).insert(Name::new("disturbed"));
                }
            }
        }
        state_hash(&world)
    };
    assert_eq!(run_with(false), run_with(true));
}

#[test]
fn the_hash_sees_one_bit_of_one_body() {
    let mut world = heap(SolverSettings::steady());
    step(&mut world);
    let before = state_hash(&world);
    let mut velocities = world.query::<&mut Velocity>();
    let mut velocity = velocities.iter_mut(&mut world).nth(40).unwrap();
    velocity.angular.z = f64::from_bits(velocity.angular.z.to_bits() ^ 1);
    assert_ne!(state_hash(&world), before);
}

/// A double pendulum by the exact method, which hits a ball on its way: whoever reads what its joints carry reads the load at
/// the end of each step, and changes no bit of what comes next.
#[test]
fn who_reads_what_joints_carry_changes_nothing() {
    let run_with = |reads: bool| {
        let mut world = world_with(SolverSettings::accurate());
        let post = world.spawn((RigidBody::Static, Position(DVec3::Y * 2.0))).id();
        let rods = [0.5, 1.5].map(|along| {
            let rod = body(&mut world, Collider::cuboid(1.0, 0.1, 0.1), DVec3::new(along, 2.0, 0.0));
            world.entity_mut(rod).insert(Mass(1.0));
            rod
        });
        body(&mut world, Collider::sphere(0.2), DVec3::new(1.2, 0.4, 0.0));
        let anchors = [DVec3::ZERO, DVec3::X * -0.5];
        let joints = [
            BallJoint::new(post, rods[0]).with_anchors(anchors[0], anchors[1]),
            BallJoint::new(rods[0], rods[1]).with_anchors(DVec3::X * 0.5, DVec3::X * -0.5),
        ]
        .map(|joint| world.spawn(joint).id());
        let mut hashes = Vec::new();
        for index in 0..60 {
            if reads && index == 5 {
                joints.into_iter().for_each(|joint| _ = world.entity_mut(joint).insert(JointLoad::default()));
            }
            step(&mut world);
            hashes.push(state_hash(&world));
        }
        hashes
    };
    assert_eq!(run_with(false), run_with(true));
}
