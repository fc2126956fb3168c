use bevy::ecs::system::RunSystemOnce;

use super::*;
use crate::physics::body::{Body, RigidBody};
use crate::physics::collision::{Manifold, Pair};
use crate::physics::joint::Joint;
use nalgebra::Vector3;

fn joint(a: u32, b: u32) -> Joint {
    Joint::new(Entity::PLACEHOLDER, [a, b], default())
}

fn touch(a: u32, b: u32) -> Manifold {
    let normal = Vector3::y();
    Manifold {
        parts: Default::default(),
        slot: None,
        pair: Pair { a, b },
        normal,
        first_point: 0,
        point_count: 0,
        friction: 0.0,
        restitution: 0.0,
    }
}

/// A world after `find_islands`.
fn islands_of(kinds: &[RigidBody], joints: &[(u32, u32)], contacts: &[(u32, u32)]) -> World {
    let mut world = World::new();
    let list = kinds.iter().map(|&kind| Body { kind, ..Body::new(Entity::PLACEHOLDER) }).collect();
    world.insert_resource(Bodies::of(list));
    world.insert_resource(Joints { list: joints.iter().map(|&(a, b)| joint(a, b)).collect(), ..Joints::default() });
    let manifolds = contacts.iter().map(|&(a, b)| touch(a, b)).collect();
    world.insert_resource(Contacts { manifolds, ..Default::default() });
    world.init_resource::<LaggedContacts>();
    world.init_resource::<SolverSettings>();
    world.init_resource::<StepStats>();
    world.init_resource::<Islands>();
    world.run_system_once(find_islands).unwrap();
    world
}

const MOVES: RigidBody = RigidBody::Dynamic;

#[test]
fn static_and_kinematic_bodies_connect_nobody() {
    let kinds = [RigidBody::Static, MOVES, MOVES, RigidBody::Kinematic, MOVES, MOVES];
    let world = islands_of(&kinds, &[(3, 4)], &[(0, 1), (2, 0), (3, 5)]);
    assert_eq!(world.resource::<StepStats>().islands, 4);
    let world = islands_of(&kinds, &[(3, 4), (1, 5)], &[(0, 1), (2, 0), (3, 5)]);
    assert_eq!(world.resource::<StepStats>().islands, 3, "1 and 5 are joined, 2 and 4 are alone");
}

#[test]
fn bodies_that_no_constraint_holds_are_moved_but_not_counted() {
    let world = islands_of(&[MOVES, RigidBody::Static, MOVES], &[], &[]);
    assert_eq!(world.resource::<StepStats>().islands, 0);
    let islands = world.resource::<Islands>();
    assert_eq!((0..islands.count()).flat_map(|group| islands.bodies(group)).collect::<Vec<_>>(), [&0, &2]);
}

#[test]
fn groups_hold_whole_islands_and_every_constraint_once_in_order() {
    // 300 bodies in chains of 5 on a static ground, and contacts listed backwards.
    let mut kinds = vec![MOVES; 300];
    kinds.push(RigidBody::Static);
    let joints: Vec<_> = (0..299).filter(|body| body % 5 != 4).map(|body| (body, body + 1)).collect();
    let contacts: Vec<_> = (0..300).rev().map(|body| (300, body)).collect();
    let world = islands_of(&kinds, &joints, &contacts);
    assert_eq!(world.resource::<StepStats>().islands, 60);
    let islands = world.resource::<Islands>();
    assert!((3..=4).contains(&islands.count()), "{} groups", islands.count());
    let mut bodies = Vec::new();
    let mut seen = (0, 0);
    for group in 0..islands.count() {
        assert!(islands.bodies(group).len() <= BODIES_PER_GROUP as usize);
        for (local, &body) in islands.bodies(group).iter().enumerate() {
            bodies.push(body);
            assert_eq!(islands.local_of(body, group), Some(local as u32));
        }
        for &index in islands.joints(group) {
            let (a, b) = joints[index as usize];
            assert!(islands.local_of(a, group).is_some() && islands.local_of(b, group).is_some());
        }
        for &index in islands.manifolds(group) {
            let (ground, body) = contacts[index as usize];
            assert!(islands.local_of(body, group).is_some());
            assert_eq!(islands.local_of(ground, group), None);
        }
        assert!(islands.joints(group).is_sorted() && islands.manifolds(group).is_sorted());
        seen = (seen.0 + islands.joints(group).len(), seen.1 + islands.manifolds(group).len());
    }
    bodies.sort_unstable();
    assert_eq!(bodies, (0..300).collect::<Vec<_>>());
    assert_eq!(seen, (joints.len(), contacts.len()));
}

#[test]
fn an_island_larger_than_a_group_stays_whole() {
    let joints: Vec<_> = (0..199).map(|body| (body, body + 1)).collect();
    let world = islands_of(&[MOVES; 200], &joints, &[]);
    let islands = world.resource::<Islands>();
    assert_eq!(islands.count(), 1);
    assert_eq!(islands.bodies(0).len(), 200);
}

#[test]
fn a_constraint_between_bodies_that_do_not_move_is_in_no_group() {
    let kinds = [RigidBody::Static, RigidBody::Kinematic, MOVES];
    let world = islands_of(&kinds, &[], &[(0, 1), (1, 2)]);
    let islands = world.resource::<Islands>();
    let manifolds: Vec<_> = (0..islands.count()).flat_map(|group| islands.manifolds(group)).collect();
    assert_eq!(manifolds, [&1]);
}
