//! Running a scene without a window.

use std::hash::Hasher;

use bevy::ecs::query::QueryState;
use bevy::math::{DQuat, DVec3};
use bevy::prelude::*;
use xxhash_rust::xxh3::Xxh3;

use crate::physics::hash_state;
use crate::physics::{
    Position, Quarantined, Rotation, SettingsError, SolverSettings, StepStats, Velocity, headless_app, step,
};
use crate::scene::{self, SceneError, SceneSpec, SpawnedScene};

use super::metrics::{Meter, Metrics, QuarantinedEntity};
use super::truth;

/// A scene in a world of its own.
pub struct Simulation {
    world: World,
    scene: SceneSpec,
    entities: SpawnedScene,
    poses: QueryState<(&'static Position, &'static Rotation, &'static Velocity)>,
    states: Vec<BodyState>,
}

/// The state of one body.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BodyState {
    /// Centre of mass, m.
    pub position: DVec3,
    /// Orientation.
    pub rotation: DQuat,
    /// m/s.
    pub linear: DVec3,
    /// rad/s, world axes.
    pub angular: DVec3,
}

/// A scene's bodies at one time.
#[derive(Clone, Copy, Debug)]
pub struct Sample<'a> {
    /// Steps since the start.
    pub step: u64,
    /// steps × h, s.
    pub time: f64,
    /// In the order of [`SceneSpec::bodies`].
    pub bodies: &'a [BodyState],
}

impl Simulation {
    /// Spawns a scene into a new headless world. Scene and settings must be valid.
    pub fn new(scene: SceneSpec, settings: SolverSettings) -> Self {
        let mut world = std::mem::take(headless_app().world_mut());
        world.insert_resource(settings);
        let entities = scene.spawn(&mut world);
        let mut simulation = Self { poses: world.query(), world, scene, entities, states: Vec::new() };
        simulation.gather();
        simulation
    }

    /// One step.
    pub fn step(&mut self) {
        step(&mut self.world);
        self.gather();
    }

    fn gather(&mut self) {
        self.poses.update_archetypes(&self.world);
        self.states.clear();
        self.states.extend(self.poses.iter_many_manual(&self.world, &self.entities.bodies).map(
            |(position, rotation, velocity)| BodyState {
                position: position.0,
                rotation: rotation.0,
                linear: velocity.linear,
                angular: velocity.angular,
            },
        ));
    }

    /// The bodies now.
    pub fn sample(&self) -> Sample<'_> {
        let world = self.world();
        let step = world.resource::<StepStats>().steps;
        // steps/hz, not steps × (1/hz): one rounding instead of two.
        let time = step as f64 / world.resource::<SolverSettings>().hz;
        Sample { step, time, bodies: &self.states }
    }

    /// The scene it was made from.
    pub fn scene(&self) -> &SceneSpec {
        &self.scene
    }

    /// The entities of the scene's bodies and joints.
    pub fn entities(&self) -> &SpawnedScene {
        &self.entities
    }

    /// The settings it runs with.
    pub fn settings(&self) -> &SolverSettings {
        self.world.resource()
    }

    /// The world it runs in.
    pub fn world(&self) -> &World {
        &self.world
    }

    /// The world it runs in, to change something.
    pub fn world_mut(&mut self) -> &mut World {
        &mut self.world
    }

    /// A fingerprint (XXH3) of every bit of the bodies' poses and velocities and of what the
    /// solver carries from step to step.
    pub fn state_hash(&self) -> u64 {
        let mut hasher = Xxh3::new();
        hash_state(self.world(), &mut hasher);
        hasher.finish()
    }

    /// Bodies and joints that the step has set aside, and why.
    pub fn quarantined(&self) -> Vec<QuarantinedEntity> {
        let bodies = self.entities.bodies.iter().zip(self.scene.bodies.iter().map(|body| body.name.clone()));
        let joints = self.entities.joints.iter().zip((0..).map(|index| format!("joints[{index}]")));
        bodies
            .chain(joints)
            .filter_map(|(&entity, body)| {
                let reason = self.world().get::<Quarantined>(entity)?.reason.to_string();
                Some(QuarantinedEntity { body, reason })
            })
            .collect()
    }
}

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

/// Runs a plan and measures it. `watch` sees the state at the start and after each step and
/// ends the run with its first error.
///
/// # Errors
/// Those of `watch`.
pub fn measure<E>(plan: &Plan, mut watch: impl FnMut(&Sample) -> Result<(), E>) -> Result<Metrics, E> {
    let mut simulation = Simulation::new(plan.scene.clone(), plan.settings);
    let known = plan.built_in.then(|| truth::of(&plan.scene, &plan.settings)).flatten();
    let truth = known
        .map(Ok)
        .or_else(|| plan.converge.then(|| truth::converged(&plan.scene, plan.steps as f64 / plan.settings.hz)));
    let mut meter = Meter::new(plan, &mut simulation, truth);
    watch(&simulation.sample())?;
    for _ in 0..plan.steps {
        simulation.step();
        meter.observe(&simulation);
        watch(&simulation.sample())?;
    }
    Ok(meter.finish(plan, &simulation))
}
