//! Carrying out what a user asks for.

use std::path::Path;

use bevy::app::FixedMain;
use bevy::prelude::*;

use super::action::CarryOut;
use super::camera::{self, Framing};
use super::dropping::FileKind;
use super::follow::{self, Followed};
use super::joint_readings::ReadJoints;
use super::motor_keys::check_keys;
use super::recent::RecentFiles;
use super::state::{SceneProblem, ShowsPlots, report};
use super::timeline::{self, Timeline};
use super::watch::Watch;
use super::{
    CurrentScene, MeshForm, Notice, Playback, SandboxAction, Selection, Tool, box_select, build, files, panel, probe,
    recordings, scale, screenshot, tools,
};
use crate::lab::recording::is_recording;
use crate::physics::{ContactForces, write_now};
use crate::scene::{self, Probes, SceneEntity, SceneSpec, SpawnedScene, ViewSpec};

pub(super) fn plugin(app: &mut App) {
    app.add_message::<SandboxAction>().add_systems(Update, carry_out_actions.in_set(CarryOut));
}

pub(super) fn carry_out_actions(
    world: &mut World,
    mut cursor: Local<bevy::ecs::message::MessageCursor<SandboxAction>>,
) {
    let messages = world.resource::<Messages<SandboxAction>>();
    let actions: Vec<_> = cursor.read(messages).cloned().collect();
    let is_any = !actions.is_empty();
    for action in actions {
        if !matches!(action, SandboxAction::LookAt { .. }) {
            timeline::arrive(world);
        }
        carry_out(world, action);
    }
    // Bodies may be new or elsewhere now, and transforms were written before.
    if is_any && let Err(reason) = write_now(world) {
        *world.resource_mut::<Notice>() = Notice::Error(reason.to_string());
    }
}

