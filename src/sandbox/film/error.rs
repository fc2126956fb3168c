//! Why there is no film, in one line.

use crate::lab::command::CommandError;
use crate::sandbox::LaunchError;

/// Why there is no film.
#[derive(Debug, thiserror::Error)]
pub enum FilmError {
    /// Bad input, or an output that cannot be written.
    #[error(transparent)]
    Command(#[from] CommandError),
    /// There is nothing to draw with.
    #[error(transparent)]
    Launch(#[from] LaunchError),
    /// It began, but no picture came of it.
    #[error("the graphics driver makes no picture of {0} x {1} pixels")]
    NoPicture(u32, u32),
}
