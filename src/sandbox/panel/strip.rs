//! The strip under the picture: play and pause, how far back what happened is kept, and the head that goes there.

use bevy::prelude::*;
use bevy_egui::{EguiContexts, egui};

use super::buttons::{toggle, tooltip};
use super::playback::Clock;
use super::theme::{Quantity, palette};
use crate::physics::{History, SolverSettings, StepStats};
use crate::sandbox::state::{Covered, ShowsPlots};
use crate::sandbox::timeline::{LIMIT, PoseTrack, ShownStep, head_and_reach};
use crate::sandbox::{CurrentScene, GhostReadings, Playback, SandboxAction, Timeline};

/// What the strip takes of the window's height, points, its margins too.
pub const STRIP_HEIGHT: f32 = 62.0;
const MARGIN: f32 = 8.0;
const BAR: f32 = 18.0;
/// Width of the time.
const CLOCK: f32 = 86.0;
/// Marks that are nearer than this to the pointer, points, draw the head to them.
const SNAP: f32 = 5.0;
/// Widths below which it leaves out what is said at its end, the time and what is done more rarely, points.
const SAYS: f32 = 600.0;
const TELLS_TIME: f32 = 520.0;
/// What is said at the end of the strip at most.
const LONGEST: &str = "8888.88 s ago";
const ABOUT: &str = "what happened: drag the head to go there; orange: what was done; yellow: marks; with a point on top: where a ghost of \
     that color parted. What you do in the past ends what came after it";

/// Draws it beside the panel, which is drawn before.
pub(super) fn show(
    mut contexts: EguiContexts,
    scene: Option<Res<CurrentScene>>,
    history: Option<Res<History>>,
    stats: Res<StepStats>,
    settings: Res<SolverSettings>,
    timeline: Res<Timeline>,
    (track, shown): (Res<PoseTrack>, Res<ShownStep>),
    ghosts: Res<GhostReadings>,
    playback: Res<Playback>,
    (covered, clock, shows_plots): (Res<Covered>, Clock, Res<ShowsPlots>),
    mut actions: MessageWriter<SandboxAction>,
) -> Result {
    let (Some(history), Some(_)) = (history, scene) else { return Ok(()) };
    let context = contexts.ctx_mut()?;
    let [panel, _] = covered.in_points(context);
    let width = context.content_rect().width() - panel - 2.0 * MARGIN;
    let (head, reach) = head_and_reach(&stats, Some(&history));
    let head = shown.step.unwrap_or(head);
    egui::Area::new(egui::Id::new("strip")).anchor(egui::Align2::LEFT_BOTTOM, [MARGIN, -MARGIN]).constrain(false).show(
        context,
        |ui| {
            egui::Frame::popup(ui.style()).inner_margin(6.0).show(ui, |ui| {
                ui.set_width((width - 12.0).max(1.0));
                ui.set_height(STRIP_HEIGHT - 2.0 * MARGIN - 12.0);
                ui.horizontal_centered(|ui| {
                    buttons(ui, &timeline, &playback, (shows_plots.0, width < TELLS_TIME), &mut actions);
                    if width >= TELLS_TIME {
                        let room = egui::vec2(CLOCK, ui.available_height());
                        ui.allocate_ui_with_layout(room, egui::Layout::top_down(egui::Align::Center), |ui| {
                            ui.set_width(CLOCK);
                            ui.spacing_mut().item_spacing.y = 1.0;
                            clock.show(ui);
                        });
                    }
                    let said = said(head, reach, &settings);
                    // The bar is as long whatever is said: the head stays under the pointer.
                    let longest =
                        egui::WidgetText::from(LONGEST).into_galley(ui, None, f32::INFINITY, egui::TextStyle::Body);
                    let says = if width < SAYS { 0.0 } else { longest.size().x + ui.spacing().item_spacing.x };
                    let room = ui.available_width() - says;
                    let bar = Bar {
                        head,
                        is_shown_alone: shown.step.is_some(),
                        reach,
                        history: &history,
                        timeline: &timeline,
                        ghosts: &ghosts,
                    };
                    if let Some(step) = bar.show(ui, room.max(40.0)) {
                        actions.write(SandboxAction::LookAt { step });
                    }
                    if width >= SAYS {
                        ui.label(said).on_hover_ui(|ui| {
                            let takes = Quantity::text((history.bytes() + track.bytes()) as f64, "B");
                            ui.label(format!("{takes} of {} MiB; what is older thins out and goes", LIMIT >> 20));
                        });
                    }
                });
            });
        },
    );
    Ok(())
}

