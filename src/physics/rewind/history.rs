//! Keyframes and acts of a running world, and the way back to any step that they reach.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use bevy::ecs::change_detection::Tick;
use bevy::prelude::*;

use super::acts::{Acts, Deeds};
use super::branch::Branch;
use super::bury::is_empty;
use super::keyframe::Keyframe;
use super::kinds::{Kinds, Removals};
use crate::physics::body::Bodies;
use crate::physics::schedule::PhysicsSchedule;
use crate::physics::stats::StepStats;

/// Steps between two keyframes at least.
const LEAST_INTERVAL: u64 = 15;
/// Share of the time of the steps that keyframes may take.
const SHARE: f64 = 0.05;
/// Steps between two keyframes at most, once they thin out: beyond it the oldest goes.
const MOST_INTERVAL: u64 = 600;

/// What happened to a world, from a first step on: kept from its insertion by [`History::begin`] until it is removed.
#[derive(Resource)]
pub struct History {
    /// Steps before it was begun.
    begun: u64,
    /// By step, ascending; the first is where what is kept begins.
    pub(super) frames: Vec<Keyframe>,
    /// What was done after so many steps, in its order.
    pub(super) acts: BTreeMap<u64, Vec<Acts>>,
    /// Steps up to which it reaches.
    pub(super) last: u64,
    /// How often something else was done in the past, so that what was to come was forgotten.
    pub(super) cuts: u64,
    /// How often what is to come has become something else.
    pub(super) turns: u64,
    /// What was to come before each, the last last.
    pub(super) branches: Vec<Branch>,
    /// What it may take, bytes.
    limit: usize,
    /// What is newer was done by others since the last step.
    since: Tick,
    /// What steps took since the last keyframe, and what that took.
    steps: Duration,
    keyframe: Duration,
}

/// Why a world cannot be brought back.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum GoError {
    /// Nothing is kept.
    #[error("nothing is kept of what happened")]
    NoHistory,
    /// What is kept does not reach there.
    #[error("step {step} is not kept: what is begins at {first} and ends at {last}")]
    OutOfReach {
        /// Where it was to go.
        step: u64,
        /// First that is kept.
        first: u64,
        /// Last that is kept.
        last: u64,
    },
    /// Somebody despawned an entity instead of burying it.
    #[error("{0} is gone for good: it was despawned and not buried")]
    Gone(Entity),
}

impl History {
    /// Keeps what happens to a world from now on, in so many bytes.
    pub fn begin(world: &mut World, limit: usize) {
        Self::end(world);
        let step = world.resource::<StepStats>().steps;
        let mut history = Self {
            begun: step,
            frames: Vec::new(),
            acts: BTreeMap::new(),
            last: step,
            cuts: 0,
            turns: 0,
            branches: Vec::new(),
            limit,
            since: world.change_tick(),
            steps: Duration::ZERO,
            keyframe: Duration::ZERO,
        };
        history.take(world, step);
        history.note_end(world);
        world.resource_mut::<Removals>().is_read = true;
        world.insert_resource(history);
    }

    /// Keeps nothing any more; what was emptied goes.
    pub fn end(world: &mut World) {
        world.remove_resource::<Self>();
        let removals = std::mem::take(&mut *world.resource_mut::<Removals>());
        for entity in removals.buried {
            if is_empty(world, entity) {
                world.despawn(entity);
            }
        }
    }

    /// The first step and the last one that it reaches.
    pub fn reach(&self) -> [u64; 2] {
        [self.frames.first().map_or(self.last, |frame| frame.step), self.last]
    }

    /// Steps before it was begun: the first that it reached.
    pub fn begun(&self) -> u64 {
        self.begun
    }

    /// Whether something was to come after so many steps.
    pub fn is_past(&self, step: u64) -> bool {
        step < self.last
    }

    /// How often something else was done in the past, so that what was to come was forgotten.
    pub fn cuts(&self) -> u64 {
        self.cuts
    }

    /// How often what is to come has become something else: by cuts, and by taking them back.
    pub fn turns(&self) -> u64 {
        self.turns
    }

    /// Takes in what was done since the last step, as the next step would: it may end what was to come.
    pub fn take_in(world: &mut World) {
        if let Some(mut history) = world.remove_resource::<Self>() {
            history.note_acts(world);
            world.insert_resource(history);
        }
    }

