//! What the step tells the rest of a game. All are messages that any system can poll with a
//! `MessageReader`; those with an event target are also triggered as entity events.

use bevy::math::DVec3;
use bevy::prelude::*;

use super::{QuarantineReason, Quarantined};

/// Two bodies touch that did not in the step before. As an entity event it is triggered for
/// each of the two that has [`super::ObserveContacts`], with that one as `a`.
#[derive(Message, EntityEvent, Clone, Copy, Debug, PartialEq, Eq)]
pub struct ContactStarted {
    /// One body.
    #[event_target]
    pub a: Entity,
    /// The other.
    pub b: Entity,
}

/// Two bodies no longer touch, or one of them is gone. As an entity event like
/// [`ContactStarted`].
#[derive(Message, EntityEvent, Clone, Copy, Debug, PartialEq, Eq)]
pub struct ContactEnded {
    /// One body.
    #[event_target]
    pub a: Entity,
    /// The other.
    pub b: Entity,
}

/// A body came into a sensor. As an entity event it is triggered for the sensor.
#[derive(Message, EntityEvent, Clone, Copy, Debug, PartialEq, Eq)]
pub struct SensorStarted {
    /// The sensor.
    #[event_target]
    pub sensor: Entity,
    /// What came.
    pub body: Entity,
}

/// A body left a sensor, or one of them is gone. As an entity event it is triggered for the sensor if that is still there.
#[derive(Message, EntityEvent, Clone, Copy, Debug, PartialEq, Eq)]
pub struct SensorEnded {
    /// The sensor.
    #[event_target]
    pub sensor: Entity,
    /// What left.
    pub body: Entity,
}

/// One contact point of one step, written for bodies with [`super::ReportCollisions`] while they or what they touch are
/// awake.
#[derive(Message, Clone, Copy, Debug, PartialEq)]
pub struct Collision {
    /// One body.
    pub a: Entity,
    /// The other.
    pub b: Entity,
    /// World position, m.
    pub point: DVec3,
    /// Unit normal from A to B.
    pub normal: DVec3,
    /// Overlap along the normal, m.
    pub depth: f64,
    /// Velocity of B's point relative to A's when the contact was found, m/s.
    pub relative_velocity: DVec3,
    /// Simulation time at which the contact was found, s.
    pub time: f64,
}

/// A joint carried more than it bears and broke at the end of the step. Also an entity event.
#[derive(Message, EntityEvent, Clone, Copy, Debug, PartialEq)]
pub struct JointBroke {
    /// The joint; it is marked [`BrokenJoint`](super::BrokenJoint).
    #[event_target]
    pub joint: Entity,
    /// Norm of its mean force over the window, N.
    pub force: f64,
    /// Norm of its mean torque about the anchor, N·m.
    pub torque: f64,
}

/// A joint came to a limit at which it was not in the step before. Also an entity event.
#[derive(Message, EntityEvent, Clone, Copy, Debug, PartialEq)]
pub struct LimitReached {
    /// The joint.
    #[event_target]
    pub joint: Entity,
    /// Simulation time at the end of that step, s.
    pub time: f64,
    /// How fast its coordinate changed, rad/s or m/s.
    pub speed: f64,
}

/// A body (or joint) made no sense and was frozen; the rest goes on. Also an entity event.
#[derive(Message, EntityEvent, Clone, Copy, Debug, PartialEq, Eq)]
pub struct BodyQuarantined {
    /// The body or joint.
    pub entity: Entity,
    /// What was wrong.
    pub reason: QuarantineReason,
}

/// Sets a body or joint aside and tells all who listen.
pub(crate) fn set_aside(
    entity: Entity,
    reason: QuarantineReason,
    commands: &mut Commands,
    messages: &mut MessageWriter<BodyQuarantined>,
) {
    commands.entity(entity).insert(Quarantined { reason });
    commands.trigger(BodyQuarantined { entity, reason });
    messages.write(BodyQuarantined { entity, reason });
}
