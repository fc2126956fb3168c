//! Avian: its plugins in a Bevy app with nothing else, at its default settings but for the
//! substeps.
//!
//! A step is one run of `FixedPostUpdate`, where its plugins put themselves, and the housekeeping
//! of a frame (messages, change trackers), as for Plumb; the rest of `App::update` is Bevy's price
//! and not counted.

use std::time::Duration;

use avian3d::prelude::*;
use bevy::app::{App, FixedPostUpdate};
use bevy::ecs::message::message_update_system;
use bevy::ecs::schedule::SingleThreadedExecutor;
use bevy::math::{Quat, Vec3};
use bevy::prelude::{Entity, EntityWorldMut, Fixed, MinimalPlugins, Time, Transform, TransformPlugin, World};
use bevy::tasks::ComputeTaskPool;
use bevy::time::TimeUpdateStrategy;
use plumb::lab::BodyState;
use plumb::physics::{Damping, MassProperties, RigidBody as Kind, Shape};

use super::{Engine, NO_HULL, cone_middle};
use crate::scene::{Body, Joint, Scene};

/// A scene in an app of its own. Its threads are those of Bevy's compute pool.
pub struct Avian {
    app: App,
    bodies: Vec<Entity>,
}

impl Avian {
    pub fn new(scene: &Scene, hz: f64, substeps: u32) -> Self {
        let mut app = App::new();
        app.add_plugins((MinimalPlugins, TransformPlugin, PhysicsPlugins::default()))
            .insert_resource(Gravity(scene.spec.gravity.as_vec3()))
            .insert_resource(SubstepCount(substeps))
            .insert_resource(Time::<Fixed>::from_duration(Duration::from_secs_f64(1.0 / hz)))
            .insert_resource(TimeUpdateStrategy::ManualDuration(Duration::ZERO));
        if ComputeTaskPool::get().thread_num() < 2 {
            // One thread starts its systems fastest itself.
            app.edit_schedule(FixedPostUpdate, |schedule| {
                schedule.set_executor(SingleThreadedExecutor::new());
            });
        }
        app.finish();
        app.cleanup();
        let world = app.world_mut();
        let bodies: Vec<Entity> = scene.bodies.iter().map(|body| spawn(world, body)).collect();
        for joint in &scene.joints {
            spawn_joint(world, joint, &bodies);
        }
        // A frame in which no time passes: what its plugins do at the start of an app.
        app.update();
        Self { app, bodies }
    }
}

impl Engine for Avian {
    fn step(&mut self) {
        let world = self.app.world_mut();
        let mut fixed = world.resource_mut::<Time<Fixed>>();
        let timestep = fixed.timestep();
        fixed.advance_by(timestep);
        let generic = fixed.as_generic();
        *world.resource_mut::<Time>() = generic;
        world.run_schedule(FixedPostUpdate);
        // It has no arguments that could be invalid.
        let _ = world.run_system_cached(message_update_system);
        world.clear_trackers();
    }

    fn read(&mut self, states: &mut Vec<BodyState>) {
        states.clear();
        states.extend(self.bodies.iter().map(|&body| {
            let body = self.app.world().entity(body);
            let (position, rotation) = body.components::<(&Position, &Rotation)>();
            let velocity = body.get_components::<(&LinearVelocity, &AngularVelocity)>();
            let (linear, angular) =
                velocity.map_or((Vec3::ZERO, Vec3::ZERO), |(linear, angular)| (linear.0, angular.0));
            BodyState {
                position: position.0.as_dvec3(),
                rotation: rotation.0.as_dquat().normalize(),
                linear: linear.as_dvec3(),
                angular: angular.as_dvec3(),
            }
        }));
    }
}

fn spawn(world: &mut World, body: &Body) -> Entity {
    let (position, rotation) = (body.position.as_vec3(), body.rotation.as_quat());
    let kind = match body.kind {
        Kind::Dynamic => RigidBody::Dynamic,
        Kind::Static | Kind::Kinematic => RigidBody::Static,
    };
    let mut entity = world.spawn((
        kind,
        Transform::from_translation(position).with_rotation(rotation),
        Position(position),
        Rotation(rotation),
        LinearVelocity(body.velocity.linear.as_vec3()),
        AngularVelocity(body.velocity.angular.as_vec3()),
        SleepingDisabled,
    ));
    if let Some(MassProperties { mass, inertia }) = body.mass {
        entity.insert((
            (Mass(mass as f32), AngularInertia::new(inertia.as_vec3()), CenterOfMass(Vec3::ZERO)),
            (NoAutoMass, NoAutoAngularInertia, NoAutoCenterOfMass),
        ));
        insert_what_acts(&mut entity, body);
    }
    if let Some(touching) = &body.collider {
        entity.insert((
            collider(touching.shape()),
            Friction::new(body.material.friction as f32).with_combine_rule(CoefficientCombine::GeometricMean),
            Restitution::new(body.material.restitution as f32).with_combine_rule(CoefficientCombine::Max),
            CollisionLayers::from_bits(body.layers.memberships, body.layers.filters),
        ));
    }
    entity.id()
}

/// Only what the body has: each of these is a component that costs its systems time.
fn insert_what_acts(entity: &mut EntityWorldMut, body: &Body) {
    if body.is_pushed() {
        entity.insert((ConstantForce(body.force.force.as_vec3()), ConstantTorque(body.force.torque.as_vec3())));
    }
    if body.gravity_scale != 1.0 {
        entity.insert(GravityScale(body.gravity_scale as f32));
    }
    if body.damping != Damping::default() {
        entity.insert((LinearDamping(body.damping.linear as f32), AngularDamping(body.damping.angular as f32)));
    }
}

fn collider(shape: &Shape) -> Collider {
    match shape {
        Shape::HalfSpace => Collider::half_space(Vec3::Y),
        Shape::Sphere { radius } => Collider::sphere(*radius as f32),
        Shape::Cuboid { size } => Collider::cuboid(size.x as f32, size.y as f32, size.z as f32),
        Shape::Cone { radius, height } => {
            let cone = Collider::cone(*radius as f32, *height as f32);
            Collider::compound(vec![(cone_middle(*height).as_vec3(), Quat::IDENTITY, cone)])
        }
        Shape::Hull(hull) => {
            Collider::convex_hull(hull.vertices().map(|vertex| vertex.as_vec3()).collect()).expect(NO_HULL)
        }
    }
}

fn spawn_joint(world: &mut World, joint: &Joint, bodies: &[Entity]) {
    let ball = SphericalJoint::new(bodies[joint.a], bodies[joint.b])
        .with_local_anchor1(joint.anchor_a.as_vec3())
        .with_local_anchor2(joint.anchor_b.as_vec3());
    let mut entity = world.spawn(ball);
    if !joint.collide {
        entity.insert(JointCollisionDisabled);
    }
}
