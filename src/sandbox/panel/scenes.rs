//! The scene on view, with its parameters.

use std::path::Path;

use bevy::prelude::*;
use bevy_egui::egui;

use super::super::state::SceneProblem;
use super::super::watch::Watch;
use super::super::{CurrentScene, SandboxAction};
use crate::scene::{Parameter, SceneInfo, find};

pub(super) fn plugin(app: &mut App) {
    app.init_resource::<SceneForm>().add_systems(PreUpdate, follow_scene);
}

/// One value per parameter of the scene on view, in order. Parameters are edited here first, so that a large scene is
/// built once, when the value is let go, and not at every movement of the mouse.
#[derive(Resource, Default)]
pub(super) struct SceneForm(Vec<f64>);

impl SceneForm {
    /// The parameters that differ from their defaults.
    fn changed(&self, info: &SceneInfo) -> Vec<(String, f64)> {
        info.parameters
            .iter()
            .zip(&self.0)
            .filter(|(parameter, value)| **value != parameter.default)
            .map(|(parameter, value)| (parameter.name.into(), *value))
            .collect()
    }
}

/// Size of the letters of the scene's name.
const TITLE: f32 = 16.0;

fn value_of(parameter: &Parameter, given: &[(String, f64)]) -> f64 {
    given.iter().find(|(name, _)| name == parameter.name).map_or(parameter.default, |(_, value)| *value)
}

fn follow_scene(scene: Option<Res<CurrentScene>>, mut form: ResMut<SceneForm>) {
    if let Some(scene) = scene.filter(|scene| scene.is_changed()) {
        form.0 = find(&scene.scene).map_or_else(Vec::new, |info| {
            info.parameters.iter().map(|parameter| value_of(parameter, &scene.parameters)).collect()
        });
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
    if let Some(info) = find(current) {
        ui.horizontal_wrapped(|ui| {
            ui.label(egui::RichText::new(info.title).size(TITLE).strong());
            ui.weak(egui::RichText::new(info.name).monospace()).on_hover_text("its name on the command line");
        });
        ui.weak(info.about).on_hover_text(format!("What is known of its answer: {}", info.truth));
        if parameters(ui, info, &mut form.0) {
            actions.write(SandboxAction::LoadScene { scene: info.name.into(), parameters: form.changed(info) });
        }
    } else if let Some(name) = Path::new(current).file_name() {
        let title = egui::RichText::new(name.to_string_lossy()).size(TITLE).strong();
        ui.add(egui::Label::new(title).truncate()).on_hover_text(current);
    }
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
