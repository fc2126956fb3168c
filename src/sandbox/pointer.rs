//! Whether a pointer's button is down.

use bevy::picking::pointer::{PointerId, PointerMap, PointerPress};
use bevy::prelude::*;

/// How far a pointer may move in a click, logical pixels.
pub const SLACK: f32 = 5.0;

/// Whether its left button is down.
pub fn is_down(world: &World, pointer: PointerId) -> bool {
    let pointer = world.resource::<PointerMap>().get_entity(pointer);
    pointer.and_then(|pointer| world.get::<PointerPress>(pointer)).is_some_and(PointerPress::is_primary_pressed)
}
