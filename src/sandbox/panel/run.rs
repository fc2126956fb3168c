//! Running what draws a part of the panel.

use bevy::prelude::*;
use bevy_egui::egui;

/// Runs a system that is handed egui's `Ui`.
pub(super) fn run<M, S>(ui: &mut egui::Ui, world: &mut World, contents: S) -> Result
where
    S: IntoSystem<InMut<'static, egui::Ui>, (), M> + 'static,
{
    Ok(world.run_system_cached_with(contents, ui)?)
}
