//! Files that are dragged onto the window: what each becomes, and what is said before it is let go.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use bevy::prelude::*;
use bevy::window::FileDragAndDrop;
use bevy_egui::{EguiContexts, EguiPrimaryContextPass, egui};

use super::SandboxAction;
use crate::lab::recording::is_recording;

/// What a file is to the sandbox.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum FileKind {
    Scene,
    Recording,
    Mesh,
}

impl FileKind {
    /// By the end of its name, or why it is nothing.
    pub fn of(path: &Path) -> Result<Self, String> {
        let ends_with = |wanted: &str| path.extension().is_some_and(|end| end.eq_ignore_ascii_case(wanted));
        if ends_with("ron") {
            Ok(Self::Scene)
        } else if path.to_str().is_some_and(is_recording) {
            Ok(Self::Recording)
        } else if ends_with("obj") {
            Ok(Self::Mesh)
        } else {
            Err(format!("{}: no scene (.ron), recording (.plumb) or mesh (.obj)", name_of(path)))
        }
    }
}

/// What is held over the window.
#[derive(Resource, Default)]
struct Held(Vec<PathBuf>);

pub(super) fn plugin(app: &mut App) {
    app.init_resource::<Held>().add_systems(PreUpdate, follow).add_systems(EguiPrimaryContextPass, show);
}

/// Of many files that are dropped at once, the first that can be opened is.
fn follow(
    mut messages: MessageReader<FileDragAndDrop>,
    mut held: ResMut<Held>,
    mut actions: MessageWriter<SandboxAction>,
) {
    let mut dropped: Vec<PathBuf> = Vec::new();
    for message in messages.read() {
        match message {
            FileDragAndDrop::HoveredFile { path_buf, .. } if !held.0.contains(path_buf) => {
                held.0.push(path_buf.clone())
            }
            FileDragAndDrop::HoveredFile { .. } => {}
            FileDragAndDrop::HoveredFileCanceled { .. } => held.0.clear(),
            FileDragAndDrop::DroppedFile { path_buf, .. } => {
                held.0.clear();
                dropped.push(path_buf.clone());
            }
        }
    }
    if let Some(path) = best(&dropped) {
        actions.write(SandboxAction::OpenFile { path: path.clone() });
    }
}

/// The one of some files that is opened: the first that can be, else the first.
fn best(paths: &[PathBuf]) -> Option<&PathBuf> {
    paths.iter().find(|path| FileKind::of(path).is_ok()).or(paths.first())
}

/// What letting go would do, over the picture.
fn show(mut contexts: EguiContexts, held: Res<Held>) -> Result {
    let Some(path) = best(&held.0) else { return Ok(()) };
    let context = contexts.ctx_mut()?;
    let name = name_of(path);
    let (said, color) = match FileKind::of(path) {
        Ok(FileKind::Scene) => (format!("drop to open the scene {name}"), egui::Color32::WHITE),
        Ok(FileKind::Recording) => (format!("drop to play the recording {name}"), egui::Color32::WHITE),
        Ok(FileKind::Mesh) => (format!("drop to build with the mesh {name}"), egui::Color32::WHITE),
        Err(reason) => (reason, context.global_style().visuals.error_fg_color),
    };
    let layer = egui::LayerId::new(egui::Order::Foreground, egui::Id::new("dropping"));
    let screen = context.content_rect();
    let painter = context.layer_painter(layer);
    painter.rect_filled(screen, 0.0, egui::Color32::from_black_alpha(150));
    painter.rect_stroke(screen.shrink(10.0), 10.0, egui::Stroke::new(2.0, color), egui::StrokeKind::Inside);
    let text = painter.layout(said, egui::FontId::proportional(20.0), color, 0.8 * screen.width());
    let place = egui::Rect::from_center_size(screen.center(), text.size());
    painter.rect_filled(place.expand(14.0), 8.0, context.global_style().visuals.window_fill);
    painter.galley(place.min, text, color);
    Ok(())
}

fn name_of(path: &Path) -> String {
    path.file_name().map_or_else(|| path.to_string_lossy(), OsStr::to_string_lossy).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_end_of_its_name_tells_what_a_file_is() {
        for (name, kind) in [
            ("/a/tower.ron", FileKind::Scene),
            ("C:\\TOWER.RON", FileKind::Scene),
            ("run.plumb", FileKind::Recording),
            ("rock.Obj", FileKind::Mesh),
        ] {
            assert_eq!(FileKind::of(Path::new(name)), Ok(kind), "{name}");
        }
        for name in ["/a/photo.png", "ron", "/"] {
            assert!(FileKind::of(Path::new(name)).unwrap_err().contains(".obj"), "{name}");
        }
    }
}
