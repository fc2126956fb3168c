//! Play, pause, step and the other things a user does, and how time runs.

use std::time::Duration;

use bevy::prelude::*;
use bevy_egui::egui;

use super::super::playback::FrameClock;
use super::super::{CurrentScene, Playback, SandboxAction};
use super::buttons::{ActionButton, button_row};
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

pub(super) fn show(
    InMut(ui): InMut<egui::Ui>,
    playback: Res<Playback>,
    stats: Res<StepStats>,
    settings: Res<SolverSettings>,
    start: Res<SceneStart>,
    pace: Res<Pace>,
    (track, shown): (Res<PoseTrack>, Res<ShownStep>),
    mut actions: MessageWriter<SandboxAction>,
) {
    ui.add_space(4.0);
    let play = if playback.paused { "▶ Play" } else { "⏸ Pause" };
    button_row(
        ui,
        &mut actions,
        [
            ActionButton::new(play, SandboxAction::TogglePause).lit_if(playback.paused),
            ActionButton::new("⏭ Step", SandboxAction::StepOnce),
            ActionButton::new("⟲ Reset", SandboxAction::Reset),
            ActionButton::new("🐢 Slow", SandboxAction::ToggleSlowMotion).lit_if(playback.slow),
        ],
    );
    button_row(
        ui,
        &mut actions,
        [
            ActionButton::new("⚽ Ball", SandboxAction::ThrowBall),
            ActionButton::new("🗑 Delete", SandboxAction::DeletePicked),
            ActionButton::new("📷 Photo", SandboxAction::Screenshot),
            ActionButton::new("❓ Help", SandboxAction::ToggleHelp),
        ],
    );
    // Of the moment that is drawn.
    let moment = shown.step.and_then(|step| Some((step, track.time(step)?)));
    let (steps, time) = moment.unwrap_or((stats.steps, stats.time));
    ui.horizontal(|ui| {
        ui.label(format!("{:.2} s", time - start.time)).on_hover_text("simulation time since the scene began");
        ui.separator();
        ui.label(format!("step {}", steps.saturating_sub(start.steps)))
            .on_hover_text(format!("of {} each", Quantity::text(settings.step(), "s")));
        ui.separator();
        let speed = if playback.paused { "paused".into() } else { format!("{:.2}× real time", pace.factor) };
        ui.label(speed)
            .on_hover_text("simulated seconds per second of the clock: below 1 where steps take longer than they last");
        if stats.quarantined > 0 {
            ui.colored_label(ui.visuals().error_fg_color, format!("{} frozen", stats.quarantined))
                .on_hover_text("bodies or joints whose state made no sense; the read-outs name them");
        }
    });
    let (frames, share) = (pace.frames, 100.0 * pace.share_of_steps);
    ui.weak(format!("{frames:.0} frames a second, physics takes {share:.0} % of the time"))
        .on_hover_text("the rest goes into the picture, or is spare");
}
