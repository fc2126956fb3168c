//! Taking back what was built, cut or deleted, the last first.

use bevy::prelude::*;

use super::joint_change::JointChange;
use super::joints::{Pin, idle_without, joints_of};
use super::kept::KeptScene;
use super::names::name_of;
use crate::physics::{History, RigidBody, StepStats, bury, is_empty, uncut};
use crate::sandbox::state::report;
use crate::sandbox::{Selection, drag};
use crate::scene::{BodySpec, JointParts, SceneEntity};

/// How many deeds are remembered.
const DEPTH: usize = 64;

/// What undo would take back. A new start of the scene, or another scene, is one deed more that takes the place of what
/// was built before it.
#[derive(Resource, Default)]
pub struct UndoStack {
    deeds: Vec<Done>,
    /// Those that the scene has not come to (it went back), the next last.
    ahead: Vec<Done>,
    /// How often what was to come had been cut off when that was looked at.
    cuts: u64,
}

/// A deed, and when it was done.
pub struct Done {
    /// Completes "undid …".
    what: String,
    deed: Deed,
    /// Steps that the world had made.
    step: u64,
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
    /// Something was done in the past: what was to come will not, by the count of such cuts, nor these deeds.
    Cut(u64, Vec<Done>),
    /// A scene in which something was built is on view no longer.
    Left(Box<KeptScene>),
}

impl UndoStack {
    /// Forgets the bodies and joints that deeds mean, which are about to go. Tells whether there were such deeds.
    pub fn leave_scene(&mut self) -> bool {
        self.ahead.clear();
        let built = self.deeds.iter().any(|done| !matches!(done.deed, Deed::Left(_) | Deed::Cut(..)));
        self.deeds.retain(|done| matches!(done.deed, Deed::Left(_)));
        built
    }

    /// What the next undo would take back.
    pub fn next(&self) -> Option<&str> {
        self.deeds.last().map(|done| done.what.as_str())
    }

    /// Whether a change of that joint would be one more like the last deed.
    pub fn goes_on(&self, joint: Entity, change: &JointChange) -> bool {
        match self.deeds.last().map(|done| &done.deed) {
            Some(Deed::Changed { joint: last, back }) => *last == joint && back.is_alike(change),
            _ => false,
        }
    }

    /// The scene went to another of its moments: what was done later is not done there, and is again once it comes to
    /// it.
    fn go(&mut self, step: u64, cuts: u64) {
        if cuts > self.cuts {
            let what = "what was done in the past".to_owned();
            let deed = Deed::Cut(cuts, std::mem::take(&mut self.ahead));
            self.deeds.push(Done { what, deed, step });
        }
        self.cuts = cuts;
        let is_done = |done: &Done| done.step <= step || matches!(done.deed, Deed::Left(_));
        while self.deeds.last().is_some_and(|done| !is_done(done)) {
            self.ahead.extend(self.deeds.pop());
        }
        while self.ahead.last().is_some_and(is_done) {
            self.deeds.extend(self.ahead.pop());
        }
    }
}

/// Has the deeds be those of the moment at which the scene is.
pub fn follow_time(world: &mut World) {
    let (step, cuts) = (world.resource::<StepStats>().steps, cuts(world));
    world.resource_mut::<UndoStack>().go(step, cuts);
}

fn cuts(world: &World) -> u64 {
    world.get_resource::<History>().map_or(0, History::cuts)
}

/// Remembers a deed; `what` completes "undid …". What was to come after this moment will not.
pub fn remember(world: &mut World, what: String, deed: Deed) {
    // Before it: what was to come is cut off by it.
    History::take_in(world);
    follow_time(world);
    let step = world.resource::<StepStats>().steps;
    let mut stack = world.resource_mut::<UndoStack>();
    if stack.deeds.len() == DEPTH {
        stack.deeds.remove(0);
    }
    stack.deeds.push(Done { what, deed, step });
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
    remember(world, format!("deleting {name}"), deed);
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
        bury(world, entity);
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
    remember(world, format!("leaving {name}"), Deed::Left(Box::new(kept)));
    Some(name)
}

/// Takes the last deed back. Of leaving a scene, tells which is to take the place of the present one.
pub fn undo(world: &mut World) -> Option<KeptScene> {
    History::take_in(world);
    follow_time(world);
    let mut left = None;
    let outcome = match world.resource_mut::<UndoStack>().deeds.pop() {
        None => Err("nothing to undo".to_owned()),
        Some(Done { what, deed: Deed::Left(scene), .. }) => {
            left = Some(*scene);
            Ok(format!("undid {what}"))
        }
        Some(Done { what, deed: Deed::Cut(cut, ahead), .. }) => take_back_cut(world, &what, cut, ahead),
        Some(Done { what, deed, .. }) => {
            let was_there = take_back(world, deed);
            // Where that ends what was to come, the next undo is not to bring back what this one took.
            History::take_in(world);
            let cuts = cuts(world);
            let mut stack = world.resource_mut::<UndoStack>();
            if std::mem::replace(&mut stack.cuts, cuts) != cuts {
                stack.ahead.clear();
            }
            match was_there {
                true => Ok(format!("undid {what}")),
                false => Err(format!("cannot undo {what}: it is gone")),
            }
        }
    };
    report(world, outcome);
    left
}

/// What was to come is again.
fn take_back_cut(world: &mut World, what: &str, cut: u64, ahead: Vec<Done>) -> Result<String, String> {
    drag::release(world);
    uncut(world, cut).map_err(|_| format!("cannot undo {what}: what was to come then is not kept any more"))?;
    let cuts = cuts(world);
    let mut stack = world.resource_mut::<UndoStack>();
    (stack.ahead, stack.cuts) = (ahead, cuts);
    Ok(format!("undid {what}: what came after is there again"))
}

/// Tells whether there was anything left to take back.
fn take_back(world: &mut World, deed: Deed) -> bool {
    match deed {
        Deed::Added(entities) => {
            let was_there: Vec<bool> = entities.into_iter().map(|entity| bury(world, entity)).collect();
            !was_there.contains(&false)
        }
        Deed::Removed { bodies, joints } => restore(world, bodies, joints),
        Deed::Changed { joint, mut back } => back.write(world, joint),
        Deed::Left(_) | Deed::Cut(..) => false, // not one thing of the running scene
    }
}

/// Has bodies and joints come back as the entities that they were; a joint whose other body has gone meanwhile stays
/// away. Tells whether anything came back.
fn restore(world: &mut World, bodies: Vec<(Entity, BodySpec)>, joints: Vec<(Entity, Name, JointParts)>) -> bool {
    let mut came_back = false;
    for (entity, body) in bodies {
        if !is_empty(world, entity) {
            continue; // it is there, or gone for good
        }
        if body.shape.is_none() {
            world.entity_mut(entity).insert(Pin); // nothing else without a shape is ever removed
        }
        body.spawn_at(world, entity);
        came_back = true;
    }
    for (entity, name, parts) in joints {
        let holds = parts.bodies().into_iter().all(|end| world.get::<RigidBody>(end).is_some());
        if holds && is_empty(world, entity) {
            let mut joint = world.entity_mut(entity);
            joint.insert((name, SceneEntity));
            parts.insert(&mut joint);
            came_back = true;
        }
    }
    came_back
}

/// A body as it is now.
fn describe(world: &World, body: Entity) -> Option<BodySpec> {
    Some(BodySpec { name: name_of(world, body), ..BodySpec::of_entity(world, body)? })
}
