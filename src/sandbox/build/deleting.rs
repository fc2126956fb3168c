//! Deleting what is picked.

use bevy::prelude::*;

use super::joining::cut;
use super::joints::{idle_without, joints};
use super::names::name_of;
use super::undo::{Deed, remember, remove};
use crate::sandbox::state::report;
use crate::sandbox::{Selection, drag};

/// Deletes the picked bodies with their joints, or the picked joint.
pub fn delete_picked(world: &mut World) {
    let selection = world.resource::<Selection>().clone();
    world.insert_resource(Selection::default());
    if let Some(joint) = selection.joint {
        return cut(world, joint);
    }
    let bodies: Vec<Entity> = selection.bodies().collect();
    if bodies.is_empty() {
        return;
    }
    let names = names(world, &bodies);
    let deed = delete(world, bodies);
    remember(world, format!("deleting {names}"), deed);
    report(world, Ok(format!("deleted {names}")));
}

/// Takes bodies out of the world, with their joints and the pins that hold nothing else.
pub fn delete(world: &mut World, mut bodies: Vec<Entity>) -> Deed {
    drag::release(world); // a hand's drag is not the body's own
    let mut own = joints(world);
    own.retain(|(_, joint)| joint.bodies().iter().any(|end| bodies.contains(end)));
    let own: Vec<Entity> = own.into_iter().map(|(joint, _)| joint).collect();
    let mut pins = idle_without(world, &own);
    pins.retain(|pin| !bodies.contains(pin));
    bodies.splice(0..0, pins);
    remove(world, bodies, &own)
}

/// What the user knows bodies by, in a few words.
pub fn names(world: &World, bodies: &[Entity]) -> String {
    match bodies {
        [one] => name_of(world, *one),
        [one, other] => format!("{} and {}", name_of(world, *one), name_of(world, *other)),
        bodies => format!("{} bodies", bodies.len()),
    }
}
