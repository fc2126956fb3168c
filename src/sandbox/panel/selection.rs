//! The body that was picked last.

use bevy::math::DVec3;
use bevy::prelude::*;
use bevy_egui::egui;

use super::super::{SandboxAction, Selection};
use super::theme::Quantity;
use crate::physics::{Mass, Position, RigidBody, Velocity};

pub(super) fn show(
    InMut(ui): InMut<egui::Ui>,
    selection: Res<Selection>,
    bodies: Query<(Option<&Name>, &RigidBody, &Position, &Velocity, Option<&Mass>)>,
    mut actions: MessageWriter<SandboxAction>,
) {
    let Some((entity, (name, kind, position, velocity, mass))) =
        selection.0.and_then(|entity| Some((entity, bodies.get(entity).ok()?)))
    else {
        ui.weak("none: click a body in the picture");
        return;
    };
    ui.horizontal(|ui| {
        ui.strong(name.map_or_else(|| entity.to_string(), ToString::to_string));
        let kind = format!("{kind:?}").to_lowercase();
        ui.weak(match mass {
            Some(mass) => format!("{kind}, {}", Quantity::text(mass.0 * 1000.0, "g")),
            None => kind,
        });
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            if ui.small_button("🗑 delete").on_hover_text("delete this body and its joints").clicked() {
                actions.write(SandboxAction::DeletePicked);
            }
        });
    });
    egui::Grid::new("selected body").num_columns(2).show(ui, |ui| {
        for (label, vector, unit) in
            [("position", position.0, "m"), ("velocity", velocity.linear, "m/s"), ("spin", velocity.angular, "rad/s")]
        {
            ui.label(label);
            ui.monospace(vector_text(vector, unit));
            ui.end_row();
        }
    });
}

fn vector_text(v: DVec3, unit: &str) -> String {
    format!("{:7.3} {:7.3} {:7.3} {unit}", v.x, v.y, v.z)
}
