//! What a race is, and how it went.

use crate::physics::SolverSettings;
use crate::scene::SceneSpec;

/// Who runs.
#[derive(Clone, Debug)]
pub struct Runner {
    /// In tables and pictures.
    pub name: String,
    /// How.
    pub settings: SolverSettings,
}

/// What to run.
#[derive(Clone, Debug)]
pub struct Race {
    /// A valid scene.
    pub scene: SceneSpec,
    /// Whether it is the built-in scene of its name, with an answer.
    pub built_in: bool,
    /// At least one, with valid settings.
    pub runners: Vec<Runner>,
    /// When they part, s after the scene's start.
    pub from: f64,
    /// For how long, s.
    pub seconds: f64,
    /// The distance whose first time is told, m.
    pub apart: f64,
}

/// How the race went.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// What distances are from.
    pub base: String,
    /// One a runner.
    pub courses: Vec<Course>,
}

/// How one of them went.
#[derive(Clone, Debug)]
pub struct Course {
    /// The runner's name.
    pub name: String,
    /// Every sixtieth of a second, from the start of the race on.
    pub moments: Vec<Moment>,
    /// When it first was farther from the base than asked for, s.
    pub parted: Option<f64>,
    /// When and how it failed.
    pub failed: Option<(f64, String)>,
}

/// One moment of a runner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    /// Since the race began, s.
    pub time: f64,
    /// Largest distance of a material point of a body from its place in the base, m.
    pub distance: f64,
    /// Largest angle between a body and itself in the base, rad.
    pub angle: f64,
    /// Energy since the race began, J.
    pub energy: f64,
    /// Largest gap of a joint, m.
    pub joint_gap: f64,
    /// Largest depth of a contact, m.
    pub overlap: f64,
    /// Mean since the moment before, ms.
    pub ms_per_step: f64,
}
