//! The last word to the user, over the picture for a few seconds.

use bevy::prelude::*;
use bevy_egui::{EguiContexts, EguiPrimaryContextPass, egui};

use super::super::Notice;
use super::entry::take_refused;
use super::strip::STRIP_HEIGHT;
use super::toolbar::BESIDE_TOOLS;
use crate::sandbox::state::Covered;

/// How long a notice stays, s.
const SECONDS: f64 = 6.0;

pub(super) fn plugin(app: &mut App) {
    app.add_systems(EguiPrimaryContextPass, show);
}

fn show(
    mut contexts: EguiContexts,
    mut notice: ResMut<Notice>,
    clock: Res<Time<Real>>,
    covered: Res<Covered>,
    mut until: Local<f64>,
) -> Result {
    let now = clock.elapsed_secs_f64();
    if let Some(reason) = take_refused(contexts.ctx_mut()?) {
        *notice = Notice::Error(reason);
    }
    if notice.is_changed() {
        *until = now + SECONDS;
    }
    if now > *until {
        return Ok(());
    }
    let context = contexts.ctx_mut()?;
    let (text, color) = match &*notice {
        Notice::None => return Ok(()),
        Notice::Info(text) => (text, egui::Color32::from_gray(225)),
        Notice::Error(text) => (text, context.global_style().visuals.error_fg_color),
    };
    let [_, plots] = covered.in_points(context);
    egui::Area::new(egui::Id::new("notice"))
        .anchor(egui::Align2::LEFT_BOTTOM, [BESIDE_TOOLS, -12.0 - STRIP_HEIGHT - plots])
        .interactable(false)
        .show(context, |ui| {
            egui::Frame::popup(ui.style()).show(ui, |ui| {
                ui.set_max_width(560.0);
                ui.colored_label(color, text);
            });
        });
    Ok(())
}
