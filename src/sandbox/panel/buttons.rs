//! Buttons that ask for what keys ask for too.

use bevy::prelude::*;
use bevy_egui::egui;

use super::super::SandboxAction;
use super::super::controls::BINDINGS;
use super::theme::ON;

/// A button and what it asks for.
pub(super) struct ActionButton {
    pub label: &'static str,
    pub action: SandboxAction,
    /// Whether it makes sense now.
    pub enabled: bool,
}

impl ActionButton {
    /// Enabled.
    pub fn new(label: &'static str, action: SandboxAction) -> Self {
        Self { label, action, enabled: true }
    }

    pub fn enabled_if(self, enabled: bool) -> Self {
        Self { enabled, ..self }
    }
}

/// Four buttons over the width of the panel.
pub(super) fn button_row(ui: &mut egui::Ui, actions: &mut MessageWriter<SandboxAction>, buttons: [ActionButton; 4]) {
    ui.columns(4, |columns| {
        for (column, ActionButton { label, action, enabled }) in columns.iter_mut().zip(buttons) {
            let tooltip = tooltip(&action);
            let shown = wide_button(column, 24.0, enabled, egui::Button::new(label));
            if shown.on_hover_text(&tooltip).on_disabled_hover_text(tooltip).clicked() {
                actions.write(action);
            }
        }
    });
}

/// A button over the whole width, with its text in the middle.
pub(super) fn wide_button(ui: &mut egui::Ui, height: f32, enabled: bool, button: egui::Button) -> egui::Response {
    let place = egui::Layout::centered_and_justified(egui::Direction::LeftToRight);
    let size = egui::vec2(ui.available_width(), height);
    ui.allocate_ui_with_layout(size, place, |ui| ui.add_enabled(enabled, button)).inner
}

/// A button that switches something: one that is on is not of the color of what is chosen.
pub(in crate::sandbox) fn toggle<'a>(
    ui: &egui::Ui,
    is_on: bool,
    text: impl Into<egui::WidgetText>,
) -> egui::Button<'a> {
    let button = egui::Button::new(text.into());
    if is_on { button.fill(ON) } else { button.fill(ui.visuals().widgets.inactive.weak_bg_fill) }
}

/// What the key of an action does, and the key.
pub(super) fn tooltip(action: &SandboxAction) -> String {
    BINDINGS
        .iter()
        .find(|binding| binding.action == *action)
        .map(|binding| format!("{} ({})", binding.about, binding.label))
        .unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_button_names_its_key() {
        for action in [
            SandboxAction::TogglePause,
            SandboxAction::StepOnce,
            SandboxAction::Reset,
            SandboxAction::ToggleSlowMotion,
            SandboxAction::ThrowBall,
            SandboxAction::SpawnBody,
            SandboxAction::JoinPicked,
            SandboxAction::PinPicked,
            SandboxAction::CutPicked,
            SandboxAction::Follow,
            SandboxAction::Undo,
            SandboxAction::Redo,
            SandboxAction::DeletePicked,
            SandboxAction::Duplicate,
            SandboxAction::Copy,
            SandboxAction::CutOut,
            SandboxAction::Paste,
            SandboxAction::MakeOneBody,
            SandboxAction::TakeApart,
            SandboxAction::Screenshot,
            SandboxAction::ToggleHelp,
        ] {
            assert!(tooltip(&action).contains('('), "{action:?} has no key");
        }
    }
}
