//! The help overlay, and a hint at the start.

use bevy::prelude::*;
use bevy_egui::{EguiContexts, EguiPrimaryContextPass, egui};

use super::controls::{BINDINGS, MOUSE};
use super::panel::{BESIDE_TOOLS, STRIP_HEIGHT};
use super::state::DrivingKeys;
use super::{SandboxAction, Selection};

/// Whether the help is on view.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct HelpOpen(pub bool);

pub(super) fn plugin(app: &mut App) {
    app.init_resource::<HelpOpen>()
        .add_systems(Update, toggle)
        .add_systems(EguiPrimaryContextPass, (show_help, show_hint));
}

fn toggle(mut actions: MessageReader<SandboxAction>, mut open: ResMut<HelpOpen>) {
    for action in actions.read() {
        match action {
            SandboxAction::ToggleHelp => open.0 = !open.0,
            SandboxAction::Escape if open.0 => open.0 = false,
            _ => {}
        }
    }
}

fn show_help(mut contexts: EguiContexts, driving: Res<DrivingKeys>, mut open: ResMut<HelpOpen>) -> Result {
    if !open.0 {
        return Ok(());
    }
    let mut stays = true;
    let context = contexts.ctx_mut()?;
    // Above the strip of time, under its own title.
    let room = context.content_rect().height() - STRIP_HEIGHT - 88.0;
    egui::Window::new("Help")
        .open(&mut stays)
        .collapsible(false)
        .resizable(false)
        .anchor(egui::Align2::LEFT_TOP, [BESIDE_TOOLS, 24.0])
        .show(context, |ui| {
            // A small window does not hold all of it.
            egui::ScrollArea::vertical().max_height(room).min_scrolled_height(room).show(ui, |ui| tables(ui, &driving));
        });
    open.set_if_neq(HelpOpen(stays));
    Ok(())
}

fn tables(ui: &mut egui::Ui, driving: &DrivingKeys) {
    let keys = BINDINGS.iter().map(|binding| (binding.label, binding.about));
    table(ui, "Mouse", MOUSE.iter().copied());
    ui.add_space(8.0);
    table(ui, "Keys", keys);
    if !driving.0.is_empty() {
        ui.add_space(8.0);
        let driven: Vec<_> = driving.0.iter().map(|motors| (&motors.label, driven(&motors.joints))).collect();
        table(ui, "Motors of this scene", driven.iter().map(|(keys, what)| (keys.as_str(), what.as_str())));
    }
}

/// What keys drive: by name where that is short.
fn driven(joints: &[String]) -> String {
    match joints {
        [one] => format!("drive {one}"),
        [one, other] => format!("drive {one}, {other}"),
        [first, ..] => format!("drive {first} and {} more", joints.len() - 1),
        [] => String::new(),
    }
}

fn table<'a>(ui: &mut egui::Ui, title: &str, rows: impl Iterator<Item = (&'a str, &'a str)>) {
    ui.strong(title);
    egui::Grid::new(title).num_columns(2).spacing([24.0, 4.0]).show(ui, |ui| {
        for (input, about) in rows {
            ui.monospace(input);
            ui.label(about);
            ui.end_row();
        }
    });
}

/// Shown until somebody picks a body or asks for help.
fn show_hint(
    mut contexts: EguiContexts,
    selection: Res<Selection>,
    help: Res<HelpOpen>,
    driving: Res<DrivingKeys>,
    mut understood: Local<bool>,
) -> Result {
    *understood |= selection.body.is_some() || help.0;
    if *understood {
        return Ok(());
    }
    egui::Area::new(egui::Id::new("hint")).anchor(egui::Align2::LEFT_TOP, [16.0, 14.0]).interactable(false).show(
        contexts.ctx_mut()?,
        |ui| {
            let keys =
                driving.0.iter().map(|motors| format!("  ·  {} drive", motors.label)).take(3).collect::<String>();
            let hint = egui::Label::new(format!("drag a body{keys}  ·  H for help")).extend();
            egui::Frame::popup(ui.style()).show(ui, |ui| ui.add(hint));
        },
    );
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_action_opens_and_closes_and_escape_only_closes() {
        let mut app = App::new();
        app.add_message::<SandboxAction>().init_resource::<HelpOpen>().add_systems(Update, toggle);
        let mut after = |action| {
            app.world_mut().write_message(action);
            app.update();
            app.world().resource::<HelpOpen>().0
        };
        assert!(!after(SandboxAction::Escape));
        assert!(after(SandboxAction::ToggleHelp));
        assert!(!after(SandboxAction::Escape));
        assert!(after(SandboxAction::ToggleHelp));
        assert!(!after(SandboxAction::ToggleHelp));
    }
}
