//! Where the world is in its time, and where it goes.
//!
//! The world's [`History`] begins with each scene and each reset. A moment is a step; what was done after it belongs to
//! it. In the past the scene plays as it played, what hands did included, until somebody does something else: that ends
//! what was to come.

use bevy::prelude::*;

use super::poses;
use super::shown::ShownStep;
use crate::physics::{History, RenderOrigin, SolverSettings, StepStats, begin_anew, go_to, stand_still};
use crate::sandbox::build::follow_time;
use crate::sandbox::held::Drag;
use crate::sandbox::state::report;
use crate::sandbox::{Notice, Playback, drag, ghost};

/// What is kept of a scene may take, bytes: its history, and the track of its poses.
pub const LIMIT: usize = 512 << 20;

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
    pub(super) due: f64,
}

/// A scene begins. To be called once it is spawned.
pub fn begin(world: &mut World) {
    begin_anew(world);
    History::begin(world, LIMIT - poses::LIMIT);
    poses::begin(world);
    world.insert_resource(Timeline::default());
}

/// The scene ends. To be called before it is despawned.
pub fn end(world: &mut World) {
    drag::release(world);
    History::end(world);
}

/// The step at which the world is, and the first and the last that it can go to.
pub fn head_and_reach(stats: &StepStats, history: Option<&History>) -> (u64, [u64; 2]) {
    (stats.steps, history.map_or([stats.steps; 2], History::reach))
}

/// Time stands still.
pub fn stop(world: &mut World) {
    world.resource_mut::<Playback>().paused = true;
    world.resource_mut::<Timeline>().backwards = false;
}

/// Pauses at that step, or at the nearest that is kept.
pub fn go(world: &mut World, step: u64) {
    stop(world);
    world.resource_mut::<Timeline>().looped = None;
    move_head(world, step);
}

/// Pauses one step back.
pub fn step_back(world: &mut World) {
    let step = world.resource::<StepStats>().steps;
    go(world, step.saturating_sub(1));
}

/// Pauses at the first moment that is kept (0) or the last (1).
pub fn go_to_end(world: &mut World, end: usize) {
    let Some(history) = world.get_resource::<History>() else { return };
    let step = history.reach()[end];
    go(world, step);
}

pub fn toggle_backwards(world: &mut World) {
    let mut timeline = world.resource_mut::<Timeline>();
    timeline.backwards = !timeline.backwards;
    (timeline.due, timeline.looped) = (0.0, None);
    if timeline.backwards {
        world.resource_mut::<Playback>().paused = true;
    }
}

pub fn toggle_mark(world: &mut World) {
    let step = world.resource::<StepStats>().steps;
    let mut timeline = world.resource_mut::<Timeline>();
    match timeline.marks.binary_search(&step) {
        Ok(place) => _ = timeline.marks.remove(place),
        Err(place) => timeline.marks.insert(place, step),
    }
}

/// Plays over and over from the last mark before the present moment, or the first moment, to the next mark after it, or
/// the last moment.
pub fn toggle_loop(world: &mut World) {
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
pub fn go_on(world: &mut World) {
    if let Some(history) = world.get_resource::<History>() {
        let last = history.reach()[1];
        move_head(world, last);
    }
}

/// Goes to that step, or to the nearest that is kept. Says why not where it cannot be.
pub fn move_head(world: &mut World, step: u64) {
    world.insert_resource(ShownStep::default());
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
    stand_still(world);
    // What sleeps is drawn from where the picture's origin is now.
    world.resource_mut::<RenderOrigin>().set_changed();
    // Where no step was made on the way, nobody has told the ghost.
    if let Err(reason) = world.run_system_cached(ghost::follow) {
        *world.resource_mut::<Notice>() = Notice::Error(reason.to_string());
    }
}

/// From the end of what is played over and over to its beginning.
pub fn go_round(world: &mut World) {
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
pub fn let_go_of_what_nobody_holds(world: &mut World) {
    if world.resource::<Drag>().is_active() {
        return;
    }
    let head = world.resource::<StepStats>().steps;
    if !world.get_resource::<History>().is_some_and(|history| history.is_past(head)) {
        drag::let_go_of_all(world);
    }
    follow_time(world);
}
