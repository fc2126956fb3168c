//! Dragging a handle.
//!
//! Each frame in which the button is down, what is picked is put where the pointer has it by then
//! ([`SandboxAction::PlaceBodies`]): paused, it stays there; while time runs, it is held there until the button goes up. All of
//! one drag is undone at once.

use bevy::math::{DQuat, DVec3};
use bevy::picking::pointer::PointerId;
use bevy::prelude::*;

use super::change::{Change, Grip, Start, is_scalable};
use super::handle::{Frame, Handle};
use super::maths::Ray;
use crate::physics::{Position, Rotation};
use crate::sandbox::aimed::Aimed;
use crate::sandbox::pointer::is_down;
use crate::sandbox::snap::snap_of;
use crate::sandbox::state::SHIFT_KEYS;
use crate::sandbox::timeline::ShownStep;
use crate::sandbox::{Playback, SandboxAction, Selection, Tool, box_select, camera, joint_click};
use crate::scene::BodySpec;

/// The drag that is going on.
#[derive(Resource, Default)]
pub struct Pull(pub(super) Option<Pulling>);

#[derive(Clone, Debug)]
pub(super) struct Pulling {
    pub grip: Grip,
    pointer: PointerId,
    starts: Vec<Start>,
    /// What it made last; none before it made anything.
    pub change: Option<Change>,
}

/// What handles are on: those of the tool in hand, about what is picked.
pub(super) fn shown(world: &mut World) -> Option<(Vec<Handle>, Frame)> {
    let tool = *world.resource::<Tool>();
    if !tool.has_handles() || world.resource::<ShownStep>().step.is_some() {
        return None;
    }
    let starts = picked(world);
    let is_one = starts.len() == 1;
    let of_shape = starts.iter().any(|start| start.shape.is_some());
    let first = starts.first().filter(|_| tool != Tool::Scale || of_shape)?;
    let axes = match tool {
        Tool::Scale if is_one => DVec3::AXES.map(|axis| first.rotation * axis),
        _ => DVec3::AXES,
    };
    let centre = starts.iter().map(|start| start.position).sum::<DVec3>() / starts.len() as f64;
    let aim = world.run_system_cached(camera::aim).ok().flatten()?;
    Some((Handle::of_tool(tool, is_one), Frame::new(centre, axes, aim.origin)))
}

/// The picked bodies, as they are.
fn picked(world: &World) -> Vec<Start> {
    let of_scale = *world.resource::<Tool>() == Tool::Scale;
    let start = |body: Entity| {
        let shape = if of_scale { BodySpec::of_entity(world, body).and_then(|body| body.shape) } else { None };
        let position = world.get::<Position>(body)?.0;
        let rotation: DQuat = world.get::<Rotation>(body)?.0;
        Some(Start { body, position, rotation, shape: shape.filter(is_scalable) })
    };
    world.resource::<Selection>().bodies().filter_map(start).collect()
}

/// The ray through the pointer, where that is on the picture.
fn ray(world: &mut World) -> Option<Ray> {
    let aim = world.run_system_cached(camera::aim).ok().flatten().filter(|aim| aim.by_pointer)?;
    Some(Ray { origin: aim.origin, direction: aim.direction })
}

/// The handle that the pointer is on.
pub(super) fn hovered(world: &mut World, handles: &[Handle], frame: &Frame) -> Option<Handle> {
    let ray = ray(world)?;
    Handle::at(handles, frame, &ray)
}

/// The left button goes down with a tool that has handles: on one, it is dragged; on a body, that is picked; beside all, a box
/// is drawn.
pub fn press(world: &mut World, aimed: Option<Aimed>, pointer: PointerId, place: Vec2) {
    let adds = world.resource::<ButtonInput<KeyCode>>().any_pressed(SHIFT_KEYS);
    // With Shift held a click picks what is behind them.
    if !adds
        && let Some((handles, frame)) = shown(world)
        && let Some(handle) = hovered(world, &handles, &frame)
        && let Some(pulling) = grab(world, handle, frame, pointer)
    {
        world.resource_mut::<Pull>().0 = Some(pulling);
        return;
    }
    let before = world.resource::<Selection>().clone();
    joint_click::press(world, pointer, place, &before);
    match aimed.filter(|aimed| !aimed.is_ground) {
        Some(aimed) => world.resource_mut::<Selection>().pick(aimed.picked, adds),
        None => {
            if !adds {
                world.insert_resource(Selection::default());
            }
            box_select::begin(world, pointer, place, adds);
        }
    }
}

fn grab(world: &mut World, handle: Handle, frame: Frame, pointer: PointerId) -> Option<Pulling> {
    let ray = ray(world)?;
    let mut cameras = world.query_filtered::<&GlobalTransform, With<Camera3d>>();
    let camera = cameras.single(world).ok()?;
    let view = [camera.forward(), camera.right(), camera.up()].map(|direction| direction.as_dvec3().normalize());
    let grip = Grip::new(handle, frame, &ray, view)?;
    Some(Pulling { grip, pointer, starts: picked(world), change: None })
}

/// Lets go of the handle, as a user does who thinks better of it: what it did is undone.
pub fn let_go(world: &mut World) {
    let pulling = world.resource_mut::<Pull>().0.take();
    if pulling.is_some_and(|pulling| pulling.change.is_some()) {
        world.write_message(SandboxAction::Undo);
    }
}

/// Puts what is picked where the handle is by now.
pub(super) fn follow(world: &mut World) {
    let Some(mut pulling) = world.resource_mut::<Pull>().0.take() else { return };
    let is_there = pulling.starts.iter().all(|start| world.get::<Position>(start.body).is_some());
    if !is_there || world.resource::<ShownStep>().step.is_some() {
        return;
    }
    let snap = snap_of(world);
    let made = ray(world).and_then(|ray| pulling.grip.change(&ray, snap)).or(pulling.change);
    let is_held = !world.resource::<Playback>().paused;
    let continues = pulling.change.is_some();
    if let Some(change) = made.filter(|change| is_held || pulling.change != Some(*change)) {
        let centre = pulling.grip.frame.centre;
        let placements = pulling.starts.iter().map(|start| start.changed(change, centre, snap)).collect();
        world.write_message(SandboxAction::PlaceBodies { placements, continues });
        pulling.change = Some(change);
    }
    if is_down(world, pulling.pointer) {
        world.resource_mut::<Pull>().0 = Some(pulling);
    }
}
