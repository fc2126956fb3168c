//! From entities back to data: a scene as it stands in a running world.

use std::collections::{HashMap, HashSet};

use bevy::math::{DQuat, DVec3};
use bevy::prelude::*;

use super::body::WORLD_PREFIX;
use super::spawn::{BodyColor, GivenShape, SceneEntity};
use super::{BodySpec, JointParts, JointSpec, MaterialSpec, PictureMesh, Probes, SceneSpec, ShapeSpec};
use crate::physics::joint::JointSlot;
use crate::physics::{
    BodySlot, Collider, CollisionLayers, Damping, Density, ExternalForce, Gravity, GravityScale, Inertia, LockedAxes,
    Mass, Position, RigidBody, Rotation, Sensor, Shape, SurfaceMaterial, Velocity,
};

/// What a body without a name is called.
const NAMELESS: &str = "body";

impl SceneSpec {
    /// The scene in a world as it stands now: every body and joint that a scene spawned
    /// ([`SceneEntity`]), in the order in which they were made, with their present poses,
    /// velocities and forces, and the [`Probes`] of what is there; no view. Spawned, it goes on from there, but for what the solver
    /// carried from the last step.
    ///
    /// Bodies keep their names, made unique by a number where two share one. Masses and inertias
    /// that follow from shape and density are left out. A body's orientation is that of the axes
    /// which its shape is given in: of a hull askew in these, within rounding of the body's.
    ///
    /// What an application has set may be out of range: [`validate`](Self::validate) says so.
    pub fn of_world(world: &mut World, name: impl Into<String>) -> Self {
        Self::with_entities(world, name).0
    }

    /// The same, and the bodies' entities in the order of [`bodies`](Self::bodies).
    pub fn with_entities(world: &mut World, name: impl Into<String>) -> (Self, Vec<Entity>) {
        let gravity = world.get_resource::<Gravity>().copied().unwrap_or_default();
        let mut scene = Self::new(name, gravity.0);
        let entities = scene_bodies(world);
        let described = entities.into_iter().filter_map(|entity| Some((entity, BodySpec::of_entity(world, entity)?)));
        let mut described: Vec<(Entity, BodySpec)> = described.collect();
        make_names_unique(described.iter_mut().map(|(_, body)| body));
        let by_entity: HashMap<Entity, &BodySpec> = described.iter().map(|(entity, body)| (*entity, body)).collect();
        let joints = scene_joints(world);
        let joints = joints.iter().filter_map(|(entity, joint)| Some((*entity, joint_between(joint, &by_entity)?)));
        let joint_entities: Vec<Entity>;
        (joint_entities, scene.joints) = joints.unzip();
        if let Some(probes) = world.get_resource::<Probes>() {
            scene.probes = probes.to_specs(&by_entity, &joint_entities);
        }
        let (entities, bodies) = described.into_iter().unzip();
        scene.bodies = bodies;
        (scene, entities)
    }
}

impl SceneSpec {
    /// With its bodies in the order that they have once a file of it is read: what joints hold to the world by stands last,
    /// in the order of the joints.
    pub fn in_order_of_a_file(mut self) -> Self {
        let Self { bodies, joints, .. } = &mut self;
        let held_by =
            |body: &BodySpec| joints.iter().position(|joint| [&joint.body_a, &joint.body_b].contains(&&body.name));
        bodies.sort_by_cached_key(|body| body.name.starts_with(WORLD_PREFIX).then(|| held_by(body)));
        self
    }
}

impl BodySpec {
    /// A body of a world as it stands now; none if it is no body, or was made since the last time
    /// that commands were applied.
    pub fn of_entity(world: &World, entity: Entity) -> Option<Self> {
        let body = world.get_entity(entity).ok()?;
        let name = body.get::<Name>().map_or(NAMELESS, Name::as_str);
        let velocity = body.get::<Velocity>().copied().unwrap_or_default();
        let force = body.get::<ExternalForce>().copied().unwrap_or_default();
        let material = body.get::<SurfaceMaterial>().copied().unwrap_or_default();
        let damping = body.get::<Damping>().copied().unwrap_or_default();
        let density = body.get::<Density>().copied().unwrap_or_default().0;
        let shape = body.get::<Collider>().map(|collider| shape_of(collider, body.get(), body.get()));
        let rotation = unit(body.get::<Rotation>()?.0);
        let (mass, inertia) = given_mass(body.get(), body.get(), body.get(), density);
        Some(Self {
            kind: *body.get::<RigidBody>()?,
            density,
            mass,
            inertia,
            // Only hulls and compounds have axes of their own, and a turn by none costs rounding.
            rotation: match shape.as_ref().and_then(ShapeSpec::own_axes) {
                Some(axes) => rotation * axes.inverse(),
                None => rotation,
            },
            shape,
            linear_velocity: velocity.linear,
            angular_velocity: velocity.angular,
            force: force.force,
            torque: force.torque,
            material: MaterialSpec { friction: material.friction, restitution: material.restitution },
            layers: body.get::<CollisionLayers>().copied().unwrap_or_default(),
            sensor: body.contains::<Sensor>(),
            locked: body.get::<LockedAxes>().copied().unwrap_or_default(),
            gravity_scale: body.get::<GravityScale>().copied().unwrap_or_default().0,
            damping: (damping.linear, damping.angular),
            color: body.get::<BodyColor>().map(|color| color.0),
            ..Self::pin(name, body.get::<Position>()?.0)
        })
    }
}

