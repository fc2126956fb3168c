//! What bodies and joints are called.

use std::collections::HashSet;

use bevy::prelude::*;

use crate::physics::RigidBody;

/// What the user knows a body by.
pub fn name_of(world: &World, body: Entity) -> String {
    world.get::<Name>(body).map_or_else(|| body.to_string(), ToString::to_string)
}

/// The noun, or with the least number that makes it a name no body has: what is saved is told
/// apart by names.
pub fn unique_name(world: &mut World, noun: &str) -> String {
    let mut names = world.query_filtered::<&Name, With<RigidBody>>();
    let taken: HashSet<&str> = names.iter(world).map(Name::as_str).collect();
    let numbered = (2_u64..).map(|number| format!("{noun} {number}"));
    std::iter::once(noun.to_owned()).chain(numbered).find(|name| !taken.contains(name.as_str())).expect("a free number")
}
