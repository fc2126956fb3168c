//! `Transform` as output and as input.
//!
//! Out: after the fixed loop, each body's `Transform` is its pose interpolated between the last
//! two steps, minus [`RenderOrigin`]. In: Plumb remembers the bits it last wrote; a `Transform`
//! that differs in any bit is the user's and teleports the body (velocity kept, no
//! interpolation).

use bevy::math::{DQuat, DVec3};
use bevy::prelude::*;

use super::body::{Position, RigidBody, Rotation, Sleeping};

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
fn bits(transform: &Transform) -> [u32; 7] {
    let (t, r) = (transform.translation, transform.rotation);
    [t.x, t.y, t.z, r.x, r.y, r.z, r.w].map(f32::to_bits)
}

/// What a transform is written from and to.
type Written = (
    &'static Position,
    &'static Rotation,
    &'static mut PoseHistory,
    &'static mut Transform,
    Option<Ref<'static, Sleeping>>,
);

/// Writes transforms between the last two poses; runs after the fixed loop.
pub(super) fn write_interpolated(
    fixed: Option<Res<Time<Fixed>>>,
    origin: Res<RenderOrigin>,
    bodies: Query<Written, With<RigidBody>>,
) {
    write(fixed.map_or(1.0, |fixed| fixed.overstep_fraction_f64()), origin, bodies);
}

/// Writes transforms of the last poses; runs after the step.
pub(super) fn write_latest(origin: Res<RenderOrigin>, bodies: Query<Written, With<RigidBody>>) {
    write(1.0, origin, bodies);
}

/// `alpha` is 0 at the pose before the last step, 1 at that after it.
fn write(alpha: f64, origin: Res<RenderOrigin>, mut bodies: Query<Written, With<RigidBody>>) {
    for (position, rotation, mut history, mut transform, sleeping) in &mut bodies {
        // What sleeps lies still: written when it has just fallen asleep, and when all is drawn elsewhere.
        if sleeping.is_some_and(|sleeping| !sleeping.is_added()) && !origin.is_changed() {
            continue;
        }
        if history.is_foreign(&transform) {
            continue; // taken over, and written again, by the next step
        }
        let (from_position, from_rotation) = history.previous.unwrap_or((position.0, rotation.0));
        let pose = Transform {
            translation: (from_position.lerp(position.0, alpha) - origin.0).as_vec3(),
            rotation: from_rotation.slerp(rotation.0, alpha).as_quat(),
            scale: transform.scale,
        };
        if bits(&pose) != bits(&transform) {
            *transform = pose;
        }
        history.written = Some(pose);
    }
}
