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
use plumb::physics::{CompoundChild, Damping, DistanceLaw, MassProperties, RigidBody as Kind, Shape};
use plumb::scene::JointKindSpec;

use super::{Engine, Follower, NO_HULL, cone_middle, finite, speed_of};
use crate::joint::{Drive, Joint, Motor, frequency_and_ratio};
use crate::scene::{Body, Scene};

/// A scene in an app of its own. Its threads are those of Bevy's compute pool.
pub struct Avian {
    app: App,
    bodies: Vec<Entity>,
    followers: Vec<Follower<Entity>>,
    hz: f64,
    steps: u64,
}

impl Avian {
    pub fn new(scene: &Scene, hz: f64, substeps: u32, sleep: bool) -> Self {
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
        let bodies: Vec<Entity> = scene.bodies.iter().map(|body| spawn(world, body, sleep)).collect();
        let joints: Vec<Entity> =
            scene.joints.iter().map(|joint| spawn_joint(world, joint, &bodies, &scene.bodies)).collect();
        // A frame in which no time passes: what its plugins do at the start of an app.
        app.update();
        Self { app, bodies, followers: Follower::of(&scene.joints, &joints), hz, steps: 0 }
    }

    fn state(&self, body: usize) -> BodyState {
        let body = self.app.world().entity(self.bodies[body]);
        let (position, rotation) = body.components::<(&Position, &Rotation)>();
        let velocity = body.get_components::<(&LinearVelocity, &AngularVelocity)>();
        let (linear, angular) = velocity.map_or((Vec3::ZERO, Vec3::ZERO), |(linear, angular)| (linear.0, angular.0));
        BodyState {
            position: position.0.as_dvec3(),
            rotation: rotation.0.as_dquat().normalize(),
            linear: linear.as_dvec3(),
            angular: angular.as_dvec3(),
        }
    }

    fn follow(&mut self) {
        let time = (self.steps + 1) as f64 / self.hz;
        for follower in &self.followers {
            let [place, speed, _] = follower.motion.at_time(time).map(|number| number as f32);
            let mut joint = self.app.world_mut().entity_mut(follower.handle);
            if let Some(mut hinge) = joint.get_mut::<RevoluteJoint>() {
                (hinge.motor.target_position, hinge.motor.target_velocity) = (place, speed);
            } else if let Some(mut slider) = joint.get_mut::<PrismaticJoint>() {
                (slider.motor.target_position, slider.motor.target_velocity) = (place, speed);
            }
        }
    }
}

impl Engine for Avian {
    fn step(&mut self) {
        self.follow();
        self.steps += 1;
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
        states.extend((0..self.bodies.len()).map(|body| self.state(body)));
    }
}

fn spawn(world: &mut World, body: &Body, sleep: bool) -> Entity {
    let (position, rotation) = (body.position.as_vec3(), body.rotation.as_quat());
    let kind = match body.kind {
        Kind::Dynamic => RigidBody::Dynamic,
        Kind::Kinematic => RigidBody::Kinematic,
        Kind::Static => RigidBody::Static,
    };
    let mut entity = world.spawn((
        kind,
        Transform::from_translation(position).with_rotation(rotation),
        Position(position),
        Rotation(rotation),
        LinearVelocity(body.velocity.linear.as_vec3()),
        AngularVelocity(body.velocity.angular.as_vec3()),
    ));
    if !sleep {
        entity.insert(SleepingDisabled);
    }
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
        Shape::Capsule { radius, length } => Collider::capsule(*radius as f32, *length as f32),
        Shape::Cylinder { radius, height } => Collider::cylinder(*radius as f32, *height as f32),
        Shape::Cone { radius, height } => {
            let cone = Collider::cone(*radius as f32, *height as f32);
            Collider::compound(vec![(cone_middle(*height).as_vec3(), Quat::IDENTITY, cone)])
        }
        Shape::Hull(hull) => {
            Collider::convex_hull(hull.vertices().map(|vertex| vertex.as_vec3()).collect()).expect(NO_HULL)
        }
        Shape::Compound(compound) => {
            let part = |child: &CompoundChild| {
                (child.position.as_vec3(), child.rotation.as_quat(), collider(child.collider.shape()))
            };
            Collider::compound(compound.children().iter().map(part).collect())
        }
        Shape::Mesh(mesh) => {
            let vertices = mesh.vertices().map(|vertex| vertex.as_vec3()).collect();
            Collider::trimesh_with_config(vertices, mesh.triangles().to_vec(), TrimeshFlags::FIX_INTERNAL_EDGES)
        }
    }
}

/// What it cannot do of a joint.
pub fn lacks(joint: &Joint) -> Option<&'static str> {
    match joint.kind {
        JointKindSpec::Generic { .. } => Some("generic joints"),
        // To it, 0 is no bound.
        _ if joint.motor.is_some_and(|motor| motor.max_force == 0.0) => Some("motors without force"),
        _ => None,
    }
}

