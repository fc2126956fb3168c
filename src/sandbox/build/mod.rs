//! Building in the running scene: new bodies, joints between picked ones, and taking it back.
//!
//! Each thing built is one [`SandboxAction`](super::SandboxAction), so that keys, buttons and tests
//! do the same. What was asked for and makes no sense is said in a [`Notice`], and nothing happens.

mod blueprint;
mod joining;
mod spawning;
mod undo;

pub use blueprint::{Blueprint, Weight};
pub(super) use blueprint::{choose_mesh, stem};
pub(super) use joining::{cut, cut_picked, join_picked, pin_picked};
pub(super) use spawning::{spawn_body, unique_name};
pub(super) use undo::{UndoStack, delete_picked, undo};

use bevy::prelude::*;

use super::Notice;

pub(super) fn plugin(app: &mut App) {
    app.init_resource::<Blueprint>().init_resource::<UndoStack>();
}

/// Says what was done, or why it was not.
fn report(world: &mut World, outcome: Result<String, String>) {
    *world.resource_mut::<Notice>() = match outcome {
        Ok(done) => Notice::Info(done),
        Err(reason) => Notice::Error(reason),
    };
}

/// What the user knows a body by.
fn name_of(world: &World, body: Entity) -> String {
    world.get::<Name>(body).map_or_else(|| body.to_string(), ToString::to_string)
}
