//! The picked bodies, and the joints of the first.

use bevy::math::DVec3;
use bevy::prelude::*;
use bevy_egui::egui;

use super::super::{SandboxAction, Selection};
use super::theme::Quantity;
use crate::physics::{BallJoint, Mass, Position, RigidBody, Velocity};
use crate::scene::SceneEntity;

/// How many joints are listed.
const LISTED: usize = 12;

pub(super) fn show(
    InMut(ui): InMut<egui::Ui>,
    selection: Res<Selection>,
    bodies: Query<(Option<&Name>, &RigidBody, &Position, &Velocity, Option<&Mass>)>,
    joints: Query<(Entity, &BallJoint), With<SceneEntity>>,
    mut actions: MessageWriter<SandboxAction>,
) {
    let Some((entity, (name, kind, position, velocity, mass))) =
        selection.entity().and_then(|entity| Some((entity, bodies.get(entity).ok()?)))
    else {
        ui.weak("none: click a body in the picture");
        return;
    };
    let name_of = |entity| match bodies.get(entity) {
        Ok((Some(name), ..)) if name.starts_with("world:") => "the world".into(),
        Ok((Some(name), ..)) => name.to_string(),
        _ => entity.to_string(),
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
    if let Some(partner) = selection.partner {
        ui.label(format!("and {}", name_of(partner.entity))).on_hover_text("picked with Shift held, to be joined");
    }
    egui::Grid::new("selected body").num_columns(2).show(ui, |ui| {
        for (label, vector, unit) in
            [("position", position.0, "m"), ("velocity", velocity.linear, "m/s"), ("spin", velocity.angular, "rad/s")]
        {
            ui.label(label);
            ui.monospace(vector_text(vector, unit));
            ui.end_row();
        }
    });
    let own = joints.iter().filter(|(_, ball)| ball.body_a == entity || ball.body_b == entity);
    for (joint, ball) in own.clone().take(LISTED) {
        let other = if ball.body_a == entity { ball.body_b } else { ball.body_a };
        ui.horizontal(|ui| {
            if ui.small_button("✂ cut").on_hover_text("cut this joint").clicked() {
                actions.write(SandboxAction::Cut(joint));
            }
            ui.add(egui::Label::new(format!("joined to {}", name_of(other))).truncate());
        });
    }
    if own.clone().nth(LISTED).is_some() {
        ui.weak(format!("and {} more joints", own.count() - LISTED));
    }
}

fn vector_text(v: DVec3, unit: &str) -> String {
    format!("{:7.3} {:7.3} {:7.3} {unit}", v.x, v.y, v.z)
}
