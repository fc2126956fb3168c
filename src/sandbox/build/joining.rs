//! Joints between picked bodies, pins to the world, and cutting them.

use bevy::math::DVec3;
use bevy::prelude::*;

use super::join_kind::{JoinKind, place_of};
use super::joints::{Pin, idle_without, joints};
use super::names::{name_of, unique_name};
use super::undo::{Deed, remember, remove};
use crate::physics::{BallJoint, Collider, RigidBody};
use crate::sandbox::any_joint::noun;
use crate::sandbox::state::report;
use crate::sandbox::{Selection, camera};
use crate::scene::{BodySpec, JointComponent, JointParts, SceneEntity};

/// Two joints of the same bodies closer than this share of a bounding radius are one and the same.
const SAME_PLACE: f64 = 0.01;
/// Where nothing is picked, a joint is meant that lies within this angle of the pointer, rad.
const POINTING: f64 = 0.03;

/// Joins the two picked bodies by the [`JoinKind`] that is chosen.
pub fn join_picked(world: &mut World) {
    let outcome = try_join(world);
    report(world, outcome);
}

fn try_join(world: &mut World) -> Result<String, String> {
    let &Selection { body: Some(a), partner: Some(b), .. } = world.resource::<Selection>() else {
        return Err("pick two bodies to join: click one, then another with Shift held".into());
    };
    let (name_a, name_b) = (name_of(world, a.entity), name_of(world, b.entity));
    if a.entity == b.entity {
        return Err(format!("{name_a} cannot be joined to itself"));
    }
    if !moves(world, a.entity) && !moves(world, b.entity) {
        return Err(format!("neither {name_a} nor {name_b} can move: a joint would do nothing"));
    }
    let kind = *world.resource::<JoinKind>();
    let joint = kind.between(world, a, b)?;
    if is_there(world, &joint) {
        return Err(format!("{name_a} and {name_b} are joined there already"));
    }
    let what = format!("{name_a} to {name_b}");
    let mut entity = world.spawn((Name::new(what.clone()), SceneEntity));
    joint.insert(&mut entity);
    let entity = entity.id();
    remember(world, format!("joining {what}"), Deed::Added(vec![entity]));
    Ok(format!("joined {what} by a {}", noun(&joint)))
}

/// Whether a joint of that kind holds the same places of the same bodies.
fn is_there(world: &mut World, joint: &JointComponent) -> bool {
    let Some(places) = ends_of_joint(world, joint) else { return false };
    let [_, b] = joint.bodies();
    let radius = world.get::<Collider>(b).map_or(1.0, Collider::bounding_radius);
    let near = |one: DVec3, other: DVec3| one.distance(other) < SAME_PLACE * radius;
    joints(world).into_iter().filter(|(_, other)| noun(other) == noun(joint)).any(|(_, other)| {
        let Some(mut there) = ends_of_joint(world, &other) else { return false };
        if other.bodies() != joint.bodies() {
            there.reverse();
        }
        links(&other, joint.bodies()) && near(there[0], places[0]) && near(there[1], places[1])
    })
}

/// Holds the picked body to the world at the place that was clicked.
pub fn pin_picked(world: &mut World) {
    let outcome = try_pin(world);
    report(world, outcome);
}

fn try_pin(world: &mut World) -> Result<String, String> {
    let Some(picked) = world.resource::<Selection>().body else {
        return Err("pick a body to pin: click it where it is to be held".into());
    };
    let name = name_of(world, picked.entity);
    if !moves(world, picked.entity) {
        return Err(format!("{name} cannot move: there is nothing to pin"));
    }
    let place = place_of(world, picked.entity, picked.point).ok_or("the picked body is gone")?;
    let pin_name = unique_name(world, "world:pin"); // as scene files name what stands for the world
    let pin = BodySpec::pin(pin_name, place).spawn(world);
    world.entity_mut(pin).insert(Pin);
    let ball = BallJoint::new(pin, picked.entity).with_anchors(DVec3::ZERO, picked.point);
    let joint = world.spawn((Name::new(format!("{name} to the world")), SceneEntity, ball)).id();
    remember(world, format!("pinning {name}"), Deed::Added(vec![joint, pin]));
    Ok(format!("pinned {name} to the world"))
}

