//! The distance joint: a rod, a rope, a range or a spring between two points.

use bevy::ecs::entity::{EntityMapper, MapEntities};
use bevy::math::DVec3;
use bevy::prelude::*;

use super::definition::{Frame, JointDefinition};
use super::kind::JointKind;
use super::law::{CoordinateLaw, JointAxis, LawPart};
use super::motion::PrescribedMotion;

/// Keeps the distance of `anchor_a` of `body_a` and `anchor_b` of `body_b`. An entity of its own.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component, Debug, PartialEq)]
#[component(map_entities)]
pub struct DistanceJoint {
    /// One body.
    pub body_a: Entity,
    /// The other body.
    pub body_b: Entity,
    /// The joint's point on A: from its centre of mass, body axes, m.
    pub anchor_a: DVec3,
    /// The joint's point on B: from its centre of mass, body axes, m.
    pub anchor_b: DVec3,
    /// What the distance may be.
    pub length: DistanceLaw,
    /// Whether the joined bodies collide with each other (default: no).
    pub collide: bool,
}

/// What the distance of two points may be.
#[derive(Reflect, Clone, Copy, Debug, PartialEq)]
pub enum DistanceLaw {
    /// Between two lengths, m; the same twice is a rod, a least one of 0 a rope. The largest may be infinite.
    Range {
        /// Least.
        min: f64,
        /// Largest.
        max: f64,
    },
    /// Any, with a force towards a rest length.
    Spring {
        /// Length without force, m.
        rest: f64,
        /// N/m.
        stiffness: f64,
        /// N·s/m.
        damping: f64,
    },
}

impl DistanceJoint {
    fn new(body_a: Entity, body_b: Entity, length: DistanceLaw) -> Self {
        Self { body_a, body_b, anchor_a: DVec3::ZERO, anchor_b: DVec3::ZERO, length, collide: false }
    }

    /// A rod of that length, m, between the centres of mass.
    pub fn rod(body_a: Entity, body_b: Entity, length: f64) -> Self {
        Self::range(body_a, body_b, length, length)
    }

    /// A rope of that length, m, between the centres of mass.
    pub fn rope(body_a: Entity, body_b: Entity, length: f64) -> Self {
        Self::range(body_a, body_b, 0.0, length)
    }

    /// Keeps the centres of mass between two distances, m.
    pub fn range(body_a: Entity, body_b: Entity, min: f64, max: f64) -> Self {
        Self::new(body_a, body_b, DistanceLaw::Range { min, max })
    }

    /// A spring between the centres of mass: rest length, m, stiffness, N/m, and damping, N·s/m.
    pub fn spring(body_a: Entity, body_b: Entity, rest: f64, stiffness: f64, damping: f64) -> Self {
        Self::new(body_a, body_b, DistanceLaw::Spring { rest, stiffness, damping })
    }

    /// Sets the points joined: from each centre of mass, in body axes, m.
    pub fn with_anchors(self, anchor_a: DVec3, anchor_b: DVec3) -> Self {
        Self { anchor_a, anchor_b, ..self }
    }

    /// Lets the joined bodies collide with each other.
    pub fn with_collision(self) -> Self {
        Self { collide: true, ..self }
    }
}

impl DistanceLaw {
    fn laws(&self) -> Vec<CoordinateLaw> {
        let law = |part| CoordinateLaw::new(JointAxis::Distance, part);
        match *self {
            Self::Range { min, max } if min == max => vec![law(LawPart::Motion(PrescribedMotion::rest(min)))],
            Self::Range { min, max } => CoordinateLaw::range(JointAxis::Distance, [min, max], 0.0)
                .filter(|law| !matches!(law.part, LawPart::Limit { bound: 0.0, .. }))
                .collect(),
            Self::Spring { rest, stiffness, damping } => vec![law(LawPart::Spring { rest, stiffness, damping })],
        }
    }
}

impl MapEntities for DistanceJoint {
    fn map_entities<M: EntityMapper>(&mut self, mapper: &mut M) {
        self.body_a = mapper.get_mapped(self.body_a);
        self.body_b = mapper.get_mapped(self.body_b);
    }
}

impl JointKind for DistanceJoint {
    fn definition(&self) -> JointDefinition {
        JointDefinition {
            bodies: [self.body_a, self.body_b],
            frames: [Frame::at(self.anchor_a), Frame::at(self.anchor_b)],
            laws: Some(self.length.laws().into()),
            axis: Some(JointAxis::Distance),
            collide: self.collide,
            ..default()
        }
    }
}
