//! Running a recording again.

use std::path::Path;

use bevy::prelude::*;

use super::deeds::Kinds;
use super::error::RecordingError;
use super::file::Recording;
use super::numbers::Numbers;
use super::print::Print;
use crate::lab::Simulation;
use crate::lab::settings_file::settings_from_ron;
use crate::physics::{ContactForces, SolverSettings, step};
use crate::scene::{SceneSpec, SpawnedScene};

/// How it went.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Replay {
    /// Steps that were made.
    pub steps: u64,
    /// Where it first came out otherwise.
    pub differs: Option<Difference>,
}

/// A step after which the world was another.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Difference {
    /// Steps since the scene's start.
    pub step: u64,
    /// The name of the first body that was elsewhere; none where the bodies are the same, but not what the solver carries
    /// from step to step, or where they are too many to be told apart.
    pub body: Option<String>,
}

impl Difference {
    /// What is to be said after the step: the body, where it is known.
    pub fn first(&self) -> String {
        self.body.as_ref().map_or(String::new(), |body| format!(", first '{body}'"))
    }
}

impl Recording {
    /// The scene in it, and the settings, of the file at that path.
    ///
    /// # Errors
    /// Either makes no sense.
    pub fn start(&self, path: &Path) -> Result<(SceneSpec, SolverSettings), RecordingError> {
        let mut scene = SceneSpec::from_ron(&self.scene, &path.display().to_string())?;
        scene.name.clone_from(&self.name);
        let refused = |problem: String| RecordingError::Malformed {
            path: path.to_owned(),
            line: self.scene.matches('\n').count() + 5,
            problem,
        };
        let settings = settings_from_ron(&self.settings).map_err(|error| refused(error.code.to_string()))?;
        settings.validate().map_err(|error| refused(error.to_string()))?;
        Ok((scene, settings))
    }

    /// Runs it again in a world of its own.
    ///
    /// # Errors
    /// The scene, the settings or an act in it makes no sense.
    pub fn replay(&self, path: &Path, watch: impl FnMut(u64)) -> Result<Replay, RecordingError> {
        let (scene, settings) = self.start(path)?;
        let mut simulation = Simulation::new(scene, settings);
        let entities = simulation.entities().clone();
        self.replay_in(simulation.world_mut(), &entities, path, watch)
    }

    /// Runs it again in a world into which its scene was spawned, with its settings. Stops where it comes out otherwise.
    ///
    /// # Errors
    /// An act in it makes no sense.
    pub fn replay_in(
        &self,
        world: &mut World,
        entities: &SpawnedScene,
        path: &Path,
        mut watch: impl FnMut(u64),
    ) -> Result<Replay, RecordingError> {
        let read_before = world.contains_resource::<ContactForces>();
        read_forces(world, self.reads_forces);
        let outcome = self.run_in(world, entities, path, &mut watch);
        read_forces(world, read_before);
        outcome
    }

    fn run_in(
        &self,
        world: &mut World,
        entities: &SpawnedScene,
        path: &Path,
        watch: &mut impl FnMut(u64),
    ) -> Result<Replay, RecordingError> {
        let (kinds, mut numbers) = (Kinds::new(world), Numbers::of_scene(entities));
        let mut deeds = self.deeds.iter().peekable();
        for (made, print) in (0..).zip(&self.prints) {
            if made > 0 {
                step(world);
            }
            watch(made);
            if Print::of(world, &numbers) != *print {
                let other = print.first_other(world, &numbers);
                let name = |body| world.get::<Name>(body).map_or_else(|| format!("{body}"), |name| name.to_string());
                return Ok(Replay { steps: made, differs: Some(Difference { step: made, body: other.map(name) }) });
            }
            while let Some((_, deed)) = deeds.next_if(|(after, _)| *after == made) {
                kinds.perform(deed, world, &mut numbers).map_err(|problem| RecordingError::Malformed {
                    path: path.to_owned(),
                    line: self.line_of_deed(made),
                    problem,
                })?;
            }
        }
        Ok(Replay { steps: self.steps(), differs: None })
    }

    /// The line of its file with the first of what was done after so many steps.
    fn line_of_deed(&self, step: u64) -> usize {
        let before = self.deeds.iter().filter(|(after, _)| *after < step).count();
        self.scene.matches('\n').count() + 6 + step as usize + 2 + before
    }
}

/// Has somebody read the forces of contacts, or nobody.
fn read_forces(world: &mut World, reads: bool) {
    if reads {
        world.init_resource::<ContactForces>();
    } else {
        world.remove_resource::<ContactForces>();
    }
}