fn scene_bodies(world: &mut World) -> Vec<Entity> {
    let mut query = world.query_filtered::<(Entity, &BodySlot), With<SceneEntity>>();
    let mut bodies: Vec<(u64, Entity)> = query.iter(world).map(|(entity, slot)| (slot.born, entity)).collect();
    bodies.sort_unstable();
    bodies.into_iter().map(|(_, entity)| entity).collect()
}

fn scene_joints(world: &mut World) -> Vec<(Entity, JointParts)> {
    let mut query = world.query_filtered::<(&JointSlot, Entity), With<SceneEntity>>();
    let mut joints: Vec<(u64, Entity)> = query.iter(world).map(|(slot, entity)| (slot.born, entity)).collect();
    joints.sort_unstable_by_key(|&(born, _)| born);
    joints.into_iter().filter_map(|(_, entity)| Some((entity, JointParts::of_entity(world, entity)?))).collect()
}

/// None where one of its bodies is not of the scene.
fn joint_between(joint: &JointParts, bodies: &HashMap<Entity, &BodySpec>) -> Option<JointSpec> {
    let [a, b] = joint.bodies();
    Some(joint.to_spec([bodies.get(&a)?, bodies.get(&b)?]))
}

/// The shape as a scene gave it, where it is still that one.
fn shape_of(collider: &Collider, mesh: Option<&PictureMesh>, given: Option<&GivenShape>) -> ShapeSpec {
    let is_still = |shape: &ShapeSpec| match (collider.shape(), shape) {
        (Shape::Hull(hull), shape) => shape.convex_hull() == Some(hull),
        (Shape::Compound(compound), shape) => shape.compound() == Some(compound),
        (Shape::Mesh(mesh), ShapeSpec::Surface(given)) => given.mesh() == mesh,
        _ => false,
    };
    let mesh = mesh.map(|picture| ShapeSpec::Mesh(picture.0.clone()));
    let given = given.map(|given| given.0.clone());
    mesh.into_iter().chain(given).find(is_still).unwrap_or_else(|| ShapeSpec::of_collider(collider))
}

/// Mass and principal moments, each only if they are not what shape and density give.
fn given_mass(
    collider: Option<&Collider>,
    mass: Option<&Mass>,
    inertia: Option<&Inertia>,
    density: f64,
) -> (Option<f64>, Option<DVec3>) {
    let computed_mass = collider.map(|collider| collider.mass_properties(density).mass);
    let mass = mass.map(|mass| mass.0);
    let computed_inertia = mass.and_then(|mass| Some(collider?.mass_properties_of_mass(mass).inertia));
    let inertia = inertia.map(|inertia| inertia.0);
    (mass.filter(|_| mass != computed_mass), inertia.filter(|_| inertia != computed_inertia))
}

/// Of length 1: a `Transform` that the user wrote to a static body is not, in double precision.
fn unit(rotation: DQuat) -> DQuat {
    if (rotation.length_squared() - 1.0).abs() < 1e-14 { rotation } else { rotation.normalize() }
}

/// The first bearer of a name keeps it; others get a number that makes theirs a new one. So do
/// those without a name, or with one that a scene file cannot have.
fn make_names_unique<'a>(bodies: impl Iterator<Item = &'a mut BodySpec>) {
    let mut bodies: Vec<&mut BodySpec> = bodies.collect();
    for body in &mut bodies {
        if body.name.is_empty() || body.name_is_reserved() {
            body.name = NAMELESS.to_owned();
        }
    }
    let mut taken: HashSet<String> = bodies.iter().map(|body| body.name.clone()).collect();
    let mut borne: HashSet<String> = HashSet::new();
    let mut numbers: HashMap<String, u64> = HashMap::new();
    for body in bodies {
        if !borne.insert(body.name.clone()) {
            let number = numbers.entry(body.name.clone()).or_insert(1);
            body.name = loop {
                *number += 1;
                let candidate = format!("{} {number}", body.name);
                if taken.insert(candidate.clone()) {
                    break candidate;
                }
            };
        }
    }
}
