//! Shapes: their volume, inertia, bounding sphere and geometry. One file a shape.
//!
//! A collider is centred on its body's centre of mass, in principal axes.

use bevy::math::DVec3;
use bevy::prelude::*;

/// The shape of a body, one per body, centred on its centre of mass. Sizes are full and in m.
#[derive(Component, Reflect, Clone, Debug, PartialEq)]
#[reflect(Component, Debug, PartialEq)]
pub struct Collider {
    shape: Shape,
}

/// What a [`Collider`] is.
#[derive(Reflect, Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// All points on and below the plane through the body's position, normal +y in body axes.
    /// Static bodies only.
    HalfSpace,
    /// A ball.
    Sphere {
        /// Radius, m.
        radius: f64,
    },
    /// A box.
    Cuboid {
        /// Full extents along x, y, z, m.
        size: DVec3,
    },
    /// A circular cone, apex up +y; the centre of mass is a quarter of the height above the base.
    Cone {
        /// Radius of the base, m.
        radius: f64,
        /// Height, m.
        height: f64,
    },
}

/// What a shape weighs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MassProperties {
    /// kg.
    pub mass: f64,
    /// Principal moments about the centre of mass, kg·m².
    pub inertia: DVec3,
}

impl Collider {
    /// All points on and below a plane, normal +y.
    pub fn half_space() -> Self {
        Self { shape: Shape::HalfSpace }
    }

    /// A ball of that radius, m.
    pub fn sphere(radius: f64) -> Self {
        Self { shape: Shape::Sphere { radius } }
    }

    /// A box of those full sizes, m.
    pub fn cuboid(x: f64, y: f64, z: f64) -> Self {
        Self { shape: Shape::Cuboid { size: DVec3::new(x, y, z) } }
    }

    /// A cone of that base radius and height, m, apex up +y.
    pub fn cone(radius: f64, height: f64) -> Self {
        Self { shape: Shape::Cone { radius, height } }
    }

    /// What it is.
    pub fn shape(&self) -> Shape {
        self.shape
    }
}

/// A shape ready for collision.
#[derive(Clone, Debug)]
pub(crate) enum Geometry {}
