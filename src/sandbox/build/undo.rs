//! Taking back what was built, cut or deleted, the last first, and having it come again.

use std::collections::VecDeque;

use bevy::prelude::*;

use super::joint_change::JointChange;
use super::joints::Pin;
use super::kept::KeptScene;
use super::names::name_of;
use super::place::Place;
use super::rewriting::write_body;
use crate::physics::{
    History, Mark, RenderOrigin, RigidBody, StepStats, bury, go_to, is_empty, swap_cut, take_back_since,
};
use crate::sandbox::drag;
use crate::sandbox::held::Drag;
use crate::sandbox::state::report;
use crate::sandbox::timeline::change_places;
use crate::scene::{BodySpec, JointParts, SceneEntity};

/// How many deeds are remembered.
const DEPTH: usize = 64;

/// What undo would take back. A new start of the scene, or another scene, is one deed more that takes the place of what
/// was built before it.
#[derive(Resource, Default)]
pub struct UndoStack {
    deeds: VecDeque<Done>,
    /// What redo would have come again, the next last.
    undone: VecDeque<Undone>,
    ahead: Ahead,
    /// How often what was to come had been cut off when that was looked at.
    cuts: u64,
}

/// What was done and undone at moments that the scene has not come to (it went back), the next last.
#[derive(Clone, Default)]
pub struct Ahead {
    deeds: Vec<Done>,
    undone: Vec<Undone>,
}

/// A deed, and when it was done.
#[derive(Clone)]
pub struct Done {
    /// Completes "undid …".
    what: String,
    deed: Deed,
    /// Steps that the world had made.
    step: u64,
}

/// A deed that was undone.
#[derive(Clone)]
struct Undone {
    done: Done,
    /// What does it again.
    again: Deed,
    /// Steps that the world had made.
    step: u64,
    /// How the history stood before it was undone and after that.
    marks: [Option<Mark>; 2],
    /// What was to come, where undoing it ended that.
    ahead: Ahead,
}

/// What a deed did to the world.
#[derive(Clone)]
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
    /// This body is another.
    Rebuilt {
        /// Its entity.
        body: Entity,
        /// What it was.
        back: Box<BodySpec>,
        /// Whether it is to be as fast as it was, too.
        velocity: bool,
    },
    /// These bodies are elsewhere.
    Placed(Vec<Place>),
    /// These, one after the other.
    Several(Vec<Deed>),
    /// Something was done in the past: what was to come will not, by the count of such cuts, nor these deeds.
    Cut(u64, Ahead),
    /// A scene in which something was built is on view no longer.
    Left(Box<KeptScene>),
}

impl UndoStack {
    /// Forgets the bodies and joints that deeds mean, which are about to go. Tells whether there were such deeds.
    pub fn leave_scene(&mut self) -> bool {
        self.ahead = Ahead::default();
        self.undone.clear();
        let built = self.deeds.iter().any(|done| !matches!(done.deed, Deed::Left(_) | Deed::Cut(..)));
        self.deeds.retain(|done| matches!(done.deed, Deed::Left(_)));
        built
    }

    /// What the next undo would take back.
    pub fn next(&self) -> Option<&str> {
        self.deeds.back().map(|done| done.what.as_str())
    }

    /// What the next redo would have come again.
    pub fn next_again(&self) -> Option<&str> {
        self.undone.back().map(|undone| undone.done.what.as_str())
    }

    /// Whether a change would be one more like the last deed.
    fn goes_on(&self, change: &Deed) -> bool {
        match (self.deeds.back().map(|done| &done.deed), change) {
            (Some(Deed::Changed { joint: last, back }), Deed::Changed { joint, back: change }) => {
                last == joint && back.is_alike(change)
            }
            (Some(Deed::Rebuilt { body: last, .. }), Deed::Rebuilt { body, .. }) => last == body,
            (Some(Deed::Placed(last)), Deed::Placed(places)) => {
                last.iter().map(Place::key).eq(places.iter().map(Place::key))
            }
            _ => false,
        }
    }

