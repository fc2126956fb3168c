//! What the next body is to be, and the buttons that build.

use bevy::prelude::*;
use bevy_egui::egui;

use super::super::build::{UndoStack, stem};
use super::super::{Blueprint, Hills, JoinKind, MeshForm, SandboxAction, Selection, Snap, Weight};
use super::buttons::{ActionButton, button_row, toggle, tooltip, wide_button};
use super::entry::{Entered, Left};
use super::hills::HillRows;
use super::mesh::MeshRows;
use super::theme::Quantity;
use super::toolbar::{SHAPES, is_alike};
use crate::scene::{ShapeSpec, builtin_meshes};

/// Sizes that can be set, m.
const SIZES: std::ops::RangeInclusive<f64> = 0.01..=100.0;
/// Densities, kg/m³, and masses, kg.
const DENSITIES: std::ops::RangeInclusive<f64> = 0.1..=1e6;
pub(super) const MASSES: std::ops::RangeInclusive<f64> = 1e-3..=1e9;

/// What is told of the two.
pub(super) const MAKE_ONE: &str = "it has their mass and momentum, of one density: their mean; surface, layers and color of the \
first; joints between them go, those to others stay";
pub(super) const TAKE_APART: &str = "each part of a compound or of a mesh in pieces moves on as a body of its own; joints hold the \
part that is nearest; parts that overlap push each other apart";

/// What the section's widgets hold.
#[derive(Default)]
pub(super) struct BuildForm {
    /// Of an OBJ file.
    path: String,
    entered: Entered,
    mesh: MeshRows,
    hills: HillRows,
}

pub(super) fn show(
    InMut(ui): InMut<egui::Ui>,
    mut blueprint: ResMut<Blueprint>,
    mut form: Local<BuildForm>,
    (mut join, mut snap): (ResMut<JoinKind>, ResMut<Snap>),
    selection: Res<Selection>,
    undo: Res<UndoStack>,
    mut actions: MessageWriter<SandboxAction>,
) {
    let mut edited = blueprint.clone();
    let file_of_mesh = MeshForm::of(&edited.shape).map(|(file, ..)| file.to_owned());
    let choose = |file: String| SandboxAction::ChooseMesh { file, scale: 1.0, form: MeshForm::Hull };
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing = egui::vec2(2.0, 2.0);
        for (name, _, start) in SHAPES {
            let chosen = is_alike(&edited.shape, &start);
            if ui.selectable_label(chosen, name).clicked() && !chosen {
                edited.shape = start;
            }
        }
        let are_hills = Hills::are(&edited.shape);
        if ui.selectable_label(are_hills, "hills").on_hover_text("a hilly ground, fixed").clicked() && !are_hills {
            actions.write(SandboxAction::ChooseHills(edited.hills));
        }
        for file in builtin_meshes() {
            let chosen = file_of_mesh.as_ref() == Some(&file);
            if ui.selectable_label(chosen, stem(&file)).on_hover_text("a mesh that comes with Plumb").clicked() {
                actions.write(choose(file));
            }
        }
    });
    ui.horizontal(|ui| {
        ui.label("mesh").on_hover_text("path of a Wavefront OBJ file: the body looks like it");
        let BuildForm { path, entered, .. } = &mut *form;
        let id = egui::Id::new("mesh file");
        if blueprint.is_changed() {
            entered.accept(ui.ctx(), id);
        }
        let field = egui::TextEdit::singleline(path).hint_text("my_mesh.obj");
        let field = field.desired_width(ui.available_width() - 50.0);
        let entered = entered.show(ui, id, field) == Some(Left::ByEnter);
        let given = !form.path.trim().is_empty();
        if (ui.add_enabled(given, egui::Button::new("Use")).clicked() || entered) && given {
            actions.write(choose(form.path.trim().into()));
        }
    });
    match &mut edited.shape {
        shape if has_sizes(shape) => _ = ui.horizontal(|ui| sizes(ui, shape)),
        shape if Hills::are(shape) => {
            form.hills.show(ui, edited.hills).into_iter().for_each(|asked| _ = actions.write(asked));
        }
        shape => form.mesh.show(ui, shape).into_iter().for_each(|asked| _ = actions.write(asked)),
    }
    ui.horizontal(|ui| weight(ui, &mut edited));
    blueprint.set_if_neq(edited);
    join_kind(ui, &mut join);
    grid(ui, &mut snap);

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
    ui.columns(2, |columns| {
        let picked = selection.bodies().count();
        let both = [
            ("Make one body", MAKE_ONE, picked > 1, SandboxAction::MakeOneBody),
            ("Take apart", TAKE_APART, picked > 0, SandboxAction::TakeApart),
        ];
        for (column, (label, about, enabled, action)) in columns.iter_mut().zip(both) {
            let about = format!("{}\n{about}", tooltip(&action));
            let shown = wide_button(column, 24.0, enabled, egui::Button::new(label));
            if shown.on_hover_text(&about).on_disabled_hover_text(about).clicked() {
                actions.write(action);
            }
        }
    });
    ui.columns(2, |columns| {
        let both = [("⮪ Undo", undo.next(), SandboxAction::Undo), ("⮫ Redo", undo.next_again(), SandboxAction::Redo)];
        for (column, (label, what, action)) in columns.iter_mut().zip(both) {
            let text = what.map_or_else(|| label.to_owned(), |what| format!("{label} {what}"));
            let button = egui::Button::new(text).truncate();
            let shown = wide_button(column, 24.0, what.is_some(), button);
            if shown.on_hover_text(tooltip(&action)).clicked() {
                actions.write(action);
            }
        }
    });
}

