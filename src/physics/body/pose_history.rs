//! The pose before the last step and the transform that was last written: what interpolation starts from, and how a
//! `Transform` of the user is told from one of Plumb.

use bevy::math::{DQuat, DVec3};
use bevy::prelude::*;

/// The point of the world, m, that is drawn at Bevy's origin. Near the camera, `f32` transforms
/// stay exact however far from the origin a scene lies.
#[derive(Resource, Reflect, Clone, Copy, Debug, Default, PartialEq, Deref, DerefMut)]
#[reflect(Resource, Debug, Default, PartialEq)]
pub struct RenderOrigin(pub DVec3);

/// The pose before the last step, and the transform last written.
#[derive(Component, Clone, Copy, Debug, Default)]
pub(crate) struct PoseHistory {
    /// `None` until the body's first step: nothing to interpolate from.
    pub previous: Option<(DVec3, DQuat)>,
    /// At first what the body was spawned with. `None` only before it is a body.
    pub written: Option<Transform>,
}

impl PoseHistory {
    /// Whether `transform` is the user's: not what was last written, bit by bit.
    pub fn is_foreign(&self, transform: &Transform) -> bool {
        self.written.is_some_and(|written| bits(&written) != bits(transform))
    }
}

/// Scale is the user's own: physics neither reads nor writes it.
pub(crate) fn bits(transform: &Transform) -> [u32; 7] {
    let (t, r) = (transform.translation, transform.rotation);
    [t.x, t.y, t.z, r.x, r.y, r.z, r.w].map(f32::to_bits)
}
