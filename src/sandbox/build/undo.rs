//! Taking back what was built, cut or deleted, the last first.

use std::collections::HashMap;

use bevy::prelude::*;

use super::joint_change::JointChange;
use super::joints::{Pin, idle_without, joints_of};
use super::kept::KeptScene;
use super::names::name_of;
use crate::physics::RigidBody;
use crate::sandbox::state::report;
use crate::sandbox::{Selection, drag};
use crate::scene::{BodySpec, JointParts, SceneEntity};

/// How many deeds are remembered.
const DEPTH: usize = 64;

/// What undo would take back. A new start of the scene, or another scene, is one deed more that takes the place of what
/// was built before it.
#[derive(Resource, Default)]
pub struct UndoStack {
    deeds: Vec<(String, Deed)>,
}

/// What a deed did to the world.
pub enum Deed {
    /// These bodies and joints are new.
    Added(Vec<Entity>),
    /// These are gone.
    Removed {
        /// What each was.
        bodies: Vec<(Entity, BodySpec)>,
        /// The entity, its name, and what it was.
        joints: Vec<(Entity, Name, JointParts)>,
    },
    /// This joint is another.
    Changed {
        /// Its entity.
        joint: Entity,
        /// What makes it what it was.
        back: JointChange,
    },
    /// A scene in which something was built is on view no longer.
    Left(Box<KeptScene>),
}

impl UndoStack {
    /// Remembers a deed; `what` completes "undid …".
    pub fn push(&mut self, what: String, deed: Deed) {
        if self.deeds.len() == DEPTH {
            self.deeds.remove(0);
        }
        self.deeds.push((what, deed));
    }

    /// The bodies and joints that deeds mean are about to go. Tells whether there were such deeds.
    pub fn leave_scene(&mut self) -> bool {
        let count = self.deeds.len();
        self.deeds.retain(|(_, deed)| matches!(deed, Deed::Left(_)));
        self.deeds.len() < count
    }

    /// What the next undo would take back.
    pub fn next(&self) -> Option<&str> {
        self.deeds.last().map(|(what, _)| what.as_str())
    }

    /// Whether a change of that joint would be one more like the last deed.
    pub fn goes_on(&self, joint: Entity, change: &JointChange) -> bool {
        match self.deeds.last() {
            Some((_, Deed::Changed { joint: last, back })) => *last == joint && back.is_alike(change),
            _ => false,
        }
    }

    /// What came back came back as other entities: earlier deeds mean those from now on.
    fn rename(&mut self, renamed: &HashMap<Entity, Entity>) {
        let now = |entity: &mut Entity| *entity = *renamed.get(entity).unwrap_or(entity);
        for (_, deed) in &mut self.deeds {
            match deed {
                Deed::Added(entities) => entities.iter_mut().for_each(now),
                Deed::Changed { joint, .. } => now(joint),
                Deed::Left(_) => {} // its entities are made anew when it comes back
                Deed::Removed { joints, .. } => {
                    joints.iter_mut().flat_map(|(_, _, parts)| parts.bodies_mut()).for_each(now);
                }
            }
        }
    }
}

/// Deletes the picked body and its joints.
pub fn delete_picked(world: &mut World) {
    let Some(body) = world.resource::<Selection>().entity() else { return };
    world.insert_resource(Selection::default());
    drag::release(world); // a hand's drag is not the body's own
    let name = name_of(world, body);
    let joints = joints_of(world, body);
    let mut bodies = idle_without(world, &joints);
    bodies.push(body);
    let deed = remove(world, bodies, &joints);
    world.resource_mut::<UndoStack>().push(format!("deleting {name}"), deed);
    report(world, Ok(format!("deleted {name}")));
}

/// Despawns bodies and joints, and tells what they were.
pub fn remove(world: &mut World, bodies: Vec<Entity>, joints: &[Entity]) -> Deed {
    let bodies = bodies.into_iter().filter_map(|body| Some((body, describe(world, body)?))).collect::<Vec<_>>();
    let name = |joint| world.get::<Name>(joint).cloned().unwrap_or_default();
    let whole = |&joint: &Entity| Some((joint, name(joint), JointParts::of_entity(world, joint)?));
    let joints: Vec<_> = joints.iter().filter_map(whole).collect();
    let gone = joints.iter().map(|&(joint, ..)| joint).chain(bodies.iter().map(|&(body, _)| body));
    for entity in gone.collect::<Vec<_>>() {
        world.despawn(entity);
    }
    Deed::Removed { bodies, joints }
}

/// Forgets what was built in the running scene, which is about to go, but for the scene itself where something was: one
/// undo brings it back. Tells its name then. To be called before its bodies are despawned.
pub fn keep_what_was_built(world: &mut World) -> Option<String> {
    if !world.resource_mut::<UndoStack>().leave_scene() {
        return None;
    }
    let kept = KeptScene::of(world)?;
    let name = kept.name().to_owned();
    world.resource_mut::<UndoStack>().push(format!("leaving {name}"), Deed::Left(Box::new(kept)));
    Some(name)
}

/// Takes the last deed back. Of leaving a scene, tells which is to take the place of the present one.
pub fn undo(world: &mut World) -> Option<KeptScene> {
    let mut left = None;
    let outcome = match world.resource_mut::<UndoStack>().deeds.pop() {
        None => Err("nothing to undo".to_owned()),
        Some((what, Deed::Left(scene))) => {
            left = Some(*scene);
            Ok(format!("undid {what}"))
        }
        Some((what, deed)) => match take_back(world, deed) {
            true => Ok(format!("undid {what}")),
            false => Err(format!("cannot undo {what}: it is gone")),
        },
    };
    report(world, outcome);
    left
}

/// Tells whether there was anything left to take back.
fn take_back(world: &mut World, deed: Deed) -> bool {
    match deed {
        Deed::Added(entities) => {
            let gone: Vec<bool> = entities.into_iter().map(|entity| world.try_despawn(entity).is_err()).collect();
            !gone.contains(&true)
        }
        Deed::Removed { bodies, joints } => restore(world, bodies, joints),
        Deed::Changed { joint, mut back } => back.write(world, joint),
        Deed::Left(_) => false, // not one thing of the running scene
    }
}

/// Spawns bodies and joints anew; a joint whose other body has gone meanwhile stays away. Tells
/// whether anything came back.
fn restore(world: &mut World, bodies: Vec<(Entity, BodySpec)>, joints: Vec<(Entity, Name, JointParts)>) -> bool {
    let mut renamed = HashMap::new();
    for (was, body) in bodies {
        renamed.insert(was, respawn(world, &body));
    }
    for (was, name, mut parts) in joints {
        for end in parts.bodies_mut() {
            *end = *renamed.get(end).unwrap_or(end);
        }
        if parts.bodies().into_iter().all(|end| world.get::<RigidBody>(end).is_some()) {
            let mut joint = world.spawn((name, SceneEntity));
            renamed.insert(was, joint.id());
            parts.insert(&mut joint);
        }
    }
    world.resource_mut::<UndoStack>().rename(&renamed);
    !renamed.is_empty()
}

/// A body as it is now.
fn describe(world: &World, body: Entity) -> Option<BodySpec> {
    Some(BodySpec { name: name_of(world, body), ..BodySpec::of_entity(world, body)? })
}

fn respawn(world: &mut World, body: &BodySpec) -> Entity {
    let entity = body.spawn(world);
    if body.shape.is_none() {
        world.entity_mut(entity).insert(Pin); // nothing else without a shape is ever removed
    }
    entity
}
