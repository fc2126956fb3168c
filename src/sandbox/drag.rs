//! Picking and dragging with the left button; with Shift held more bodies are picked. A press beside all bodies draws a box
//! around those that it is to pick.
//!
//! The body is held at the very point that was hit, by a soft ball joint to a body without a
//! shape: the *handle*. The handle goes where the pointer is, in the plane through the held point
//! parallel to the picture; the wheel moves that plane. A pointer that jumps pulls no harder than
//! the joint's bounded force.

use bevy::app::{RunFixedMainLoop, RunFixedMainLoopSystems};
use bevy::input::mouse::{AccumulatedMouseScroll, MouseScrollUnit};
use bevy::math::DVec3;
use bevy::picking::pointer::{PointerLocation, PointerMap, PointerPress};
use bevy::prelude::*;

use super::aimed::{Aimed, Picture, Targets};
use super::any_joint::{AnyJoint, IsJoint};
use super::held::{Drag, DragPart, Held};
use super::in_front::in_front;
use super::probe::TapeStart;
use super::state::SHIFT_KEYS;
use super::timeline::ShownStep;
use super::{Picked, Playback, Selection, Tool, box_select, joint_click};
use crate::physics::{
    BallJoint, BrokenJoint, Collider, Damping, History, Mass, Position, Quarantined, RenderOrigin, RigidBody, Rotation,
    Shape, Softness, SolverSettings, StepStats, bury,
};

/// Frequency of the joint that holds a single body, Hz: firm, and calm at 60 steps a second.
const FREQUENCY: f64 = 5.0;
/// The most that what hangs on the held body raises the frequency.
const MOST_STIFFENING: f64 = 3.0;
/// The pull's bound in weights of all that hangs on the held body: it is to be swung, not only
/// lifted …
const PULL_PER_JOINED_WEIGHT: f64 = 5.0;
/// … but in weights of the held body itself no less, and no more, than this: joints between a
/// light body and a very heavy one would be torn apart.
const PULL_PER_OWN_WEIGHT: (f64, f64) = (30.0, 200.0);
/// Standard gravity, m/s²: how hard a pull is must not depend on the scene's.
const STANDARD_GRAVITY: f64 = 9.81;
/// The handle's greatest speed, in distances from the camera a second: it crosses the picture in
/// a quarter of a second.
const HANDLE_SPEED: f64 = 4.0;
/// Added to the held body's angular drag, 1/s: a hand does not hold a thing by a frictionless
/// point, and what spins about one cannot be put anywhere.
const GRIP_DRAG: f64 = 3.0;
/// Factor on the distance per notch of the wheel.
const WHEEL_FACTOR: f64 = 1.1;
/// Scrolled pixels that make a notch.
const PIXELS_PER_NOTCH: f32 = 50.0;
/// Distances at which a body can be held, m from the camera along its view.
const DEPTHS: (f64, f64) = (0.5, 2000.0);

pub(super) fn plugin(app: &mut App) {
    in_front::<DragGizmos>(app, 1.0, 3.0);
    app.init_resource::<Drag>()
        .add_observer(pick)
        .add_systems(
            RunFixedMainLoop,
            (end_drag, scroll, aim_handle)
                .chain()
                .in_set(RunFixedMainLoopSystems::BeforeFixedMainLoop)
                .after(super::camera::keep_origin_near),
        )
        .add_systems(FixedUpdate, move_handle)
        .add_systems(PostUpdate, draw.before(TransformSystems::Propagate));
}

