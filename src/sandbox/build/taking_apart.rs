//! A body for each part of one.
//!
//! Each moves as it moved as a part: with the velocity of its centre of mass, and the same spin. Together they have the mass, the
//! momentum and the angular momentum that they had as one.

use bevy::math::{DQuat, DVec3};
use bevy::prelude::*;

use super::blueprint::{noun_of, stem};
use super::deleting::names;
use super::making_one::{mass, picked};
use super::moving_joints::{NewEnd, move_joints};
use super::names::unique_names;
use super::undo::{Deed, remember, remove};
use crate::physics::{Collider, PlacedCollider, Position, RigidBody, Rotation};
use crate::sandbox::state::report;
use crate::sandbox::{Selection, drag};
use crate::scene::{BodySpec, ChildSpec, MAX_BODIES, SceneSpec, ShapeSpec};

/// Takes those of the picked bodies apart that are of several parts, and picks these.
pub fn take_apart(world: &mut World) {
    let outcome = try_take(world);
    report(world, outcome);
}

/// Where the parts of a body are.
struct Taken {
    body: Entity,
    parts: Vec<(Entity, BodySpec)>,
}

fn try_take(world: &mut World) -> Result<String, String> {
    let picked = picked(world);
    drag::release(world); // a hand's drag is not the body's own
    let described = picked.iter().filter_map(|&body| Some((body, parts_of(&BodySpec::of_entity(world, body)?)?)));
    let (bodies, mut parts): (Vec<Entity>, Vec<Vec<BodySpec>>) = described.unzip();
    if bodies.is_empty() {
        return Err("pick what is to be taken apart: a compound, or a mesh in pieces".into());
    }
    let there = world.query::<&RigidBody>().iter(world).count();
    if there + parts.iter().map(Vec::len).sum::<usize>() > MAX_BODIES {
        return Err(format!("a scene has at most {MAX_BODIES} bodies: it has {there} already"));
    }
    let wanted: Vec<String> = parts.iter().flatten().map(|part| part.name.clone()).collect();
    let unique = unique_names(world, wanted.iter().map(String::as_str));
    parts.iter_mut().flatten().zip(unique).for_each(|(part, name)| part.name = name);
    let all = SceneSpec { bodies: parts.concat(), ..SceneSpec::new("parts", DVec3::ZERO) };
    all.validate().map_err(|error| error.to_string())?;
    let what = names(world, &bodies);

    let mut spawn = |parts: Vec<BodySpec>| parts.into_iter().map(|part| (part.spawn(world), part)).collect();
    let taken: Vec<Taken> =
        bodies.iter().zip(parts).map(|(&body, parts)| Taken { body, parts: spawn(parts) }).collect();
    let moved = move_joints(world, &bodies, |body, place, rotation| {
        let parts = &taken.iter().find(|taken| taken.body == body).expect("it is taken apart").parts;
        let (part, spec) = nearest(parts, place);
        let back = spec.principal_rotation().inverse();
        NewEnd { body: *part, anchor: back * (place - spec.position), turn: back * rotation }
    });
    let made: Vec<Entity> = taken.iter().flat_map(|taken| &taken.parts).map(|(part, _)| *part).collect();
    let count = made.len();
    let removed = remove(world, bodies, &moved.gone);
    world.insert_resource(Selection::of_bodies(made.iter().copied()));
    let made = moved.made.into_iter().chain(made).collect();
    remember(world, format!("taking {what} apart"), Deed::Several(vec![removed, Deed::Added(made)]));
    Ok(format!("took {what} apart: {count} bodies"))
}

/// A body for each part of one that has several; none of others.
fn parts_of(whole: &BodySpec) -> Option<Vec<BodySpec>> {
    let shape = whole.shape.as_ref()?;
    let (children, center) = (shape.children()?, shape.compound()?.center());
    let all = mass(whole);
    // The very density that was given, unless a mass was.
    let density = if whole.mass.is_some() { all / shape.volume() } else { whole.density };
    let part = |child: ChildSpec| {
        let arm = whole.rotation * (child.position - center);
        let share = density * child.shape.volume() / all;
        let name = match shape {
            ShapeSpec::Mesh(mesh) => format!("{} piece", stem(mesh.file())),
            _ => noun_of(&child.shape).to_owned(),
        };
        BodySpec {
            name,
            shape: Some(child.shape),
            density,
            mass: None,
            inertia: None,
            position: whole.position + arm,
            rotation: (whole.rotation * child.rotation).normalize(),
            linear_velocity: whole.linear_velocity + whole.angular_velocity.cross(arm),
            force: whole.force * share,
            torque: whole.torque * share,
            ..whole.clone()
        }
    };
    Some(children.into_iter().map(part).collect())
}

/// The part that is nearest to a place of the world, or that it is deepest in.
fn nearest(parts: &[(Entity, BodySpec)], place: DVec3) -> &(Entity, BodySpec) {
    let farthest = parts.iter().map(|(_, part)| part.position.distance(place)).fold(0.0, f64::max);
    // A ball about the place that reaches to the middle of each: it overlaps most what is nearest to its middle.
    let ball = Collider::sphere(1.01 * farthest.max(f64::MIN_POSITIVE));
    let ball = PlacedCollider { collider: &ball, position: Position(place), rotation: Rotation(DQuat::IDENTITY) };
    let depth = |part: &BodySpec| {
        let collider = part.shape.as_ref()?.collider();
        let (position, rotation) = (Position(part.position), Rotation(part.principal_rotation()));
        ball.overlap(&PlacedCollider { collider: &collider, position, rotation })
    };
    let depths = parts.iter().map(|part| (depth(&part.1).unwrap_or(f64::NEG_INFINITY), part));
    // The first of several.
    depths.reduce(|best, other| if other.0 > best.0 { other } else { best }).expect("a body has parts").1
}
