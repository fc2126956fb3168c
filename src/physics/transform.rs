//! `Transform` as output and as input.
//!
//! Out: after the fixed loop, each body's `Transform` is its pose interpolated between the last
//! two steps, minus [`RenderOrigin`]. In: Plumb remembers the bits it last wrote; a `Transform`
//! that differs in any bit is the user's and teleports the body (velocity kept, no
//! interpolation).

use bevy::math::{DQuat, DVec3};
use bevy::prelude::*;

use super::{PoseHistory, Position, RenderOrigin, RigidBody, Rotation, Sleeping, StepStats, bits};

/// What is written of a body that is put somewhere else.
type Placed = (&'static mut Position, &'static mut Rotation, &'static mut PoseHistory, &'static mut Transform);

/// What a transform is written from and to.
type Written = (
    Ref<'static, Position>,
    Ref<'static, Rotation>,
    &'static mut PoseHistory,
    &'static mut Transform,
    Option<Ref<'static, Sleeping>>,
);

/// Writes transforms between the last two poses; runs after the fixed loop. Where time stands still and nobody has put
/// anything elsewhere they are what they were.
pub(super) fn write_interpolated(
    fixed: Option<Res<Time<Fixed>>>,
    stats: Res<StepStats>,
    origin: Res<RenderOrigin>,
    mut bodies: Query<Written, With<RigidBody>>,
    // Of which step, and how far on from it, transforms are.
    mut drawn: Local<Option<(u64, u64)>>,
) {
    let alpha = alpha(fixed.as_deref());
    let now = Some((stats.steps, alpha.to_bits()));
    let is_as_drawn = now == *drawn
        && !origin.is_changed()
        && bodies.iter_mut().all(|(position, rotation, history, ..)| {
            !position.is_changed() && !rotation.is_changed() && !history.is_changed()
        });
    if !is_as_drawn {
        *drawn = now;
        write(alpha, origin, bodies);
    }
}

/// How far time is on from the last step, in steps.
fn alpha(fixed: Option<&Time<Fixed>>) -> f64 {
    fixed.map_or(1.0, Time::overstep_fraction_f64)
}

/// Writes transforms at once: something was done since the fixed loop, and the next picture is to show it.
///
/// # Errors
/// The world has no [`PhysicsPlugin`](super::PhysicsPlugin).
pub fn write_now(world: &mut World) -> Result {
    let write =
        |fixed: Option<Res<Time<Fixed>>>, origin: Res<RenderOrigin>, bodies: Query<Written, With<RigidBody>>| {
            write(alpha(fixed.as_deref()), origin, bodies);
        };
    Ok(world.run_system_cached(write)?)
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
        history.previous = None;
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
            rotation: between(from_rotation, rotation.0, alpha).as_quat(),
            scale: transform.scale,
        };
        if bits(&pose) != bits(&transform) {
            *transform = pose;
        }
        history.written = Some(pose);
    }
}

/// Cosine of half the angle from which on a rotation is drawn on the chord instead of the arc: up to 0.6 rad it is 1 mrad
/// from it, which nobody sees, and three times as fast.
const NEAR: f64 = 0.955;

/// A rotation on the way from one to another, 0 at the first and 1 at the second.
fn between(from: DQuat, to: DQuat, alpha: f64) -> DQuat {
    if from.dot(to) > NEAR { from.lerp(to, alpha) } else { from.slerp(to, alpha) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_chord_is_near_the_arc() {
        let axis = DVec3::new(0.3, -0.5, 0.8).normalize();
        let from = DQuat::from_rotation_x(0.7);
        let mut worst: f64 = 0.0;
        for angle in [1e-6, 0.01, 0.1, 0.3, 0.59, 0.61, 1.5, 3.0] {
            let to = DQuat::from_axis_angle(axis, angle) * from;
            for tenth in 0..=10 {
                let alpha = f64::from(tenth) / 10.0;
                let on_arc = DQuat::from_axis_angle(axis, angle * alpha) * from;
                worst = worst.max(between(from, to, alpha).angle_between(on_arc));
            }
        }
        assert!(worst < 1e-3, "{worst} rad");
        assert!(worst > 1e-5, "the chord is not drawn on");
    }
}