/// Cuts the joint that is meant: of those between two picked bodies, of the picked body, or of all
/// where none is picked, the one nearest the pointer; but where two are picked and the pointer is on a
/// joint, that one. With the pointer off the picture, nearest the place that was clicked.
pub fn cut_picked(world: &mut World) {
    match meant_joint(world) {
        Ok(joint) => cut(world, joint),
        Err(reason) => report(world, Err(reason)),
    }
}

fn meant_joint(world: &mut World) -> Result<Entity, String> {
    let selection = world.resource::<Selection>().clone();
    let all = joints(world);
    let mut candidates = all.clone();
    candidates.retain(|(_, joint)| match (selection.body, selection.partner) {
        (Some(a), Some(b)) => links(joint, [a.entity, b.entity]),
        (Some(a), None) => joint.bodies().contains(&a.entity),
        _ => true,
    });
    let picked = selection.partner.or(selection.body);
    let aim = world.run_system_cached(camera::aim).ok().flatten().ok_or("there is no picture to point into")?;
    let toward = match picked.and_then(|picked| place_of(world, picked.entity, picked.point)) {
        Some(place) if !aim.by_pointer => (place - aim.origin).normalize_or(aim.direction),
        _ => aim.direction,
    };
    let nearest = |candidates: Vec<(Entity, JointComponent)>| nearest(world, &candidates, aim.origin, toward);
    if aim.by_pointer
        && selection.partner.is_some()
        && let Some((joint, _)) = nearest(all).filter(|(_, angle)| *angle < POINTING)
    {
        return Ok(joint);
    }
    let nearest = nearest(candidates);
    match (nearest, picked) {
        (Some((joint, _)), Some(_)) => Ok(joint),
        (Some((joint, angle)), None) if angle < POINTING => Ok(joint),
        (_, None) => Err("no joint there: pick a body, or point at a joint".into()),
        (None, Some(picked)) => match selection.partner {
            Some(_) => Err("no joint between the two picked bodies".into()),
            None => Err(format!("{} has no joint", name_of(world, picked.entity))),
        },
    }
}

/// The joint that the pointer is on, if it is on one.
pub fn joint_at_pointer(world: &mut World) -> Option<Entity> {
    let aim = world.run_system_cached(camera::aim).ok().flatten().filter(|aim| aim.by_pointer)?;
    let all = joints(world);
    nearest(world, &all, aim.origin, aim.direction).filter(|(_, angle)| *angle < POINTING).map(|(joint, _)| joint)
}

/// The joint that is nearest to a direction as seen from a place, and the angle to it, rad.
fn nearest(world: &World, candidates: &[(Entity, JointComponent)], eye: DVec3, toward: DVec3) -> Option<(Entity, f64)> {
    let angle = |joint| Some(toward.angle_between(place_of_joint(world, joint)? - eye));
    let angles = candidates.iter().filter_map(|(entity, joint)| Some((*entity, angle(joint)?)));
    angles.min_by(|(_, a), (_, b)| a.total_cmp(b))
}

/// Cuts that joint.
pub fn cut(world: &mut World, joint: Entity) {
    let outcome = try_cut(world, joint);
    report(world, outcome);
}

fn try_cut(world: &mut World, joint: Entity) -> Result<String, String> {
    JointParts::of_entity(world, joint).ok_or("that joint is gone")?;
    let what = name_of(world, joint);
    let pins = idle_without(world, &[joint]);
    let deed = remove(world, pins, &[joint]);
    remember(world, format!("cutting {what}"), deed);
    Ok(format!("cut {what}"))
}

fn links(joint: &JointComponent, [a, b]: [Entity; 2]) -> bool {
    joint.bodies() == [a, b] || joint.bodies() == [b, a]
}

fn moves(world: &World, body: Entity) -> bool {
    world.get::<RigidBody>(body) == Some(&RigidBody::Dynamic)
}

/// The points of a joint on A and B, world, m.
pub fn ends_of(world: &World, joint: Entity) -> Option<[DVec3; 2]> {
    ends_of_joint(world, &JointParts::of_entity(world, joint)?.joint)
}

/// The points on A and B, world, m.
fn ends_of_joint(world: &World, joint: &JointComponent) -> Option<[DVec3; 2]> {
    let [(a, on_a), (b, on_b)] = joint.ends();
    Some([place_of(world, a, on_a)?, place_of(world, b, on_b)?])
}

/// Half-way between the two points, world, m.
fn place_of_joint(world: &World, joint: &JointComponent) -> Option<DVec3> {
    let [on_a, on_b] = ends_of_joint(world, joint)?;
    Some(on_a.midpoint(on_b))
}
