//! Having it be as if something had never been done: what was done in the past gives way to what was to come, and comes
//! again; what was done since a moment is no more.

use bevy::prelude::*;

use super::branch::Branch;
use super::history::{GoError, History};
use crate::physics::stats::StepStats;

/// Where a history stands: while it is the same, no step was made and nothing was done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Mark {
    /// Steps of the world.
    pub step: u64,
    /// Acts after that step.
    acts: usize,
    /// Steps up to which it reaches.
    last: u64,
    cuts: u64,
}

impl Mark {
    /// Where the history of a world stands, with all that was done since the last step; none where none is kept.
    pub fn of(world: &mut World) -> Option<Self> {
        History::take_in(world);
        let step = world.resource::<StepStats>().steps;
        Some(world.get_resource::<History>()?.mark(step))
    }
}

impl History {
    fn mark(&self, step: u64) -> Mark {
        Mark { step, acts: self.acts.get(&step).map_or(0, Vec::len), last: self.last, cuts: self.cuts }
    }

    /// The world is where that cut was made, and what was to come is again; what was done instead takes its place.
    fn swap(&mut self, world: &mut World, cut: u64) -> Result<(), GoError> {
        self.note_acts(world);
        let place = self.branches.iter().position(|branch| branch.cut == cut).ok_or(GoError::NoHistory)?;
        // Those after it began in what was done instead.
        let inner = self.branches.split_off(place + 1);
        let Some(branch) = self.branches.pop() else { return Err(GoError::NoHistory) };
        let Branch { at, acts_at, own, frames, acts, last, inner: began_in_it, .. } = branch;
        let here = self.acts.entry(at).or_default();
        let own_instead = here.split_off(acts_at.min(here.len()));
        here.extend(own);
        if here.is_empty() {
            self.acts.remove(&at);
        }
        let instead = Branch {
            cut,
            at,
            acts_at,
            own: own_instead,
            frames: self.frames.split_off(self.frames.partition_point(|frame| frame.step <= at)),
            acts: self.acts.split_off(&(at + 1)),
            last: self.last,
            inner,
        };
        self.frames.extend(frames);
        self.acts.extend(acts);
        self.last = last;
        self.turns += 1;
        self.branches.push(instead);
        self.branches.extend(began_in_it);
        self.go(world, at)
    }

    /// What lies in the place of that cut is forgotten.
    fn forget(&mut self, cut: u64) {
        self.branches.retain(|branch| branch.cut != cut);
    }

    fn take_back_since(&mut self, world: &mut World, mark: Mark) -> Result<(), GoError> {
        self.note_acts(world);
        let now = self.mark(world.resource::<StepStats>().steps);
        if now.step != mark.step || now.acts < mark.acts || now.cuts > mark.cuts + 1 {
            return Err(GoError::NoHistory);
        }
        if now.cuts > mark.cuts {
            self.swap(world, now.cuts)?;
            self.forget(now.cuts);
            return Ok(());
        }
        if let Some(acts) = self.acts.get_mut(&mark.step) {
            acts.truncate(mark.acts);
            if acts.is_empty() {
                self.acts.remove(&mark.step);
            }
        }
        self.go(world, mark.step)
    }
}

fn with_history<T>(
    world: &mut World,
    change: impl FnOnce(&mut History, &mut World) -> Result<T, GoError>,
) -> Result<T, GoError> {
    let mut history = world.remove_resource::<History>().ok_or(GoError::NoHistory)?;
    let outcome = change(&mut history, world);
    world.insert_resource(history);
    outcome
}

/// Takes back what was done in the past: the world is where it was done, and what was to come then is again. Cuts are
/// counted by [`History::cuts`]. What was done instead takes the place of what was to come, and comes again by the same
/// call.
///
/// # Errors
/// What was to come is not kept any more, or one of the entities is gone for good.
pub fn swap_cut(world: &mut World, cut: u64) -> Result<(), GoError> {
    with_history(world, |history, world| history.swap(world, cut))
}

/// The same; what was done instead is forgotten.
///
/// # Errors
/// As [`swap_cut`].
pub fn uncut(world: &mut World, cut: u64) -> Result<(), GoError> {
    with_history(world, |history, world| {
        let outcome = history.swap(world, cut);
        history.forget(cut);
        outcome
    })
}

/// Has all be, to the last bit, as if nothing had been done since that mark, after which no step was made.
///
/// # Errors
/// A step was made since, or one of the entities is gone for good.
pub fn take_back_since(world: &mut World, mark: Mark) -> Result<(), GoError> {
    with_history(world, |history, world| history.take_back_since(world, mark))
}
