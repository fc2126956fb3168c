//! Time that runs both ways: back to any moment that is kept, on from there, backwards, round and round.
//!
//! The world's [`History`] begins with each scene and each reset. A moment is a step; what was done after it belongs to
//! it. In the past the scene plays as it played, what hands did included, until somebody does something else: that ends
//! what was to come.

use bevy::app::{RunFixedMainLoop, RunFixedMainLoopSystems};
use bevy::picking::mesh_picking::ray_cast::RayCastBackfaces;
use bevy::prelude::*;

use super::build::{Pin, follow_time};
use super::held::{Drag, DragPart};
use super::state::report;
use super::{Notice, Playback, drag, ghost};
use crate::physics::{History, Keep, RenderOrigin, SolverSettings, StepStats, begin_anew, go_to};
use crate::scene::keep_scene;

/// What the history of a scene may take, bytes.
pub(super) const LIMIT: usize = 512 << 20;

/// Marked moments, and how the head moves.
#[derive(Resource, Clone, Debug, Default, PartialEq)]
pub struct Timeline {
    /// Steps of the world, ascending.
    pub marks: Vec<u64>,
    /// The first and the last step of what is played over and over.
    pub looped: Option<[u64; 2]>,
    /// Whether time runs backwards.
    pub backwards: bool,
    /// What of a step is due backwards.
    due: f64,
}

pub(super) fn plugin(app: &mut App) {
    keep_scene(app);
    app.keep_look::<Mesh3d>()
        .keep_look::<MeshMaterial3d<StandardMaterial>>()
        .keep_look::<RayCastBackfaces>()
        .keep_look::<Pin>()
        .keep_look::<DragPart>();
    app.init_resource::<Timeline>()
        .add_systems(RunFixedMainLoop, run_backwards.in_set(RunFixedMainLoopSystems::BeforeFixedMainLoop))
        .add_systems(FixedPreUpdate, let_go_of_what_nobody_holds)
        .add_systems(FixedLast, go_round);
}

/// A scene begins. To be called once it is spawned.
pub(super) fn begin(world: &mut World) {
    begin_anew(world);
    History::begin(world, LIMIT);
    world.insert_resource(Timeline::default());
}

/// The scene ends. To be called before it is despawned.
pub(super) fn end(world: &mut World) {
    drag::release(world);
    History::end(world);
}

/// The step at which the world is, and the first and the last that it can go to.
pub(super) fn head_and_reach(stats: &StepStats, history: Option<&History>) -> (u64, [u64; 2]) {
    (stats.steps, history.map_or([stats.steps; 2], History::reach))
}

/// Time stands still.
pub(super) fn stop(world: &mut World) {
    world.resource_mut::<Playback>().paused = true;
    world.resource_mut::<Timeline>().backwards = false;
}

/// Pauses at that step, or at the nearest that is kept.
pub(super) fn go(world: &mut World, step: u64) {
    stop(world);
    world.resource_mut::<Timeline>().looped = None;
    move_head(world, step);
}

/// Pauses one step back.
pub(super) fn step_back(world: &mut World) {
    let step = world.resource::<StepStats>().steps;
    go(world, step.saturating_sub(1));
}

/// Pauses at the first moment that is kept (0) or the last (1).
pub(super) fn go_to_end(world: &mut World, end: usize) {
    let Some(history) = world.get_resource::<History>() else { return };
    let step = history.reach()[end];
    go(world, step);
}

pub(super) fn toggle_backwards(world: &mut World) {
    let mut timeline = world.resource_mut::<Timeline>();
    timeline.backwards = !timeline.backwards;
    (timeline.due, timeline.looped) = (0.0, None);
    if timeline.backwards {
        world.resource_mut::<Playback>().paused = true;
    }
}

pub(super) fn toggle_mark(world: &mut World) {
    let step = world.resource::<StepStats>().steps;
    let mut timeline = world.resource_mut::<Timeline>();
    match timeline.marks.binary_search(&step) {
        Ok(place) => _ = timeline.marks.remove(place),
        Err(place) => timeline.marks.insert(place, step),
    }
}