/// Play is the largest; before it what goes back, after it what goes on. Where there is little room, what has a key and is used
/// rarely is left out.
fn buttons(
    ui: &mut egui::Ui,
    timeline: &Timeline,
    playback: &Playback,
    (shows_plots, is_narrow): (bool, bool),
    actions: &mut MessageWriter<SandboxAction>,
) {
    let play = if playback.paused { "▶" } else { "⏸" };
    for (label, action, is_on) in [
        ("⟲", SandboxAction::Reset, false),
        ("⏮", SandboxAction::GoToStart, false),
        ("◀", SandboxAction::TogglePlayBackwards, timeline.backwards),
        ("⏴", SandboxAction::StepBack, false),
        (play, SandboxAction::TogglePause, false),
        ("⏵", SandboxAction::StepOnce, false),
        ("⏭", SandboxAction::GoToNow, false),
        ("🐢", SandboxAction::ToggleSlowMotion, playback.slow),
        ("⚑", SandboxAction::ToggleMark, false),
        ("🔁", SandboxAction::ToggleLoop, timeline.looped.is_some()),
        ("📈", SandboxAction::TogglePlots, shows_plots),
    ] {
        let is_rare = matches!(
            action,
            SandboxAction::GoToStart
                | SandboxAction::GoToNow
                | SandboxAction::ToggleSlowMotion
                | SandboxAction::ToggleMark
                | SandboxAction::ToggleLoop
        );
        if is_narrow && is_rare {
            continue;
        }
        let is_play = action == SandboxAction::TogglePause;
        let (size, text) = match is_play {
            true => (egui::vec2(46.0, 36.0), egui::RichText::new(label).size(22.0)),
            false => (egui::vec2(24.0, 26.0), egui::RichText::new(label)),
        };
        let button = toggle(ui, is_on || is_play && playback.paused, text).min_size(size);
        if ui.add(button).on_hover_text(tooltip(&action)).clicked() {
            actions.write(action);
        }
    }
}

/// How far the head is from the last moment.
fn said(head: u64, [_, last]: [u64; 2], settings: &SolverSettings) -> String {
    let behind = (last - head) as f64 * settings.step();
    if head == last { "now".into() } else { format!("{behind:.2} s ago") }
}

struct Bar<'a> {
    head: u64,
    /// Whether the world is elsewhere.
    is_shown_alone: bool,
    reach: [u64; 2],
    history: &'a History,
    timeline: &'a Timeline,
    ghosts: &'a GhostReadings,
}

impl Bar<'_> {
    /// Draws it; the step that the pointer asks for.
    fn show(&self, ui: &mut egui::Ui, width: f32) -> Option<u64> {
        let (rect, response) = ui.allocate_exact_size(egui::vec2(width, BAR), egui::Sense::click_and_drag());
        let [first, last] = self.reach;
        let span = (last - first).max(1) as f32;
        let x = |step: u64| rect.left() + rect.width() * (step.clamp(first, last) - first) as f32 / span;
        let painter = ui.painter_at(rect.expand(2.0));
        let color = |[r, g, b]: [u8; 3]| egui::Color32::from_rgb(r, g, b);
        painter.rect_filled(rect, 3.0, egui::Color32::from_gray(45));
        let mut past = rect;
        past.set_right(x(self.head));
        painter.rect_filled(past, 3.0, color(palette::SKY).gamma_multiply(0.45));
        if let Some([from, to]) = self.timeline.looped {
            let looped = egui::Rect::from_x_y_ranges(x(from)..=x(to), rect.bottom() - 4.0..=rect.bottom());
            painter.rect_filled(looped, 0.0, color(palette::GREEN));
        }
        // Of deeds in a row one line.
        let mut drawn = f32::NEG_INFINITY;
        for at in self.history.acts().filter(|step| *step > first).map(x) {
            if at - drawn >= 1.0 {
                painter.vline(at, rect.top()..=rect.center().y, (1.0, color(palette::ORANGE)));
                drawn = at;
            }
        }
        for &mark in self.timeline.marks.iter().filter(|mark| (first..=last).contains(mark)) {
            painter.vline(x(mark), rect.y_range(), (2.0, color(palette::YELLOW)));
        }
        // Where a ghost parted, in its color.
        for ghost in &self.ghosts.ghosts {
            if let Some(at) = ghost.parted.filter(|step| (first..=last).contains(step)).map(x) {
                painter.vline(at, rect.y_range(), (2.0, color(ghost.color)));
                let corners = [[-4.0, 0.0], [4.0, 0.0], [0.0, 6.0]];
                let corners = corners.map(|[dx, dy]| egui::pos2(at + dx, rect.top() + dy)).to_vec();
                painter.add(egui::Shape::convex_polygon(corners, color(ghost.color), egui::Stroke::NONE));
            }
        }
        painter.vline(x(self.head), rect.expand(2.0).y_range(), (2.0, egui::Color32::WHITE));
        let pointer = response.interact_pointer_pos();
        // What is drawn is looked at, and not to be covered.
        let response = if response.dragged() { response } else { response.on_hover_text(ABOUT) };
        if !(response.dragged() || response.clicked()) {
            return None;
        }
        let at = pointer?.x;
        let parted = self.ghosts.ghosts.iter().filter_map(|ghost| ghost.parted);
        let mark = self.timeline.marks.iter().copied().chain(parted).find(|mark| (x(*mark) - at).abs() <= SNAP);
        let share = ((at - rect.left()) / rect.width()).clamp(0.0, 1.0);
        let step = mark.unwrap_or(first + (f64::from(share) * (last - first) as f64).round() as u64);
        // What is looked at is held on to.
        (step != self.head || self.is_shown_alone).then_some(step)
    }
}