/// The grid for what is put by hand.
fn grid(ui: &mut egui::Ui, snap: &mut ResMut<Snap>) {
    let mut edited = **snap;
    ui.horizontal(|ui| {
        let about = "handles, new bodies and bars go to multiples of these; Ctrl turns it round while it is held";
        if ui.add(toggle(ui, edited.is_on, "snap")).on_hover_text(about).clicked() {
            edited.is_on = !edited.is_on;
        }
        let grid = egui::DragValue::new(&mut edited.grid).suffix(" m").speed(0.005).range(Snap::GRIDS).max_decimals(3);
        ui.add(grid).on_hover_text("places and sizes");
        let turns = egui::DragValue::new(&mut edited.degrees).suffix("°").speed(0.2).range(Snap::TURNS).max_decimals(1);
        ui.add(turns).on_hover_text("turns");
    });
    snap.set_if_neq(edited);
}

/// What joints are made as.
fn join_kind(ui: &mut egui::Ui, chosen: &mut ResMut<JoinKind>) {
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing = egui::vec2(2.0, 2.0);
        ui.label("join by").on_hover_text("what 'Join' makes of two picked bodies");
        for (kind, name, about) in JoinKind::ALL {
            if ui.selectable_label(**chosen == kind, name).on_hover_text(about).clicked() {
                chosen.set_if_neq(kind);
            }
        }
    });
}

/// Whether a shape is told by a few sizes.
pub(super) fn has_sizes(shape: &ShapeSpec) -> bool {
    matches!(
        shape,
        ShapeSpec::Sphere { .. }
            | ShapeSpec::Cuboid { .. }
            | ShapeSpec::Capsule { .. }
            | ShapeSpec::Cylinder { .. }
            | ShapeSpec::Cone { .. }
    )
}

pub(super) fn sizes(ui: &mut egui::Ui, shape: &mut ShapeSpec) {
    let mut size = |label: &str, value: &mut f64| {
        ui.add(egui::DragValue::new(value).prefix(format!("{label} ")).speed(0.01).range(SIZES).max_decimals(3));
    };
    match shape {
        ShapeSpec::HalfSpace
        | ShapeSpec::Hull(_)
        | ShapeSpec::Mesh(_)
        | ShapeSpec::Compound(_)
        | ShapeSpec::Surface(_) => {}
        ShapeSpec::Sphere { radius } => size("radius", radius),
        ShapeSpec::Cuboid { size: extents } => {
            for (axis, value) in ["x", "y", "z"].into_iter().zip(extents.as_mut()) {
                size(axis, value);
            }
        }
        ShapeSpec::Capsule { radius, length } => {
            size("radius", radius);
            size("length", length);
        }
        ShapeSpec::Cylinder { radius, height } | ShapeSpec::Cone { radius, height } => {
            size("radius", radius);
            size("height", height);
        }
    }
    ui.label("m");
}

/// Density or mass, and the other one of the two.
fn weight(ui: &mut egui::Ui, blueprint: &mut Blueprint) {
    let volume = blueprint.shape.volume();
    if volume.is_infinite() {
        ui.weak("fixed: a surface has no mass");
        return;
    }
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
