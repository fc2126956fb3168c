//! Why there is no film, in one line.

use std::io;
use std::path::{Path, PathBuf};

use crate::lab::PlanError;
use crate::lab::recording::RecordingError;
use crate::sandbox::LaunchError;

/// Why there is no film.
#[derive(Debug, thiserror::Error)]
pub enum FilmError {
    /// The scene, its parameters, the settings or the length make no sense.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// The recording cannot be had, or not be run again.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// There is nothing to draw with.
    #[error(transparent)]
    Launch(#[from] LaunchError),
    /// It began, but no picture came of it.
    #[error("the graphics driver makes no picture of {0} x {1} pixels")]
    NoPicture(u32, u32),
    /// A file that cannot be written.
    #[error("{}: cannot be written: {reason}", path.display())]
    Unwritable {
        /// The file or the folder.
        path: PathBuf,
        /// What the system said.
        reason: io::Error,
    },
}

impl FilmError {
    /// For a file that cannot be written.
    pub(super) fn unwritable(path: &Path) -> impl FnOnce(io::Error) -> Self {
        let path = path.to_owned();
        move |reason| Self::Unwritable { path, reason }
    }
}
