//! The data of a body. Plain numbers in SI; [`SceneSpec::validate`](super::SceneSpec::validate) says what they may be.

use bevy::math::{DQuat, DVec3};

use super::ShapeSpec;
use crate::physics::{CollisionLayers, LockedAxes, RigidBody};

/// What joints call the fixed world.
pub(super) const WORLD: &str = "world";

/// What the names of the bodies start with that joints to the world are made to.
pub(super) const WORLD_PREFIX: &str = "world:";

/// One body.
#[derive(Clone, Debug, PartialEq)]
pub struct BodySpec {
    /// Unique in the scene; joints refer to it.
    pub name: String,
    /// Dynamic, kinematic or static.
    pub kind: RigidBody,
    /// None: a point to pin things to (static or kinematic only, unless mass and inertia are given).
    pub shape: Option<ShapeSpec>,
    /// kg/m³; the mass wins where both are given.
    pub density: f64,
    /// kg.
    pub mass: Option<f64>,
    /// Principal moments about the centre of mass, kg·m²; see [`ShapeSpec::axes`].
    pub inertia: Option<DVec3>,
    /// Centre of mass, m.
    pub position: DVec3,
    /// Orientation of the axes that the shape is given in.
    pub rotation: DQuat,
    /// m/s.
    pub linear_velocity: DVec3,
    /// rad/s, world axes.
    pub angular_velocity: DVec3,
    /// N, lasts.
    pub force: DVec3,
    /// N·m, lasts.
    pub torque: DVec3,
    /// Surface.
    pub material: MaterialSpec,
    /// What it touches.
    pub layers: CollisionLayers,
    /// Whether its shape only reports what is in it.
    pub sensor: bool,
    /// World axes it does not move along or about.
    pub locked: LockedAxes,
    /// Factor on gravity.
    pub gravity_scale: f64,
    /// Linear and angular drag, 1/s.
    pub damping: (f64, f64),
    /// sRGB colour in the picture, 0 to 1 each; none: chosen from the shape.
    pub color: Option<[f32; 3]>,
}

/// Friction and restitution of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MaterialSpec {
    /// μ ≥ 0.
    pub friction: f64,
    /// e, 0 to 1.
    pub restitution: f64,
}

impl BodySpec {
    /// A dynamic body of that name, shape and centre of mass, all else at its default.
    pub fn new(name: impl Into<String>, shape: ShapeSpec, position: DVec3) -> Self {
        Self {
            name: name.into(),
            kind: RigidBody::Dynamic,
            shape: Some(shape),
            density: 1000.0,
            mass: None,
            inertia: None,
            position,
            rotation: DQuat::IDENTITY,
            linear_velocity: DVec3::ZERO,
            angular_velocity: DVec3::ZERO,
            force: DVec3::ZERO,
            torque: DVec3::ZERO,
            material: MaterialSpec { friction: 0.6, restitution: 0.0 },
            layers: CollisionLayers::ALL,
            sensor: false,
            locked: LockedAxes::default(),
            gravity_scale: 1.0,
            damping: (0.0, 0.0),
            color: None,
        }
    }

    /// A static body without a shape, to join others to: a point of the world.
    pub fn pin(name: impl Into<String>, position: DVec3) -> Self {
        Self { kind: RigidBody::Static, shape: None, ..Self::new(name, ShapeSpec::HalfSpace, position) }
    }

    /// The ground: a static half-space, level, its surface through the origin, named "ground".
    pub fn ground() -> Self {
        Self { kind: RigidBody::Static, ..Self::new("ground", ShapeSpec::HalfSpace, DVec3::ZERO) }
    }

    /// Whether it is what a scene file's joints to `"world"` are made to: a point that stands still,
    /// under a name that files cannot give.
    pub(super) fn stands_for_world(&self) -> bool {
        self.name.starts_with(WORLD_PREFIX) && *self == Self::pin(&self.name, self.position)
    }

    /// Whether it has a name that is kept for the world, and is not it.
    pub(super) fn name_is_reserved(&self) -> bool {
        (self.name == WORLD || self.name.starts_with(WORLD_PREFIX)) && !self.stands_for_world()
    }

    /// Makes it static.
    pub fn fixed(self) -> Self {
        Self { kind: RigidBody::Static, ..self }
    }

    /// Sets the mass, kg.
    pub fn with_mass(self, mass: f64) -> Self {
        Self { mass: Some(mass), ..self }
    }

    /// Sets the orientation.
    pub fn with_rotation(self, rotation: DQuat) -> Self {
        Self { rotation, ..self }
    }

    /// Sets the linear velocity, m/s, and the angular, rad/s, both in world axes.
    pub fn with_velocity(self, linear: DVec3, angular: DVec3) -> Self {
        Self { linear_velocity: linear, angular_velocity: angular, ..self }
    }

    /// Sets friction and restitution.
    pub fn with_material(self, friction: f64, restitution: f64) -> Self {
        Self { material: MaterialSpec { friction, restitution }, ..self }
    }

    /// Sets the colour, sRGB, 0 to 1 each.
    pub fn with_color(self, color: [f32; 3]) -> Self {
        Self { color: Some(color), ..self }
    }

    /// Makes it touch nothing: its shape gives mass, inertia and a picture.
    pub fn without_collision(self) -> Self {
        Self { layers: CollisionLayers::NONE, ..self }
    }

    /// Orientation of the principal axes, the simulated body's: that of the axes which the shape is
    /// given in, but for hulls and compounds that lie askew in these.
    pub fn principal_rotation(&self) -> DQuat {
        let axes = self.shape.as_ref().and_then(ShapeSpec::own_axes);
        axes.map_or(self.rotation, |axes| self.rotation * axes)
    }

    /// A point of the world, m, as this body's anchor: from its centre of mass, in its own axes.
    pub fn anchor(&self, point: DVec3) -> DVec3 {
        self.rotation.inverse() * (point - self.position)
    }

    /// A point of this body, from its centre of mass in its own axes, as a point of the world, m.
    pub fn point(&self, anchor: DVec3) -> DVec3 {
        self.position + self.rotation * anchor
    }
}
