//! How a command ends, and what it prints.

use std::io::{self, Write};
use std::path::Path;
use std::process::ExitCode;

use crate::lab::chart::{ChartError, PeersError};
use crate::lab::recording::RecordingError;
use crate::lab::vary::VaryError;
use crate::lab::{PictureError, PlanError, SettingsFileError};
use crate::physics::SettingsError;
use crate::scene::SceneError;

/// Bad usage or input, in one line.
#[derive(Debug, thiserror::Error)]
pub enum CommandError {
    /// A command line that makes no sense.
    #[error("{0}")]
    Usage(String),
    /// A scene that cannot be had.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// Settings that cannot be had.
    #[error(transparent)]
    SettingsFile(#[from] SettingsFileError),
    /// Settings that are out of range.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// A run that makes no sense.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// Charts that cannot be made.
    #[error(transparent)]
    Chart(#[from] ChartError),
    /// Recordings that cannot be had.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// What cannot be varied.
    #[error(transparent)]
    Vary(#[from] VaryError),
    /// Rows of other engines that cannot be had.
    #[error(transparent)]
    Peers(#[from] PeersError),
    /// A picture that cannot be drawn.
    #[error(transparent)]
    Picture(#[from] PictureError),
    /// An output that cannot be written.
    #[error("{place}: cannot be written: {reason}")]
    Output {
        /// The file.
        place: String,
        /// What the system said.
        reason: io::Error,
    },
}

impl CommandError {
    /// For an output that cannot be written.
    pub fn unwritable(place: &Path) -> impl FnOnce(io::Error) -> Self {
        let place = place.display().to_string();
        move |reason| Self::Output { place, reason }
    }
}

/// How a task ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Exit status 0.
    Done,
    /// Exit status 1: a body was quarantined, no settings hold the error asked for, or a recording comes out otherwise.
    CheckFailed,
}

impl From<Outcome> for ExitCode {
    fn from(outcome: Outcome) -> Self {
        match outcome {
            Outcome::Done => Self::SUCCESS,
            Outcome::CheckFailed => Self::FAILURE,
        }
    }
}

/// Prints to standard output. A reader that has seen enough (`plumb scenes | head`) is no error.
///
/// # Errors
/// Standard output cannot be written.
pub fn print(text: &str) -> Result<(), CommandError> {
    let mut output = io::stdout().lock();
    match output.write_all(text.as_bytes()).and_then(|()| output.flush()) {
        Err(reason) if reason.kind() != io::ErrorKind::BrokenPipe => {
            Err(CommandError::Output { place: "standard output".into(), reason })
        }
        _ => Ok(()),
    }
}