fn spawn_joint(world: &mut World, joint: &Joint, entities: &[Entity], bodies: &[Body]) -> Entity {
    let (a, b) = (entities[joint.a], entities[joint.b]);
    let (anchor_a, anchor_b) = (joint.anchor_a.as_vec3(), joint.anchor_b.as_vec3());
    let (basis_a, basis_b) = (joint.frame_a.as_quat(), joint.frame_b.as_quat());
    let range = joint.range().map(|range| range.map(finite));
    let mut entity = match joint.kind {
        JointKindSpec::Ball => world.spawn(ball(joint, [a, b])),
        JointKindSpec::Hinge | JointKindSpec::Generic { .. } => {
            let mut hinge = RevoluteJoint::new(a, b)
                .with_local_anchor1(anchor_a)
                .with_local_anchor2(anchor_b)
                .with_local_basis1(basis_a)
                .with_local_basis2(basis_b)
                .with_hinge_axis(Vec3::X);
            hinge.angle_limit = range.map(|[min, max]| AngleLimit::new(min, max));
            if let Some(motor) = joint.motor {
                hinge.motor = AngularMotor::new(model(&motor, joint, bodies))
                    .with_target_velocity(speed_of(&motor).unwrap_or(0.0) as f32)
                    .with_target_position(place(&motor))
                    .with_max_torque(finite(motor.max_force));
            }
            world.spawn(hinge)
        }
        JointKindSpec::Slider => {
            let mut slider = PrismaticJoint::new(a, b)
                .with_local_anchor1(anchor_a)
                .with_local_anchor2(anchor_b)
                .with_local_basis1(basis_a)
                .with_local_basis2(basis_b)
                .with_slider_axis(Vec3::X);
            slider.limits = range.map(|[min, max]| DistanceLimit { min, max });
            if let Some(motor) = joint.motor {
                slider.motor = LinearMotor::new(model(&motor, joint, bodies))
                    .with_target_velocity(speed_of(&motor).unwrap_or(0.0) as f32)
                    .with_target_position(place(&motor))
                    .with_max_force(finite(motor.max_force));
            }
            world.spawn(slider)
        }
        JointKindSpec::Fixed => world.spawn(
            FixedJoint::new(a, b)
                .with_local_anchor1(anchor_a)
                .with_local_anchor2(anchor_b)
                .with_local_basis1(basis_a)
                .with_local_basis2(basis_b),
        ),
        JointKindSpec::Distance(law) => {
            let mut rod = DistanceJoint::new(a, b).with_local_anchor1(anchor_a).with_local_anchor2(anchor_b);
            if let DistanceLaw::Range { min, max } = law {
                rod = rod.with_limits(min as f32, finite(max));
            }
            world.spawn(rod)
        }
    };
    if !joint.collide {
        entity.insert(JointCollisionDisabled);
    }
    entity.id()
}

/// A ball joint. Its documentation has the swing measured between the twist axes of both bodies; the code has it measured
/// between vectors across them, and the twist about those. So such a vector is laid along the joint's axis.
fn ball(joint: &Joint, [a, b]: [Entity; 2]) -> SphericalJoint {
    let across = SphericalJoint::DEFAULT_TWIST_AXIS.any_orthonormal_vector();
    let turn = Quat::from_rotation_arc(across, Vec3::X);
    let mut ball = SphericalJoint::new(a, b)
        .with_local_anchor1(joint.anchor_a.as_vec3())
        .with_local_anchor2(joint.anchor_b.as_vec3());
    if let (Some(limits), Some([min, max])) = (joint.limits, joint.range()) {
        ball = ball
            .with_local_basis1(joint.frame_a.as_quat() * turn)
            .with_local_basis2(joint.frame_b.as_quat() * turn)
            .with_twist_limits(min as f32, max as f32);
        if let Some(swing) = limits.swing.filter(|swing| swing.is_finite()) {
            ball = ball.with_swing_limits(-swing as f32, swing as f32);
        }
    }
    ball
}

/// Of the critically damped spring that follows a motion, Hz: half of the rate of its substeps at 60 Hz. A softer one lags
/// by more in `arm`, and a speed that is told anew, as the other engines follow, tears it apart.
const FOLLOWING: f32 = 120.0;

/// How a motor gets to its target. Only its implicit spring has forces of the units that it tells.
fn model(motor: &Motor, joint: &Joint, bodies: &[Body]) -> MotorModel {
    match motor.drive {
        // All that its speed lacks, within a substep.
        Drive::Motion(_) => MotorModel::SpringDamper { frequency: FOLLOWING, damping_ratio: 1.0 },
        Drive::Speed(_) => MotorModel::AccelerationBased { stiffness: 0.0, damping: 1.0 },
        Drive::Spring { stiffness, damping, .. } => {
            let (frequency, ratio) = frequency_and_ratio(stiffness, damping, joint.effective_mass(bodies));
            MotorModel::SpringDamper { frequency: frequency as f32, damping_ratio: ratio as f32 }
        }
    }
}

fn place(motor: &Motor) -> f32 {
    if let Drive::Spring { target, .. } = motor.drive { target as f32 } else { 0.0 }
}
