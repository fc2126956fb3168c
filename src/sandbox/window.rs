//! Opening the window, or saying in one line why there is none.

use std::panic::{self, AssertUnwindSafe};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

use bevy::log::LogPlugin;
use bevy::prelude::*;
use bevy::window::{WindowResizeConstraints, WindowResolution};

use super::clipboard::Clipboard;
use super::motor_keys::check_keys;
use super::scale::LEAST_WINDOW;
use super::window_memory::{MemoryFile, users_file};
use super::{SandboxAction, SandboxPlugin};
use crate::lab::recording::is_recording;
use crate::physics::SolverSettings;
use crate::scene::{self, SceneError};

/// What the sandbox opens with.
#[derive(Clone, Debug)]
pub struct Launch {
    /// A built-in scene, or the path of a RON file or of a recording that can be read.
    pub scene: String,
    /// Its parameters, as on the command line.
    pub parameters: Vec<(String, f64)>,
    /// The solver's settings.
    pub settings: SolverSettings,
}

/// Why the window did not open, in one line.
#[derive(Debug, thiserror::Error)]
pub enum LaunchError {
    /// The scene could not be had.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A motor of the scene names a key that there is not.
    #[error("{0}")]
    Keys(String),
    /// No window system.
    #[error("no display to open a window on; 'plumb run SCENE' simulates without one")]
    NoDisplay,
    /// A window system, but nothing to draw with.
    #[error("no graphics driver to draw with; 'plumb run SCENE' simulates without one")]
    NoGraphics,
    /// Something else that a window needs.
    #[error("the window did not open ({0}); 'plumb run SCENE' simulates without one")]
    Other(String),
}

/// Opens the window and returns when it is closed.
///
/// # Errors
/// The scene, the display or the graphics driver is missing or wrong.
pub fn launch(launch: Launch) -> Result<(), LaunchError> {
    if !is_recording(&launch.scene) {
        let spec = scene::load(&launch.scene, &launch.parameters)?;
        check_keys(&launch.scene, &spec).map_err(LaunchError::Keys)?;
    }
    let exit = catch_failed_start(|| run(launch))?;
    match exit {
        AppExit::Success => Ok(()),
        AppExit::Error(code) => Err(LaunchError::Other(format!("it closed with code {code}"))),
    }
}

/// Errors, but for those of a search for drivers that finds none: [`LaunchError::NoGraphics`] says
/// so in words of its own.
pub(super) const LOG_FILTER: &str = "error,wgpu_hal::vulkan::instance=off";

fn run(launch: Launch) -> AppExit {
    let remembered = users_file().map(|file| MemoryFile::read(&file));
    let [width, height] = remembered.as_ref().map_or([1280.0, 720.0], |file| file.memory().size);
    let window = Window {
        title: "Plumb".into(),
        name: Some("plumb".into()),
        resolution: WindowResolution::new(width as u32, height as u32),
        // Beside the panel there is still a picture, and the playback buttons are all there.
        resize_constraints: WindowResizeConstraints {
            min_width: LEAST_WINDOW.x,
            min_height: LEAST_WINDOW.y,
            ..default()
        },
        ..default()
    };
    let mut app = App::new();
    app.add_plugins(
        DefaultPlugins
            .set(WindowPlugin { primary_window: Some(window), ..default() })
            .set(LogPlugin { filter: LOG_FILTER.into(), ..default() }),
    )
    .insert_resource(launch.settings)
    .insert_resource(Clipboard::of_system())
    .add_plugins(SandboxPlugin)
    .add_systems(Startup, move |mut actions: MessageWriter<SandboxAction>| {
        let (scene, parameters) = (launch.scene.clone(), launch.parameters.clone());
        actions.write(SandboxAction::LoadScene { scene, parameters });
    })
    .add_systems(Last, || STARTED.store(true, Ordering::Relaxed));
    if let Some(file) = remembered {
        file.put_in(&mut app);
    }
    app.run()
}

/// Whether the first frame has been reached.
static STARTED: AtomicBool = AtomicBool::new(false);

/// Bevy panics where it finds no display or no driver. Until the first frame such a panic is
/// kept quiet and becomes an error; after it, panics are what they always are.
pub(super) fn catch_failed_start<T>(run: impl FnOnce() -> T) -> Result<T, LaunchError> {
    static FIRST_PANIC: Mutex<Option<String>> = Mutex::new(None);
    let loud = panic::take_hook();
    panic::set_hook(Box::new(move |info| {
        if STARTED.load(Ordering::Relaxed) {
            return loud(info);
        }
        let message = info.payload_as_str().unwrap_or("no reason given").to_owned();
        FIRST_PANIC.lock().unwrap_or_else(|poisoned| poisoned.into_inner()).get_or_insert(message);
    }));
    let outcome = panic::catch_unwind(AssertUnwindSafe(run));
    if outcome.is_ok() {
        STARTED.store(true, Ordering::Relaxed);
    }
    outcome.map_err(|payload| {
        if STARTED.load(Ordering::Relaxed) {
            panic::resume_unwind(payload);
        }
        let message = FIRST_PANIC.lock().unwrap_or_else(|poisoned| poisoned.into_inner()).take();
        explain(&message.unwrap_or_default())
    })
}

/// What a panic at start was about, from the words of winit and of Bevy's renderer.
fn explain(message: &str) -> LaunchError {
    if message.contains("event loop") || message.contains("DISPLAY") {
        LaunchError::NoDisplay
    } else if message.contains("GPU") || message.contains("wgpu") || message.contains("adapter") {
        LaunchError::NoGraphics
    } else {
        LaunchError::Other(message.lines().next().unwrap_or_default().to_owned())
    }
}
