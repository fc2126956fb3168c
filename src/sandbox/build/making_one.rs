//! One body of several.
//!
//! It has their mass, their momentum, and their angular momentum about their centre of mass; where they moved as one it has their
//! energy. A compound has one density: its mass is spread evenly over the parts, so that its centre of mass and its inertia are
//! theirs where they are of the same density.

use bevy::math::{DQuat, DVec3};
use bevy::prelude::*;

use super::deleting::names;
use super::moving_joints::{NewEnd, move_joints};
use super::names::unique_name;
use super::undo::{Deed, remember, remove};
use crate::physics::LockedAxes;
use crate::sandbox::state::report;
use crate::sandbox::{Selection, drag};
use crate::scene::{BodySpec, ChildSpec, CompoundSpec, SceneSpec, ShapeSpec};

/// Makes the picked bodies one, and picks it.
pub fn make_one_body(world: &mut World) {
    let outcome = try_make(world);
    report(world, outcome);
}

fn try_make(world: &mut World) -> Result<String, String> {
    let bodies = picked(world);
    if bodies.len() < 2 {
        return Err("pick what is to be one body: click one, then others with Shift held, or draw a box".into());
    }
    drag::release(world); // a hand's drag is not the body's own
    let parts = bodies.iter().map(|&body| BodySpec::of_entity(world, body).ok_or("a picked body is gone"));
    let parts = parts.collect::<Result<Vec<_>, _>>()?;
    let name = unique_name(world, "compound");
    let whole = BodySpec { name: name.clone(), ..one_of(&parts)? };
    let alone = SceneSpec { bodies: vec![whole.clone()], ..SceneSpec::new("new body", DVec3::ZERO) };
    alone.validate().map_err(|error| error.to_string())?;
    let what = names(world, &bodies);

    let compound = whole.spawn(world);
    let back = whole.principal_rotation().inverse();
    let moved = move_joints(world, &bodies, |_, place, rotation| NewEnd {
        body: compound,
        anchor: back * (place - whole.position),
        turn: back * rotation,
    });
    let removed = remove(world, bodies, &moved.gone);
    let made = moved.made.into_iter().chain([compound]).collect();
    world.insert_resource(Selection::of(compound));
    remember(world, format!("making one body of {what}"), Deed::Several(vec![removed, Deed::Added(made)]));
    Ok(format!("made {name} of {what}"))
}

/// The picked bodies, each once.
pub(super) fn picked(world: &World) -> Vec<Entity> {
    let mut bodies: Vec<Entity> = Vec::new();
    for body in world.resource::<Selection>().bodies() {
        if !bodies.contains(&body) {
            bodies.push(body);
        }
    }
    bodies
}

/// What some bodies are as one. What a body has only one of (surface, layers, color) is that of the first.
fn one_of(parts: &[BodySpec]) -> Result<BodySpec, String> {
    let first = parts.first().ok_or("nothing is picked")?;
    parts.iter().try_for_each(|part| can_be_one(first, part))?;
    let weighed: Vec<(&BodySpec, f64)> = parts.iter().map(|part| (part, mass(part))).collect();
    let mass: f64 = weighed.iter().map(|(_, mass)| mass).sum();
    let mean = |of: fn(&BodySpec) -> f64| weighed.iter().map(|(part, own)| of(part) * (own / mass)).sum::<f64>();
    // From the first: where all are far from the origin, differences of places keep their digits.
    let origin = first.position;
    let children = parts.iter().flat_map(|part| solids_of(part, origin)).collect();
    let shape = CompoundSpec::new(children).map_err(|error| error.to_string())?;
    let position = origin + shape.compound().center();
    let shape = ShapeSpec::Compound(shape);
    let mut whole = BodySpec {
        kind: first.kind,
        density: mass / shape.volume(),
        material: first.material,
        layers: first.layers,
        sensor: first.sensor,
        color: first.color,
        gravity_scale: mean(|part| part.gravity_scale),
        damping: (mean(|part| part.damping.0), mean(|part| part.damping.1)),
        linear_velocity: weighed.iter().map(|(part, own)| part.linear_velocity * (own / mass)).sum(),
        force: parts.iter().map(|part| part.force).sum(),
        torque: parts.iter().map(|part| part.torque + (part.position - position).cross(part.force)).sum(),
        ..BodySpec::new("", shape, position)
    };
    let LockedAxes { translation, rotation } = &mut whole.locked;
    for part in parts {
        (0..3).for_each(|axis| translation[axis] |= part.locked.translation[axis]);
        (0..3).for_each(|axis| rotation[axis] |= part.locked.rotation[axis]);
    }
    let momentum = |(part, mass): &(&BodySpec, f64)| {
        let spin = turned(inertia(part, *mass), part.principal_rotation(), part.angular_velocity);
        // What only goes along does not turn it, wherever a mean density puts the centre.
        let relative = part.linear_velocity - whole.linear_velocity;
        spin + (part.position - position).cross(relative * *mass)
    };
    let angular_momentum: DVec3 = weighed.iter().map(momentum).sum();
    whole.angular_velocity = turned(inertia(&whole, mass).recip(), whole.principal_rotation(), angular_momentum);
    Ok(whole)
}

