//! `Transform` as output and as input.
//!
//! Out: after the fixed loop, each body's `Transform` is its pose interpolated between the last
//! two steps, minus [`RenderOrigin`]. In: Plumb remembers the bits it last wrote; a `Transform`
//! that differs in any bit is the user's and teleports the body (velocity kept, no
//! interpolation).

use bevy::math::{DQuat, DVec3};
use bevy::prelude::*;

use super::{PoseHistory, Position, RenderOrigin, RigidBody, Rotation, Sleeping, bits};

/// What is written of a body that is put somewhere else.
type Placed = (&'static mut Position, &'static mut Rotation, &'static mut PoseHistory, &'static mut Transform);

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

/// Writes transforms at once: something was done since the fixed loop, and the next picture is to show it.
///
/// # Errors
/// The world has no [`PhysicsPlugin`](super::PhysicsPlugin).
pub fn write_now(world: &mut World) -> Result {
    Ok(world.run_system_cached(write_interpolated)?)
}

/// Puts a body somewhere else between two steps, with its velocity: the centre of mass, m, and its orientation. It is drawn
/// there at once, and not on the way. Tells whether there is such a body.
pub fn place(world: &mut World, body: Entity, position: DVec3, rotation: DQuat) -> bool {
    let origin = world.get_resource::<RenderOrigin>().copied().unwrap_or_default();
    let mut bodies = world.query_filtered::<Placed, With<RigidBody>>();
    let Ok((mut own_position, mut own_rotation, mut history, mut transform)) = bodies.get_mut(world, body) else {
        return false;
    };
    own_position.set_if_neq(Position(position));
    own_rotation.set_if_neq(Rotation(rotation));
    *transform = Transform {
        translation: (position - origin.0).as_vec3(),
        rotation: rotation.as_quat(),
        scale: transform.scale,
    };
    *history.bypass_change_detection() = PoseHistory { previous: None, written: Some(*transform) };
    true
}

/// Has transforms be those of the last poses until the next step, and not between two: for a world that [`go_to`](super::go_to)
/// has brought to where it is.
pub fn stand_still(world: &mut World) {
    for mut history in world.query::<&mut PoseHistory>().iter_mut(world) {
        history.bypass_change_detection().previous = None;
    }
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
