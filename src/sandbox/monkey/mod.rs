//! A monkey at the sandbox: anything that hands can do, at random, without a display, and what must hold all the while.
//!
//! It plays in bouts of a minute of steps, each from the start of the scene. What breaks is kept as a recording of the bout up to
//! there; the seed makes it happen again.

mod checks;
mod deeds;
mod play;

pub use play::{Failure, Played, play};