/// A press picks the body under it, and drags it if it can move; with Shift held it picks that body
/// beside the one that is picked already.
fn pick(
    press: On<Pointer<Press>>,
    mut commands: Commands,
    mut drag: ResMut<Drag>,
    mut selection: ResMut<Selection>,
    (mut picture, targets): (Picture, Targets),
    bodies: Query<(&RigidBody, Option<&Damping>, Has<Quarantined>)>,
    cameras: Query<&GlobalTransform, With<Camera>>,
    (keys, tape, shown, tool): (Res<ButtonInput<KeyCode>>, Res<TapeStart>, Res<ShownStep>, Res<Tool>),
    joined: Joined,
    (parts, playback, stats, history): (Query<&DragPart>, Res<Playback>, Res<StepStats>, Option<Res<History>>),
) {
    if press.button != PointerButton::Primary || drag.is_active() || tape.is_waiting() {
        return;
    }
    // What is drawn there is elsewhere in the world.
    if shown.step.is_some() || *tool != Tool::Drag {
        return;
    }
    if !picture.is_pressed(&press) {
        return;
    }
    let adds = keys.any_pressed(SHIFT_KEYS);
    let aimed = targets.aimed(press.entity, &press.hit).filter(|aimed| !aimed.is_ground);
    let (pointer, place, before) = (press.pointer_id, press.pointer_location.position, selection.clone());
    commands.queue(move |world: &mut World| joint_click::press(world, pointer, place, &before));
    let Some(Aimed { picked: aimed, place: target, .. }) = aimed else {
        if !adds {
            selection.set_if_neq(Selection::default());
        }
        commands.queue(move |world: &mut World| box_select::begin(world, pointer, place, adds));
        return;
    };
    let (Some(hit), Ok(camera)) = (press.hit.position, cameras.get(press.hit.camera)) else { return };
    let Ok((kind, damping, quarantined)) = bodies.get(aimed.entity) else { return };
    let Picked { entity: body, point: anchor, .. } = aimed;
    let adds = adds && selection.body.is_some();
    selection.pick(aimed, adds);
    if adds {
        return; // picked to be joined, not dragged
    }
    if *kind != RigidBody::Dynamic || quarantined {
        return;
    }
    // In the past, while time stands still, a press only picks: it is not to end what was to come.
    let is_past = history.is_some_and(|history| history.is_past(stats.steps));
    if is_past && playback.paused {
        return;
    }
    // One that held it before lets go.
    let own = parts.iter().find(|part| part.body == body).map_or(damping.copied(), |part| part.damping);
    commands.queue(let_go_of_all);
    let part = DragPart { body, damping: own };
    let handle = commands.spawn((Name::new("drag handle"), part, RigidBody::Kinematic, Position(target))).id();
    let joint = BallJoint::new(handle, body).with_anchors(DVec3::ZERO, anchor).with_softness(joined.softness_for(body));
    commands.spawn((Name::new("drag joint"), part, joint));
    let own = own.unwrap_or_default();
    commands.entity(body).insert(Damping { angular: own.angular + GRIP_DRAG, ..own });
    drag.0 = Some(Held {
        body,
        anchor,
        handle,
        pointer: press.pointer_id,
        depth: f64::from((hit - camera.translation()).dot(*camera.forward())),
        target,
    });
}

/// What hangs on a body through joints.
#[derive(bevy::ecs::system::SystemParam)]
struct Joined<'w, 's> {
    joints: Query<'w, 's, AnyJoint, (IsJoint, Without<BrokenJoint>)>,
    bodies: Query<'w, 's, (&'static RigidBody, &'static Mass)>,
}

impl Joined<'_, '_> {
    fn softness_for(&self, body: Entity) -> Softness {
        let own = self.mass(body).unwrap_or(1.0);
        let all = self.mass_of_all(body).max(own);
        let (least, most) = PULL_PER_OWN_WEIGHT;
        let pull = (PULL_PER_JOINED_WEIGHT * all).clamp(least * own, most * own);
        Softness {
            frequency: FREQUENCY * (all / own).sqrt().min(MOST_STIFFENING),
            damping_ratio: 1.0,
            max_force: pull * STANDARD_GRAVITY,
        }
    }

    /// Mass of a dynamic body.
    fn mass(&self, body: Entity) -> Option<f64> {
        self.bodies.get(body).ok().filter(|(kind, _)| **kind == RigidBody::Dynamic).map(|(_, mass)| mass.0)
    }

    /// Mass of all dynamic bodies that joints connect with this one.
    fn mass_of_all(&self, body: Entity) -> f64 {
        let mut found = vec![body];
        let mut next = 0;
        let joined = self.joints.iter().filter_map(|joint| Some(joint.component()?.bodies())).collect::<Vec<_>>();
        while let Some(&body) = found.get(next) {
            for &[a, b] in &joined {
                let other = match body {
                    body if body == a => b,
                    body if body == b => a,
                    _ => continue,
                };
                if self.mass(other).is_some() && !found.contains(&other) {
                    found.push(other);
                }
            }
            next += 1;
        }
        found.iter().filter_map(|&body| self.mass(body)).sum()
    }
}

/// Lets go when the button is up or the body is no longer one that moves.
fn end_drag(
    mut commands: Commands,
    drag: Res<Drag>,
    bodies: Query<(&RigidBody, Has<Quarantined>)>,
    pointers: Query<&PointerPress>,
    pointer_map: Res<PointerMap>,
) {
    let Some(held) = &drag.0 else { return };
    let is_pressed = pointer_map
        .get_entity(held.pointer)
        .and_then(|pointer| pointers.get(pointer).ok())
        .is_some_and(PointerPress::is_primary_pressed);
    let moves = bodies.get(held.body).is_ok_and(|(kind, quarantined)| *kind == RigidBody::Dynamic && !quarantined);
    if !is_pressed || !moves {
        commands.queue(release);
    }
}