    /// The steps after which somebody did something.
    pub fn acts(&self) -> impl Iterator<Item = u64> + '_ {
        self.acts.keys().copied()
    }

    /// The steps of which the whole state is kept.
    pub fn keyframes(&self) -> impl Iterator<Item = u64> + '_ {
        self.frames.iter().map(|frame| frame.step)
    }

    /// How many steps have to be made to go to that one.
    pub fn way_to(&self, step: u64) -> u64 {
        let place = self.frames.partition_point(|frame| frame.step <= step);
        self.frames[..place].last().map_or(0, |frame| step - frame.step)
    }

    /// About what it takes, bytes.
    pub fn bytes(&self) -> usize {
        let frames: usize = self.frames.iter().map(Keyframe::bytes).sum();
        let acts: usize = self.acts.values().flatten().map(Acts::bytes).sum();
        frames + acts + self.branches.iter().map(Branch::bytes).sum::<usize>()
    }

    fn take(&mut self, world: &mut World, step: u64) {
        let start = Instant::now();
        let frame = world.resource_scope(|world, mut kinds: Mut<Kinds>| Keyframe::of(world, &mut kinds, step));
        let place = self.frames.partition_point(|frame| frame.step < step);
        self.frames.insert(place, frame);
        (self.steps, self.keyframe) = (Duration::ZERO, start.elapsed());
        self.thin_out();
    }

    /// Drops keyframes until the rest fits: those that stand closest for their age, or the first where none is close.
    fn thin_out(&mut self) {
        while !self.branches.is_empty() && self.bytes() > self.limit {
            self.branches.remove(0);
        }
        while self.frames.len() > 2 && self.bytes() > self.limit {
            let now = self.last as f64 + 1.0;
            let gaps = self.frames.windows(3).enumerate().map(|(place, frames)| {
                let gap = frames[2].step - frames[0].step;
                (place + 1, gap, gap as f64 / (now - frames[1].step as f64))
            });
            let closest = gaps.min_by(|a, b| a.2.total_cmp(&b.2)).filter(|&(_, gap, _)| gap <= MOST_INTERVAL);
            self.frames.remove(closest.map_or(0, |(place, ..)| place));
            let first = self.frames[0].step;
            self.acts = self.acts.split_off(&first);
        }
    }

    /// The end of a step: what is written from now on is somebody else's.
    fn note_end(&mut self, world: &mut World) {
        world.resource_mut::<Removals>().list.clear();
        self.since = world.increment_change_tick();
    }

    pub(super) fn go(&mut self, world: &mut World, step: u64) -> Result<(), GoError> {
        self.note_acts(world);
        let [first, last] = self.reach();
        if !(first..=last).contains(&step) {
            return Err(GoError::OutOfReach { step, first, last });
        }
        let frame = &self.frames[self.frames.partition_point(|frame| frame.step <= step) - 1];
        bring_back(world, frame)?;
        let start = frame.step;
        self.repeat(world, start);
        for made in start + 1..=step {
            make_step(world);
            // Whoever goes back goes back again: the next way is short.
            if made < step && (made - start).is_multiple_of(LEAST_INTERVAL) {
                self.take(world, made);
            }
            self.repeat(world, made);
        }
        self.note_end(world);
        Ok(())
    }

    /// From the first step on to the last, with all acts, and back to where the world is.
    fn retell(&mut self, world: &mut World, tell: &mut dyn FnMut(&mut World, Told)) -> Result<(), GoError> {
        self.note_acts(world);
        let here = world.resource::<StepStats>().steps;
        let [first, last] = self.reach();
        let frame = self.frames.first().ok_or(GoError::NoHistory)?;
        bring_back(world, frame)?;
        for step in first..=last {
            if step > first {
                make_step(world);
            }
            tell(world, Told::Step);
            for acts in self.acts.get(&step).map_or(&[][..], |acts| acts) {
                let deeds = world.resource_scope(|world, kinds: Mut<Kinds>| {
                    acts.repeat(world, &kinds);
                    acts.deeds(&kinds)
                });
                tell(world, Told::Deeds(&deeds));
            }
        }
        self.note_end(world);
        self.go(world, here)
    }

    /// Does again what was done after so many steps.
    fn repeat(&self, world: &mut World, step: u64) {
        let acts = self.acts.get(&step).map_or(&[][..], |acts| acts);
        for acts in acts {
            world.resource_scope(|world, kinds: Mut<Kinds>| acts.repeat(world, &kinds));
        }
    }

    /// Takes in what was done since the last step. Where that lies in the past, what came after it is forgotten.
    pub(super) fn note_acts(&mut self, world: &mut World) {
        let (step, since) = (world.resource::<StepStats>().steps, self.since);
        let acts = world.resource_scope(|world, mut kinds: Mut<Kinds>| Acts::since(world, &mut kinds, since));
        if acts.is_empty() {
            return;
        }
        if self.is_past(step) {
            self.cuts += 1;
            self.turns += 1;
            self.branches.push(Branch {
                cut: self.cuts,
                at: step,
                acts_at: self.acts.get(&step).map_or(0, Vec::len),
                own: Vec::new(),
                frames: self.frames.split_off(self.frames.partition_point(|frame| frame.step <= step)),
                acts: self.acts.split_off(&(step + 1)),
                last: self.last,
                inner: Vec::new(),
            });
            self.last = step;
        }
        self.acts.entry(step).or_default().push(acts);
        self.note_end(world);
    }

    /// Takes in a step that was made, and took so long: what was done after it is done again where it lies in the past.
    fn note_step(&mut self, world: &mut World, took: Duration) {
        let step = world.resource::<StepStats>().steps;
        self.steps += took;
        if step <= self.last {
            self.repeat(world, step);
        } else {
            self.last = step;
            let newest = self.frames.last().map_or(0, |frame| frame.step);
            if step >= newest + LEAST_INTERVAL && self.keyframe <= self.steps.mul_f64(SHARE) {
                self.take(world, step);
            }
        }
        self.note_end(world);
    }
}

