//! The components a body is made of. A body is a root entity with [`RigidBody`]; everything
//! else is optional or filled in at its first step.
//!
//! All quantities are SI and world-space unless stated. Poses are `f64`: the `Transform` that
//! Bevy renders is an output (see [`crate::physics::transform`]).

use bevy::ecs::lifecycle::HookContext;
use bevy::ecs::world::DeferredWorld;
use bevy::math::{DQuat, DVec3};
use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use super::{BirthCounter, BodySlot, GatheredWith, PoseHistory, RenderOrigin};

/// Whether the solver moves a body. Adding it makes an entity a body.
///
/// A body that has no [`Position`] takes its pose from its `Transform`.
#[derive(Component, Reflect, Serialize, Deserialize, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[reflect(Component, Debug, Default, PartialEq)]
#[require(Transform, Velocity, PoseHistory, BodySlot, GatheredWith)]
#[component(on_add = enter_world)]
pub enum RigidBody {
    /// Moved by forces, contacts and joints.
    #[default]
    Dynamic,
    /// Moved by its own [`Velocity`] alone; pushes and is never pushed.
    Kinematic,
    /// Never moves by itself.
    Static,
}

/// Numbers the body and gives it a pose. `Position` and `Rotation` are not required components:
/// only so can a body that was given a pose be told from one that was not.
fn enter_world(mut world: DeferredWorld, context: HookContext) {
    let born = world.get_resource_mut::<BirthCounter>().map_or(0, |mut counter| counter.next());
    if let Some(mut slot) = world.get_mut::<BodySlot>(context.entity) {
        *slot = BodySlot { born, ..default() };
    }
    if let Some(mut gathered_with) = world.get_mut::<GatheredWith>(context.entity) {
        *gathered_with = GatheredWith::NOTHING;
    }
    let body = world.entity(context.entity);
    let transform = body.get::<Transform>().copied().unwrap_or_default();
    let has_position = body.contains::<Position>();
    let has_rotation = body.contains::<Rotation>();
    let origin = world.get_resource::<RenderOrigin>().map_or(DVec3::ZERO, |origin| origin.0);
    if let Some(mut history) = world.get_mut::<PoseHistory>(context.entity) {
        // Taken over here; from now on a change of it is a teleport.
        *history = PoseHistory { previous: None, written: Some(transform) };
    }
    let mut commands = world.commands();
    let mut body = commands.entity(context.entity);
    if !has_position {
        body.insert(Position(transform.translation.as_dvec3() + origin));
    }
    if !has_rotation {
        body.insert(Rotation(transform.rotation.as_dquat()));
    }
}

/// World position of the centre of mass, m. A cone's is a quarter of its height above its base.
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq, Deref, DerefMut)]
#[reflect(Component, Debug, Default, PartialEq)]
pub struct Position(pub DVec3);

/// World orientation of the body's principal axes; kept at unit length by the step.
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq, Deref, DerefMut)]
#[reflect(Component, Debug, Default, PartialEq)]
pub struct Rotation(pub DQuat);

/// Velocity of the centre of mass, m/s, and angular velocity in world axes, rad/s.
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Component, Debug, Default, PartialEq)]
pub struct Velocity {
    /// m/s.
    pub linear: DVec3,
    /// rad/s, world axes.
    pub angular: DVec3,
}

/// A force through the centre of mass, N, and a torque, N·m, in world axes. Both last until
/// changed.
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Component, Debug, Default, PartialEq)]
pub struct ExternalForce {
    /// N.
    pub force: DVec3,
    /// N·m.
    pub torque: DVec3,
}

/// Density of the collider, kg/m³; without it 1000 (water). Ignored where [`Mass`] is given.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component, Debug, Default, PartialEq)]
pub struct Density(pub f64);

impl Default for Density {
    fn default() -> Self {
        Self(1000.0)
    }
}

/// Mass, kg, positive. Computed from the collider and [`Density`] at the first step where it
/// was not given.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component, Debug, PartialEq)]
pub struct Mass(pub f64);

/// Principal moments of inertia about the centre of mass in body axes, kg·m², positive.
/// Computed from the collider and the mass at the first step where it was not given.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component, Debug, PartialEq)]
pub struct Inertia(pub DVec3);

/// Friction and restitution of a body's surface. A pair has μ = √(μ_A μ_B) and
/// e = max(e_A, e_B).
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component, Debug, Default, PartialEq)]
pub struct SurfaceMaterial {
    /// Coulomb coefficient μ ≥ 0.
    pub friction: f64,
    /// Coefficient of restitution e, 0 to 1.
    pub restitution: f64,
}

impl Default for SurfaceMaterial {
    fn default() -> Self {
        Self { friction: 0.6, restitution: 0.0 }
    }
}

impl SurfaceMaterial {
    /// The material of a pair of touching surfaces.
    pub fn pair(self, other: Self) -> Self {
        Self { friction: (self.friction * other.friction).sqrt(), restitution: self.restitution.max(other.restitution) }
    }
}

