//! A hash of everything that the next step depends on.

use std::hash::Hasher;

use bevy::prelude::*;

use super::{Bodies, ContactGraph, ExactGroups, Joints, LaggedContacts, Position, Rotation, Velocity};

/// Feeds every bit that the next step depends on to a hasher: poses and velocities of all bodies
/// in the order in which they became bodies, what joints carried and their turns, who sleeps (not how long others have been calm), what
/// contacts carried, and those that wait for a lagged solve.
pub fn hash_state<H: Hasher>(world: &World, hasher: &mut H) {
    let mut feed = |value: f64| hasher.write_u64(value.to_bits());
    let Some(bodies) = world.get_resource::<Bodies>() else { return };
    for body in &bodies.list {
        if let (Some(position), Some(rotation), Some(velocity)) =
            (world.get::<Position>(body.entity), world.get::<Rotation>(body.entity), world.get::<Velocity>(body.entity))
        {
            position.0.to_array().into_iter().for_each(&mut feed);
            rotation.0.to_array().into_iter().for_each(&mut feed);
            velocity.linear.to_array().into_iter().for_each(&mut feed);
            velocity.angular.to_array().into_iter().for_each(&mut feed);
        }
    }
    bodies.asleep.iter().map(f64::from).for_each(&mut feed);
    if let Some(joints) = world.get_resource::<Joints>() {
        // What a joint carried the next step starts from; its turns tell which angle it is at.
        for joint in &joints.list {
            joint.force.iter().chain(&joint.torque).chain(&joint.multipliers).copied().for_each(&mut feed);
            feed(joint.definition.turned);
        }
    }
    if let Some(groups) = world.get_resource::<ExactGroups>() {
        groups.memory().for_each(&mut feed);
    }
    if let Some(graph) = world.get_resource::<ContactGraph>() {
        graph.forces().flat_map(|force| force.iter().copied()).for_each(&mut feed);
        for (slot, state) in graph.slots.iter().zip(&graph.states).filter(|(slot, _)| slot.touching) {
            feed(f64::from(slot.pair.a));
            state.impulses.0.iter().map(|&impulse| f64::from(impulse)).for_each(&mut feed);
        }
    }
    if let Some(lagged) = world.get_resource::<LaggedContacts>() {
        for manifold in &lagged.pending().manifolds {
            manifold.normal.iter().copied().for_each(&mut feed);
            for point in lagged.pending().points_of(manifold) {
                point.point.iter().copied().for_each(&mut feed);
                feed(point.depth);
            }
        }
    }
}
