//! Where the pointer is, and whether its button is down.

use bevy::picking::pointer::{PointerId, PointerMap, PointerPress};
use bevy::prelude::*;
use bevy::window::PrimaryWindow;

/// How far a pointer may move in a click, logical pixels.
pub const SLACK: f32 = 5.0;

/// Where the pointer is in the window, logical pixels; none where it is outside.
pub fn place(world: &mut World) -> Option<Vec2> {
    let mut windows = world.query_filtered::<&Window, With<PrimaryWindow>>();
    windows.single(world).ok()?.cursor_position()
}

/// Whether its left button is down.
pub fn is_down(world: &World, pointer: PointerId) -> bool {
    let pointer = world.resource::<PointerMap>().get_entity(pointer);
    pointer.and_then(|pointer| world.get::<PointerPress>(pointer)).is_some_and(PointerPress::is_primary_pressed)
}
