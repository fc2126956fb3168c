//! Carrying out what a user asks for.

use bevy::app::FixedMain;
use bevy::prelude::*;

use super::build::UndoStack;
use super::camera::{self, Framing};
use super::follow::{self, Followed};
use super::joint_readings::ReadJoints;
use super::motor_keys::check_keys;
use super::watch::Watch;
use super::{CurrentScene, Notice, Playback, SandboxAction, Selection, build, files, panel, screenshot};
use crate::physics::{Collider, Position, RigidBody, Velocity};
use crate::scene::{self, BodyColor, SceneEntity, SceneSpec, SpawnedScene};

pub(super) fn plugin(app: &mut App) {
    app.add_message::<SandboxAction>().add_systems(Update, carry_out_actions);
}

pub(super) fn carry_out_actions(
    world: &mut World,
    mut cursor: Local<bevy::ecs::message::MessageCursor<SandboxAction>>,
) {
    let messages = world.resource::<Messages<SandboxAction>>();
    let actions: Vec<_> = cursor.read(messages).cloned().collect();
    for action in actions {
        carry_out(world, action);
    }
}

fn carry_out(world: &mut World, action: SandboxAction) {
    match action {
        SandboxAction::LoadScene { scene, parameters } => load_scene(world, scene, parameters),
        SandboxAction::ReloadScene => reload_scene(world),
        SandboxAction::Reset => reset(world),
        SandboxAction::SaveScene { path, overwrite } => files::save_scene(world, &path, overwrite),
        SandboxAction::SaveSettings { path, overwrite } => files::save_settings(world, &path, overwrite),
        SandboxAction::LoadSettings { path } => files::load_settings(world, &path),
        SandboxAction::TogglePause => {
            let mut playback = world.resource_mut::<Playback>();
            playback.paused = !playback.paused;
        }
        SandboxAction::StepOnce => {
            world.resource_mut::<Playback>().paused = true;
            world.run_schedule(FixedMain);
        }
        SandboxAction::ToggleSlowMotion => {
            let mut playback = world.resource_mut::<Playback>();
            playback.slow = !playback.slow;
        }
        SandboxAction::ThrowBall => throw_ball(world),
        SandboxAction::DeletePicked => build::delete_picked(world),
        SandboxAction::SpawnBody => build::spawn_body(world),
        SandboxAction::ChooseMesh { file, scale } => build::choose_mesh(world, &file, scale),
        SandboxAction::JoinPicked => build::join_picked(world),
        SandboxAction::PinPicked => build::pin_picked(world),
        SandboxAction::CutPicked => build::cut_picked(world),
        SandboxAction::Cut(joint) => build::cut(world, joint),
        SandboxAction::ChangeJoint { joint, change, continues } => build::change_joint(world, joint, change, continues),
        SandboxAction::Undo => build::undo(world),
        SandboxAction::Escape => world.insert_resource(Selection::default()),
        SandboxAction::FrameScene => frame_scene(world),
        SandboxAction::Follow => follow::toggle(world),
        SandboxAction::Screenshot => screenshot::take(world),
        SandboxAction::MeasureChart => panel::measure_chart(world),
        SandboxAction::ToggleHelp => {} // the help's own
    }
}

fn load_scene(world: &mut World, scene: String, parameters: Vec<(String, f64)>) {
    let watch = Watch::on(&scene);
    match load(&scene, &parameters) {
        Ok(spec) => {
            let entities = replace_bodies(world, &spec);
            world.insert_resource(watch.with_meshes(&spec));
            world.insert_resource(CurrentScene { scene, parameters, spec, entities });
            *world.resource_mut::<Notice>() = Notice::None;
            frame_scene(world);
        }
        Err(problem) => *world.resource_mut::<Notice>() = Notice::Error(problem),
    }
}

/// A scene whose keys are keys.
fn load(scene: &str, parameters: &[(String, f64)]) -> Result<SceneSpec, String> {
    let spec = scene::load(scene, parameters).map_err(|error| error.to_string())?;
    check_keys(scene, &spec)?;
    Ok(spec)
}

fn reload_scene(world: &mut World) {
    let Some(mut current) = world.get_resource::<CurrentScene>().cloned() else { return };
    let mut watch = Watch::on(&current.scene).with_meshes(&current.spec);
    let notice = match load(&current.scene, &current.parameters) {
        Ok(spec) => {
            respawn(world, &mut current.entities, &spec);
            watch = watch.with_meshes(&spec);
            current.spec = spec;
            let notice = Notice::Info(format!("reloaded {}", current.scene));
            world.insert_resource(current);
            notice
        }
        Err(problem) => {
            watch.problem = Some(problem.clone());
            Notice::Error(problem)
        }
    };
    world.insert_resource(watch);
    world.insert_resource(notice);
}

/// The camera stays: whoever resets wants to see the same thing again.
fn reset(world: &mut World) {
    let Some(mut current) = world.get_resource::<CurrentScene>().cloned() else { return };
    respawn(world, &mut current.entities, &current.spec);
    world.insert_resource(current);
}

/// Spawns the same scene anew; what is plotted of it stays so.
fn respawn(world: &mut World, entities: &mut SpawnedScene, spec: &SceneSpec) {
    let now = replace_bodies(world, spec);
    world.resource_mut::<ReadJoints>().follow(entities, &now);
    world.resource_mut::<Followed>().follow(entities, &now);
    *entities = now;
}

/// Despawns what the last scene and the user spawned, and spawns the scene anew.
fn replace_bodies(world: &mut World, spec: &SceneSpec) -> SpawnedScene {
    let old: Vec<Entity> = world.query_filtered::<Entity, With<SceneEntity>>().iter(world).collect();
    for entity in old {
        world.despawn(entity);
    }
    world.insert_resource(Selection::default());
    world.resource_mut::<UndoStack>().clear();
    spec.spawn(world)
}

/// The view is the scene's again, and nobody's else.
fn frame_scene(world: &mut World) {
    world.insert_resource(Followed::default());
    if let Some(current) = world.get_resource::<CurrentScene>() {
        let framing = Framing::of(&current.spec);
        camera::look(world, framing);
    }
}

/// The ball is a good deal heavier than a limb and fast enough to cross the view in half a
/// second, whatever the scale of the scene.
fn throw_ball(world: &mut World) {
    let Some(aim) = world.run_system_cached(camera::aim).ok().flatten() else { return };
    let radius = (0.03 * aim.distance).clamp(0.1, 1.0);
    let name = build::unique_name(world, "thrown ball");
    world.spawn((
        Name::new(name),
        SceneEntity,
        BodyColor([0.95, 0.76, 0.2]),
        RigidBody::Dynamic,
        Collider::sphere(radius),
        Position(aim.origin + aim.direction * (4.0 * radius)),
        Velocity { linear: aim.direction * (2.0 * aim.distance).clamp(5.0, 40.0), ..default() },
    ));
}
