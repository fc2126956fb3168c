//! Rapier: its default parameters, one solver iteration a substep, as it recommends.

use bevy::math::{DQuat, DVec3};
use plumb::lab::BodyState;
use plumb::physics::{Collider, RigidBody as Kind, Shape};
use rapier3d::prelude::{
    CoefficientCombineRule, ColliderBuilder, Group, InteractionGroups, InteractionTestMode, MassProperties,
    PhysicsWorld, Pose, RigidBodyBuilder, RigidBodyHandle, Rotation, SphericalJoint, Vector, nalgebra,
};

use super::{Engine, NO_HULL, cone_middle};
use crate::scene::{Body, Joint, Scene};

/// A scene in a Rapier world. Its threads are those of the global rayon pool.
pub struct Rapier {
    world: PhysicsWorld,
    bodies: Vec<RigidBodyHandle>,
}

impl Rapier {
    pub fn new(scene: &Scene, hz: f64, substeps: u32) -> Self {
        let mut world = PhysicsWorld { gravity: vector(scene.spec.gravity), ..Default::default() };
        world.integration_parameters.dt = (1.0 / hz) as f32;
        world.integration_parameters.num_solver_iterations = substeps as usize;
        let bodies: Vec<RigidBodyHandle> = scene.bodies.iter().map(|body| insert(&mut world, body)).collect();
        for joint in &scene.joints {
            world.insert_impulse_joint(bodies[joint.a], bodies[joint.b], ball(joint));
        }
        Self { world, bodies }
    }
}

impl Engine for Rapier {
    fn step(&mut self) {
        self.world.step();
    }

    fn read(&mut self, states: &mut Vec<BodyState>) {
        states.clear();
        states.extend(self.bodies.iter().map(|&body| {
            let body = &self.world.bodies[body];
            let rotation = body.rotation();
            BodyState {
                position: double(body.translation()),
                rotation: DQuat::from_array([rotation.x, rotation.y, rotation.z, rotation.w].map(f64::from))
                    .normalize(),
                linear: double(body.linvel()),
                angular: double(body.angvel()),
            }
        }));
    }
}

fn insert(world: &mut PhysicsWorld, body: &Body) -> RigidBodyHandle {
    let mut builder = match body.kind {
        Kind::Dynamic => RigidBodyBuilder::dynamic(),
        Kind::Static | Kind::Kinematic => RigidBodyBuilder::fixed(),
    }
    .pose(Pose::from_parts(vector(body.position), rotation(body.rotation)))
    .linvel(vector(body.velocity.linear))
    .angvel(vector(body.velocity.angular))
    .linear_damping(body.damping.linear as f32)
    .angular_damping(body.damping.angular as f32)
    .gravity_scale(body.gravity_scale as f32)
    .can_sleep(false);
    if let Some(mass) = body.mass {
        let (mass, inertia) = (mass.mass as f32, vector(mass.inertia));
        builder = builder.additional_mass_properties(MassProperties::new(Vector::ZERO, mass, inertia));
    }
    let handle = world.insert_body(builder);
    if body.is_pushed() {
        // Until it is told otherwise.
        world.bodies[handle].add_force(vector(body.force.force), true);
        world.bodies[handle].add_torque(vector(body.force.torque), true);
    }
    if let Some(collider) = &body.collider {
        insert_collider(world, collider, body, handle);
    }
    handle
}

fn insert_collider(world: &mut PhysicsWorld, collider: &Collider, body: &Body, parent: RigidBodyHandle) {
    let groups = InteractionGroups::new(
        Group::from_bits_retain(body.layers.memberships),
        Group::from_bits_retain(body.layers.filters),
        InteractionTestMode::And,
    );
    let builder = shape(collider.shape())
        // The body has its mass from elsewhere.
        .density(0.0)
        .friction(body.material.friction as f32)
        .friction_combine_rule(CoefficientCombineRule::GeometricMean)
        .restitution(body.material.restitution as f32)
        .restitution_combine_rule(CoefficientCombineRule::Max)
        .collision_groups(groups);
    world.insert_collider(builder, Some(parent));
}

fn shape(shape: &Shape) -> ColliderBuilder {
    match shape {
        Shape::HalfSpace => ColliderBuilder::halfspace(nalgebra::Unit::new_unchecked(Vector::Y)),
        Shape::Sphere { radius } => ColliderBuilder::ball(*radius as f32),
        Shape::Cuboid { size } => {
            let half = vector(*size / 2.0);
            ColliderBuilder::cuboid(half.x, half.y, half.z)
        }
        Shape::Cone { radius, height } => {
            ColliderBuilder::cone((*height / 2.0) as f32, *radius as f32).translation(vector(cone_middle(*height)))
        }
        Shape::Hull(hull) => {
            let points: Vec<Vector> = hull.vertices().map(vector).collect();
            ColliderBuilder::convex_hull(&points).expect(NO_HULL)
        }
    }
}

fn ball(joint: &Joint) -> SphericalJoint {
    let mut ball = SphericalJoint::new();
    ball.set_local_anchor1(vector(joint.anchor_a))
        .set_local_anchor2(vector(joint.anchor_b))
        .set_contacts_enabled(joint.collide);
    ball
}

fn vector(v: DVec3) -> Vector {
    Vector::new(v.x as f32, v.y as f32, v.z as f32)
}

fn rotation(q: DQuat) -> Rotation {
    Rotation::from_xyzw(q.x as f32, q.y as f32, q.z as f32, q.w as f32)
}

fn double(v: Vector) -> DVec3 {
    DVec3::new(f64::from(v.x), f64::from(v.y), f64::from(v.z))
}
