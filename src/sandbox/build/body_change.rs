//! Changing a body while it is in the running scene.

use bevy::math::DVec3;
use bevy::prelude::*;

use super::names::name_of;
use super::rewriting::write_body;
use super::undo::{Deed, remember_change};
use crate::physics::RigidBody;
use crate::sandbox::state::report;
use crate::scene::{BodySpec, SceneSpec};

/// Has a body be as that says, but for its pose. What goes on with the last change, as a value does that is dragged, is undone
/// with it.
pub fn change_body(world: &mut World, body: Entity, asked: BodySpec, continues: bool) {
    if let Err(reason) = try_change(world, body, asked, continues) {
        report(world, Err(reason));
    }
}

fn try_change(world: &mut World, body: Entity, asked: BodySpec, continues: bool) -> Result<(), String> {
    let was = BodySpec::of_entity(world, body).ok_or("that body is gone")?;
    if asked.name.trim().is_empty() {
        return Err("a body has a name".into());
    }
    if asked.name != was.name && is_taken(world, &asked.name) {
        return Err(format!("another body is called {} already", asked.name));
    }
    let alone = SceneSpec { bodies: vec![asked.clone()], ..SceneSpec::new("changed body", DVec3::ZERO) };
    alone.validate().map_err(|error| error.to_string())?;
    let what = format!("changing {}", name_of(world, body));
    write_body(world, body, &asked);
    let speeds = |body: &BodySpec| [body.linear_velocity, body.angular_velocity];
    let velocity = speeds(&was) != speeds(&asked);
    remember_change(world, what, Deed::Rebuilt { body, back: Box::new(was), velocity }, continues);
    Ok(())
}

fn is_taken(world: &mut World, name: &str) -> bool {
    let mut names = world.query_filtered::<&Name, With<RigidBody>>();
    names.iter(world).any(|other| other.as_str() == name)
}
