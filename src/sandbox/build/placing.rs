//! Putting bodies somewhere else, turned or of another size.

use bevy::math::DVec3;
use bevy::prelude::*;

use super::names::name_of;
use super::place::Place;
use super::placement::Placement;
use super::rewriting::write_body;
use super::undo::{Deed, remember_change};
use crate::physics::{RigidBody, Velocity, place};
use crate::sandbox::Playback;
use crate::sandbox::state::report;
use crate::scene::{BodySpec, SceneSpec};

/// Puts them there. While time runs they stand still there: a hand holds them. What goes on with the last change, as a drag
/// does, is undone with it.
pub fn place_bodies(world: &mut World, placements: &[Placement], continues: bool) {
    if let Err(reason) = try_place(world, placements, continues) {
        report(world, Err(reason));
    }
}

fn try_place(world: &mut World, placements: &[Placement], continues: bool) -> Result<(), String> {
    let mut were = Vec::with_capacity(placements.len());
    let mut asked = Vec::with_capacity(placements.len());
    for placement in placements {
        let was = Place::of(world, placement.body, placement.shape.is_some()).ok_or("a body is gone")?;
        asked.push(check(world, placement)?);
        were.push(was);
    }
    let Some(first) = placements.first() else { return Ok(()) };
    let what = match placements.len() {
        1 => format!("moving {}", name_of(world, first.body)),
        count => format!("moving {count} bodies"),
    };
    let is_held = !world.resource::<Playback>().paused;
    for (placement, asked) in placements.iter().zip(asked) {
        if let Some(asked) = asked {
            write_body(world, placement.body, &asked);
        }
        place(world, placement.body, placement.position, placement.rotation);
        let mut body = world.entity_mut(placement.body);
        let moves = body.get::<RigidBody>() == Some(&RigidBody::Dynamic);
        if is_held && moves && body.get::<Velocity>() != Some(&Velocity::default()) {
            body.insert(Velocity::default());
        }
    }
    remember_change(world, what, Deed::Placed(were), continues);
    Ok(())
}

/// What the body is to be, where its shape changes.
fn check(world: &World, placement: &Placement) -> Result<Option<BodySpec>, String> {
    let Placement { body, position, rotation, shape } = placement;
    let name = name_of(world, *body);
    if !position.is_finite() || (rotation.length() - 1.0).abs() > 1e-6 {
        return Err(format!("{name} cannot be put there: the place or the turn is none"));
    }
    let Some(shape) = shape else { return Ok(None) };
    let mut asked = BodySpec::of_entity(world, *body).ok_or("that body is gone")?;
    asked.shape = Some(shape.clone());
    let alone = SceneSpec { bodies: vec![asked.clone()], ..SceneSpec::new("placed body", DVec3::ZERO) };
    alone.validate().map_err(|error| error.to_string())?;
    Ok(Some(asked))
}