/// Lets go of what is held, if anything is.
pub(super) fn release(world: &mut World) {
    if world.resource_mut::<Drag>().0.take().is_some() {
        let_go_of_all(world);
    }
}

/// Takes away all that drags are made of, also what nobody holds any more.
pub(super) fn let_go_of_all(world: &mut World) {
    let mut parts = world.query::<(Entity, &DragPart)>();
    let parts: Vec<(Entity, DragPart)> = parts.iter(world).map(|(part, of)| (part, *of)).collect();
    for (part, DragPart { body, damping }) in parts {
        bury(world, part);
        let Ok(mut body) = world.get_entity_mut(body) else { continue };
        if !body.contains::<RigidBody>() {
            continue;
        }
        match damping {
            Some(damping) => _ = body.insert(damping),
            None => _ = body.remove::<Damping>(),
        }
    }
}

/// The wheel moves the held body farther away (up) or nearer (down).
fn scroll(mut drag: ResMut<Drag>, wheel: Res<AccumulatedMouseScroll>) {
    if wheel.delta.y == 0.0 {
        return;
    }
    let Some(held) = &mut drag.0 else { return };
    let notches = match wheel.unit {
        MouseScrollUnit::Line => wheel.delta.y,
        MouseScrollUnit::Pixel => wheel.delta.y / PIXELS_PER_NOTCH,
    };
    held.depth = (held.depth * WHEEL_FACTOR.powf(f64::from(notches))).clamp(DEPTHS.0, DEPTHS.1);
}

/// Puts the target under the pointer, but never below the ground: pressed into it with all that
/// force, a body would sink.
fn aim_handle(
    mut drag: ResMut<Drag>,
    pointers: Query<&PointerLocation>,
    pointer_map: Res<PointerMap>,
    camera: Single<(&Camera, &GlobalTransform)>,
    grounds: Query<(&Collider, &Position, &Rotation)>,
    origin: Res<RenderOrigin>,
) {
    let Some(held) = &mut drag.0 else { return };
    let (camera, transform) = *camera;
    let Some(ray) = pointer_map
        .get_entity(held.pointer)
        .and_then(|pointer| pointers.get(pointer).ok()?.location())
        .and_then(|location| camera.viewport_to_world(transform, location.position).ok())
    else {
        return;
    };
    let along_view = f64::from(ray.direction.dot(*transform.forward()));
    if along_view <= 0.0 {
        return;
    }
    // From the camera itself: the ray starts on the near plane.
    let offset = ray.direction.as_dvec3() * (held.depth / along_view);
    let mut target = origin.0 + transform.translation().as_dvec3() + offset;
    for (collider, position, rotation) in &grounds {
        if *collider.shape() == Shape::HalfSpace {
            let up = rotation.0 * DVec3::Y;
            target -= up * (target - position.0).dot(up).min(0.0);
        }
    }
    held.target = target;
}

/// Moves the handle toward its target, no faster than [`HANDLE_SPEED`] says.
fn move_handle(drag: Res<Drag>, mut handles: Query<&mut Position>, settings: Res<SolverSettings>) {
    let Some(held) = &drag.0 else { return };
    let Ok(mut position) = handles.get_mut(held.handle) else { return };
    let farthest = HANDLE_SPEED * held.depth * settings.step();
    let next = position.0 + (held.target - position.0).clamp_length_max(farthest);
    position.set_if_neq(Position(next));
}

/// Drawn over everything: the held point may be on the far side of its body by now.
#[derive(Default, Reflect, GizmoConfigGroup)]
struct DragGizmos;

/// A line from the held point to the pointer, with a dot at each end.
fn draw(
    drag: Res<Drag>,
    bodies: Query<&Transform, With<RigidBody>>,
    camera: Single<&GlobalTransform, With<Camera3d>>,
    origin: Res<RenderOrigin>,
    mut gizmos: Gizmos<DragGizmos>,
) {
    const COLOR: Color = Color::srgb(1.0, 0.85, 0.1);
    let Some(held) = &drag.0 else { return };
    let Ok(body) = bodies.get(held.body) else { return };
    let from = body.translation + body.rotation * held.anchor.as_vec3();
    let to = (held.target - origin.0).as_vec3();
    gizmos.line(from, to, COLOR);
    for (end, size) in [(from, 0.006), (to, 0.004)] {
        gizmos.sphere(end, size * end.distance(camera.translation()), COLOR);
    }
}
