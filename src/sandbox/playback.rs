//! Simulation time against the clock: pause, slow motion, and no spiral on a slow machine.
//!
//! A frame makes all the steps that its time asks for, unless they take more of the clock than they may
//! ([`StepBudget`]): what is left over then is dropped, and the world goes slower than the clock. A slow picture alone
//! slows nothing down.

use std::time::{Duration, Instant};

use bevy::app::{RunFixedMainLoop, RunFixedMainLoopSystems};
use bevy::prelude::*;

use super::{CurrentScene, Playback};

/// Longest frame that is simulated whole, of the clock: after a longer one, as when the window was held still, nobody
/// waits for what is missing.
const LONGEST_FRAME: Duration = Duration::from_millis(500);
/// Frames from the start of a scene in which a single step is made: they last as long as its pictures take to prepare,
/// and what the scene begins with is to be seen.
const FIRST_FRAMES: u32 = 2;

/// What the steps of a frame may take of the clock. The step that goes beyond it is the frame's last.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
pub struct StepBudget {
    /// However fast the picture is: 40 frames a second are left where steps take all they may.
    pub least: Duration,
    /// Share of the time that the rest of the frame took: where the picture is slow, steps may be too.
    pub of_picture: f64,
}

impl Default for StepBudget {
    fn default() -> Self {
        Self { least: Duration::from_millis(20), of_picture: 0.5 }
    }
}

impl StepBudget {
    /// In a frame whose rest took that long.
    fn after(&self, picture: Duration) -> Duration {
        self.least.max(picture.mul_f64(self.of_picture))
    }
}

/// Where the time of a frame goes.
#[derive(Resource, Clone, Copy, Debug, Default)]
pub(super) struct FrameClock {
    /// When the steps of this frame began and those of the last one ended.
    began: Option<Instant>,
    ended: Option<Instant>,
    /// What the steps may take, and what they took.
    budget: Duration,
    pub steps: Duration,
    /// Since the scene began.
    frames: u32,
}

pub(super) fn plugin(app: &mut App) {
    app.init_resource::<Playback>()
        .init_resource::<StepBudget>()
        .init_resource::<FrameClock>()
        .add_systems(Startup, |mut time: ResMut<Time<Virtual>>| time.set_max_delta(LONGEST_FRAME))
        // At the end of a frame too, so that the next one stands still that is to.
        .add_systems(PreUpdate, apply_playback)
        .add_systems(Last, apply_playback)
        .add_systems(
            RunFixedMainLoop,
            (
                begin_steps.in_set(RunFixedMainLoopSystems::BeforeFixedMainLoop),
                end_steps.in_set(RunFixedMainLoopSystems::AfterFixedMainLoop),
            ),
        )
        .add_systems(FixedLast, drop_what_is_over);
}

fn begin_steps(scene: Option<Res<CurrentScene>>, budget: Res<StepBudget>, mut clock: ResMut<FrameClock>) {
    let now = Instant::now();
    clock.frames = match scene.is_some_and(|scene| scene.is_changed()) {
        true => 0,
        false => clock.frames.saturating_add(1),
    };
    let picture = clock.ended.map_or(Duration::ZERO, |ended| now - ended);
    clock.budget = if clock.frames < FIRST_FRAMES { Duration::ZERO } else { budget.after(picture) };
    clock.began = Some(now);
}

fn end_steps(mut clock: ResMut<FrameClock>) {
    let now = Instant::now();
    clock.steps = clock.began.map_or(Duration::ZERO, |began| now - began);
    clock.ended = Some(now);
}

/// Once the budget is spent, whole steps that are still due are not made. What is left of one is kept: the picture stands
/// between two steps.
fn drop_what_is_over(clock: Res<FrameClock>, mut time: ResMut<Time<Fixed>>) {
    if clock.began.is_none_or(|began| began.elapsed() < clock.budget) {
        return;
    }
    let (due, step) = (time.overstep(), time.timestep());
    if due >= step {
        let kept = (due.as_nanos() % step.as_nanos()) as u64; // less than a step
        time.discard_overstep(due - Duration::from_nanos(kept));
    }
}

fn apply_playback(playback: Res<Playback>, mut time: ResMut<Time<Virtual>>) {
    if playback.is_changed() {
        time.set_relative_speed_f64(playback.speed());
        if playback.paused {
            time.pause();
        } else {
            time.unpause();
        }
    }
}
