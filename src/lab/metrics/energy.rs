//! Energy, and how far it strays.

use serde::Serialize;

use super::extent::height;
use super::moving::Moving;
use crate::lab::truth::EnergyScale;
use crate::physics::BodyState;
use crate::scene::SceneSpec;

/// Σ ½mv² + ½ωᵀIω − (m g + F)·(x − x₀) over what moves, J, x₀ each body's start, F the force that the scene puts on it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct EnergyMetrics {
    /// At the start.
    pub start: f64,
    /// At the end.
    pub end: f64,
    /// Largest |E − E₀|/S over the run; S is the largest kinetic energy of the answer, or of the
    /// run where the answer does not say, or for a scene at rest its weight × its height. None
    /// where S is 0, or where motors do work.
    pub max_relative_drift: Option<f64>,
}

/// Watches the energy of a run.
pub(super) struct EnergyMeter {
    start: f64,
    end: f64,
    strays: f64,
    rises: f64,
    kinetic_max: f64,
}

impl EnergyMeter {
    pub fn new(bodies: &[Moving], start: &[BodyState]) -> Self {
        let kinetic = kinetic(bodies, start);
        Self { start: kinetic, end: kinetic, strays: 0.0, rises: 0.0, kinetic_max: kinetic }
    }

    pub fn observe(&mut self, bodies: &[Moving], start: &[BodyState], states: &[BodyState]) {
        let kinetic = kinetic(bodies, states);
        let moved = |body: &Moving| states[body.index].position - start[body.index].position;
        let work: f64 = bodies.iter().map(|body| (body.mass * body.gravity + body.force).dot(moved(body))).sum();
        self.end = kinetic - work;
        self.strays = self.strays.max((self.end - self.start).abs());
        self.rises = self.rises.max(self.end - self.start);
        self.kinetic_max = self.kinetic_max.max(kinetic);
    }

    /// S, J.
    pub fn scale(&self, scale: EnergyScale, bodies: &[Moving], scene: &SceneSpec) -> f64 {
        match scale {
            EnergyScale::Known(joules) => joules,
            EnergyScale::LargestKinetic => self.kinetic_max,
            EnergyScale::NotKept => 0.0,
            EnergyScale::WeightTimesHeight => {
                let weight: f64 = bodies.iter().map(|body| body.mass * body.gravity.length()).sum();
                weight * height(scene, bodies.iter().map(|body| &scene.bodies[body.index]))
            }
        }
    }

    pub fn metrics(&self, scale: f64) -> EnergyMetrics {
        let Self { start, end, strays, .. } = *self;
        EnergyMetrics { start, end, max_relative_drift: (scale > 0.0).then(|| strays / scale) }
    }

    /// Largest (E − E₀)/S; none where S is 0.
    pub fn rise(&self, scale: f64) -> Option<f64> {
        (scale > 0.0).then(|| self.rises / scale)
    }
}

fn kinetic(bodies: &[Moving], states: &[BodyState]) -> f64 {
    bodies.iter().map(|body| body.kinetic_energy(states)).sum()
}
