//! The panel: scenes, settings, read-outs.

pub(super) fn plugin(_app: &mut bevy::prelude::App) {}