    /// The scene went to another of its moments: what was done later is not done there, and is again once it comes to
    /// it.
    fn go(&mut self, step: u64, cuts: u64) {
        if cuts > self.cuts {
            let what = "what was done in the past".to_owned();
            let deed = Deed::Cut(cuts, std::mem::take(&mut self.ahead));
            self.deeds.push_back(Done { what, deed, step });
            self.undone.clear();
        }
        self.cuts = cuts;
        let is_past = |at: u64, deed: &Deed| at <= step || matches!(deed, Deed::Left(_));
        change_places(&mut self.deeds, &mut self.ahead.deeds, |done| is_past(done.step, &done.deed));
        change_places(&mut self.undone, &mut self.ahead.undone, |undone| is_past(undone.step, &undone.done.deed));
    }

    /// Takes in whether undo or redo itself ended what was to come: that is no deed of its own. What was to come then.
    fn note_cut(&mut self, cuts: u64) -> Ahead {
        match std::mem::replace(&mut self.cuts, cuts) == cuts {
            true => Ahead::default(),
            false => std::mem::take(&mut self.ahead),
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
    stack.undone.clear();
    if stack.deeds.len() == DEPTH {
        stack.deeds.pop_front();
    }
    stack.deeds.push_back(Done { what, deed, step });
}

/// Remembers a change, unless it `continues` the last, as a value does that is dragged: both are undone together then.
pub fn remember_change(world: &mut World, what: String, change: Deed, continues: bool) {
    if !(continues && world.resource::<UndoStack>().goes_on(&change)) {
        remember(world, what, change);
    }
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
    let before = Mark::of(world);
    follow_time(world);
    let Some(done) = world.resource_mut::<UndoStack>().deeds.pop_back() else {
        report(world, Err("nothing to undo".to_owned()));
        return None;
    };
    let what = done.what.clone();
    let (again, left) = match done.deed.clone() {
        Deed::Left(scene) => (leave(world), Some(*scene)),
        Deed::Cut(cut, ahead) => (swap(world, cut, ahead, None), None),
        deed => (take_back(world, deed).ok_or("it is gone"), None),
    };
    let ahead = note_cut(world);
    let outcome = match again {
        Ok(again) => {
            let (step, marks) = (world.resource::<StepStats>().steps, [before, Mark::of(world)]);
            world.resource_mut::<UndoStack>().undone.push_back(Undone { done, again, step, marks, ahead });
            Ok(format!("undid {what}"))
        }
        Err(reason) => Err(format!("cannot undo {what}: {reason}")),
    };
    let left = left.filter(|_| outcome.is_ok());
    report(world, outcome);
    left
}

/// Has what was undone last come again: to the last bit where nothing has happened since, else as it can be by now. Of a
/// scene that was left again, tells that it is to take the place of the present one.
pub fn redo(world: &mut World) -> Option<KeptScene> {
    let now = Mark::of(world);
    follow_time(world);
    let Some(undone) = world.resource_mut::<UndoStack>().undone.pop_back() else {
        report(world, Err("nothing to redo".to_owned()));
        return None;
    };
    let Undone { done: Done { what, deed, mut step }, again, marks: [before, after], ahead, .. } = undone;
    let is_as_it_was = now == after && !world.resource::<Drag>().is_active();
    let (came, left) = match (again, before.filter(|_| is_as_it_was)) {
        (Deed::Left(scene), _) => (leave(world), Some(*scene)),
        (Deed::Cut(cut, instead), _) => (swap(world, cut, instead, before), None),
        (_, Some(before)) => {
            let came = take_back_since(world, before).map_err(|_| "it is gone");
            world.resource_mut::<RenderOrigin>().set_changed();
            let mut stack = world.resource_mut::<UndoStack>();
            stack.ahead.deeds.extend(ahead.deeds);
            stack.ahead.undone.extend(ahead.undone);
            (came.map(|()| deed), None)
        }
        (again, None) => {
            step = world.resource::<StepStats>().steps;
            (take_back(world, again).ok_or("it is gone"), None)
        }
    };
    note_cut(world);
    let outcome = match came {
        Ok(deed) => {
            world.resource_mut::<UndoStack>().deeds.push_back(Done { what: what.clone(), deed, step });
            follow_time(world);
            Ok(format!("redid {what}"))
        }
        Err(reason) => Err(format!("cannot redo {what}: {reason}")),
    };
    let left = left.filter(|_| outcome.is_ok());
    report(world, outcome);
    left
}

/// Where undo or redo ends what was to come, the next undo is not to bring back what this one took. What was to come.
fn note_cut(world: &mut World) -> Ahead {
    History::take_in(world);
    let cuts = cuts(world);
    world.resource_mut::<UndoStack>().note_cut(cuts)
}

/// The scene on view makes place for another: how it comes back. Deeds that mean its bodies are none any more.
fn leave(world: &mut World) -> Result<Deed, &'static str> {
    drag::release(world);
    let kept = KeptScene::of(world).ok_or("there is no scene")?;
    let mut stack = world.resource_mut::<UndoStack>();
    stack.undone.retain(|undone| matches!(undone.done.deed, Deed::Left(_)));
    stack.ahead = Ahead::default();
    Ok(Deed::Left(Box::new(kept)))
}

/// What was to come at a cut, and what was done instead, change places, with the deeds of the one that is to be on the strip;
/// the world is at the cut then, or where it was in that when they last did. What has them change again.
fn swap(world: &mut World, cut: u64, deeds: Ahead, back_to: Option<Mark>) -> Result<Deed, &'static str> {
    drag::release(world);
    swap_cut(world, cut).map_err(|_| "what was to come then is not kept any more")?;
    note_cut(world);
    follow_time(world);
    let others = std::mem::replace(&mut world.resource_mut::<UndoStack>().ahead, deeds);
    if let Some(mark) = back_to {
        go_to(world, mark.step).map_err(|_| "what was done then is not kept any more")?;
    }
    world.resource_mut::<RenderOrigin>().set_changed();
    Ok(Deed::Cut(cut, others))
}

