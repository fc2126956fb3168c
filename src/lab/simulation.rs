//! A scene in a headless world, its state after each step.

use std::hash::Hasher;

use bevy::ecs::query::QueryState;
use bevy::prelude::*;
use serde::Serialize;
use xxhash_rust::xxh3::Xxh3;

use crate::physics::hash_state;
use crate::physics::{
    BodyState, GoError, History, JointLoad, Position, Quarantined, Rotation, SolverSettings, StepStats, Velocity,
    go_to, headless_app, step,
};
use crate::scene::{SceneSpec, SpawnedScene};

/// A scene in a world of its own.
pub struct Simulation {
    world: World,
    scene: SceneSpec,
    entities: SpawnedScene,
    poses: QueryState<(&'static Position, &'static Rotation, &'static Velocity)>,
    states: Vec<BodyState>,
    loads: Vec<JointLoad>,
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
    /// In the order of [`SceneSpec::joints`]; none unless they are [read](Simulation::read_loads).
    pub loads: &'a [JointLoad],
}

/// A body or joint that the step has set aside.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct QuarantinedEntity {
    /// Its name; a joint by its place in the scene.
    pub body: String,
    /// What was wrong.
    pub reason: String,
}

impl Simulation {
    /// Spawns a scene into a new headless world. Scene and settings must be valid.
    pub fn new(scene: SceneSpec, settings: SolverSettings) -> Self {
        let mut world = std::mem::take(headless_app().world_mut());
        world.insert_resource(settings);
        let entities = scene.spawn(&mut world);
        let mut simulation =
            Self { poses: world.query(), world, scene, entities, states: Vec::new(), loads: Vec::new() };
        simulation.gather();
        simulation
    }

    /// One step.
    pub fn step(&mut self) {
        step(&mut self.world);
        self.gather();
    }

    /// Steps until it is as near to that time, s, as whole steps come; `after` sees it after each.
    pub fn step_to(&mut self, time: f64, mut after: impl FnMut(&Self)) {
        let half = 0.5 * self.settings().step();
        while self.sample().time < time - half {
            self.step();
            after(self);
        }
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
        let entities = self.entities.joints.iter();
        self.loads.clear();
        self.loads.extend(entities.map_while(|&joint| self.world.get::<JointLoad>(joint)));
    }

    /// Has the scene be as it stands at that time after its start, s, to a step: motors that follow a motion go on from
    /// there, and what holds at first does so no longer. To be called before the first step.
    pub fn set_clock(&mut self, time: f64) {
        let settings = *self.settings();
        let mut stats = self.world.resource_mut::<StepStats>();
        stats.steps = (time * settings.hz).round() as u64;
        stats.time = stats.steps as f64 * settings.step();
    }

    /// Keeps what happens from now on, in so many bytes, so that it can go back.
    pub fn keep_history(&mut self, limit: usize) {
        History::begin(&mut self.world, limit);
    }

    /// Goes back to where it was after so many steps, or on again.
    ///
    /// # Errors
    /// That is not kept.
    pub fn go_to(&mut self, step: u64) -> Result<(), GoError> {
        go_to(&mut self.world, step)?;
        self.gather();
        Ok(())
    }

    /// Has samples tell the loads of joints, from the next step on.
    pub fn read_loads(&mut self) {
        for &joint in &self.entities.joints {
            self.world.entity_mut(joint).insert(JointLoad::default());
        }
        self.gather();
    }

    /// The bodies now.
    pub fn sample(&self) -> Sample<'_> {
        let world = self.world();
        let step = world.resource::<StepStats>().steps;
        // steps/hz, not steps × (1/hz): one rounding instead of two.
        let time = step as f64 / world.resource::<SolverSettings>().hz;
        Sample { step, time, bodies: &self.states, loads: &self.loads }
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
        state_hash(self.world())
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

/// A fingerprint (XXH3) of every bit that the next step of a world depends on.
pub fn state_hash(world: &World) -> u64 {
    let mut hasher = Xxh3::new();
    hash_state(world, &mut hasher);
    hasher.finish()
}
