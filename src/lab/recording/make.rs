//! Making recordings: of a plan that is run, of a world whose history is kept.

use bevy::prelude::*;

use super::deeds::Kinds;
use super::error::RecordingError;
use super::file::Recording;
use super::numbers::Numbers;
use super::print::Print;
use crate::lab::{Plan, Simulation};
use crate::physics::{ContactForces, GoError, History, SolverSettings, StepStats, Told, retell};
use crate::scene::{SceneSpec, SpawnedScene};

impl Recording {
    /// Of a scene that runs by itself. To be told of each state that it comes to.
    ///
    /// # Errors
    /// The scene cannot be written.
    pub fn of_plan(plan: &Plan) -> Result<Self, RecordingError> {
        Ok(Self::new(&plan.scene, &plan.settings)?)
    }

    /// Takes in the state that it has come to.
    pub fn note(&mut self, simulation: &Simulation) {
        let numbers = Numbers::of_scene(simulation.entities());
        self.reads_forces = simulation.world().contains_resource::<ContactForces>();
        self.prints.push(Print::of(simulation.world(), &numbers));
    }

    /// Of all that happened in a world since a scene was spawned into it and its [`History`] began, by going through it
    /// once more.
    ///
    /// # Errors
    /// The history does not reach back to the scene's first step.
    pub fn of_world(world: &mut World, scene: &SceneSpec, entities: &SpawnedScene) -> Result<Self, RecordingError> {
        History::take_in(world);
        let history = world.get_resource::<History>().ok_or(GoError::NoHistory)?;
        let (first, begun) = (history.reach()[0], history.begun());
        if first > begun {
            let seconds = (first - begun) as f64 * world.resource::<SolverSettings>().step();
            return Err(RecordingError::TooLate { seconds });
        }
        let mut recording = None;
        let (mut kinds, mut numbers, mut step) = (None, Numbers::of_scene(entities), 0);
        retell(world, |world, told| {
            let recording = recording.get_or_insert_with(|| {
                Self::new(scene, world.resource::<SolverSettings>()).map_err(RecordingError::from)
            });
            let Ok(recording) = recording else { return };
            recording.reads_forces = world.contains_resource::<ContactForces>();
            let kinds = kinds.get_or_insert_with(|| Kinds::new(world));
            match told {
                Told::Step => {
                    step = world.resource::<StepStats>().steps - first;
                    recording.prints.push(Print::of(world, &numbers));
                }
                Told::Deeds(deeds) => {
                    let text = kinds.write(world, deeds, &mut numbers);
                    recording.deeds.extend(text.map(|text| (step, text)));
                }
            }
        })?;
        recording.expect("a history has a first step")
    }
}
