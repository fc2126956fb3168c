//! The drag that is going on, if there is one.

use bevy::math::DVec3;
use bevy::picking::pointer::PointerId;
use bevy::prelude::*;

use crate::physics::Damping;

/// The drag that is going on.
#[derive(Resource, Default)]
pub(super) struct Drag(pub Option<Held>);

impl Drag {
    pub fn is_active(&self) -> bool {
        self.0.is_some()
    }
}

/// Marks what a drag is made of: the handle and the joint.
#[derive(Component, Clone, Copy)]
pub(super) struct DragPart {
    pub body: Entity,
    /// The body's own, to be given back.
    pub damping: Option<Damping>,
}

/// What is held, and how.
pub(super) struct Held {
    pub body: Entity,
    /// From its centre of mass to the held point, body axes, m.
    pub anchor: DVec3,
    pub handle: Entity,
    pub pointer: PointerId,
    /// Of the plane in which the handle moves: from the camera along its view, m.
    pub depth: f64,
    /// Where the handle is to be, world, m.
    pub target: DVec3,
}
