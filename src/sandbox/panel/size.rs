//! How large the interface is.

use bevy::prelude::*;
use bevy::window::PrimaryWindow;
use bevy_egui::egui;

use super::buttons::tooltip;
use crate::sandbox::{InterfaceScale, SandboxAction, ScaleChange};

pub(super) fn show(
    InMut(ui): InMut<egui::Ui>,
    scale: Res<InterfaceScale>,
    window: Single<&Window, With<PrimaryWindow>>,
    mut actions: MessageWriter<SandboxAction>,
) {
    ui.horizontal(|ui| {
        ui.label("scale").on_hover_text("of all that lies over the picture");
        let now = format!("{} %", scale.fitting(window.size()));
        for (label, change) in [("−", ScaleChange::Smaller), (&now, ScaleChange::Normal), ("+", ScaleChange::Larger)]
        {
            let action = SandboxAction::ScaleInterface(change);
            let width = if change == ScaleChange::Normal { 56.0 } else { 28.0 };
            let button = egui::Button::new(label).min_size(egui::vec2(width, 0.0));
            if ui.add(button).on_hover_text(tooltip(&action)).clicked() {
                actions.write(action);
            }
        }
    });
}
