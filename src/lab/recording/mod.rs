//! Recordings: what happened to a scene, as a file that makes it happen again.
//!
//! A file holds the scene, the settings, every outside act with the step after which it was done, and a fingerprint of the
//! world after each step, of up to [`MOST_BODIES`] bodies one of each as well. What a step depends on follows from these, so
//! that nothing else is kept; who runs a recording again is told the first step that comes out otherwise, and the first body.
//! The file is text, one line an act and a step, after a first line with the version of the format.

mod deeds;
mod error;
mod file;
mod make;
mod numbers;
mod print;
mod replay;

pub use error::RecordingError;
pub use file::{EXTENSION, Recording, is_recording};
pub use numbers::Numbers;
pub use print::{MOST_BODIES, Print};
pub use replay::{Difference, Replay};
