//! Copies of what is picked: beside it, or by way of the clipboard, as the text of a scene file.

use std::collections::HashMap;

use bevy::math::DVec3;
use bevy::prelude::*;

use super::deleting::{delete, names};
use super::excerpt::{excerpt, excerpt_of_world};
use super::joints::Pin;
use super::names::unique_names;
use super::room::Crowd;
use super::spawning::surface;
use super::undo::{Deed, remember};
use crate::physics::{Collider, Gravity, RigidBody, Shape};
use crate::sandbox::clipboard::Clipboard;
use crate::sandbox::state::report;
use crate::sandbox::{Selection, camera};
use crate::scene::{MAX_BODIES, MAX_FILE_BYTES, SceneSpec, ShapeSpec};

/// What texts from the clipboard are called in what is said of them.
const SOURCE: &str = "clipboard";

/// Makes the picked bodies once more, beside them.
pub fn duplicate(world: &mut World) {
    let outcome = try_duplicate(world);
    report(world, outcome);
}

fn try_duplicate(world: &mut World) -> Result<String, String> {
    let (bodies, scene) = picked(world)?;
    let crowd = Crowd::new(&scene);
    let offset = beside(world, &crowd, &bodies)?;
    let what = names(world, &bodies);
    put(world, scene, offset, |_, _| format!("duplicating {what}"))?;
    Ok(format!("duplicated {what}"))
}

/// Copies the picked bodies to the clipboard.
pub fn copy(world: &mut World) {
    let outcome = try_copy(world).map(|bodies| format!("copied {}", names(world, &bodies)));
    report(world, outcome);
}

/// Copies them to the clipboard and deletes them.
pub fn cut_out(world: &mut World) {
    let outcome = try_copy(world).map(|bodies| {
        let what = names(world, &bodies);
        world.insert_resource(Selection::default());
        let deed = delete(world, bodies);
        remember(world, format!("cutting out {what}"), deed);
        format!("cut out {what}")
    });
    report(world, outcome);
}

fn try_copy(world: &mut World) -> Result<Vec<Entity>, String> {
    let (bodies, scene) = picked(world)?;
    let text = scene.to_ron(None).map_err(|error| error.to_string())?;
    world.resource_mut::<Clipboard>().set(text);
    Ok(bodies)
}

/// The picked bodies, and a scene of them.
fn picked(world: &mut World) -> Result<(Vec<Entity>, SceneSpec), String> {
    let mut bodies: Vec<Entity> = world.resource::<Selection>().bodies().collect();
    bodies.retain(|body| world.get::<Collider>(*body).is_some());
    if bodies.is_empty() {
        return Err("pick what is to be copied: click a body, or draw a box around some".into());
    }
    let scene = excerpt_of_world(world, &bodies);
    Ok((bodies, scene))
}

/// Adds what the clipboard has: at the pointer; where that is off the picture, where it was, or beside it.
pub fn paste(world: &mut World) {
    let outcome = try_paste(world);
    report(world, outcome);
}

fn try_paste(world: &mut World) -> Result<String, String> {
    let text = world.resource_mut::<Clipboard>().get();
    let text = text.ok_or("there is nothing to paste: copy bodies, or the text of a scene file")?;
    if text.len() as u64 > MAX_FILE_BYTES {
        return Err(format!(
            "what the clipboard has is larger than {} MiB, the limit for a scene",
            MAX_FILE_BYTES >> 20
        ));
    }
    let scene = SceneSpec::from_ron(&text, SOURCE).map_err(|error| format!("cannot be pasted: {error}"))?;
    let scene = without_second_ground(world, scene);
    if scene.bodies.is_empty() {
        return Err("cannot be pasted: the clipboard has a scene without bodies".into());
    }
    let crowd = Crowd::new(&scene);
    let offset = match at_pointer(world, &crowd, scene.bodies.iter().any(|body| body.shape.is_none()))? {
        Some(offset) => offset,
        None => match crowd.room(world, &[], DVec3::ZERO, DVec3::X) {
            Some(DVec3::ZERO) => DVec3::ZERO,
            _ => beside(world, &crowd, &[])?,
        },
    };
    let bodies = put(world, scene, offset, |world, made| format!("pasting {}", names(world, made)))?;
    Ok(format!("pasted {}", names(world, &bodies)))
}