/// Whether a body can be one with another; why not, in one line.
fn can_be_one(first: &BodySpec, part: &BodySpec) -> Result<(), String> {
    let name = &part.name;
    let no_solid = match &part.shape {
        None => Some("has no shape"),
        Some(ShapeSpec::HalfSpace) => Some("is a half-space, which is no solid"),
        Some(ShapeSpec::Surface(_)) => Some("is a surface, which is no solid"),
        Some(_) => None,
    };
    if let Some(reason) = no_solid {
        return Err(format!("{name} cannot be a part: it {reason}; pick the others without it"));
    }
    if part.kind != first.kind {
        let kind = |body: &BodySpec| format!("{:?}", body.kind).to_lowercase();
        let [one, other] = [first, part].map(|body| format!("{} is {}", body.name, kind(body)));
        return Err(format!("{one} and {other}: make both the same in the inspector, or pick one kind"));
    }
    if part.sensor != first.sensor {
        let (sensor, other) = if part.sensor { (part, first) } else { (first, part) };
        let (sensor, other) = (&sensor.name, &other.name);
        return Err(format!("{sensor} only reports and {other} does not: make both the same in the inspector"));
    }
    Ok(())
}

/// The solids that a body is of, placed in the world's axes from an origin.
fn solids_of(body: &BodySpec, origin: DVec3) -> Vec<ChildSpec> {
    let from = body.position - origin;
    let Some(shape) = &body.shape else { return Vec::new() };
    let place = |child: ChildSpec, center: DVec3| ChildSpec {
        position: from + body.rotation * (child.position - center),
        rotation: (body.rotation * child.rotation).normalize(),
        shape: child.shape,
    };
    match (shape.children(), shape.compound()) {
        (Some(children), Some(compound)) => children.into_iter().map(|child| place(child, compound.center())).collect(),
        _ => vec![ChildSpec { shape: shape.clone(), position: from, rotation: body.rotation }],
    }
}

/// kg.
pub(super) fn mass(body: &BodySpec) -> f64 {
    body.mass.unwrap_or_else(|| body.density * body.shape.as_ref().map_or(0.0, ShapeSpec::volume))
}

/// Principal moments of a body of that mass, kg·m².
fn inertia(body: &BodySpec, mass: f64) -> DVec3 {
    let of_shape = || body.shape.as_ref().map(|shape| shape.collider().mass_properties_of_mass(mass).inertia);
    body.inertia.or_else(of_shape).unwrap_or_default()
}

/// Moments along principal axes of that rotation, on a vector of the world.
fn turned(moments: DVec3, rotation: DQuat, vector: DVec3) -> DVec3 {
    rotation * (moments * (rotation.inverse() * vector))
}
