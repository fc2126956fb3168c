//! What to run: a scene, settings, how long.

use crate::physics::{SettingsError, SolverSettings};
use crate::scene::{self, SceneError, SceneSpec};

/// What to run: a valid scene, valid settings, how long.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The scene.
    pub scene: SceneSpec,
    /// Whether [`scene`](Self::scene) is the built-in scene of its name, with a known answer.
    pub built_in: bool,
    /// Whether to work out a converged answer where none is known otherwise.
    pub converge: bool,
    /// Every parameter of a built-in scene with its value.
    pub parameters: Vec<(String, f64)>,
    /// The solver's settings.
    pub settings: SolverSettings,
    /// Steps to take, at least 1.
    pub steps: u64,
}

/// Most steps of one run: their times are kept for the median.
pub const MOST_STEPS: u64 = 50_000_000;

/// Seconds that a scene from a file is run where none are asked for.
const DEFAULT_SECONDS: f64 = 10.0;

/// Why a plan makes no sense.
#[derive(Debug, thiserror::Error)]
pub enum PlanError {
    /// The scene could not be had.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A setting is out of its range.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// The length of the run.
    #[error("seconds: {0} is out of range, must be greater than 0 and finite")]
    Seconds(f64),
    /// Too long a run.
    #[error("seconds: {seconds} s at {hz} steps a second are more than {MOST_STEPS} steps")]
    TooManySteps {
        /// Asked for.
        seconds: f64,
        /// Steps per second.
        hz: f64,
    },
}

impl Plan {
    /// Plans to run a built-in scene, or one from a RON file, as on the command line; for
    /// `seconds`, or as long as the scene suggests.
    ///
    /// # Errors
    /// Whatever is wrong with the scene, its parameters, the settings or the length.
    pub fn new(
        scene: &str,
        parameters: &[(String, f64)],
        settings: SolverSettings,
        seconds: Option<f64>,
    ) -> Result<Self, PlanError> {
        settings.validate()?;
        if let Some(seconds) = seconds.filter(|seconds| !(seconds.is_finite() && *seconds > 0.0)) {
            return Err(PlanError::Seconds(seconds));
        }
        let built_in = scene::find(scene);
        let seconds = seconds.or(built_in.map(|info| info.seconds)).unwrap_or(DEFAULT_SECONDS);
        let steps = (seconds * settings.hz).round().max(1.0);
        if steps > MOST_STEPS as f64 {
            return Err(PlanError::TooManySteps { seconds, hz: settings.hz });
        }
        let value =
            |name: &str, default| parameters.iter().rev().find(|(known, _)| known == name).map_or(default, |p| p.1);
        let all = built_in.iter().flat_map(|info| info.parameters);
        Ok(Self {
            scene: scene::load(scene, parameters)?,
            built_in: built_in.is_some(),
            converge: built_in.is_some(),
            parameters: all.map(|info| (info.name.to_owned(), value(info.name, info.default))).collect(),
            settings,
            steps: steps as u64,
        })
    }
}
