//! Taking back what was built, cut or deleted, the last first.

use std::collections::HashMap;

use bevy::math::DQuat;
use bevy::prelude::*;

use super::joining::{Pin, idle_without, joints_of};
use super::{name_of, report};
use crate::physics::{
    BallJoint, Collider, CollisionLayers, Damping, Density, ExternalForce, GravityScale, Inertia, LockedAxes, Mass,
    Position, RigidBody, Rotation, Shape, SurfaceMaterial, Velocity,
};
use crate::sandbox::meshes::{self, BodyColor};
use crate::sandbox::{Selection, drag};
use crate::scene::{BodySpec, MaterialSpec, PictureMesh, SceneEntity, ShapeSpec};

/// How many deeds are remembered.
const DEPTH: usize = 64;

/// What undo would take back. A new start of the scene forgets it all.
#[derive(Resource, Default)]
pub struct UndoStack {
    deeds: Vec<(String, Deed)>,
}

/// What a deed did to the world.
pub enum Deed {
    /// These bodies and joints are new.
    Added(Vec<Entity>),
    /// These are gone.
    Removed {
        /// What each was.
        bodies: Vec<(Entity, BodySpec)>,
        /// The entity, its name, and what it joined.
        joints: Vec<(Entity, Name, BallJoint)>,
    },
}

impl UndoStack {
    /// Remembers a deed; `what` completes "undid …".
    pub fn push(&mut self, what: String, deed: Deed) {
        if self.deeds.len() == DEPTH {
            self.deeds.remove(0);
        }
        self.deeds.push((what, deed));
    }

    /// Forgets everything.
    pub fn clear(&mut self) {
        self.deeds.clear();
    }

    /// What the next undo would take back.
    pub fn next(&self) -> Option<&str> {
        self.deeds.last().map(|(what, _)| what.as_str())
    }

    /// What came back came back as other entities: earlier deeds mean those from now on.
    fn rename(&mut self, renamed: &HashMap<Entity, Entity>) {
        let now = |entity: &mut Entity| *entity = *renamed.get(entity).unwrap_or(entity);
        for (_, deed) in &mut self.deeds {
            match deed {
                Deed::Added(entities) => entities.iter_mut().for_each(now),
                Deed::Removed { joints, .. } => {
                    joints.iter_mut().flat_map(|(_, _, ball)| [&mut ball.body_a, &mut ball.body_b]).for_each(now);
                }
            }
        }
    }
}

/// Deletes the picked body and its joints.
pub fn delete_picked(world: &mut World) {
    let Some(body) = world.resource::<Selection>().entity() else { return };
    world.insert_resource(Selection::default());
    drag::release(world); // a hand's drag is not the body's own
    let name = name_of(world, body);
    let joints = joints_of(world, body);
    let mut bodies = idle_without(world, &joints);
    bodies.push(body);
    let deed = remove(world, bodies, &joints);
    world.resource_mut::<UndoStack>().push(format!("deleting {name}"), deed);
    report(world, Ok(format!("deleted {name}")));
}

/// Despawns bodies and joints, and tells what they were.
pub fn remove(world: &mut World, bodies: Vec<Entity>, joints: &[(Entity, BallJoint)]) -> Deed {
    let bodies = bodies.into_iter().filter_map(|body| Some((body, describe(world, body)?))).collect::<Vec<_>>();
    let name = |joint| world.get::<Name>(joint).cloned().unwrap_or_default();
    let joints: Vec<_> = joints.iter().map(|&(joint, ball)| (joint, name(joint), ball)).collect();
    let gone = joints.iter().map(|&(joint, ..)| joint).chain(bodies.iter().map(|&(body, _)| body));
    for entity in gone.collect::<Vec<_>>() {
        world.despawn(entity);
    }
    Deed::Removed { bodies, joints }
}

/// Takes the last deed back.
pub fn undo(world: &mut World) {
    let outcome = match world.resource_mut::<UndoStack>().deeds.pop() {
        None => Err("nothing to undo".to_owned()),
        Some((what, deed)) => match take_back(world, deed) {
            true => Ok(format!("undid {what}")),
            false => Err(format!("cannot undo {what}: it is gone")),
        },
    };
    report(world, outcome);
}

