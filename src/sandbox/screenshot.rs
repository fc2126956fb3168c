//! Screenshots, numbered, in the working directory.

use std::path::PathBuf;

use bevy::prelude::*;
use bevy::render::view::screenshot::{Screenshot, ScreenshotCaptured};

use super::Notice;

pub(super) fn plugin(app: &mut App) {
    app.add_observer(save);
}

/// Asks for a picture of the window; it is saved a frame or two later.
pub(super) fn take(world: &mut World) {
    world.spawn(Screenshot::primary_window());
}

fn save(captured: On<ScreenshotCaptured>, mut notice: ResMut<Notice>) {
    let path = next_free_path("png");
    let saved = captured
        .image
        .clone()
        .try_into_dynamic()
        .map_err(|error| error.to_string())
        .and_then(|image| image.to_rgb8().save(&path).map_err(|error| error.to_string()));
    let shown = std::path::absolute(&path).unwrap_or(path);
    *notice = match saved {
        Ok(()) => Notice::Info(format!("saved {}", shown.display())),
        Err(error) => Notice::Error(format!("{}: {error}", shown.display())),
    };
}

/// In the working directory.
pub(super) fn next_free_path(extension: &str) -> PathBuf {
    (1..).map(|n| PathBuf::from(format!("plumb-{n}.{extension}"))).find(|path| !path.exists()).expect("a free number")
}
