//! The ball joint: a point of one body stays at a point of another (3 rows).

use bevy::ecs::entity::{EntityMapper, MapEntities};
use bevy::math::DVec3;
use bevy::prelude::*;

use super::definition::{Frame, JointDefinition, Laws};
use super::kind::JointKind;
use super::softness::Softness;

/// Holds `anchor_a` of `body_a` at `anchor_b` of `body_b`, free to rotate. An entity of its own.
///
/// Joined bodies do not collide unless [`collide`](Self::collide) says so. Despawning a body
/// despawns its joints.
///
/// ```
/// # use plumb::prelude::*;
/// # use bevy::prelude::*;
/// # use bevy::math::DVec3;
/// # fn setup(mut commands: Commands) {
/// let post = commands.spawn((RigidBody::Static, Transform::from_xyz(0., 2., 0.))).id();
/// let bob = commands
///     .spawn((RigidBody::Dynamic, Collider::sphere(0.2), Transform::from_xyz(1., 2., 0.)))
///     .id();
/// commands.spawn(BallJoint::new(post, bob).with_anchors(DVec3::ZERO, -DVec3::X));
/// # }
/// ```
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component, Debug, PartialEq)]
#[component(map_entities)]
pub struct BallJoint {
    /// One body.
    pub body_a: Entity,
    /// The other body.
    pub body_b: Entity,
    /// The joint's point on A: from its centre of mass, body axes, m.
    pub anchor_a: DVec3,
    /// The joint's point on B: from its centre of mass, body axes, m.
    pub anchor_b: DVec3,
    /// Whether the joined bodies collide with each other (default: no).
    pub collide: bool,
    /// A spring and damper instead of a rigid joint (default: rigid).
    pub softness: Option<Softness>,
}

impl BallJoint {
    /// Joins the centres of mass of two bodies.
    pub fn new(body_a: Entity, body_b: Entity) -> Self {
        Self { body_a, body_b, anchor_a: DVec3::ZERO, anchor_b: DVec3::ZERO, collide: false, softness: None }
    }

    /// Sets the points joined: from each centre of mass, in body axes, m.
    pub fn with_anchors(mut self, anchor_a: DVec3, anchor_b: DVec3) -> Self {
        self.anchor_a = anchor_a;
        self.anchor_b = anchor_b;
        self
    }

    /// Lets the joined bodies collide with each other.
    pub fn with_collision(mut self) -> Self {
        self.collide = true;
        self
    }

    /// Makes the joint a damped spring.
    pub fn with_softness(mut self, softness: Softness) -> Self {
        self.softness = Some(softness);
        self
    }
}

impl MapEntities for BallJoint {
    fn map_entities<M: EntityMapper>(&mut self, mapper: &mut M) {
        self.body_a = mapper.get_mapped(self.body_a);
        self.body_b = mapper.get_mapped(self.body_b);
    }
}

impl JointKind for BallJoint {
    fn definition(&self) -> JointDefinition {
        JointDefinition {
            bodies: [self.body_a, self.body_b],
            frames: [Frame::at(self.anchor_a), Frame::at(self.anchor_b)],
            translation: Laws { spring: self.softness, ..Laws::LOCKED },
            collide: self.collide,
            ..default()
        }
    }
}
