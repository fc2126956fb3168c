//! The window: picture, camera, drag, building, panel.
//!
//! Keys ([`controls::BINDINGS`]) and the buttons of the panel write the same [`SandboxAction`]s,
//! carried out in one place; the panel shows [`CurrentScene`], [`Playback`] and [`Notice`], and works
//! on the physics resources themselves.
//!
//! A frame: `PreUpdate` picks and reads keys; before the fixed loop the camera's [`RenderOrigin`]
//! and the drag's target are brought up to date; the fixed loop steps; `Update` carries out
//! actions and gives new bodies their meshes; `PostUpdate` runs camera and panel.
//!
//! [`RenderOrigin`]: crate::physics::RenderOrigin

mod actions;
mod build;
mod camera;
pub mod controls;
mod drag;
mod files;
mod ghost;
mod gizmos;
mod ground;
mod help;
mod highlight;
mod light;
mod meshes;
mod panel;
mod playback;
mod plots;
mod quality;
mod reload;
mod screenshot;
mod sky;
mod state;
mod window;

pub use actions::SandboxAction;
pub use build::{Blueprint, Weight};
pub use ghost::{GhostChoice, GhostDistance};
pub use panel::ChartSource;
pub use state::{CurrentScene, Notice, Picked, Playback, Selection};
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
            .add_plugins((state::plugin, playback::plugin, actions::plugin, controls::plugin, screenshot::plugin))
            .add_plugins((quality::plugin, camera::plugin, light::plugin, sky::plugin, ground::plugin, meshes::plugin))
            .add_plugins((drag::plugin, highlight::plugin, build::plugin, reload::plugin))
            .add_plugins((panel::plugin, plots::plugin, ghost::plugin, gizmos::plugin, help::plugin));
    }
}
