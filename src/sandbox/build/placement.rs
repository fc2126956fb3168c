//! Where a body is to be.

use bevy::math::{DQuat, DVec3};
use bevy::prelude::*;

use crate::scene::ShapeSpec;

/// Where [`SandboxAction::PlaceBodies`](crate::sandbox::SandboxAction::PlaceBodies) puts a body.
#[derive(Clone, Debug, PartialEq)]
pub struct Placement {
    /// The body.
    pub body: Entity,
    /// Its centre of mass, m.
    pub position: DVec3,
    /// Its orientation: of its principal axes.
    pub rotation: DQuat,
    /// Its shape, if that changes.
    pub shape: Option<ShapeSpec>,
}
