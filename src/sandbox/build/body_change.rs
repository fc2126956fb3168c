//! Changing a body while it is in the running scene.

use bevy::prelude::*;

use super::names::name_of;
use super::undo::{Deed, UndoStack, remember};
use crate::physics::{Inertia, Mass, SurfaceMaterial, Velocity};
use crate::sandbox::state::report;
use crate::scene::{BodyColor, BodySpec, SceneSpec};

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
    let alone = SceneSpec { bodies: vec![asked.clone()], ..SceneSpec::new("changed body", bevy::math::DVec3::ZERO) };
    alone.validate().map_err(|error| error.to_string())?;
    let what = format!("changing {}", name_of(world, body));
    write_body(world, body, &asked);
    if !(continues && world.resource::<UndoStack>().goes_on_with_body(body)) {
        let speeds = |body: &BodySpec| [body.linear_velocity, body.angular_velocity];
        let velocity = speeds(&was) != speeds(&asked);
        remember(world, what, Deed::Rebuilt { body, back: Box::new(was), velocity });
    }
    Ok(())
}

fn is_taken(world: &mut World, name: &str) -> bool {
    let mut names = world.query_filtered::<&Name, With<crate::physics::RigidBody>>();
    names.iter(world).any(|other| other.as_str() == name)
}

/// Writes what of it differs, but for the pose. What it was; none where it is gone.
pub fn write_body(world: &mut World, body: Entity, asked: &BodySpec) -> Option<BodySpec> {
    let was = BodySpec::of_entity(world, body)?;
    let mut entity = world.entity_mut(body);
    if asked.name != was.name {
        entity.insert(Name::new(asked.name.clone()));
    }
    if asked.kind != was.kind {
        entity.insert(asked.kind);
    }
    let has_other_shape = asked.shape != was.shape;
    if let (Some(shape), true) = (&asked.shape, has_other_shape) {
        entity.insert(shape.collider());
    }
    match asked.mass {
        Some(mass) if asked.mass != was.mass => _ = entity.insert(Mass(mass)),
        // Found anew from shape and density.
        None if was.mass.is_some() || has_other_shape => _ = entity.remove::<Mass>(),
        _ => {}
    }
    if has_other_shape || asked.mass != was.mass {
        entity.remove::<Inertia>();
    }
    if asked.material != was.material {
        let material = asked.material;
        entity.insert(SurfaceMaterial { friction: material.friction, restitution: material.restitution });
    }
    if asked.layers != was.layers {
        entity.insert(asked.layers);
    }
    let velocity = Velocity { linear: asked.linear_velocity, angular: asked.angular_velocity };
    if velocity != (Velocity { linear: was.linear_velocity, angular: was.angular_velocity }) {
        entity.insert(velocity);
    }
    if asked.color != was.color {
        match asked.color {
            Some(color) => _ = entity.insert(BodyColor(color)),
            None => _ = entity.remove::<BodyColor>(),
        }
    }
    Some(was)
}
