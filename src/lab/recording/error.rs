//! What may be wrong with a recording, in one line.

use std::io;
use std::path::PathBuf;

use crate::physics::GoError;
use crate::scene::SceneError;

/// Of the format. A change of what an older build cannot read makes it another.
pub(super) const VERSION: &str = "1";
/// What the first line of a file says before that.
pub(super) const FIRST_WORDS: &str = "plumb recording ";

/// Why there is no recording, or why it cannot be run again.
#[derive(Debug, thiserror::Error)]
pub enum RecordingError {
    /// No such file, no right to read it, or not text.
    #[error("{}: cannot be read: {reason}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the system said.
        reason: io::Error,
    },
    /// Another kind of file.
    #[error("{}: is no recording: one begins with the line '{}{}'", path.display(), FIRST_WORDS, VERSION)]
    NoRecording {
        /// The file.
        path: PathBuf,
    },
    /// One that a later build wrote, or an earlier one.
    #[error("{}: is a recording of format {version}, this build reads format {}", path.display(), VERSION)]
    OtherVersion {
        /// The file.
        path: PathBuf,
        /// Its format.
        version: String,
    },
    /// Its end is missing.
    #[error("{}: ends in the middle, after {steps} whole steps: what came then is lost; record it again", path.display())]
    Cut {
        /// The file.
        path: PathBuf,
        /// Steps that it has.
        steps: usize,
    },
    /// A line that makes no sense.
    #[error("{}:{line}: {problem}", path.display())]
    Malformed {
        /// The file.
        path: PathBuf,
        /// From 1.
        line: usize,
        /// What is wrong with it.
        problem: String,
    },
    /// The scene in it.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// What happened is not known from the scene's start on.
    #[error("what happened in the first {seconds:.1} s is not kept any more: reset the scene to record from its start")]
    TooLate {
        /// Where what is kept begins, s.
        seconds: f64,
    },
    /// What happened cannot be told.
    #[error(transparent)]
    History(#[from] GoError),
}
