//! The gallery: scenes as pictures, by subject or as they are searched for, and the user's own files.

use std::path::Path;

use bevy::prelude::*;
use bevy_egui::egui;

use super::pictures::{ASPECT, Pictures};
use crate::lab::recording::is_recording;
use crate::sandbox::recent::RecentFiles;
use crate::sandbox::{CurrentScene, SandboxAction};
use crate::scene::{SceneInfo, Subject, catalog, find};

/// A tile is at least that wide, points.
const LEAST_WIDTH: f32 = 92.0;
const GAP: f32 = 6.0;
/// Size of the letters of a title, and how many lines there are for it.
const LETTERS: f32 = 12.0;
const LINES: usize = 2;
/// How wide what is told of a scene may be: it lies over the picture.
const TOLD_WIDTH: f32 = 280.0;

/// Which scenes are on view.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Shelf {
    Of(Subject),
    All,
    /// The user's own files.
    Yours,
}

/// What the section's widgets hold.
#[derive(Resource)]
pub(super) struct GalleryForm {
    search: String,
    shelf: Shelf,
}

pub(super) fn plugin(app: &mut App) {
    app.insert_resource(GalleryForm { search: String::new(), shelf: Shelf::Of(Subject::Joints) })
        .add_systems(PreUpdate, follow_scene);
}

/// The scene on view is among those that are shown, however it was asked for.
fn follow_scene(scene: Option<Res<CurrentScene>>, mut form: ResMut<GalleryForm>) {
    if let Some(scene) = scene.filter(|scene| scene.is_changed())
        && let Shelf::Of(shown) = form.shelf
        && let Some(info) = find(&scene.scene)
        && info.subject != shown
    {
        form.shelf = Shelf::Of(info.subject);
    }
}

pub(super) fn show(
    InMut(ui): InMut<egui::Ui>,
    scene: Option<Res<CurrentScene>>,
    recent: Res<RecentFiles>,
    mut form: ResMut<GalleryForm>,
    mut pictures: Local<Pictures>,
    mut actions: MessageWriter<SandboxAction>,
) {
    let current = scene.as_ref().map_or("", |scene| &scene.scene);
    let is_entered = search_line(ui, &mut form.search);
    let words: Vec<String> = form.search.to_lowercase().split_whitespace().map(str::to_owned).collect();
    let is_searched = !words.is_empty();
    if !is_searched {
        shelves(ui, &mut form.shelf);
    }
    ui.add_space(2.0);
    let is_shown = |info: &&SceneInfo| match form.shelf {
        _ if is_searched => has_all(&searched(info), &words),
        Shelf::Of(subject) => info.subject == subject,
        Shelf::All => true,
        Shelf::Yours => false,
    };
    let mut scenes: Vec<&'static SceneInfo> = catalog().iter().filter(is_shown).collect();
    // What is called so comes before what has something to do with it.
    if is_searched {
        scenes.sort_by_cached_key(|info| !has_all(&names(info), &words));
    }
    let files: Vec<&String> = match form.shelf {
        _ if is_searched => recent.0.iter().filter(|file| has_all(&file.to_lowercase(), &words)).collect(),
        Shelf::Yours => recent.0.iter().collect(),
        _ => Vec::new(),
    };
    let mut chosen = None;
    tiles(ui, scenes.len() + files.len(), |ui, index, width| match scenes.get(index) {
        Some(info) => {
            let face = Face::Of(info.name);
            let tile = Tile { title: info.title, face, is_chosen: info.name == current };
            let response = tile.show(ui, width, &mut pictures);
            let told = response.on_hover_ui(|ui| {
                ui.set_max_width(TOLD_WIDTH);
                ui.strong(info.title);
                ui.monospace(info.name);
                ui.label(format!("{}\n\nWhat is known of its answer: {}", info.about, info.truth));
            });
            if told.clicked() {
                chosen = Some(info.name.to_owned());
            }
        }
        None => {
            let file = files[index - scenes.len()];
            let title = Path::new(file).file_stem().map_or_else(|| file.into(), |stem| stem.to_string_lossy());
            let face = if is_recording(file) { Face::Recording } else { Face::File };
            let tile = Tile { title: &title, face, is_chosen: file == current };
            if tile.show(ui, width, &mut pictures).on_hover_text(file).clicked() {
                chosen = Some(file.clone());
            }
        }
    });
    if scenes.is_empty() && files.is_empty() {
        ui.weak(match is_searched {
            true => "no scene has this in its names or in what it is",
            false => {
                "scenes and recordings that you open or save are kept here; one that you drop on the window is opened"
            }
        });
    }
    if is_entered && chosen.is_none() {
        chosen = scenes.first().map(|info| info.name.to_owned()).or_else(|| files.first().map(|file| (*file).clone()));
    }
    if let Some(scene) = chosen {
        actions.write(SandboxAction::LoadScene { scene, parameters: Vec::new() });
    }
}

/// Tells whether Enter was pressed.
fn search_line(ui: &mut egui::Ui, search: &mut String) -> bool {
    ui.horizontal(|ui| {
        let is_given = !search.is_empty();
        let room = if is_given { 28.0 } else { 0.0 };
        let line = egui::TextEdit::singleline(search).id(egui::Id::new("scene search"));
        let line = line.hint_text("🔍 find a scene").desired_width(ui.available_width() - room);
        let response = ui.add(line);
        let is_entered = response.lost_focus() && ui.input(|input| input.key_pressed(egui::Key::Enter));
        if is_given && ui.button("✖").on_hover_text("all scenes again").clicked() {
            search.clear();
        }
        is_entered && !search.trim().is_empty()
    })
    .inner
}

