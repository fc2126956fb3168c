//! Looks at a moment before the world is there: where the way to it is long, while the head is dragged and while time runs
//! backwards, bodies are drawn from the track of their poses alone. The world follows when the head is let go.

use bevy::prelude::*;

use super::head::{Timeline, head_and_reach, move_head, stop};
use super::poses::PoseTrack;
use super::shown::ShownStep;
use crate::physics::{History, RenderOrigin, RigidBody, SolverSettings, StepStats};
use crate::sandbox::Playback;

/// Steps of a body on a way, up to which the world goes along with the head: some 40 ms.
const SHORT_WAY: u64 = 20_000;

/// Pauses at that step while the head is held there, or at the nearest that is kept.
pub fn look_at(world: &mut World, step: u64) {
    stop(world);
    world.resource_mut::<Timeline>().looped = None;
    turn_to(world, step);
}

/// The world goes to that step where that is near; else it is looked at.
fn turn_to(world: &mut World, step: u64) {
    let Some(history) = world.get_resource::<History>() else { return };
    let stats = world.resource::<StepStats>();
    let [first, last] = history.reach();
    let step = step.clamp(first, last);
    let awake = u64::from(stats.bodies.saturating_sub(stats.sleeping));
    let is_near = history.way_to(step) * awake <= SHORT_WAY;
    if is_near || !world.resource::<PoseTrack>().has(step) {
        return move_head(world, step);
    }
    world.insert_resource(ShownStep { step: Some(step), is_held: true });
}

/// As many steps back as the clock asks for.
pub fn run_backwards(world: &mut World) {
    if !world.resource::<Timeline>().backwards {
        return;
    }
    let passed = world.resource::<Time<Real>>().delta_secs_f64().min(0.5);
    let (speed, hz) = (world.resource::<Playback>().speed(), world.resource::<SolverSettings>().hz);
    let mut timeline = world.resource_mut::<Timeline>();
    timeline.due += passed * speed * hz;
    let steps = timeline.due as u64;
    timeline.due -= steps as f64;
    let mut shown = world.resource_mut::<ShownStep>();
    shown.is_held = true;
    let shown = shown.step;
    let (head, [first, _]) = head_and_reach(world.resource::<StepStats>(), world.get_resource::<History>());
    let from = shown.unwrap_or(head);
    if steps > 0 {
        turn_to(world, from.saturating_sub(steps));
    }
    if from <= first {
        world.resource_mut::<Timeline>().backwards = false;
    }
}

/// The world goes to what is looked at, if anything is.
pub fn arrive(world: &mut World) {
    if let Some(step) = world.resource::<ShownStep>().step {
        move_head(world, step);
    }
}

/// The same once nobody holds the head there any more.
pub fn follow_the_head(world: &mut World) {
    if !std::mem::take(&mut world.resource_mut::<ShownStep>().is_held) {
        arrive(world);
    }
}

/// Draws the bodies where they were at the moment that is looked at; those that were not there have no size.
pub fn draw(
    shown: Res<ShownStep>,
    track: Res<PoseTrack>,
    origin: Res<RenderOrigin>,
    mut was_drawn: Local<bool>,
    mut bodies: Query<(Entity, &Transform, &mut GlobalTransform), With<RigidBody>>,
) {
    let poses = shown.step.map(|step| track.at(step, origin.0));
    if poses.is_none() && !std::mem::take(&mut *was_drawn) {
        return;
    }
    *was_drawn = poses.is_some();
    for (entity, transform, mut drawn) in &mut bodies {
        let pose = match &poses {
            None => *transform,
            Some(poses) => match poses.get(&entity) {
                Some((position, rotation)) => {
                    Transform { translation: position.as_vec3(), rotation: rotation.as_quat(), scale: transform.scale }
                }
                None => transform.with_scale(Vec3::ZERO),
            },
        };
        *drawn = pose.into();
    }
}
