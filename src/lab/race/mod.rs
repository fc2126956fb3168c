//! A race: a scene run on from one moment by several methods side by side, and how they part.
//!
//! All start from the same state: the scene as it stands after so many seconds by the first of them. What a solver carries
//! from step to step is handed on to none, so that they are alike. Distances are from the scene's answer where that gives
//! the whole motion, else from the first runner.

mod limits;
mod outcome;
mod picture;
mod run;
mod table;

pub use limits::Limits;
pub use outcome::{Course, Moment, Outcome, Race, Runner};
