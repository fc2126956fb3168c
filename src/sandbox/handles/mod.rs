//! Handles on what is picked, to move, turn and scale it by hand: arrows, squares, rings and boxes in front of the scene.

mod change;
mod draw;
mod handle;
mod maths;
mod plugin;
mod pull;

pub(super) use plugin::plugin;
pub(super) use pull::{let_go, press};
