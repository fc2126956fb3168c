//! Recordings: what happened in the window, to a file and back.

use std::path::Path;

use bevy::prelude::*;

use super::recent::RecentFiles;
use super::screenshot::next_free_path;
use super::state::report;
use super::{CurrentScene, drag, timeline};
use crate::lab::recording::{EXTENSION, Recording, RecordingError, Replay};
use crate::physics::SolverSettings;
use crate::scene::SceneSpec;

/// Writes what happened since the scene began.
pub(super) fn record(world: &mut World) {
    drag::release(world);
    let Some(recorded) = so_far(world) else { return };
    let path = next_free_path(EXTENSION);
    let written = recorded.map_err(|error| error.to_string()).and_then(|recording| {
        let bytes =
            recording.write(&path).map_err(|error| format!("{}: cannot be written: {error}", path.display()))?;
        let shown = std::path::absolute(&path).unwrap_or(path);
        world.resource_mut::<RecentFiles>().add(&shown);
        let kilobytes = bytes.div_ceil(1000);
        Ok(format!("recorded {} steps to {}, {kilobytes} kB", recording.steps(), shown.display()))
    });
    report(world, written);
}

/// What happened since the scene on view began; none where there is no scene.
pub(super) fn so_far(world: &mut World) -> Option<Result<Recording, RecordingError>> {
    let current = world.get_resource::<CurrentScene>()?.clone();
    let (scene, entities) = current.beginning();
    Some(Recording::of_world(world, scene, entities))
}

/// The recording in a file, its scene and its settings.
pub(super) fn read(file: &str) -> Result<(Recording, SceneSpec, SolverSettings), String> {
    let path = Path::new(file);
    let all = Recording::read(path).and_then(|recording| {
        let (spec, settings) = recording.start(path)?;
        Ok((recording, spec, settings))
    });
    all.map_err(|error| error.to_string())
}

/// Runs a recording again whose scene is on view, up to where it comes out otherwise, and goes back to its start. What is to
/// be said of it.
pub(super) fn play(world: &mut World, recording: &Recording, file: &str) -> Result<String, String> {
    let entities = world.resource::<CurrentScene>().entities.clone();
    let replayed = recording.replay_in(world, &entities, Path::new(file), |_| ());
    timeline::go_to_end(world, 0);
    let Replay { steps, differs } = replayed.map_err(|error| error.to_string())?;
    match differs {
        None => Ok(format!("{file}: {steps} steps, all as they were recorded; Space plays them")),
        Some(differs) => Err(format!(
            "{file}: step {} comes out otherwise than recorded{}: it is played up to there",
            differs.step,
            differs.first()
        )),
    }
}
