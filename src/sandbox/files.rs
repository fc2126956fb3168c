//! Saving the scene and the settings, and loading settings.

use std::path::{Path, PathBuf};

use bevy::prelude::*;

use super::recent::RecentFiles;
use super::state::report;
use super::watch::Watch;
use super::{CurrentScene, camera};
use crate::lab::{read_settings, settings_text, write_whole};
use crate::physics::SolverSettings;
use crate::scene::SceneSpec;

/// Saves the scene as it stands now, seen from where the camera is.
pub(super) fn save_scene(world: &mut World, path: &Path, overwrite: bool) {
    let outcome = scene_now(world, path).and_then(|text| save(path, overwrite, &text));
    if let Ok(path) = &outcome {
        world.resource_mut::<RecentFiles>().add(path);
    }
    if let Ok(path) = &outcome
        && world.get_resource::<CurrentScene>().is_some_and(|current| Path::new(&current.scene) == path)
    {
        world.resource_mut::<Watch>().accept(); // what is on view need not be read again
    }
    report(world, outcome.map(|path| format!("saved {}", absolute(&path))));
}

/// The scene as the text of a file at that path: meshes are named relative to it.
fn scene_now(world: &mut World, path: &Path) -> Result<String, String> {
    let name = world.get_resource::<CurrentScene>().map_or_else(|| "scene".into(), |current| current.spec.name.clone());
    let mut scene = SceneSpec::of_world(world, name);
    scene.view = camera::view(world);
    scene.to_ron(path.parent()).map_err(|error| error.to_string())
}

/// Saves the solver's settings.
pub(super) fn save_settings(world: &mut World, path: &Path, overwrite: bool) {
    let text = settings_text(world.resource::<SolverSettings>());
    let outcome = save(path, overwrite, &text).map(|path| format!("saved {}", absolute(&path)));
    report(world, outcome);
}

/// Loads the solver's settings.
pub(super) fn load_settings(world: &mut World, path: &Path) {
    let outcome = read_settings(path).map_err(|error| error.to_string()).map(|settings| {
        world.insert_resource(settings);
        format!("settings from {}", path.display())
    });
    report(world, outcome);
}

/// Where a file of that name goes: what the user typed, with `.ron` at its end.
pub(super) fn file_path(typed: &str) -> PathBuf {
    let typed = typed.trim();
    if typed.is_empty() || typed.ends_with(".ron") { typed.into() } else { format!("{typed}.ron").into() }
}

fn save(path: &Path, overwrite: bool, text: &str) -> Result<PathBuf, String> {
    if path.as_os_str().is_empty() {
        return Err("a file needs a name to be saved under".into());
    }
    if !overwrite && path.exists() {
        return Err(format!("{} exists already: save it again to overwrite it", path.display()));
    }
    write_whole(path, text).map_err(|error| format!("{}: cannot be written: {error}", path.display()))?;
    Ok(path.to_owned())
}

fn absolute(path: &Path) -> String {
    std::path::absolute(path).unwrap_or_else(|_| path.to_owned()).display().to_string()
}
