//! The same bits whatever the number of threads, from run to run, and however entities are made.

use bevy::math::{DQuat, DVec3};
use bevy::prelude::*;
use bevy::tasks::ComputeTaskPool;
use plumb::prelude::*;

use crate::rig::*;

/// A heap of mixed shapes with every third one joined to the next, and loose ones around it: many
/// islands, one of them large.
fn heap(settings: SolverSettings) -> World {
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
fn threads_do_not_change_a_bit() {
    for settings in [
        SolverSettings::game(),
        SolverSettings::sequential_impulses(),
        SolverSettings::xpbd(),
        SolverSettings::steady(),
        SolverSettings::classic(),
        SolverSettings::accurate(),
        SolverSettings { method: Method::PrimedGaussSeidel, ..SolverSettings::steady() },
        SolverSettings { method: Method::NonsmoothConjugateGradient, ..SolverSettings::steady() },
        SolverSettings { method: Method::JointSpace, ..SolverSettings::steady() },
    ] {
        for precision in [Precision::F32, Precision::F64] {
            let hashes: Vec<Vec<u64>> = [1, 2, 4, 1]
                .into_iter()
                .map(|threads| {
                    let mut world = heap(SolverSettings { threads, precision, ..settings });
                    (0..3)
                        .map(|_| {
                            steps(&mut world, 12);
                            state_hash(&world)
                        })
                        .collect()
                })
                .collect();
            assert!(ComputeTaskPool::get().thread_num() >= 4, "the pool has too few threads to prove it");
            assert!(
                hashes.iter().all(|of_run| *of_run == hashes[0]),
                "{:?} {precision:?}: {hashes:?}",
                settings.method
            );
            let of_run = &hashes[0];
            assert!(of_run[0] != of_run[1] && of_run[1] != of_run[2], "{:?}: the hash sees no motion", settings.method);
        }
    }
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
