//! Gravity.

use bevy::math::DVec3;
use bevy::prelude::*;
use bevy_egui::egui;

use crate::physics::Gravity;

pub(super) fn show(InMut(ui): InMut<egui::Ui>, mut gravity: ResMut<Gravity>) {
    let mut edited = gravity.0;
    ui.horizontal(|ui| {
        ui.label("gravity").on_hover_text("acceleration of gravity, m/s²; y is up");
        for (axis, value) in ["x ", "y ", "z "].into_iter().zip(edited.as_mut()) {
            ui.add(egui::DragValue::new(value).prefix(axis).speed(0.05).range(-1000.0..=1000.0).max_decimals(3));
        }
        ui.label("m/s²");
    });
    ui.horizontal(|ui| {
        for (name, g) in [("none", 0.0), ("Moon", 1.62), ("Earth", 9.81), ("Jupiter", 24.79)] {
            if ui.small_button(name).on_hover_text(format!("{g} m/s² downwards")).clicked() {
                edited = DVec3::new(0.0, -g, 0.0);
            }
        }
    });
    gravity.set_if_neq(Gravity(edited));
}
