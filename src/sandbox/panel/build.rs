//! What the next body is to be, and the buttons that build.

use bevy::prelude::*;
use bevy_egui::egui;

use super::super::build::UndoStack;
use super::super::{Blueprint, SandboxAction, Selection, Weight};
use super::buttons::{ActionButton, button_row, tooltip};
use super::theme::Quantity;
use crate::scene::ShapeSpec;

/// Sizes that can be set, m.
const SIZES: std::ops::RangeInclusive<f64> = 0.01..=100.0;
/// Densities, kg/m³, and masses, kg.
const DENSITIES: std::ops::RangeInclusive<f64> = 0.1..=1e6;
const MASSES: std::ops::RangeInclusive<f64> = 1e-3..=1e9;

/// Something to choose: its name, and what it starts as.
const SHAPES: [(&str, ShapeSpec); 3] = [
    ("ball", ShapeSpec::Sphere { radius: 0.25 }),
    ("box", ShapeSpec::Cuboid { size: bevy::math::DVec3::splat(0.5) }),
    ("cone", ShapeSpec::Cone { radius: 0.25, height: 0.6 }),
];

pub(super) fn show(
    InMut(ui): InMut<egui::Ui>,
    mut blueprint: ResMut<Blueprint>,
    selection: Res<Selection>,
    undo: Res<UndoStack>,
    mut actions: MessageWriter<SandboxAction>,
) {
    let mut edited = blueprint.clone();
    ui.horizontal_wrapped(|ui| {
        for (name, start) in SHAPES {
            let chosen = std::mem::discriminant(&edited.shape) == std::mem::discriminant(&start);
            if ui.selectable_label(chosen, name).clicked() && !chosen {
                edited.shape = start;
            }
        }
    });
    ui.horizontal(|ui| sizes(ui, &mut edited.shape));
    ui.horizontal(|ui| weight(ui, &mut edited));
    blueprint.set_if_neq(edited);

    button_row(
        ui,
        &mut actions,
        [
            ActionButton::new("➕ Add", SandboxAction::SpawnBody),
            ActionButton::new("🔗 Join", SandboxAction::JoinPicked).enabled_if(selection.partner.is_some()),
            ActionButton::new("📌 Pin", SandboxAction::PinPicked).enabled_if(selection.body.is_some()),
            ActionButton::new("✂ Cut", SandboxAction::CutPicked).enabled_if(selection.body.is_some()),
        ],
    );
    let undoes = undo.next().map(|what| format!("⮪ Undo {what}"));
    let button = egui::Button::new(undoes.as_deref().unwrap_or("⮪ Undo")).truncate();
    if ui.add_enabled(undoes.is_some(), button).on_hover_text(tooltip(&SandboxAction::Undo)).clicked() {
        actions.write(SandboxAction::Undo);
    }
}

fn sizes(ui: &mut egui::Ui, shape: &mut ShapeSpec) {
    let mut size = |label: &str, value: &mut f64| {
        ui.add(egui::DragValue::new(value).prefix(format!("{label} ")).speed(0.01).range(SIZES).max_decimals(3));
    };
    match shape {
        ShapeSpec::HalfSpace | ShapeSpec::Hull(_) | ShapeSpec::Mesh(_) => {}
        ShapeSpec::Sphere { radius } => size("radius", radius),
        ShapeSpec::Cuboid { size: extents } => {
            for (axis, value) in ["x", "y", "z"].into_iter().zip(extents.as_mut()) {
                size(axis, value);
            }
        }
        ShapeSpec::Cone { radius, height } => {
            size("radius", radius);
            size("height", height);
        }
    }
    ui.label("m");
}

/// Density or mass, and the other one of the two.
fn weight(ui: &mut egui::Ui, blueprint: &mut Blueprint) {
    let volume = blueprint.shape.volume();
    let (density, mass) = (blueprint.mass() / volume, blueprint.mass());
    let by_density = matches!(blueprint.weight, Weight::Density(_));
    if ui.selectable_label(by_density, "density").clicked() {
        blueprint.weight = Weight::Density(density);
    }
    if ui.selectable_label(!by_density, "mass").clicked() {
        blueprint.weight = Weight::Mass(mass);
    }
    match &mut blueprint.weight {
        Weight::Density(density) => {
            let speed = *density * 0.01;
            ui.add(egui::DragValue::new(density).suffix(" kg/m³").speed(speed).range(DENSITIES).max_decimals(1));
            ui.weak(Quantity::text(mass * 1000.0, "g"));
        }
        Weight::Mass(mass) => {
            let speed = *mass * 0.01;
            ui.add(egui::DragValue::new(mass).suffix(" kg").speed(speed).range(MASSES).max_decimals(3));
            ui.weak(format!("{density:.0} kg/m³"));
        }
    }
}