fn carry_out(world: &mut World, action: SandboxAction) {
    match action {
        SandboxAction::LoadScene { scene, parameters } => load_scene(world, scene, parameters),
        SandboxAction::OpenFile { path } => open_file(world, &path),
        SandboxAction::ReloadScene => reload_scene(world),
        SandboxAction::Reset => reset(world),
        SandboxAction::SaveScene { path, overwrite } => files::save_scene(world, &path, overwrite),
        SandboxAction::SaveSettings { path, overwrite } => files::save_settings(world, &path, overwrite),
        SandboxAction::LoadSettings { path } => files::load_settings(world, &path),
        SandboxAction::TogglePause => {
            world.resource_mut::<Timeline>().backwards = false;
            let mut playback = world.resource_mut::<Playback>();
            playback.paused = !playback.paused;
        }
        SandboxAction::StepOnce => {
            timeline::stop(world);
            world.run_schedule(FixedMain);
        }
        SandboxAction::StepBack => timeline::step_back(world),
        SandboxAction::GoTo { step } => timeline::go(world, step),
        SandboxAction::LookAt { step } => timeline::look_at(world, step),
        SandboxAction::GoToStart => timeline::go_to_end(world, 0),
        SandboxAction::GoToNow => timeline::go_to_end(world, 1),
        SandboxAction::TogglePlayBackwards => timeline::toggle_backwards(world),
        SandboxAction::ToggleMark => timeline::toggle_mark(world),
        SandboxAction::ToggleLoop => timeline::toggle_loop(world),
        SandboxAction::ToggleSlowMotion => {
            let mut playback = world.resource_mut::<Playback>();
            playback.slow = !playback.slow;
        }
        SandboxAction::ThrowBall => build::throw_ball(world),
        SandboxAction::DeletePicked => build::delete_picked(world),
        SandboxAction::SelectBox { from, to, adds } => box_select::select_box(world, from, to, adds),
        SandboxAction::SelectAll => box_select::select_all(world),
        SandboxAction::PickJoint(joint) => world.insert_resource(Selection::of_joint(joint)),
        SandboxAction::Duplicate => build::duplicate(world),
        SandboxAction::Copy => build::copy(world),
        SandboxAction::CutOut => build::cut_out(world),
        SandboxAction::Paste => build::paste(world),
        SandboxAction::PlaceBodies { placements, continues } => build::place_bodies(world, &placements, continues),
        SandboxAction::SpawnBody => build::spawn_body(world),
        SandboxAction::ChooseMesh { file, scale, form } => _ = build::choose_mesh(world, &file, scale, form),
        SandboxAction::ChooseHills(hills) => build::choose_hills(world, hills),
        SandboxAction::MakeOneBody => build::make_one_body(world),
        SandboxAction::TakeApart => build::take_apart(world),
        SandboxAction::JoinPicked => build::join_picked(world),
        SandboxAction::PinPicked => build::pin_picked(world),
        SandboxAction::CutPicked => build::cut_picked(world),
        SandboxAction::Cut(joint) => build::cut(world, joint),
        SandboxAction::ChangeJoint { joint, change, continues } => build::change_joint(world, joint, change, continues),
        SandboxAction::ChangeBody { body, asked, continues } => build::change_body(world, body, *asked, continues),
        SandboxAction::Undo => {
            if let Some(scene) = build::undo(world) {
                bring_back(world, scene);
            }
        }
        SandboxAction::Escape => {
            world.insert_resource(Selection::default());
            probe::escape(world);
            box_select::give_up(world);
            tools::put_down(world);
        }
        SandboxAction::ChooseTool(tool) => {
            tools::put_down(world);
            world.insert_resource(tool);
            // What was said of the tool before is out of date.
            world.insert_resource(Notice::None);
            if tool == Tool::Join {
                tools::ask_for_second(world);
            }
        }
        SandboxAction::Redo => {
            if let Some(scene) = build::redo(world) {
                bring_back(world, scene);
            }
        }
        SandboxAction::FrameScene => frame_scene(world),
        SandboxAction::Follow => follow::toggle(world),
        SandboxAction::Record => recordings::record(world),
        SandboxAction::SaveProbes => probe::save(world),
        SandboxAction::Screenshot => screenshot::take(world),
        SandboxAction::MeasureChart => panel::measure_chart(world),
        SandboxAction::TogglePlots => {
            let mut shows = world.resource_mut::<ShowsPlots>();
            shows.0 = !shows.0;
        }
        SandboxAction::ScaleInterface(change) => scale::change(world, change),
        SandboxAction::ToggleHelp => {} // the help's own
    }
}

fn load_scene(world: &mut World, scene: String, parameters: Vec<(String, f64)>) {
    if is_recording(&scene) {
        return play_recording(world, scene);
    }
    let watch = Watch::on(&scene);
    match load(&scene, &parameters) {
        Ok(spec) => {
            let kept = put_on_view(
                world,
                CurrentScene { scene, parameters, spec, entities: default(), came_back_as: None },
                watch,
            );
            *world.resource_mut::<Notice>() = kept.map_or(Notice::None, |name| Notice::Info(kept_text(&name)));
        }
        Err(problem) => {
            *world.resource_mut::<SceneProblem>() = SceneProblem(Some(problem.clone()));
            *world.resource_mut::<Notice>() = Notice::Error(problem);
            world.resource_mut::<RecentFiles>().forget_missing();
            return;
        }
    }
    *world.resource_mut::<SceneProblem>() = SceneProblem(None);
}

/// Opens a file as what it is.
fn open_file(world: &mut World, path: &Path) {
    let file = path.to_string_lossy().into_owned();
    match FileKind::of(path) {
        Ok(FileKind::Scene | FileKind::Recording) => load_scene(world, file, Vec::new()),
        Ok(FileKind::Mesh) => {
            if build::choose_mesh(world, &file, 1.0, MeshForm::Hull) {
                tools::put_down(world);
                world.insert_resource(Tool::Add);
                *world.resource_mut::<Notice>() =
                    Notice::Info(format!("click where '{}' is to be", build::stem(&file)));
            }
        }
        Err(reason) => *world.resource_mut::<Notice>() = Notice::Error(reason),
    }
}