/// Takes a deed of the running scene back, and tells the deed that does so, which is taken back in the same way; none where
/// there was nothing left to take back.
fn take_back(world: &mut World, deed: Deed) -> Option<Deed> {
    match deed {
        Deed::Added(entities) => {
            let is_there = |&entity: &Entity| world.get_entity(entity).is_ok() && !is_empty(world, entity);
            let was_there = entities.iter().all(is_there);
            let is_body = |entity: &Entity| world.get::<RigidBody>(*entity).is_some();
            let (bodies, joints): (Vec<_>, Vec<_>) = entities.iter().copied().partition(is_body);
            let removed = remove(world, bodies, &joints);
            was_there.then_some(removed)
        }
        Deed::Removed { bodies, joints } => {
            let came_back = restore(world, bodies, joints);
            (!came_back.is_empty()).then_some(Deed::Added(came_back))
        }
        Deed::Changed { joint, mut back } => back.write(world, joint).then_some(Deed::Changed { joint, back }),
        Deed::Rebuilt { body, mut back, velocity } => {
            if !velocity {
                let now = BodySpec::of_entity(world, body)?;
                (back.linear_velocity, back.angular_velocity) = (now.linear_velocity, now.angular_velocity);
            }
            let was = write_body(world, body, &back)?;
            Some(Deed::Rebuilt { body, back: Box::new(was), velocity })
        }
        Deed::Placed(places) => {
            let were: Vec<Place> = places.iter().filter_map(|place| place.write(world)).collect();
            (!were.is_empty()).then_some(Deed::Placed(were))
        }
        Deed::Several(deeds) => {
            let again: Option<Vec<Deed>> = deeds.into_iter().rev().map(|deed| take_back(world, deed)).collect();
            again.map(Deed::Several)
        }
        Deed::Left(_) | Deed::Cut(..) => None, // not one thing of the running scene
    }
}

/// Has bodies and joints come back as the entities that they were; a joint whose other body has gone meanwhile stays
/// away. Tells what came back.
fn restore(world: &mut World, bodies: Vec<(Entity, BodySpec)>, joints: Vec<(Entity, Name, JointParts)>) -> Vec<Entity> {
    let mut came_back = Vec::new();
    for (entity, body) in bodies {
        if !is_empty(world, entity) {
            continue; // it is there, or gone for good
        }
        if body.shape.is_none() {
            world.entity_mut(entity).insert(Pin); // nothing else without a shape is ever removed
        }
        body.spawn_at(world, entity);
        came_back.push(entity);
    }
    for (entity, name, parts) in joints {
        let holds = parts.bodies().into_iter().all(|end| world.get::<RigidBody>(end).is_some());
        if holds && is_empty(world, entity) {
            let mut joint = world.entity_mut(entity);
            joint.insert((name, SceneEntity));
            parts.insert(&mut joint);
            came_back.push(entity);
        }
    }
    came_back
}

/// A body as it is now.
fn describe(world: &World, body: Entity) -> Option<BodySpec> {
    Some(BodySpec { name: name_of(world, body), ..BodySpec::of_entity(world, body)? })
}
