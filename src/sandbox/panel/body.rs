//! What a body is, to be changed while the scene runs.

use bevy::math::DVec3;
use bevy::prelude::*;
use bevy_egui::egui;

use super::build::{MASSES, TAKE_APART, has_sizes, sizes};
use super::buttons::{toggle, tooltip};
use super::theme::Quantity;
use super::vector::VectorFields;
use crate::physics::{Collider, Density, Mass, RigidBody};
use crate::sandbox::build::stem;
use crate::sandbox::{SandboxAction, Selection};
use crate::scene::{BodySpec, ShapeSpec, SurfaceForm};

/// Layers that have a box; the others stay as they are.
const LAYERS: u32 = 8;
/// Speeds that can be set, m/s and rad/s.
const SPEED: VectorFields = VectorFields { range: -1000.0..=1000.0, speed: 0.05, decimals: 2, width: 58.0 };

/// The name that is being typed.
#[derive(Default)]
pub(super) struct Typed(Option<String>);

/// The picked body, as it is.
pub(super) struct Described {
    entity: Entity,
    was: BodySpec,
}

impl Described {
    pub fn picked(world: &World) -> Option<Self> {
        let entity = world.resource::<Selection>().entity()?;
        Some(Self { entity, was: BodySpec::of_entity(world, entity)? })
    }

    /// Asks for what it is to be.
    fn ask(&self, now: BodySpec, continues: bool, actions: &mut MessageWriter<SandboxAction>) {
        actions.write(SandboxAction::ChangeBody { body: self.entity, asked: Box::new(now), continues });
    }
}

/// Its name, kind and color.
pub(super) fn show_name(
    (InMut(ui), InRef(body)): (InMut<egui::Ui>, InRef<Described>),
    drawn: Query<&MeshMaterial3d<StandardMaterial>>,
    materials: Res<Assets<StandardMaterial>>,
    mut typed: Local<Typed>,
    mut actions: MessageWriter<SandboxAction>,
) {
    let mut now = body.was.clone();
    let material = drawn.get(body.entity).ok().and_then(|material| materials.get(&material.0));
    name_and_kind(ui, &mut now, material.map(|material| material.base_color), &mut typed);
    if now != body.was {
        body.ask(now, false, &mut actions);
    }
}

