//! A press in the picture with a tool in hand.

use bevy::math::DVec3;
use bevy::prelude::*;

use super::bar::{self, BarDraft};
use crate::physics::{Inertia, Mass, Quarantined, RigidBody, Rotation, Velocity};
use crate::sandbox::aimed::{Aimed, Picture, Targets};
use crate::sandbox::state::report;
use crate::sandbox::timeline::ShownStep;
use crate::sandbox::{JoinKind, Notice, Selection, Tool, build, camera, handles};

/// Speed that a kick through the centre of mass gives a body, m/s.
const KICK: f64 = 4.0;

/// The left button goes down on something.
pub fn press(
    press: On<Pointer<Press>>,
    mut commands: Commands,
    (mut picture, targets): (Picture, Targets),
    (tool, shown): (Res<Tool>, Res<ShownStep>),
) {
    // What is drawn there is elsewhere in the world while another moment is looked at.
    let is_ours = press.button == PointerButton::Primary && *tool != Tool::Drag && shown.step.is_none();
    if !is_ours || !picture.is_pressed(&press) {
        return;
    }
    let aimed = targets.aimed(press.entity, &press.hit);
    let (tool, pointer, place) = (*tool, press.pointer_id, press.pointer_location.position);
    commands.queue(move |world: &mut World| {
        match tool {
            // By its own observers.
            Tool::Drag | Tool::Measure => {}
            Tool::Move | Tool::Turn | Tool::Scale => handles::press(world, aimed, pointer, place),
            Tool::Push => push(world, aimed),
            Tool::Throw => build::throw_ball(world),
            Tool::Add => build::spawn_body(world),
            Tool::Bar => bar::begin(world, aimed, pointer),
            Tool::Join => join(world, aimed),
            Tool::Pin => {
                world.insert_resource(only(aimed));
                build::pin_picked(world);
            }
            Tool::Cut => {
                world.insert_resource(Selection::default());
                build::cut_picked(world);
            }
        }
    });
}

/// The hand is empty again: it drags.
pub fn put_down(world: &mut World) {
    world.insert_resource(BarDraft::default());
    handles::let_go(world);
    world.insert_resource(Tool::default());
}

/// What was hit, picked alone.
fn only(aimed: Option<Aimed>) -> Selection {
    Selection { body: aimed.filter(|aimed| !aimed.is_ground).map(|aimed| aimed.picked), ..default() }
}

/// The first click picks a body, the second joins another to it.
fn join(world: &mut World, aimed: Option<Aimed>) {
    let before = world.resource::<Selection>().body;
    let (first, second) = match (before, aimed) {
        (_, None) => {
            world.insert_resource(Selection::default());
            return report(world, Err("there is nothing to join: click a body".into()));
        }
        (None, Some(aimed)) => {
            world.insert_resource(Selection { body: Some(aimed.picked), ..default() });
            ask_for_second(world);
            return;
        }
        (Some(first), Some(aimed)) => (first, aimed.picked),
    };
    world.insert_resource(Selection { body: Some(first), partner: Some(second), ..default() });
    build::join_picked(world);
    let is_done = !matches!(world.resource::<Notice>(), Notice::Error(_));
    let body = if is_done { None } else { Some(first) };
    world.insert_resource(Selection { body, ..default() });
}

/// Says what the next click joins.
pub fn ask_for_second(world: &mut World) {
    let Some(first) = world.resource::<Selection>().body else { return };
    let where_to = match world.resource::<JoinKind>().has_axis() {
        true => "the other body where the joint is to be: its axis stands on that face",
        false => "the other body",
    };
    let name = build::name_of(world, first.entity);
    *world.resource_mut::<Notice>() = Notice::Info(format!("joins {name}: click {where_to}; Esc: none"));
}

/// A kick where the body was hit, along the view: what is hit off its centre turns.
fn push(world: &mut World, aimed: Option<Aimed>) {
    let outcome = try_push(world, aimed);
    if let Err(reason) = outcome {
        report(world, Err(reason));
    }
}

fn try_push(world: &mut World, aimed: Option<Aimed>) -> Result<(), String> {
    let aimed = aimed.ok_or("there is nothing to push: click a body")?;
    let aim = world.run_system_cached(camera::aim).ok().flatten().ok_or("there is no picture to point into")?;
    let body = world.get_entity(aimed.picked.entity).map_err(|_| "that body is gone")?;
    let moves = body.get::<RigidBody>() == Some(&RigidBody::Dynamic) && !body.contains::<Quarantined>();
    let parts = (body.get::<Mass>(), body.get::<Inertia>(), body.get::<Rotation>(), body.get::<Velocity>());
    let (Some(&Mass(mass)), Some(&Inertia(inertia)), Some(&Rotation(rotation)), Some(&velocity), true) =
        (parts.0, parts.1, parts.2, parts.3, moves)
    else {
        return Err("that cannot be pushed: it does not move".into());
    };
    let impulse = aim.direction * (mass * KICK);
    // In body axes, along which the moments of inertia are.
    let turning = aimed.picked.point.cross(rotation.inverse() * impulse);
    let spin = DVec3::from_array([0, 1, 2].map(|axis| turning[axis] / inertia[axis].max(f64::MIN_POSITIVE)));
    let kicked = Velocity { linear: velocity.linear + impulse / mass, angular: velocity.angular + rotation * spin };
    world.entity_mut(aimed.picked.entity).insert(kicked);
    world.insert_resource(only(Some(aimed)));
    Ok(())
}