/// Which bodies may touch: each must be a member of a layer that the other filters for.
#[derive(Component, Reflect, Serialize, Deserialize, Clone, Copy, Debug, PartialEq, Eq)]
#[reflect(Component, Debug, Default, PartialEq)]
#[serde(default, deny_unknown_fields)]
pub struct CollisionLayers {
    /// The layers this body is in, one bit each.
    pub memberships: u32,
    /// The layers it collides with, one bit each.
    pub filters: u32,
}

impl CollisionLayers {
    /// In every layer, touching every layer (the default).
    pub const ALL: Self = Self { memberships: u32::MAX, filters: u32::MAX };
    /// In no layer: the collider gives mass, inertia and a picture, and touches nothing.
    pub const NONE: Self = Self { memberships: 0, filters: 0 };

    /// Whether two bodies with these layers may touch.
    pub fn interact(self, other: Self) -> bool {
        self.memberships & other.filters != 0 && other.memberships & self.filters != 0
    }

    /// Whether no other layers interact with these.
    pub(crate) fn touch_nothing(self) -> bool {
        self.memberships == 0 || self.filters == 0
    }
}

impl Default for CollisionLayers {
    fn default() -> Self {
        Self::ALL
    }
}

/// World axes along or about which a body does not move: its inverse mass is zero there.
#[derive(Component, Reflect, Serialize, Deserialize, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[reflect(Component, Debug, Default, PartialEq)]
#[serde(default, deny_unknown_fields)]
pub struct LockedAxes {
    /// Translation along x, y, z.
    pub translation: [bool; 3],
    /// Rotation about x, y, z.
    pub rotation: [bool; 3],
}

/// Factor on [`crate::physics::Gravity`] for one body (default 1).
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component, Debug, Default, PartialEq)]
pub struct GravityScale(pub f64);

impl Default for GravityScale {
    fn default() -> Self {
        Self(1.0)
    }
}

/// Drag on one body, 1/s, both ≥ 0: v ← v/(1 + c h) each (sub)step, added to
/// [`crate::physics::SolverSettings::drag`].
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Component, Debug, Default, PartialEq)]
pub struct Damping {
    /// c for the linear velocity, 1/s.
    pub linear: f64,
    /// c for the angular velocity, 1/s.
    pub angular: f64,
}

/// Asks for a [`crate::physics::Collision`] message per contact point and step of this body.
#[derive(Component, Reflect, Clone, Copy, Debug, Default)]
#[reflect(Component, Debug, Default)]
pub struct ReportCollisions;

/// Asks for [`crate::physics::ContactStarted`] and [`crate::physics::ContactEnded`] as entity events on this body.
#[derive(Component, Reflect, Clone, Copy, Debug, Default)]
#[reflect(Component, Debug, Default)]
pub struct ObserveContacts;

/// On a body while it sleeps: its island came to rest, and nothing in it is looked at until something disturbs it.
///
/// The step puts it on and takes it off. Who takes it off wakes the island; who puts it on achieves nothing.
#[derive(Component, Reflect, Clone, Copy, Debug, Default)]
#[reflect(Component, Debug, Default)]
pub struct Sleeping;

/// Set on a body or joint that the step leaves alone because its state makes no sense; the
/// reason says what to mend. A quarantined body stands still at its last finite pose and acts
/// as a static one. Remove the component to let it go again.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq, Eq)]
#[reflect(Component, Debug, PartialEq)]
pub struct Quarantined {
    /// What was wrong.
    pub reason: QuarantineReason,
}

/// Why an entity was quarantined.
#[derive(Reflect, Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum QuarantineReason {
    /// A pose, velocity or force was NaN or infinite.
    #[error("its state is not finite")]
    NotFinite,
    /// The body has a parent entity.
    #[error("a body must be a root entity, and this one has a parent")]
    HasParent,
    /// Mass, inertia, density or size is zero, negative or not finite, or none can be computed.
    #[error("mass, inertia, density and sizes must be finite and positive")]
    BadMass,
    /// Friction below 0 or restitution outside 0 to 1, drag below 0, or one of them not finite.
    #[error("friction and drag must be at least 0, restitution 0 to 1")]
    BadMaterial,
    /// A joint of a body to itself, or between two bodies that do not move.
    #[error("a joint needs two different bodies, one of them dynamic")]
    BadJoint,
    /// Limits, a motor or friction beside a joint that has no such coordinate.
    #[error("its joint has no coordinate that limits, a motor or friction could act on")]
    NoSuchAxis,
    /// Limits in the wrong order or out of range, a restitution outside 0 to 1, a negative stiffness, damping, largest
    /// force or strength, or one of them not finite.
    #[error(
        "limits must be in order, swings and twists within half a turn, restitution 0 to 1, stiffness, damping and \
         largest forces at least 0, strengths over 0"
    )]
    BadJointLaw,
}

/// Marks a body whose collider only reports what overlaps or touches it, and neither pushes nor is pushed: no contact, no
/// row. It is told after each step of bodies whose [`CollisionLayers`] go with its own, by
/// [`SensorStarted`](crate::physics::SensorStarted) and [`SensorEnded`](crate::physics::SensorEnded); not of other sensors,
/// nor of static bodies where it is static itself. It may be of any kind and on joints.
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[reflect(Component, Debug, Default, PartialEq)]
pub struct Sensor;
