//! From data to entities.

use std::collections::HashMap;

use bevy::prelude::*;

use super::{BodySpec, JointParts, JointSpec, MotorKeys, PictureMesh, Probes, SceneSpec, ShapeSpec};
use crate::physics::{
    Damping, Density, ExternalForce, Gravity, GravityScale, Inertia, Keep, Mass, Position, RenderOrigin, Rotation,
    Sensor, SurfaceMaterial, Velocity,
};

/// Marks what a scene spawned (bodies and joints), so that a reset can despawn it.
#[derive(Component, Reflect, Clone, Copy, Debug, Default)]
#[reflect(Component, Debug, Default)]
pub struct SceneEntity;

/// The color of a body in the picture, sRGB, 0 to 1 each; without it, one is chosen.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component, Debug, PartialEq)]
pub struct BodyColor(pub [f32; 3]);

/// The shape as the scene has it, where the collider does not tell.
#[derive(Component, Clone, Debug)]
pub(super) struct GivenShape(pub ShapeSpec);

/// The entities of a spawned scene, in the order of its lists.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SpawnedScene {
    /// One per [`SceneSpec::bodies`].
    pub bodies: Vec<Entity>,
    /// One per [`SceneSpec::joints`].
    pub joints: Vec<Entity>,
}

impl SceneSpec {
    /// Spawns every body (with its `Name`) and joint into a world and sets its gravity and its [`Probes`]. The scene
    /// must be valid.
    ///
    /// # Panics
    /// A joint names a body that the scene does not have, or a hull has no volume.
    pub fn spawn(&self, world: &mut World) -> SpawnedScene {
        world.insert_resource(Gravity(self.gravity));
        let spawned = self.spawn_beside(world);
        world.insert_resource(Probes::of_specs(&self.probes, &self.bodies, [&spawned.bodies, &spawned.joints]));
        spawned
    }

    /// Spawns its bodies and joints beside what is there: gravity and probes stay as they are. The scene must be valid.
    ///
    /// # Panics
    /// As [`spawn`](Self::spawn).
    pub fn spawn_beside(&self, world: &mut World) -> SpawnedScene {
        let origin = world.get_resource::<RenderOrigin>().copied().unwrap_or_default();
        let spawn = |body: &BodySpec| {
            let mut entity = world.spawn_empty();
            insert_body(body, origin, &mut entity);
            entity.id()
        };
        let bodies: Vec<Entity> = self.bodies.iter().map(spawn).collect();
        let by_name: HashMap<&str, (Entity, &BodySpec)> =
            self.bodies.iter().zip(&bodies).map(|(body, &entity)| (body.name.as_str(), (entity, body))).collect();
        let joints = self.joints.iter().map(|joint| spawn_joint(joint, &by_name, world)).collect();
        SpawnedScene { bodies, joints }
    }
}

impl Probes {
    /// Of the bodies of the same names and of the same joints, in a scene that was spawned anew.
    #[cfg(feature = "sandbox")]
    pub(crate) fn follow(&self, before: (&SceneSpec, &SpawnedScene), now: (&SceneSpec, &SpawnedScene)) -> Self {
        let bodies = before.1.bodies.iter().copied().zip(&before.0.bodies).collect();
        let probes = self.to_specs(&bodies, &before.1.joints);
        Self::of_specs(&probes, &now.0.bodies, [&now.1.bodies, &now.1.joints])
    }
}

impl BodySpec {
    /// Spawns it alone, as [`SceneSpec::spawn`] does with each of its bodies. It must be valid.
    pub fn spawn(&self, world: &mut World) -> Entity {
        let entity = world.spawn_empty().id();
        self.spawn_at(world, entity);
        entity
    }

    /// Makes an entity that has nothing this body. It must be valid.
    ///
    /// # Panics
    /// There is no such entity.
    pub fn spawn_at(&self, world: &mut World, entity: Entity) {
        let origin = world.get_resource::<RenderOrigin>().copied().unwrap_or_default();
        insert_body(self, origin, &mut world.entity_mut(entity));
    }
}

/// Components that have a default are left out where the body has it, so that what a scene does
/// not need costs it nothing.
fn insert_body(body: &BodySpec, origin: RenderOrigin, entity: &mut EntityWorldMut) {
    let rotation = body.principal_rotation();
    entity.insert((
        Name::new(body.name.clone()),
        SceneEntity,
        body.kind,
        Position(body.position),
        Rotation(rotation),
        Velocity { linear: body.linear_velocity, angular: body.angular_velocity },
        Transform::from_translation((body.position - origin.0).as_vec3()).with_rotation(rotation.as_quat()),
    ));
    if let Some(shape) = &body.shape {
        entity.insert(shape.collider());
        insert_unless_default(
            entity,
            SurfaceMaterial { friction: body.material.friction, restitution: body.material.restitution },
        );
        insert_unless_default(entity, body.layers);
        if body.sensor {
            entity.insert(Sensor);
        }
        match shape {
            ShapeSpec::Mesh(mesh) => _ = entity.insert(PictureMesh(mesh.clone())),
            ShapeSpec::Hull(_) | ShapeSpec::Compound(_) | ShapeSpec::Surface(_) => {
                entity.insert(GivenShape(shape.clone()));
            }
            _ => {}
        }
    }
    match body.mass {
        Some(mass) => _ = entity.insert(Mass(mass)),
        None => insert_unless_default(entity, Density(body.density)),
    }
    if let Some(inertia) = body.inertia {
        entity.insert(Inertia(inertia));
    }
    insert_unless_default(entity, ExternalForce { force: body.force, torque: body.torque });
    insert_unless_default(entity, body.locked);
    insert_unless_default(entity, GravityScale(body.gravity_scale));
    if let Some(color) = body.color {
        entity.insert(BodyColor(color));
    }
    let (linear, angular) = body.damping;
    insert_unless_default(entity, Damping { linear, angular });
}

fn insert_unless_default<C: Component + Default + PartialEq>(entity: &mut EntityWorldMut, component: C) {
    if component != C::default() {
        entity.insert(component);
    }
}

fn spawn_joint(joint: &JointSpec, bodies: &HashMap<&str, (Entity, &BodySpec)>, world: &mut World) -> Entity {
    let ends = [&joint.body_a, &joint.body_b].map(|name| bodies[name.as_str()]);
    let name = Name::new(format!("{} to {}", joint.body_a, joint.body_b));
    let mut entity = world.spawn((name, SceneEntity));
    JointParts::of_spec(joint, ends).insert(&mut entity);
    entity.id()
}

/// Has bodies and joints of scenes that come back by [`go_to`](crate::physics::go_to) be what they were to a scene.
pub fn keep_scene(app: &mut App) {
    app.keep_look::<MotorKeys>();
    app.keep_look::<SceneEntity>().keep_look::<BodyColor>().keep_look::<PictureMesh>().keep_look::<GivenShape>();
}
