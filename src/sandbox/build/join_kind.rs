//! What kinds of joints two clicks can make.

use std::f64::consts::TAU;

use bevy::math::DVec3;
use bevy::prelude::*;

use crate::physics::{
    BallJoint, DistanceJoint, FixedJoint, HingeJoint, Mass, Position, RigidBody, Rotation, SliderJoint,
};
use crate::sandbox::Picked;
use crate::scene::JointComponent;

/// Of a spring between two bodies, by their masses, Hz: firm, and seen to swing.
const FREQUENCY: f64 = 5.0;
/// Share of the critical damping that a spring has: it comes to rest within a second or two.
const DAMPING_RATIO: f64 = 0.1;

/// What [`SandboxAction::JoinPicked`](crate::sandbox::SandboxAction::JoinPicked) makes.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum JoinKind {
    /// A point, where the second body was clicked.
    #[default]
    Ball,
    /// An axis there, normal to the face that was hit.
    Hinge,
    /// A way along that axis.
    Slider,
    /// All.
    Fixed,
    /// The distance of the two places that were clicked.
    Rod,
    /// At most that distance.
    Rope,
    /// A spring of that length.
    Spring,
}

impl JoinKind {
    /// All of them, as the panel lists them: what each is called, and what it does.
    pub const ALL: [(Self, &str, &str); 7] = [
        (Self::Ball, "ball", "holds a point, where the second body was clicked"),
        (Self::Hinge, "hinge", "turns about an axis, normal to the face of the second body that was clicked"),
        (Self::Slider, "slider", "slides along an axis, normal to the face of the second body that was clicked"),
        (Self::Fixed, "fixed", "holds the two as they stand"),
        (Self::Rod, "rod", "keeps the distance of the two places that were clicked"),
        (Self::Rope, "rope", "lets them come nearer, but not farther apart"),
        (Self::Spring, "spring", "pulls them back to the distance that they have now"),
    ];

    /// Whether it has an axis, which the second click decides.
    pub(in crate::sandbox) fn has_axis(self) -> bool {
        matches!(self, Self::Hinge | Self::Slider)
    }

    /// The joint of that kind at two picked places, as they lie now.
    pub(super) fn between(self, world: &World, a: Picked, b: Picked) -> Result<JointComponent, String> {
        const GONE: &str = "a picked body is gone";
        let place = place_of(world, b.entity, b.point).ok_or(GONE)?;
        let length = place_of(world, a.entity, a.point).ok_or(GONE)?.distance(place);
        let anchor = anchor_at(world, a.entity, place).ok_or(GONE)?;
        let (bodies, at_place) = ((a.entity, b.entity), (anchor, b.point));
        let axis = || {
            let normal = b.normal.ok_or("the second click hit no face to take an axis from: click it again")?;
            Ok::<_, String>(world.get::<Rotation>(b.entity).ok_or(GONE)?.0 * normal)
        };
        let apart = |joint: fn(Entity, Entity, f64) -> DistanceJoint| match length > 0.0 {
            true => Ok(JointComponent::Distance(joint(bodies.0, bodies.1, length).with_anchors(a.point, b.point))),
            false => Err("the two places that were clicked are the same: there is no length between them".to_owned()),
        };
        match self {
            Self::Ball => {
                let joint = BallJoint::new(bodies.0, bodies.1).with_anchors(at_place.0, at_place.1);
                Ok(JointComponent::Ball(joint))
            }
            Self::Hinge => {
                let joint = HingeJoint::new(bodies.0, bodies.1).with_anchors(at_place.0, at_place.1);
                Ok(JointComponent::Hinge(joint.with_axis(axis()?)))
            }
            Self::Slider => {
                let joint = SliderJoint::new(bodies.0, bodies.1).with_anchors(at_place.0, at_place.1);
                Ok(JointComponent::Slider(joint.with_axis(axis()?)))
            }
            Self::Fixed => {
                let joint = FixedJoint::new(bodies.0, bodies.1).with_anchors(at_place.0, at_place.1);
                Ok(JointComponent::Fixed(joint))
            }
            Self::Rod => apart(DistanceJoint::rod),
            Self::Rope => apart(DistanceJoint::rope),
            Self::Spring => {
                let (mass, omega) = (reduced_mass(world, [a.entity, b.entity]), TAU * FREQUENCY);
                let (stiffness, damping) = (mass * omega * omega, 2.0 * DAMPING_RATIO * omega * mass);
                let joint = DistanceJoint::spring(bodies.0, bodies.1, length, stiffness, damping);
                Ok(JointComponent::Distance(joint.with_anchors(a.point, b.point)))
            }
        }
    }
}

/// Of what moves, kg; 1 where that is not known yet.
fn reduced_mass(world: &World, bodies: [Entity; 2]) -> f64 {
    let moving = bodies.into_iter().filter(|body| world.get::<RigidBody>(*body) == Some(&RigidBody::Dynamic));
    let inverse: f64 = moving.filter_map(|body| Some(1.0 / world.get::<Mass>(body)?.0)).sum();
    if inverse > 0.0 { 1.0 / inverse } else { 1.0 }
}

/// A point of a body, from its centre of mass, body axes, in the world, m.
pub fn place_of(world: &World, body: Entity, point: DVec3) -> Option<DVec3> {
    let body = world.get_entity(body).ok()?;
    Some(body.get::<Position>()?.0 + body.get::<Rotation>()?.0 * point)
}

/// A place of the world from a body's centre of mass, body axes, m.
pub fn anchor_at(world: &World, body: Entity, place: DVec3) -> Option<DVec3> {
    let body = world.get_entity(body).ok()?;
    Some(body.get::<Rotation>()?.0.inverse() * (place - body.get::<Position>()?.0))
}
