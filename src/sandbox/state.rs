//! What the parts of the sandbox share.

use bevy::prelude::*;

use crate::scene::{SceneSpec, SpawnedScene};

/// The scene that is loaded; written by [`super::SandboxAction::LoadScene`] and
/// [`super::SandboxAction::Reset`] alone, and changed at each.
#[derive(Resource, Clone, Debug)]
pub struct CurrentScene {
    /// A built-in name, or the path of a RON file.
    pub scene: String,
    /// The parameters it was loaded with, those left at their default not among them.
    pub parameters: Vec<(String, f64)>,
    /// What was loaded.
    pub spec: SceneSpec,
    /// Its entities, in the order of the spec's lists; some may be despawned since.
    pub entities: SpawnedScene,
}

/// The body that was picked last.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Selection(pub Option<Entity>);

/// How simulation time runs against the clock.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Playback {
    /// Time stands still.
    pub paused: bool,
    /// Time runs at [`Playback::SLOW`] of the clock.
    pub slow: bool,
}

impl Playback {
    /// Speed of slow motion.
    pub const SLOW: f64 = 0.2;

    /// Simulated seconds per second while not paused.
    pub fn speed(&self) -> f64 {
        if self.slow { Self::SLOW } else { 1.0 }
    }
}

/// The last word to the user, in one line.
#[derive(Resource, Clone, Debug, Default, PartialEq, Eq)]
pub enum Notice {
    /// Nothing to say.
    #[default]
    None,
    /// Something was done.
    Info(String),
    /// Something could not be done.
    Error(String),
}

/// Width of the window's right side that the panel covers, logical pixels.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Covered(pub f32);

pub(super) fn plugin(app: &mut App) {
    app.init_resource::<Selection>().init_resource::<Notice>().init_resource::<Covered>();
}
