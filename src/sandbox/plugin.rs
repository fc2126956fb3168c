//! The plugin that adds all parts of the sandbox.

use bevy::app::RunFixedMainLoop;
use bevy::ecs::schedule::{ScheduleLabel, SingleThreadedExecutor};
use bevy::prelude::*;
use bevy_egui::{EguiPlugin, EguiPrimaryContextPass};
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
        on_one_thread(app);
    }
}

/// Runs the systems of a frame one after the other. There are hundreds, and but for those that go over all bodies, which
/// take threads for that by themselves, each does next to nothing: to wake a thread for it costs more (`cargo bench --bench
/// picture`).
fn on_one_thread(app: &mut App) {
    let run = [
        First.intern(),
        PreUpdate.intern(),
        RunFixedMainLoop.intern(),
        FixedFirst.intern(),
        FixedPreUpdate.intern(),
        FixedUpdate.intern(),
        FixedPostUpdate.intern(),
        FixedLast.intern(),
        Update.intern(),
        SpawnScene.intern(),
        PostUpdate.intern(),
        Last.intern(),
        EguiPrimaryContextPass.intern(),
    ];
    for label in run {
        app.edit_schedule(label, |schedule| {
            schedule.set_executor(SingleThreadedExecutor::new());
        });
    }
}
