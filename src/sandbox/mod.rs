//! The window: picture, camera, drag, panel.
//!
//! Keys ([`controls::BINDINGS`]) and the buttons of the panel write the same [`SandboxAction`]s,
//! carried out in one place; the panel shows [`CurrentScene`], [`Playback`] and [`Notice`], and works
//! on the physics resources themselves.

mod actions;
pub mod controls;
mod gizmos;
mod help;
mod panel;
mod plots;
mod state;
mod window;

pub use actions::SandboxAction;
pub use state::{CurrentScene, Notice, Playback, Selection};
pub use window::{Launch, LaunchError, launch};

use bevy::prelude::*;
use bevy_egui::EguiPlugin;
use bevy_panorbit_camera::PanOrbitCameraPlugin;

use crate::physics::PhysicsPlugin;

/// Everything of the sandbox but the window, the renderer and the clock: add Bevy's
/// `DefaultPlugins` before it, then write a [`SandboxAction::LoadScene`].
pub struct SandboxPlugin;

impl Plugin for SandboxPlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins((PhysicsPlugin::default(), MeshPickingPlugin, EguiPlugin::default(), PanOrbitCameraPlugin))
            .add_plugins((state::plugin, actions::plugin, controls::plugin))
            .add_plugins((panel::plugin, plots::plugin, gizmos::plugin, help::plugin));
    }
}
