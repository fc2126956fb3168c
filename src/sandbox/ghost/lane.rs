//! One ghost at work: where its bodies are, and what is measured of it.

use bevy::math::{DQuat, DVec3};
use bevy::prelude::*;

use crate::lab::race::Limits;
use crate::lab::{Simulation, truth, turn_between};
use crate::physics::{Collider, Diagnostics, History, SolverSettings, StepStats};
use crate::scene::SceneSpec;

/// What a ghost's history may take, bytes.
const HISTORY: usize = 128 << 20;

/// How far apart two worlds are.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Apart {
    /// Largest distance between two places of a material point of a body, m.
    pub distance: f64,
    /// Largest angle between two orientations of a body, rad.
    pub angle: f64,
}

/// What is measured of a world after a step.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Reading {
    /// Since the ghosts started, J.
    pub energy: f64,
    /// Largest gap of a joint, m.
    pub joint_gap: f64,
    /// Largest depth of a contact, m.
    pub overlap: f64,
    /// What a step took, s: a running mean.
    pub step_seconds: f64,
    /// When it first failed, as maps have it, s, and why.
    pub failed: Option<(f64, String)>,
    energy_at_start: Option<f64>,
}

impl Reading {
    /// Weight of the newest step in the mean of what steps take.
    const NEWEST: f64 = 0.1;

    /// Takes in what was measured after a step.
    pub(super) fn note(&mut self, measured: &Diagnostics, stats: &StepStats, limits: &Limits) {
        let energy = measured.kinetic_energy + measured.potential_energy;
        self.energy = energy - *self.energy_at_start.get_or_insert(energy);
        (self.joint_gap, self.overlap) = (measured.joint_error, measured.penetration);
        let newest = if self.step_seconds == 0.0 { 1.0 } else { Self::NEWEST };
        self.step_seconds += newest * (stats.step_seconds - self.step_seconds);
        // What is gone back behind has not happened.
        self.failed.take_if(|(time, _)| *time > stats.time);
        if self.failed.is_none() {
            self.failed = limits.failure(measured).map(|reason| (stats.time, reason));
        }
    }
}

/// A body and its ghost.
pub(super) struct Pair {
    /// In the scene's list.
    pub index: usize,
    /// In the first world.
    pub body: Entity,
    /// What is drawn.
    pub ghost: Entity,
    /// Before and after the ghost's last step.
    pub poses: [(DVec3, DQuat); 2],
}

/// Where bodies are, by index in the scene's list.
enum Source {
    Method(Box<Simulation>),
    Answer(truth::Poses),
}

/// A ghost at work.
pub(super) struct Lane {
    source: Source,
    pub pairs: Vec<Pair>,
}

impl Lane {
    /// By those settings from a scene as it stands at that time, s, on.
    pub fn by(settings: SolverSettings, scene: &SceneSpec, time: f64) -> Self {
        let mut simulation = Simulation::new(scene.clone(), settings);
        simulation.set_clock(time);
        simulation.world_mut().init_resource::<Diagnostics>();
        simulation.keep_history(HISTORY);
        Self { source: Source::Method(Box::new(simulation)), pairs: Vec::new() }
    }

    /// The answer of a scene, if that gives the whole motion.
    pub fn answer(scene: &SceneSpec) -> Option<Self> {
        let source = Source::Answer(truth::poses(scene)?);
        Some(Self { source, pairs: Vec::new() })
    }

    /// Goes on to a time of the scene, s, or back, and tells where the bodies are then; `note` sees what was measured after
    /// each step.
    pub fn advance(&mut self, time: f64, mut note: impl FnMut(&Diagnostics, &StepStats)) -> Vec<(usize, DVec3, DQuat)> {
        let simulation = match &mut self.source {
            Source::Answer(poses) => return poses(time),
            Source::Method(simulation) => simulation,
        };
        let step = simulation.settings().step();
        if simulation.sample().time > time + 0.5 * step {
            // As far back as is kept; it waits there.
            let first = simulation.world().resource::<History>().reach()[0];
            let _ = simulation.go_to(((time / step).round() as u64).max(first));
        }
        simulation.step_to(time, |simulation| {
            let world = simulation.world();
            note(world.resource::<Diagnostics>(), world.resource::<StepStats>());
        });
        let bodies = simulation.sample().bodies.iter().enumerate();
        bodies.map(|(index, body)| (index, body.position, body.rotation)).collect()
    }

    /// Goes to a time of the scene, s. How far it is then from the first world's bodies.
    pub fn follow<'a>(
        &mut self,
        time: f64,
        note: impl FnMut(&Diagnostics, &StepStats),
        body: impl Fn(Entity) -> Option<(DVec3, DQuat, &'a Collider)>,
    ) -> Apart {
        // Both go up by index.
        let mut poses = self.advance(time, note).into_iter();
        let mut apart = Apart::default();
        for pair in &mut self.pairs {
            let Some((_, position, rotation)) = poses.by_ref().find(|(index, ..)| *index == pair.index) else { break };
            pair.poses = [pair.poses[1], (position, rotation)];
            if let Some((at, turned, collider)) = body(pair.body) {
                let distance = collider.largest_displacement(position - at, [turned, rotation]);
                apart.distance = apart.distance.max(distance);
                apart.angle = apart.angle.max(turn_between(turned, rotation));
            }
        }
        apart
    }
}
