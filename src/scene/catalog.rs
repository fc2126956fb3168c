//! The built-in scenes, by name, with their parameters.

use super::{SceneError, SceneSpec};

/// A built-in scene.
pub struct SceneInfo {
    /// Its name on the command line.
    pub name: &'static str,
    /// What it is, in one line.
    pub about: &'static str,
    /// What is known of its answer, in one line.
    pub truth: &'static str,
    /// Its parameters, in order.
    pub parameters: &'static [Parameter],
    /// Seconds that `plumb run` simulates where none are asked for.
    pub seconds: f64,
    /// Builds it from one value per parameter, in order, each in its range.
    pub build: fn(&[f64]) -> SceneSpec,
}

/// A number that a built-in scene depends on.
pub struct Parameter {
    /// Its name on the command line.
    pub name: &'static str,
    /// What it is, with its unit.
    pub about: &'static str,
    /// Its value where none is given.
    pub default: f64,
    /// Smallest value.
    pub min: f64,
    /// Largest value.
    pub max: f64,
    /// Whether only whole numbers make sense.
    pub integer: bool,
}

/// All built-in scenes, the start scene first.
pub fn catalog() -> &'static [SceneInfo] {
    &[]
}

/// The built-in scene of that name.
pub fn find(name: &str) -> Option<&'static SceneInfo> {
    catalog().iter().find(|scene| scene.name == name)
}

/// A scene by built-in name or path to a RON file, with parameters as given on the command line
/// (`n=40`); checked.
///
/// # Errors
/// An unknown scene or parameter, a value out of range, or whatever is wrong with the file.
pub fn load(scene: &str, _parameters: &[(String, f64)]) -> Result<SceneSpec, SceneError> {
    Err(SceneError::UnknownScene(scene.into()))
}
