//! The plugin that adds all parts of the sandbox.

use bevy::prelude::*;
use bevy_egui::EguiPlugin;
use bevy_panorbit_camera::PanOrbitCameraPlugin;

use super::{
    box_select, build, camera, carry_out, clipboard, controls, drag, dropping, follow, ghost, gizmos, ground, handles,
    help, highlight, joint_click, joint_readings, light, meshes, motor_keys, panel, playback, plots, probe, quality,
    recent, reload, scale, screenshot, sky, snap, state, timeline, tools, why, without_ground,
};
use crate::physics::PhysicsPlugin;

/// Everything of the sandbox but the window, the renderer and the clock: add Bevy's
/// `DefaultPlugins` before it, then write a [`SandboxAction::LoadScene`](super::SandboxAction::LoadScene).
pub struct SandboxPlugin;

impl Plugin for SandboxPlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins((PhysicsPlugin::default(), MeshPickingPlugin, EguiPlugin::default(), PanOrbitCameraPlugin))
            .add_plugins((state::plugin, playback::plugin, carry_out::plugin, controls::plugin, screenshot::plugin))
            .add_plugins((
                quality::plugin,
                camera::plugin,
                follow::plugin,
                light::plugin,
                sky::plugin,
                ground::plugin,
                meshes::plugin,
            ))
            .add_plugins((
                drag::plugin,
                tools::plugin,
                highlight::plugin,
                build::plugin,
                reload::plugin,
                motor_keys::plugin,
            ))
            .add_plugins((dropping::plugin, recent::plugin, scale::plugin))
            .add_plugins((box_select::plugin, clipboard::plugin, handles::plugin, joint_click::plugin, snap::plugin))
            .add_plugins((timeline::plugin, without_ground::plugin))
            .add_plugins((
                panel::plugin,
                joint_readings::plugin,
                plots::plugin,
                probe::plugin,
                ghost::plugin,
                why::plugin,
                gizmos::plugin,
                help::plugin,
            ));
    }
}
