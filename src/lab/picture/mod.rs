//! Pictures as files: each is drawn twice, as SVG and as PNG, by one piece of code.

mod axis;
mod paint;
mod style;

use std::fmt;
use std::path::Path;

use plotters::prelude::*;

pub use axis::round_step;
pub(super) use axis::{decades, number, ticks};
pub(super) use paint::{PaintResult, Picture};
pub(super) use style::{FAINT, TEXT, draw_mark, mark, text};

use style::register_font;

/// Why there is no picture.
#[derive(Debug, thiserror::Error)]
#[error("{path}: cannot be drawn: {reason}")]
pub struct PictureError {
    path: String,
    reason: String,
}

/// Draws a picture to `path` with the extensions `.svg` and `.png`.
pub(super) fn write(picture: &impl Picture, path: &Path) -> Result<(), PictureError> {
    register_font();
    let svg = path.with_extension("svg");
    write_on(picture, SVGBackend::new(&svg, picture.size()), &svg)?;
    let png = path.with_extension("png");
    write_on(picture, BitMapBackend::new(&png, picture.size()), &png)
}

fn write_on<DB: DrawingBackend>(picture: &impl Picture, backend: DB, path: &Path) -> Result<(), PictureError> {
    let failed =
        |reason: &dyn fmt::Display| PictureError { path: path.display().to_string(), reason: reason.to_string() };
    let area = backend.into_drawing_area();
    area.fill(&WHITE).map_err(|error| failed(&error))?;
    picture.paint(&area).map_err(|error| failed(&error))?;
    area.present().map_err(|error| failed(&error))
}