/// A whole scene that is pasted into one with a ground stands on that.
fn without_second_ground(world: &mut World, scene: SceneSpec) -> SceneSpec {
    let mut bodies = world.query_filtered::<&Collider, With<RigidBody>>();
    if !bodies.iter(world).any(|collider| *collider.shape() == Shape::HalfSpace) {
        return scene;
    }
    let stays = |shape: &Option<ShapeSpec>| *shape != Some(ShapeSpec::HalfSpace);
    let stay: Vec<bool> = scene.bodies.iter().map(|body| stays(&body.shape)).collect();
    excerpt(scene, &stay)
}

/// The offset that puts a crowd on what the pointer is on; what hangs on the world keeps its height. None: the pointer is off
/// the picture.
fn at_pointer(world: &mut World, crowd: &Crowd, hangs: bool) -> Result<Option<DVec3>, String> {
    let Some(aim) = world.run_system_cached(camera::aim).ok().flatten().filter(|aim| aim.by_pointer) else {
        return Ok(None);
    };
    let up = up(world);
    let middle = crowd.middle();
    let offset = match world.run_system_cached_with(surface, aim).ok().flatten() {
        Some((point, _)) => {
            let aside = (point - middle).reject_from_normalized(up);
            let lift = if hangs { 0.0 } else { point.dot(up) - crowd.extent(up)[0] + crowd.gap() };
            aside + up * lift
        }
        None => aim.origin + aim.direction * aim.distance - middle,
    };
    crowd.room(world, &[], offset, up).map(Some).ok_or("there is no room for it there".into())
}

/// Against gravity, along an axis of the world.
fn up(world: &World) -> DVec3 {
    let up = world.get_resource::<Gravity>().map_or(DVec3::Y, |gravity| -gravity.0);
    if up == DVec3::ZERO {
        return DVec3::Y;
    }
    let axis = up.abs().max_position();
    DVec3::AXES[axis] * up[axis].signum()
}

/// The least offset to the right, as it is seen, at which a crowd overlaps neither these bodies nor anything else.
fn beside(world: &mut World, crowd: &Crowd, own: &[Entity]) -> Result<DVec3, String> {
    let mut cameras = world.query_filtered::<&GlobalTransform, With<Camera3d>>();
    let right = cameras.single(world).map_or(DVec3::X, |camera| camera.right().as_dvec3());
    let right = right.reject_from_normalized(up(world));
    let axis = right.abs().max_position();
    let along = DVec3::AXES[axis] * if right[axis] < 0.0 { -1.0 } else { 1.0 };
    let [low, high] = crowd.extent(along);
    let clear = high - low + crowd.gap();
    crowd.room(world, own, along * clear, along).ok_or("there is no room beside it".into())
}

/// Spawns a scene beside what is there, moved by that, and picks it; `what` says of the bodies that are drawn, which are handed
/// back, what was done.
fn put(
    world: &mut World,
    mut scene: SceneSpec,
    offset: DVec3,
    what: impl FnOnce(&World, &[Entity]) -> String,
) -> Result<Vec<Entity>, String> {
    let there = world.query::<&RigidBody>().iter(world).count();
    if there + scene.bodies.len() > MAX_BODIES {
        return Err(format!("a scene has at most {MAX_BODIES} bodies: it has {there} already"));
    }
    let is_world = |name: &str| name.starts_with("world:");
    let wanted = scene.bodies.iter().map(|body| if is_world(&body.name) { "world:pin" } else { &body.name });
    let unique = unique_names(world, wanted);
    let renamed: HashMap<&str, &String> = scene.bodies.iter().map(|body| body.name.as_str()).zip(&unique).collect();
    for joint in &mut scene.joints {
        for name in [&mut joint.body_a, &mut joint.body_b] {
            if let Some(unique) = renamed.get(name.as_str()) {
                name.clone_from(unique);
            }
        }
    }
    for (body, name) in scene.bodies.iter_mut().zip(unique) {
        body.name = name;
        body.position += offset;
    }
    scene.validate().map_err(|error| error.to_string())?;
    let spawned = scene.spawn_beside(world);
    let mut bodies = Vec::new();
    for (entity, body) in spawned.bodies.iter().zip(&scene.bodies) {
        if body.shape.is_some() {
            bodies.push(*entity);
        } else if is_world(&body.name) {
            world.entity_mut(*entity).insert(Pin);
        }
    }
    world.insert_resource(Selection::of_bodies(bodies.iter().copied()));
    let made = spawned.joints.into_iter().chain(spawned.bodies).collect();
    let what = what(world, &bodies);
    remember(world, what, Deed::Added(made));
    Ok(bodies)
}
