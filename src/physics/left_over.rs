//! Whether the step keeps something of what is gone.

use bevy::prelude::*;

use super::{Bodies, ContactGraph, JointSlot, Joints, RigidBody, SolverSettings};

/// The first thing that the step still keeps of an entity that is no body or joint any more, in words. To be asked right
/// after a step: what goes later is known to the next.
pub fn left_over(world: &World) -> Option<String> {
    let is_body = |entity: Entity| world.get::<RigidBody>(entity).is_some();
    let bodies = world.get_resource::<Bodies>().map_or(&[][..], |bodies| &bodies.list);
    if let Some(body) = bodies.iter().find(|body| !is_body(body.entity)) {
        return Some(format!("{} is gone, but not its packed body", body.entity));
    }
    let joints = world.get_resource::<Joints>().map_or(&[][..], |joints| &joints.list);
    if let Some(joint) = joints.iter().find(|joint| world.get::<JointSlot>(joint.entity).is_none()) {
        return Some(format!("{} is gone, but not its packed joint", joint.entity));
    }
    // Methods without contacts that last leave those of another as they were; who comes back to it begins anew.
    if !world.resource::<SolverSettings>().method.keeps_contacts() {
        return None;
    }
    let slots = world.get_resource::<ContactGraph>().map_or(&[][..], |graph| &graph.slots);
    let ends = slots.iter().filter_map(|slot| slot.entities);
    let mut gone = ends.filter(|(a, b)| !is_body(*a) || !is_body(*b));
    gone.next().map(|(a, b)| format!("the pair of {a} and {b} has a slot, but one of them is gone"))
}
