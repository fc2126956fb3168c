//! What the next body is to be.

use bevy::math::DVec3;
use bevy::prelude::*;

use crate::scene::{BodySpec, ShapeSpec};

/// What [`SandboxAction::SpawnBody`](crate::sandbox::SandboxAction::SpawnBody) makes.
#[derive(Resource, Clone, Debug, PartialEq)]
pub struct Blueprint {
    /// Shape with its sizes, m.
    pub shape: ShapeSpec,
    /// How heavy it is.
    pub weight: Weight,
}

/// How a body's mass is given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Weight {
    /// kg/m³.
    Density(f64),
    /// kg.
    Mass(f64),
}

impl Default for Blueprint {
    fn default() -> Self {
        Self { shape: ShapeSpec::Cuboid { size: DVec3::splat(0.5) }, weight: Weight::Density(1000.0) }
    }
}

impl Blueprint {
    /// kg.
    pub fn mass(&self) -> f64 {
        match self.weight {
            Weight::Density(density) => density * self.shape.volume(),
            Weight::Mass(mass) => mass,
        }
    }

    /// What bodies of it are called, before a number is added.
    pub(super) fn noun(&self) -> &str {
        match self.shape {
            ShapeSpec::Sphere { .. } => "ball",
            ShapeSpec::Cuboid { .. } => "box",
            ShapeSpec::Cone { .. } => "cone",
            ShapeSpec::HalfSpace => "ground",
            ShapeSpec::Hull(_) => "block",
            ShapeSpec::Mesh(_) => "mesh",
        }
    }

    /// A body of it at the origin.
    pub(super) fn body(&self, name: String) -> BodySpec {
        let body = BodySpec::new(name, self.shape.clone(), DVec3::ZERO);
        match self.weight {
            Weight::Density(density) => BodySpec { density, ..body },
            Weight::Mass(mass) => body.with_mass(mass),
        }
    }
}
