//! Screenshots, numbered, in the working directory.

use std::io;
use std::path::{Path, PathBuf};

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
    let saved = save_picture(captured.image.clone(), &path);
    let shown = std::path::absolute(&path).unwrap_or(path);
    *notice = match saved {
        Ok(()) => Notice::Info(format!("saved {}", shown.display())),
        Err(error) => Notice::Error(format!("{}: {error}", shown.display())),
    };
}

/// Writes a picture without its alpha, as what its name ends with.
pub(super) fn save_picture(image: Image, path: &Path) -> io::Result<()> {
    let image = image.try_into_dynamic().map_err(io::Error::other)?;
    image.to_rgb8().save(path).map_err(io::Error::other)
}

/// In the working directory.
pub(super) fn next_free_path(extension: &str) -> PathBuf {
    (1..).map(|n| PathBuf::from(format!("plumb-{n}.{extension}"))).find(|path| !path.exists()).expect("a free number")
}