/// Has a world be as a keyframe has it, if all of its entities are there.
fn bring_back(world: &mut World, frame: &Keyframe) -> Result<(), GoError> {
    if let Some(entity) = frame.missing(world) {
        return Err(GoError::Gone(entity));
    }
    world.resource_scope(|world, mut kinds: Mut<Kinds>| frame.bring_back(world, &mut kinds));
    Ok(())
}

/// One step, whatever the settings.
fn make_step(world: &mut World) {
    world.run_schedule(PhysicsSchedule);
    let ended = world.change_tick();
    world.resource_mut::<Bodies>().bypass_change_detection().ended = Some(ended);
}

/// One step, noted where a history is kept. How long the step itself took.
pub(crate) fn step_and_note(world: &mut World) -> Duration {
    let mut history = world.remove_resource::<History>();
    if let Some(history) = &mut history {
        history.note_acts(world);
    }
    let start = Instant::now();
    make_step(world);
    let took = start.elapsed();
    if let Some(mut history) = history {
        history.note_step(world, took);
        world.insert_resource(history);
    }
    took
}

/// Remembers what resources are in a world without a body, for [`begin_anew`].
pub(crate) fn note_blank(world: &mut World) {
    world.resource_scope(|world, mut kinds: Mut<Kinds>| {
        kinds.blank = kinds.resources.iter().map(|kind| (kind.copy)(world)).collect();
    });
}

/// Has a world whose bodies and joints have all gone, or have been spawned since the last step, be as if it had never made a
/// step: its next one is the first, at time 0, and nothing depends on what was there before. Settings stay.
pub fn begin_anew(world: &mut World) {
    let new = world.increment_change_tick();
    world.resource_scope(|world, kinds: Mut<Kinds>| {
        for (kind, blank) in kinds.resources.iter().zip(&kinds.blank).filter(|(kind, _)| !kind.is_setting) {
            if let Some(blank) = blank {
                (kind.put_back)(world, blank, new);
            }
        }
    });
}

/// What is told of a history, in its order.
#[derive(Clone, Copy, Debug)]
pub enum Told<'a> {
    /// The world is at its first step that is kept, or has made another.
    Step,
    /// Somebody did this since, and the world is as it was left.
    Deeds(&'a Deeds),
}

/// Tells all that happened since the beginning of a world's [`History`] by having it happen again; then the world is where
/// it was. What `tell` does to it is nobody's act.
///
/// # Errors
/// No history is kept, or one of the entities is gone for good.
pub fn retell(world: &mut World, mut tell: impl FnMut(&mut World, Told)) -> Result<(), GoError> {
    let mut history = world.remove_resource::<History>().ok_or(GoError::NoHistory)?;
    let outcome = history.retell(world, &mut tell);
    world.insert_resource(history);
    outcome
}

/// Brings a world back to where it was after so many steps since its start, or forward again.
///
/// # Errors
/// No [`History`] was kept that far, or one of the entities is gone for good.
pub fn go_to(world: &mut World, step: u64) -> Result<(), GoError> {
    let mut history = world.remove_resource::<History>().ok_or(GoError::NoHistory)?;
    let outcome = history.go(world, step);
    world.insert_resource(history);
    outcome
}
