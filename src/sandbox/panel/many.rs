//! Several picked bodies: what they are together, and what can be done with them.

use bevy::prelude::*;
use bevy_egui::egui;

use super::body::{MassParts, mass_of};
use super::build::MAKE_ONE;
use super::buttons::{ActionButton, button_row, tooltip, wide_button};
use super::theme::Quantity;
use crate::physics::RigidBody;
use crate::sandbox::{SandboxAction, Selection};

pub(super) fn show(
    InMut(ui): InMut<egui::Ui>,
    selection: Res<Selection>,
    bodies: Query<(&RigidBody, MassParts)>,
    mut actions: MessageWriter<SandboxAction>,
) {
    let picked: Vec<_> = selection.bodies().filter_map(|body| bodies.get(body).ok()).collect();
    let moving = picked.iter().filter(|(kind, _)| **kind == RigidBody::Dynamic);
    let mass: f64 = moving.map(|(_, parts)| mass_of(*parts)).sum();
    ui.strong(format!("{} bodies", picked.len()));
    ui.weak(format!("{} of what moves", Quantity::text(mass * 1000.0, "g")));
    ui.add_space(4.0);
    button_row(
        ui,
        &mut actions,
        [
            ActionButton::new("Duplicate", SandboxAction::Duplicate),
            ActionButton::new("Copy", SandboxAction::Copy),
            ActionButton::new("Cut out", SandboxAction::CutOut),
            ActionButton::new("Delete", SandboxAction::DeletePicked),
        ],
    );
    let join = ui.add_enabled(
        selection.partner.is_some(),
        egui::Button::new("🔗 Join the first and the last that were clicked"),
    );
    let join = join
        .on_disabled_hover_text("click one body, then another with Shift held: where they are clicked they are joined");
    if join.on_hover_text(tooltip(&SandboxAction::JoinPicked)).clicked() {
        actions.write(SandboxAction::JoinPicked);
    }
    let one = wide_button(ui, 24.0, true, egui::Button::new("Make one body"));
    if one.on_hover_text(format!("{}\n{MAKE_ONE}", tooltip(&SandboxAction::MakeOneBody))).clicked() {
        actions.write(SandboxAction::MakeOneBody);
    }
    ui.weak("T, E and S: handles that move, turn and scale all of them");
}
