//! What the measures need of the bodies that move, besides their states.

use bevy::math::DVec3;

use crate::lab::simulation::Simulation;
use crate::physics::{BodyState, Inertia, Mass, RigidBody};

/// A dynamic body.
pub(super) struct Moving {
    /// Its place in the scene.
    pub index: usize,
    /// kg.
    pub mass: f64,
    /// Principal moments, kg·m².
    pub inertia: DVec3,
    /// What pulls it, m/s².
    pub gravity: DVec3,
    /// What else pushes it, N.
    pub force: DVec3,
    /// Smallest full extent, m.
    pub size: f64,
    /// Radius of the ball about its centre that holds it, m; 0 where it has no shape.
    pub radius: f64,
}

/// The dynamic bodies of a scene, in its order. Masses are known from the first step on.
pub(super) fn moving(simulation: &Simulation) -> Vec<Moving> {
    let scene = simulation.scene();
    let bodies = scene.bodies.iter().zip(&simulation.entities().bodies).enumerate();
    bodies
        .filter(|(_, (body, _))| body.kind == RigidBody::Dynamic)
        .filter_map(|(index, (body, &entity))| {
            let mass = simulation.world().get::<Mass>(entity)?.0;
            let inertia = simulation.world().get::<Inertia>(entity)?.0;
            let size = body.shape.as_ref().map_or(f64::INFINITY, |shape| shape.smallest_extent());
            let radius = body.shape.as_ref().map_or(0.0, |shape| shape.bounding_radius());
            let (gravity, force) = (scene.gravity * body.gravity_scale, body.force);
            Some(Moving { index, mass, inertia, gravity, force, size, radius })
        })
        .collect()
}

impl Moving {
    /// Kinetic energy, J.
    pub fn kinetic_energy(&self, states: &[BodyState]) -> f64 {
        let BodyState { rotation, linear, angular, .. } = states[self.index];
        let spin = rotation.inverse() * angular;
        0.5 * (self.mass * linear.length_squared() + (self.inertia * spin).dot(spin))
    }

    /// I ω, world axes, kg·m²/s.
    pub fn spin_momentum(&self, states: &[BodyState]) -> DVec3 {
        let BodyState { rotation, angular, .. } = states[self.index];
        rotation * (self.inertia * (rotation.inverse() * angular))
    }
}
