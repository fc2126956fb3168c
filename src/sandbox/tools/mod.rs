//! Tools: what a press in the picture does but for picking and dragging, and a preview of it.

mod bar;
mod plugin;
mod press;
mod preview;

pub(super) use plugin::plugin;
pub(super) use press::{ask_for_second, put_down};
