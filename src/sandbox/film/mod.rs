//! Films: a scene or a recording drawn frame by frame off screen, without a window.
//!
//! Each frame shows the scene at its very time, however long it takes to draw: between two steps, bodies stand between
//! their poses, as in the window.

mod error;
mod reel;
mod shoot;
mod studio;

pub use error::FilmError;
pub use shoot::{Filmed, shoot};
