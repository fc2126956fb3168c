//! How time runs, and how fast.

use std::time::Duration;

use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use bevy_egui::egui;

use super::super::playback::FrameClock;
use super::super::{CurrentScene, Playback};
use super::theme::Quantity;
use crate::physics::{SolverSettings, StepStats};
use crate::sandbox::timeline::{PoseTrack, ShownStep};

pub(super) fn plugin(app: &mut App) {
    app.init_resource::<Pace>()
        .init_resource::<SceneStart>()
        .add_systems(Update, measure_pace)
        .add_systems(PostUpdate, note_scene_start);
}

/// The step count and the time at which the scene on view started.
#[derive(Resource, Clone, Copy, Debug, Default)]
pub(super) struct SceneStart {
    steps: u64,
    time: f64,
}

fn note_scene_start(scene: Option<Res<CurrentScene>>, stats: Res<StepStats>, mut start: ResMut<SceneStart>) {
    let replaced = scene.is_some_and(|scene| scene.is_changed());
    if replaced || stats.steps < start.steps {
        *start = SceneStart { steps: stats.steps, time: stats.time };
    }
}

/// How fast simulation and picture go, over the last half second or so.
#[derive(Resource, Clone, Copy, Debug, Default)]
pub(super) struct Pace {
    /// Simulated seconds per second of the clock.
    factor: f64,
    /// Per second.
    frames: f64,
    /// Of the clock's time, what steps took.
    share_of_steps: f64,
    /// Since when the next measurement runs: clock and simulation time, s.
    since: Option<(f64, f64)>,
    /// Since then.
    counted: u32,
    stepped: Duration,
}

fn measure_pace(clock: Res<Time<Real>>, stats: Res<StepStats>, frame: Res<FrameClock>, mut pace: ResMut<Pace>) {
    const SPAN: f64 = 0.5;
    let now = (clock.elapsed_secs_f64(), stats.time);
    let Some(since) = pace.since.filter(|since| since.1 <= now.1) else {
        *pace = Pace { since: Some(now), ..default() };
        return;
    };
    pace.counted += 1;
    pace.stepped += frame.steps;
    let span = now.0 - since.0;
    if span >= SPAN {
        *pace = Pace {
            factor: (now.1 - since.1) / span,
            frames: f64::from(pace.counted) / span,
            share_of_steps: pace.stepped.as_secs_f64() / span,
            since: Some(now),
            ..default()
        };
    }
}

/// The time of what is drawn, and how fast it goes.
#[derive(SystemParam)]
pub(super) struct Clock<'w> {
    playback: Res<'w, Playback>,
    stats: Res<'w, StepStats>,
    settings: Res<'w, SolverSettings>,
    start: Res<'w, SceneStart>,
    pace: Res<'w, Pace>,
    track: Res<'w, PoseTrack>,
    shown: Res<'w, ShownStep>,
}

impl Clock<'_> {
    /// Two short lines.
    pub fn show(&self, ui: &mut egui::Ui) {
        let moment = self.shown.step.and_then(|step| Some((step, self.track.time(step)?)));
        let (steps, time) = moment.unwrap_or((self.stats.steps, self.stats.time));
        let steps = steps.saturating_sub(self.start.steps);
        let each = Quantity::text(self.settings.step(), "s");
        ui.label(egui::RichText::new(format!("{:.2} s", time - self.start.time)).size(15.0))
            .on_hover_text(format!("simulation time since the scene began: step {steps}, of {each} each"));
        let (frames, share) = (self.pace.frames, 100.0 * self.pace.share_of_steps);
        let speed = match self.playback.paused {
            true => "paused".into(),
            false => format!("{:.2}× real time", self.pace.factor),
        };
        ui.label(egui::RichText::new(speed).small().weak()).on_hover_text(format!(
            "simulated seconds per second of the clock: below 1 where steps take longer than they last\n{frames:.0} frames a \
             second, physics takes {share:.0} % of the time; the rest goes into the picture, or is spare"
        ));
    }
}
