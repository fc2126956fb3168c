//! Ghosts: the scene run on by up to three other methods, or its reference answer, translucent over the first, and how far
//! they part.
//!
//! Each other method runs in a headless world of its own, made by the same plugin from the scene as it stands when the
//! ghosts are chosen, or as it starts. It is stepped after the first up to the same simulation time; only its poses are drawn. What
//! a solver carries from step to step is handed on to none, and hands and what they build reach the first world alone.

mod choice;
mod ghosts;
mod lane;
mod section;

pub use choice::{GhostChoice, Ghosts, MOST_GHOSTS};
pub use ghosts::{GhostReading, GhostReadings, follow, plugin};
pub use lane::{Apart, Reading};
pub use section::show;