/// Plays over and over from the last mark before the present moment, or the first moment, to the next mark after it, or
/// the last moment.
pub(super) fn toggle_loop(world: &mut World) {
    let (head, reach) = head_and_reach(world.resource::<StepStats>(), world.get_resource::<History>());
    let mut timeline = world.resource_mut::<Timeline>();
    if timeline.looped.take().is_some() {
        return;
    }
    timeline.marks.retain(|mark| (reach[0]..=reach[1]).contains(mark));
    let from = timeline.marks.iter().rev().find(|&&mark| mark <= head).copied().unwrap_or(reach[0]);
    let to = timeline.marks.iter().find(|&&mark| mark > from && mark >= head).copied().unwrap_or(reach[1]);
    if to <= from {
        return report(world, Err("there is nothing to play over: let the scene run, or mark a moment".into()));
    }
    timeline.looped = Some([from, to]);
    timeline.backwards = false;
    world.resource_mut::<Playback>().paused = false;
    if head == to {
        move_head(world, from);
    }
}

/// On to the last moment, without a word: what leaves a scene leaves all of it.
pub(super) fn go_on(world: &mut World) {
    if let Some(history) = world.get_resource::<History>() {
        let last = history.reach()[1];
        move_head(world, last);
    }
}

/// Goes to that step, or to the nearest that is kept. Says why not where it cannot be.
fn move_head(world: &mut World, step: u64) {
    drag::release(world);
    History::take_in(world);
    let (head, [first, last]) = head_and_reach(world.resource::<StepStats>(), world.get_resource::<History>());
    let step = step.clamp(first, last);
    if step == head {
        return;
    }
    if let Err(reason) = go_to(world, step) {
        world.resource_mut::<Timeline>().looped = None;
        *world.resource_mut::<Notice>() = Notice::Error(reason.to_string());
        return;
    }
    let length = world.resource::<SolverSettings>().step();
    if let Some(mut fixed) = world.get_resource_mut::<Time<Fixed>>() {
        fixed.set_timestep_seconds(length);
        let over = fixed.overstep();
        fixed.discard_overstep(over);
    }
    follow_time(world);
    // What sleeps is drawn from where the picture's origin is now.
    world.resource_mut::<RenderOrigin>().set_changed();
    // Where no step was made on the way, nobody has told the ghost.
    if let Err(reason) = world.run_system_cached(ghost::follow) {
        *world.resource_mut::<Notice>() = Notice::Error(reason.to_string());
    }
}

/// As many steps back as the clock asks for.
fn run_backwards(world: &mut World) {
    if !world.resource::<Timeline>().backwards {
        return;
    }
    let passed = world.resource::<Time<Real>>().delta_secs_f64().min(0.1);
    let (speed, hz) = (world.resource::<Playback>().speed(), world.resource::<SolverSettings>().hz);
    let mut timeline = world.resource_mut::<Timeline>();
    timeline.due += passed * speed * hz;
    let steps = timeline.due as u64;
    timeline.due -= steps as f64;
    let (head, [first, _]) = head_and_reach(world.resource::<StepStats>(), world.get_resource::<History>());
    if steps > 0 {
        move_head(world, head.saturating_sub(steps).max(first));
    }
    if head <= first {
        world.resource_mut::<Timeline>().backwards = false;
    }
}

/// From the end of what is played over and over to its beginning.
fn go_round(world: &mut World) {
    let Some([from, to]) = world.resource::<Timeline>().looped else { return };
    let (head, [first, last]) = head_and_reach(world.resource::<StepStats>(), world.get_resource::<History>());
    if first > from || last < to {
        // Something else was done there, or it is too long ago.
        world.resource_mut::<Timeline>().looped = None;
    } else if head >= to {
        move_head(world, from);
    }
}

/// What a hand held in what was to come, and holds no longer since something else happened.
fn let_go_of_what_nobody_holds(world: &mut World) {
    if world.resource::<Drag>().is_active() {
        return;
    }
    let head = world.resource::<StepStats>().steps;
    if !world.get_resource::<History>().is_some_and(|history| history.is_past(head)) {
        drag::let_go_of_all(world);
    }
    follow_time(world);
}