/// Tells whether there was anything left to take back.
fn take_back(world: &mut World, deed: Deed) -> bool {
    match deed {
        Deed::Added(entities) => {
            let gone: Vec<bool> = entities.into_iter().map(|entity| world.try_despawn(entity).is_err()).collect();
            !gone.contains(&true)
        }
        Deed::Removed { bodies, joints } => restore(world, bodies, joints),
    }
}

/// Spawns bodies and joints anew; a joint whose other body has gone meanwhile stays away. Tells
/// whether anything came back.
fn restore(world: &mut World, bodies: Vec<(Entity, BodySpec)>, joints: Vec<(Entity, Name, BallJoint)>) -> bool {
    let mut renamed = HashMap::new();
    for (was, body) in bodies {
        renamed.insert(was, respawn(world, &body));
    }
    for (was, name, mut ball) in joints {
        for end in [&mut ball.body_a, &mut ball.body_b] {
            *end = *renamed.get(end).unwrap_or(end);
        }
        let ends = [ball.body_a, ball.body_b];
        if ends.into_iter().all(|end| world.get::<RigidBody>(end).is_some()) {
            renamed.insert(was, world.spawn((name, SceneEntity, ball)).id());
        }
    }
    world.resource_mut::<UndoStack>().rename(&renamed);
    !renamed.is_empty()
}

/// A body as it is now.
fn describe(world: &World, body: Entity) -> Option<BodySpec> {
    let name = name_of(world, body);
    let body = world.get_entity(body).ok()?;
    let shape = body.get::<Collider>().map(|collider| shape_of(collider.shape(), body.get()));
    let axes = shape.as_ref().map_or(DQuat::IDENTITY, ShapeSpec::axes);
    let usual = BodySpec::pin(name, body.get::<Position>()?.0);
    let velocity = body.get::<Velocity>().copied().unwrap_or_default();
    let force = body.get::<ExternalForce>().copied().unwrap_or_default();
    let material = body.get::<SurfaceMaterial>().copied().unwrap_or_default();
    let damping = body.get::<Damping>().copied().unwrap_or_default();
    Some(BodySpec {
        kind: *body.get::<RigidBody>()?,
        shape,
        density: body.get::<Density>().copied().unwrap_or_default().0,
        mass: body.get::<Mass>().map(|mass| mass.0),
        inertia: body.get::<Inertia>().map(|inertia| inertia.0),
        rotation: body.get::<Rotation>()?.0 * axes.inverse(),
        linear_velocity: velocity.linear,
        angular_velocity: velocity.angular,
        force: force.force,
        torque: force.torque,
        material: MaterialSpec { friction: material.friction, restitution: material.restitution },
        layers: body.get::<CollisionLayers>().copied().unwrap_or_default(),
        locked: body.get::<LockedAxes>().copied().unwrap_or_default(),
        gravity_scale: body.get::<GravityScale>().copied().unwrap_or_default().0,
        damping: (damping.linear, damping.angular),
        color: body.get::<BodyColor>().map(|color| color.0.to_srgba().to_f32_array_no_alpha()),
        ..usual
    })
}

fn respawn(world: &mut World, body: &BodySpec) -> Entity {
    let entity = body.spawn(world);
    meshes::color(world, entity, body);
    if body.shape.is_none() {
        world.entity_mut(entity).insert(Pin); // nothing else without a shape is ever removed
    }
    entity
}

fn shape_of(shape: &Shape, picture: Option<&PictureMesh>) -> ShapeSpec {
    match (shape.clone(), picture) {
        (Shape::HalfSpace, _) => ShapeSpec::HalfSpace,
        (Shape::Sphere { radius }, _) => ShapeSpec::Sphere { radius },
        (Shape::Cuboid { size }, _) => ShapeSpec::Cuboid { size },
        (Shape::Cone { radius, height }, _) => ShapeSpec::Cone { radius, height },
        (Shape::Hull(_), Some(PictureMesh(mesh))) => ShapeSpec::Mesh(mesh.clone()),
        (Shape::Hull(hull), None) => ShapeSpec::Hull(hull.into()),
    }
}