/// What a body's mass is told by.
pub(super) type MassParts = (Option<&'static Mass>, Option<&'static Collider>, Option<&'static Density>);

/// Its mass, kg: one that no step has seen yet has none of its own, but that of its shape and density.
pub(super) fn mass_of((mass, collider, density): (Option<&Mass>, Option<&Collider>, Option<&Density>)) -> f64 {
    match (mass, collider) {
        (Some(mass), _) => mass.0,
        (None, Some(collider)) => collider.mass_properties(density.copied().unwrap_or_default().0).mass,
        (None, None) => 0.0,
    }
}

/// The other fields. What is changed is asked for.
pub(super) fn show(
    (InMut(ui), InRef(body)): (InMut<egui::Ui>, InRef<Described>),
    masses: Query<MassParts>,
    mut changing: Local<bool>,
    mut actions: MessageWriter<SandboxAction>,
) {
    let was = &body.was;
    let mass = masses.get(body.entity).map_or(0.0, mass_of);
    *changing &= ui.input(|input| input.pointer.any_down());
    let mut now = was.clone();
    // Other rows, another grid.
    let has_sizes = was.shape.as_ref().is_some_and(has_sizes);
    let rows = (was.kind, was.shape.is_some(), has_sizes);
    egui::Grid::new(("body", rows)).num_columns(2).spacing([10.0, 4.0]).show(ui, |ui| {
        if let Some(shape) = now.shape.as_mut().filter(|_| has_sizes) {
            ui.label("size");
            ui.horizontal(|ui| sizes(ui, shape));
            ui.end_row();
        }
        if let Some(shape) = was.shape.as_ref().filter(|_| !has_sizes) {
            ui.label("shape");
            ui.horizontal(|ui| {
                ui.add(egui::Label::new(about_shape(shape)).truncate());
                let about = || format!("{}\n{TAKE_APART}", tooltip(&SandboxAction::TakeApart));
                if shape.compound().is_some() && ui.small_button("take apart").on_hover_text(about()).clicked() {
                    actions.write(SandboxAction::TakeApart);
                }
            });
            ui.end_row();
        }
        if now.kind == RigidBody::Dynamic {
            ui.label("mass").on_hover_text("a body whose mass is set keeps it when its size is changed");
            ui.horizontal(|ui| {
                let mut edited = mass;
                let drag =
                    egui::DragValue::new(&mut edited).suffix(" kg").speed(0.01 * mass).range(MASSES).max_decimals(3);
                if ui.add(drag.update_while_editing(false)).changed() {
                    now.mass = Some(edited);
                }
                if now.mass.is_some() && now.shape.is_some() {
                    let back = format!("by its density of {} again", Quantity::text(now.density * 1000.0, "g/m³"));
                    if ui.small_button("⟲").on_hover_text(back).clicked() {
                        now.mass = None;
                    }
                }
            });
            ui.end_row();
        }
        if now.shape.is_some() {
            ui.label("surface");
            ui.horizontal(|ui| {
                let friction = egui::DragValue::new(&mut now.material.friction).prefix("friction ").speed(0.01);
                ui.add(friction.range(0.0..=10.0).max_decimals(3).update_while_editing(false));
                let bounce = egui::DragValue::new(&mut now.material.restitution).prefix("bounce ").speed(0.01);
                ui.add(bounce.range(0.0..=1.0).max_decimals(3).update_while_editing(false));
            });
            ui.end_row();
        }
        if now.kind != RigidBody::Static {
            velocity(ui, "velocity", "m/s", &mut now.linear_velocity);
            velocity(ui, "spin", "rad/s", &mut now.angular_velocity);
        }
        if now.shape.is_some() {
            layers(
                ui,
                "is in",
                "layers that it is in: two bodies touch if each touches a layer of the other",
                &mut now.layers.memberships,
            );
            layers(ui, "touches", "layers that it touches", &mut now.layers.filters);
            ui.label("sensor");
            let about = "it only reports what is in it, and neither pushes nor is pushed";
            ui.checkbox(&mut now.sensor, "only reports").on_hover_text(about);
            ui.end_row();
        }
    });
    if now != *was {
        body.ask(now, *changing, &mut actions);
        *changing = ui.input(|input| input.pointer.any_down());
    }
}

/// What a shape is that has no sizes to be set.
fn about_shape(shape: &ShapeSpec) -> String {
    let of_file = |file: &str| format!(" of {}", stem(file));
    match shape {
        ShapeSpec::Mesh(mesh) => match mesh.pieces() {
            Some(pieces) => format!("{} pieces{}", pieces.children().len(), of_file(mesh.file())),
            None => format!("hull{}", of_file(mesh.file())),
        },
        ShapeSpec::Compound(compound) => match compound.children().len() {
            1 => "1 solid".into(),
            count => format!("{count} solids"),
        },
        ShapeSpec::Surface(surface) => {
            let sides = if surface.is_two_sided() { ", two-sided" } else { "" };
            let of = match surface.form() {
                SurfaceForm::File { file, .. } | SurfaceForm::Picture { file, .. } => of_file(file),
                SurfaceForm::Heights { .. } | SurfaceForm::Triangles { .. } => String::new(),
            };
            format!("{} triangles{of}{sides}", surface.mesh().triangles().len())
        }
        ShapeSpec::Hull(hull) => format!("hull of {} corners", hull.points().len()),
        ShapeSpec::HalfSpace => "half-space".into(),
        ShapeSpec::Sphere { .. }
        | ShapeSpec::Cuboid { .. }
        | ShapeSpec::Capsule { .. }
        | ShapeSpec::Cylinder { .. }
        | ShapeSpec::Cone { .. } => String::new(),
    }
}

/// `drawn`: the color that it is drawn with.
fn name_and_kind(ui: &mut egui::Ui, now: &mut BodySpec, drawn: Option<Color>, typed: &mut Typed) {
    ui.horizontal(|ui| {
        let mut text = typed.0.clone().unwrap_or_else(|| now.name.clone());
        let line = ui.add(egui::TextEdit::singleline(&mut text).desired_width(118.0)).on_hover_text("its name");
        typed.0 = line.has_focus().then(|| text.clone());
        if line.lost_focus() {
            now.name = text.trim().to_owned();
        }
        let name = |kind: RigidBody| format!("{kind:?}").to_lowercase();
        egui::ComboBox::from_id_salt("kind").width(86.0).selected_text(name(now.kind)).show_ui(ui, |ui| {
            for kind in [RigidBody::Dynamic, RigidBody::Kinematic, RigidBody::Static] {
                ui.selectable_value(&mut now.kind, kind, name(kind));
            }
        });
        if now.shape.is_some() {
            let shown = now.color.or_else(|| drawn.map(|color| color.to_srgba().to_f32_array_no_alpha()));
            let mut color = shown.unwrap_or([0.6; 3]).map(|part| (part * 255.0).round() as u8);
            if ui.color_edit_button_srgb(&mut color).on_hover_text("its color").changed() {
                now.color = Some(color.map(|part| f32::from(part) / 255.0));
            }
        }
    });
}

fn velocity(ui: &mut egui::Ui, label: &str, unit: &str, vector: &mut DVec3) {
    ui.label(label).on_hover_text(unit);
    ui.horizontal(|ui| {
        SPEED.show(ui, vector);
        if *vector != DVec3::ZERO && ui.small_button("0").on_hover_text("stop it").clicked() {
            *vector = DVec3::ZERO;
        }
    });
    ui.end_row();
}

fn layers(ui: &mut egui::Ui, label: &str, about: &str, bits: &mut u32) {
    ui.label(label).on_hover_text(about);
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 2.0;
        for layer in 0..LAYERS {
            let is_in = *bits >> layer & 1 == 1;
            if ui.add(toggle(ui, is_in, (layer + 1).to_string()).small()).on_hover_text(about).clicked() {
                *bits ^= 1 << layer;
            }
        }
    });
    ui.end_row();
}