/// Spawns a scene in the place of the present one. The name of that where it is kept as it was built.
fn put_on_view(world: &mut World, mut scene: CurrentScene, watch: Watch) -> Option<String> {
    timeline::go_on(world);
    let kept = build::keep_what_was_built(world);
    despawn_scene(world);
    scene.entities = scene.spec.spawn(world);
    timeline::begin(world);
    world.insert_resource(watch.with_meshes(&scene.spec));
    world.insert_resource(scene);
    frame_scene(world);
    kept
}

/// Puts a recording's scene on view and runs all of it again: then it can be looked at like what happened here.
fn play_recording(world: &mut World, file: String) {
    let played = recordings::read(&file).and_then(|(recording, spec, settings)| {
        check_keys(&file, &spec)?;
        world.insert_resource(settings);
        // Nobody writes to it while it is on view.
        let watch = Watch::default();
        put_on_view(
            world,
            CurrentScene { scene: file.clone(), parameters: Vec::new(), spec, entities: default(), came_back_as: None },
            watch,
        );
        recordings::play(world, &recording, &file)
    });
    *world.resource_mut::<SceneProblem>() = SceneProblem(played.as_ref().err().cloned());
    if played.is_err() {
        world.resource_mut::<RecentFiles>().forget_missing();
    }
    report(world, played);
}

fn kept_text(name: &str) -> String {
    format!("{name} is kept as you built it: Ctrl+Z brings it back")
}

/// Puts a scene that was left back in the place of the present one.
fn bring_back(world: &mut World, scene: build::KeptScene) {
    despawn_scene(world);
    let (scene, view) = scene.bring_back(world);
    timeline::begin(world);
    world.insert_resource(Watch::on(&scene.scene).with_meshes(&scene.spec));
    world.insert_resource(Followed::default());
    if let Some(ViewSpec { eye, target }) = view {
        camera::look(world, Framing { eye, target });
    }
    world.insert_resource(scene);
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
            let kept = respawn(world, (&current.spec, &mut current.entities), &spec);
            watch = watch.with_meshes(&spec);
            (current.spec, current.came_back_as) = (spec, None);
            let reloaded = format!("reloaded {}", current.scene);
            let notice =
                Notice::Info(kept.map_or(reloaded.clone(), |name| format!("{reloaded}; {}", kept_text(&name))));
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
    if let Some(name) = respawn(world, (&current.spec, &mut current.entities), &current.spec) {
        *world.resource_mut::<Notice>() = Notice::Info(kept_text(&name));
    }
    current.came_back_as = None;
    world.insert_resource(current);
}

/// Spawns the same scene anew; what is plotted of it stays so, but where a file says otherwise. The scene's name where it is
/// kept as it stood.
fn respawn(world: &mut World, (before, entities): (&SceneSpec, &mut SpawnedScene), spec: &SceneSpec) -> Option<String> {
    timeline::go_on(world);
    let kept = build::keep_what_was_built(world);
    let probes = world.resource::<Probes>().clone();
    despawn_scene(world);
    let now = spec.spawn(world);
    if spec.probes == before.probes {
        world.insert_resource(probes.follow((before, entities), (spec, &now)));
    }
    timeline::begin(world);
    world.resource_mut::<ReadJoints>().follow(entities, &now);
    world.resource_mut::<Followed>().follow(entities, &now);
    *entities = now;
    kept
}

/// Despawns what the scene and the user spawned.
fn despawn_scene(world: &mut World) {
    timeline::end(world);
    let old: Vec<Entity> = world.query_filtered::<Entity, With<SceneEntity>>().iter(world).collect();
    for entity in old {
        world.despawn(entity);
    }
    world.insert_resource(Selection::default());
    // What touched there does not touch here, and no step may come for long to say so.
    if let Some(mut forces) = world.get_resource_mut::<ContactForces>() {
        forces.0.clear();
    }
}

/// The view is the scene's again, and nobody's else.
fn frame_scene(world: &mut World) {
    world.insert_resource(Followed::default());
    if let Some(current) = world.get_resource::<CurrentScene>() {
        let framing = Framing::of(&current.spec);
        camera::look(world, framing);
    }
}