/// The subjects, of which one is chosen.
fn shelves(ui: &mut egui::Ui, shelf: &mut Shelf) {
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing = egui::vec2(2.0, 2.0);
        let subjects = Subject::ALL.map(|(subject, title)| (Shelf::Of(subject), title));
        for (own, title) in subjects.into_iter().chain([(Shelf::Yours, "Yours"), (Shelf::All, "All")]) {
            if ui.selectable_label(*shelf == own, title).clicked() {
                *shelf = own;
            }
        }
    });
}

/// What a scene is called, in small letters.
fn names(info: &SceneInfo) -> String {
    format!("{} {}", info.title, info.name).to_lowercase()
}

/// All that a scene is found by, in small letters.
fn searched(info: &SceneInfo) -> String {
    let subject = Subject::ALL.iter().find(|(subject, _)| *subject == info.subject).map_or("", |(_, title)| title);
    format!("{} {} {subject}", names(info), info.about).to_lowercase()
}

fn has_all(text: &str, words: &[String]) -> bool {
    words.iter().all(|word| text.contains(word))
}

/// As many beside each other as there is room for.
fn tiles(ui: &mut egui::Ui, count: usize, mut tile: impl FnMut(&mut egui::Ui, usize, f32)) {
    let room = ui.available_width();
    let columns = (((room + GAP) / (LEAST_WIDTH + GAP)) as usize).max(1);
    let width = (room - GAP * (columns - 1) as f32) / columns as f32;
    ui.spacing_mut().item_spacing = egui::vec2(GAP, GAP);
    for row in 0..count.div_ceil(columns) {
        ui.horizontal(|ui| {
            for index in row * columns..((row + 1) * columns).min(count) {
                tile(ui, index, width);
            }
        });
    }
}

/// What a tile shows above its title.
#[derive(Clone, Copy)]
enum Face {
    /// The picture of a built-in scene.
    Of(&'static str),
    File,
    Recording,
}

struct Tile<'a> {
    title: &'a str,
    face: Face,
    is_chosen: bool,
}

impl Tile<'_> {
    fn show(&self, ui: &mut egui::Ui, width: f32, pictures: &mut Pictures) -> egui::Response {
        let picture = egui::vec2(width, width * ASPECT);
        let line = ui.fonts_mut(|fonts| fonts.row_height(&egui::FontId::proportional(LETTERS)));
        let size = egui::vec2(width, picture.y + 2.0 + LINES as f32 * line);
        let (place, response) = ui.allocate_exact_size(size, egui::Sense::click());
        let told = || egui::WidgetInfo::selected(egui::WidgetType::Button, true, self.is_chosen, self.title);
        response.widget_info(told);
        if !ui.is_rect_visible(place) {
            return response;
        }
        let face = egui::Rect::from_min_size(place.min, picture);
        let visuals = ui.style().interact_selectable(&response, self.is_chosen);
        let letter = |text: &str| {
            ui.painter().rect_filled(face, 4.0, egui::Color32::from_gray(45));
            let font = egui::FontId::proportional(0.5 * picture.y);
            ui.painter().text(face.center(), egui::Align2::CENTER_CENTER, text, font, egui::Color32::from_gray(150));
        };
        match self.face {
            Face::Of(name) => match pictures.of(name, ui.ctx()) {
                Some(id) => {
                    let image = egui::Image::from_texture((id, picture)).corner_radius(4.0);
                    image.paint_at(ui, face);
                }
                None => letter("?"),
            },
            Face::File => letter("📄"),
            Face::Recording => letter("🎬"),
        }
        let (thickness, color) = match (self.is_chosen, response.hovered()) {
            (true, _) => (3.0, ui.visuals().selection.stroke.color),
            (false, true) => (1.5, egui::Color32::from_gray(200)),
            (false, false) => (1.0, egui::Color32::from_gray(70)),
        };
        ui.painter().rect_stroke(face, 4.0, egui::Stroke::new(thickness, color), egui::StrokeKind::Inside);
        let mut text = egui::text::LayoutJob::simple(
            self.title.to_owned(),
            egui::FontId::proportional(LETTERS),
            visuals.text_color(),
            width,
        );
        text.wrap.max_rows = LINES;
        text.halign = egui::Align::Center;
        let title = ui.painter().layout_job(text);
        ui.painter().galley(egui::pos2(place.center().x, face.bottom() + 2.0), title, visuals.text_color());
        response
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scenes_are_found_by_either_name_by_what_they_are_and_by_subject() {
        for (typed, found) in
            [("newton's", "cradle"), ("joint_grid", "joint_grid"), ("VOUSSOIRS", "arch"), ("rotation box", "top")]
        {
            let words: Vec<String> = typed.to_lowercase().split_whitespace().map(str::to_owned).collect();
            let names = catalog().iter().filter(|info| has_all(&searched(info), &words)).map(|info| info.name);
            assert_eq!(names.collect::<Vec<_>>(), [found], "{typed}");
        }
    }
}
