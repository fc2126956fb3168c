//! Where a scene of the user's is opened from, and where the scene and the settings are saved.

use bevy::prelude::*;
use bevy_egui::egui;

use super::super::files::file_path;
use super::super::{CurrentScene, SandboxAction};
use super::entry::{Entered, Left};
use crate::scene::find;

pub(super) fn plugin(app: &mut App) {
    app.init_resource::<FilesForm>().add_systems(PreUpdate, follow_scene);
}

/// What the section's widgets hold.
#[derive(Resource)]
pub(super) struct FilesForm {
    scene: PathField,
    settings: PathField,
    /// The scene whose name was offered last.
    offered: String,
    /// What is to be opened.
    opened: String,
    entered: Entered,
}

/// A path, and whether the user was told that something is there.
#[derive(Default)]
struct PathField {
    text: String,
    warned: bool,
}

impl Default for FilesForm {
    fn default() -> Self {
        let settings = PathField { text: "settings.ron".into(), warned: false };
        Self {
            scene: PathField::default(),
            settings,
            offered: String::new(),
            opened: String::new(),
            entered: Entered::default(),
        }
    }
}

/// Offers a built-in scene's name, or the file that the scene came from.
fn follow_scene(scene: Option<Res<CurrentScene>>, mut form: ResMut<FilesForm>) {
    let Some(scene) = scene.filter(|scene| scene.is_changed()) else { return };
    if find(&scene.scene).is_none() {
        form.opened.clone_from(&scene.scene);
    }
    if scene.scene != form.offered {
        let text = file_path(&scene.scene).display().to_string();
        form.scene = PathField { text, warned: false };
        form.offered.clone_from(&scene.scene);
    }
}

pub(super) fn show(
    InMut(ui): InMut<egui::Ui>,
    current: Option<Res<CurrentScene>>,
    mut form: ResMut<FilesForm>,
    mut actions: MessageWriter<SandboxAction>,
) {
    let FilesForm { scene, settings, opened, entered, .. } = &mut *form;
    egui::Grid::new("files").num_columns(2).spacing([8.0, 4.0]).show(ui, |ui| {
        ui.label("open").on_hover_text("path of a scene in RON, the README describes the format; or of a recording");
        ui.horizontal(|ui| {
            let is_loaded = current.is_some_and(|scene| scene.is_changed());
            if let Some(scene) = open(ui, opened, entered, is_loaded) {
                actions.write(SandboxAction::LoadScene { scene, parameters: Vec::new() });
            }
        });
        ui.end_row();
        ui.label("scene").on_hover_text("the scene as it stands now, in RON; the README describes the format");
        ui.horizontal(|ui| {
            scene.edit(ui, 92.0);
            if let Some(overwrite) = scene.save_button(ui) {
                actions.write(SandboxAction::SaveScene { path: file_path(&scene.text), overwrite });
            }
        });
        ui.end_row();
        ui.label("settings").on_hover_text("all settings of the solver; 'plumb run --settings FILE' reads them too");
        ui.horizontal(|ui| {
            settings.edit(ui, 142.0);
            if let Some(overwrite) = settings.save_button(ui) {
                actions.write(SandboxAction::SaveSettings { path: file_path(&settings.text), overwrite });
            }
            if ui.button("Load").clicked() {
                actions.write(SandboxAction::LoadSettings { path: file_path(&settings.text) });
            }
        });
        ui.end_row();
    });
}

/// A line for a path, and a button; the path that is to be opened. The line is left once a scene came of it.
fn open(ui: &mut egui::Ui, path: &mut String, entered: &mut Entered, is_loaded: bool) -> Option<String> {
    let id = egui::Id::new("scene file");
    if is_loaded {
        entered.accept(ui.ctx(), id);
    }
    let line = egui::TextEdit::singleline(path).hint_text("my_scene.ron").desired_width(ui.available_width() - 92.0);
    let is_entered = entered.show(ui, id, line) == Some(Left::ByEnter);
    let given = !path.trim().is_empty();
    let button = egui::Button::new("Open").min_size(egui::vec2(SAVE_WIDTH, 0.0));
    let is_clicked = ui.add_enabled(given, button).clicked();
    ((is_clicked || is_entered) && given).then(|| path.trim().to_owned())
}

impl PathField {
    /// The text field, leaving room at its right.
    fn edit(&mut self, ui: &mut egui::Ui, room: f32) {
        let field = egui::TextEdit::singleline(&mut self.text).desired_width(ui.available_width() - room);
        if ui.add(field).changed() {
            self.warned = false;
        }
    }

    /// Tells, when the user has decided to save, whether to overwrite.
    fn save_button(&mut self, ui: &mut egui::Ui) -> Option<bool> {
        let label = match self.asks() {
            true => egui::RichText::new("Overwrite?").color(ui.visuals().warn_fg_color),
            false => "Save".into(),
        };
        let button = egui::Button::new(label).min_size(egui::vec2(SAVE_WIDTH, 0.0));
        let clicked = ui.add_enabled(!self.text.trim().is_empty(), button).clicked();
        clicked.then(|| self.click()).flatten()
    }

    /// Whether the next click overwrites a file.
    fn asks(&self) -> bool {
        self.warned && file_path(&self.text).exists()
    }

    /// Where a file is there already, a first click only warns.
    fn click(&mut self) -> Option<bool> {
        let overwrite = self.asks();
        self.warned = !overwrite && file_path(&self.text).exists();
        (!self.warned).then_some(overwrite)
    }
}

/// Wide enough for the question, so that the button stays put.
const SAVE_WIDTH: f32 = 76.0;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_is_there_takes_two_clicks() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("scene.ron");
        let mut field = PathField { text: path.to_str().unwrap().into(), warned: false };
        assert_eq!(field.click(), Some(false), "nothing is there");
        std::fs::write(&path, "").unwrap();
        assert_eq!(field.click(), None);
        assert!(field.asks());
        assert_eq!(field.click(), Some(true));
        assert!(!field.asks(), "and the next time it asks again");
        assert_eq!(field.click(), None);
        // Gone meanwhile: there is nothing to overwrite any more.
        std::fs::remove_file(&path).unwrap();
        assert_eq!(field.click(), Some(false));
    }
}
