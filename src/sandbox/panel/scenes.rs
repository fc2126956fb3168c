//! The built-in scenes with their parameters, and scenes from files.

use bevy::prelude::*;
use bevy_egui::egui;

use super::super::state::SceneProblem;
use super::super::watch::Watch;
use super::super::{CurrentScene, SandboxAction};
use super::entry::{Entered, Left};
use crate::scene::{Parameter, SceneInfo, catalog, find};

pub(super) fn plugin(app: &mut App) {
    app.init_resource::<SceneForm>().add_systems(PreUpdate, follow_scene);
}

/// What the section's widgets hold. Parameters are edited here first, so that a large scene is
/// built once, when the value is let go, and not at every movement of the mouse.
#[derive(Resource, Default)]
pub(super) struct SceneForm {
    /// One value per parameter of the scene on view, in order.
    values: Vec<f64>,
    /// Path of a file.
    path: String,
    entered: Entered,
}

impl SceneForm {
    fn of(scene: &CurrentScene) -> Self {
        let values = find(&scene.scene).map_or_else(Vec::new, |info| {
            info.parameters.iter().map(|parameter| value_of(parameter, &scene.parameters)).collect()
        });
        let path = if find(&scene.scene).is_none() { scene.scene.clone() } else { String::new() };
        Self { values, path, entered: Entered::default() }
    }

    /// The parameters that differ from their defaults.
    fn changed(&self, info: &SceneInfo) -> Vec<(String, f64)> {
        info.parameters
            .iter()
            .zip(&self.values)
            .filter(|(parameter, value)| **value != parameter.default)
            .map(|(parameter, value)| (parameter.name.into(), *value))
            .collect()
    }
}

fn value_of(parameter: &Parameter, given: &[(String, f64)]) -> f64 {
    given.iter().find(|(name, _)| name == parameter.name).map_or(parameter.default, |(_, value)| *value)
}

fn follow_scene(scene: Option<Res<CurrentScene>>, mut form: ResMut<SceneForm>) {
    if let Some(scene) = scene.filter(|scene| scene.is_changed()) {
        let SceneForm { path, entered, .. } = std::mem::take(&mut *form);
        *form = SceneForm { entered, ..SceneForm::of(&scene) };
        if form.path.is_empty() {
            form.path = path;
        }
    }
}

pub(super) fn show(
    InMut(ui): InMut<egui::Ui>,
    scene: Option<Res<CurrentScene>>,
    problem: Res<SceneProblem>,
    watch: Res<Watch>,
    mut form: ResMut<SceneForm>,
    mut actions: MessageWriter<SandboxAction>,
) {
    let current = scene.as_ref().map_or("", |scene| &scene.scene);
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing = egui::vec2(2.0, 2.0);
        for info in catalog() {
            let about = format!("{}\n\nWhat is known of its answer: {}", info.about, info.truth);
            if ui.selectable_label(info.name == current, info.name).on_hover_text(about).clicked() {
                actions.write(SandboxAction::LoadScene { scene: info.name.into(), parameters: Vec::new() });
            }
        }
    });
    if let Some(info) = find(current) {
        ui.add_space(2.0);
        ui.weak(info.about);
        if parameters(ui, info, &mut form.values) {
            actions.write(SandboxAction::LoadScene { scene: info.name.into(), parameters: form.changed(info) });
        }
    }
    ui.horizontal(|ui| {
        ui.label("file").on_hover_text("path of a scene in RON; the README describes the format");
        let width = ui.available_width() - 56.0;
        let SceneForm { path, entered, .. } = &mut *form;
        let id = egui::Id::new("scene file");
        if scene.as_ref().is_some_and(|scene| scene.is_changed()) {
            entered.accept(ui.ctx(), id);
        }
        let field = egui::TextEdit::singleline(path).hint_text("my_scene.ron").desired_width(width);
        let entered = entered.show(ui, id, field) == Some(Left::ByEnter);
        let given = !form.path.trim().is_empty();
        if (ui.add_enabled(given, egui::Button::new("Open")).clicked() || entered) && given {
            actions.write(SandboxAction::LoadScene { scene: form.path.trim().into(), parameters: Vec::new() });
        }
    });
    // The running file's own problem stays until the file is mended.
    for error in watch.problem.iter().chain(&problem.0) {
        ui.colored_label(ui.visuals().error_fg_color, error);
    }
}

/// One row per parameter. Tells whether a value was let go that differs from before.
fn parameters(ui: &mut egui::Ui, info: &SceneInfo, values: &mut [f64]) -> bool {
    let mut settled = false;
    for (parameter, value) in info.parameters.iter().zip(values) {
        ui.horizontal(|ui| {
            let range = format!("{} to {}", parameter.min, parameter.max);
            let label = ui.label(parameter.name).on_hover_text(format!("{}\n{range}", parameter.about));
            let response = ui.add(drag_value(parameter, value)).labelled_by(label.id);
            // Told in full where one points: a long one is not to widen the panel.
            ui.add(egui::Label::new(egui::RichText::new(parameter.about).weak()).truncate());
            // A drag that has ended, or a number typed and left.
            settled |= response.drag_stopped() || (response.lost_focus() && !response.dragged());
        });
    }
    settled
}

fn drag_value<'a>(parameter: &Parameter, value: &'a mut f64) -> egui::DragValue<'a> {
    let range = parameter.min..=parameter.max;
    let drag = egui::DragValue::new(value).range(range).update_while_editing(false);
    if parameter.integer {
        return drag.fixed_decimals(0).speed(0.1).custom_parser(|text| text.trim().parse().ok().map(f64::round));
    }
    let span = if (parameter.max - parameter.min).is_finite() { parameter.max - parameter.min } else { f64::INFINITY };
    drag.speed((parameter.default.abs() * 0.01).max(1e-3).min(span * 0.01)).max_decimals(4)
}
