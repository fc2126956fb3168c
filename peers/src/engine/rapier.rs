//! Rapier: its default parameters, one solver iteration a substep, as it recommends.

use bevy::math::{DQuat, DVec3};
use plumb::lab::BodyState;
use plumb::physics::{
    Collider, CompoundChild, DistanceLaw, JointAxis as Coordinate, RigidBody as Kind, Shape, TriangleMesh,
};
use plumb::scene::JointKindSpec;
use rapier3d::prelude::{
    CoefficientCombineRule, ColliderBuilder, GenericJoint, Group, ImpulseJointHandle, InteractionGroups,
    InteractionTestMode, JointAxesMask, JointAxis, MassProperties, MotorModel, PhysicsWorld, Pose, RigidBodyBuilder,
    RigidBodyHandle, Rotation, SharedShape, TriMeshFlags, Vector, nalgebra,
};

use super::{Engine, Follower, NO_HULL, cone_middle, finite, speed_of};
use crate::joint::{Drive, Joint};
use crate::scene::{Body, Scene};

/// A scene in a Rapier world. Its threads are those of the global rayon pool.
pub struct Rapier {
    world: PhysicsWorld,
    bodies: Vec<RigidBodyHandle>,
    followers: Vec<Follower<ImpulseJointHandle>>,
    hz: f64,
    steps: u64,
}

impl Rapier {
    pub fn new(scene: &Scene, hz: f64, substeps: u32, sleep: bool) -> Self {
        let mut world = PhysicsWorld { gravity: vector(scene.spec.gravity), ..Default::default() };
        world.integration_parameters.dt = (1.0 / hz) as f32;
        world.integration_parameters.num_solver_iterations = substeps as usize;
        let bodies: Vec<RigidBodyHandle> = scene.bodies.iter().map(|body| insert(&mut world, body, sleep)).collect();
        let join = |joint: &Joint| world.insert_impulse_joint(bodies[joint.a], bodies[joint.b], joint_of(joint));
        let joints: Vec<ImpulseJointHandle> = scene.joints.iter().map(join).collect();
        Self { world, bodies, followers: Follower::of(&scene.joints, &joints), hz, steps: 0 }
    }

    fn state(&self, body: usize) -> BodyState {
        let body = &self.world.bodies[self.bodies[body]];
        let rotation = body.rotation();
        BodyState {
            position: double(body.translation()),
            rotation: DQuat::from_array([rotation.x, rotation.y, rotation.z, rotation.w].map(f64::from)).normalize(),
            linear: double(body.linvel()),
            angular: double(body.angvel()),
        }
    }

    fn follow(&mut self) {
        let times = [self.steps as f64 / self.hz, self.hz.recip()];
        let speeds: Vec<f64> =
            self.followers.iter().map(|joint| joint.speed(times, MADE_GOOD, |body| self.state(body))).collect();
        for (follower, speed) in self.followers.iter().zip(speeds) {
            let Some(joint) = self.world.impulse_joints.get_mut(follower.handle, false) else { continue };
            if let Some(axis) = axis_of(&follower.joint) {
                joint.data.set_motor_velocity(axis, speed as f32, RIGID);
            }
        }
    }
}

impl Engine for Rapier {
    fn step(&mut self) {
        self.follow();
        self.world.step();
        self.steps += 1;
    }

    fn read(&mut self, states: &mut Vec<BodyState>) {
        states.clear();
        states.extend((0..self.bodies.len()).map(|body| self.state(body)));
    }
}

fn insert(world: &mut PhysicsWorld, body: &Body, sleep: bool) -> RigidBodyHandle {
    let mut builder = match body.kind {
        Kind::Dynamic => RigidBodyBuilder::dynamic(),
        Kind::Static => RigidBodyBuilder::fixed(),
        Kind::Kinematic => RigidBodyBuilder::kinematic_velocity_based(),
    }
    .pose(Pose::from_parts(vector(body.position), rotation(body.rotation)))
    .linvel(vector(body.velocity.linear))
    .angvel(vector(body.velocity.angular))
    .linear_damping(body.damping.linear as f32)
    .angular_damping(body.damping.angular as f32)
    .gravity_scale(body.gravity_scale as f32)
    .can_sleep(sleep);
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
        Shape::Capsule { radius, length } => ColliderBuilder::capsule_y((*length / 2.0) as f32, *radius as f32),
        Shape::Cylinder { radius, height } => ColliderBuilder::cylinder((*height / 2.0) as f32, *radius as f32),
        Shape::Cone { radius, height } => {
            ColliderBuilder::cone((*height / 2.0) as f32, *radius as f32).translation(vector(cone_middle(*height)))
        }
        Shape::Hull(hull) => {
            let points: Vec<Vector> = hull.vertices().map(vector).collect();
            ColliderBuilder::convex_hull(&points).expect(NO_HULL)
        }
        Shape::Compound(compound) => ColliderBuilder::compound(compound.children().iter().map(part).collect()),
        Shape::Mesh(mesh) => ColliderBuilder::new(surface(mesh)),
    }
}

/// A part of a compound where it lies in it.
fn part(child: &CompoundChild) -> (Pose, SharedShape) {
    let collider = shape(child.collider.shape()).build();
    let place = Pose::from_parts(vector(child.position), rotation(child.rotation));
    (place * *collider.position(), collider.shared_shape().clone())
}

/// One-sided: what touches an edge is turned to a face beside it, as its documentation recommends for grounds.
fn surface(mesh: &TriangleMesh) -> SharedShape {
    let vertices = mesh.vertices().map(vector).collect();
    SharedShape::trimesh_with_flags(vertices, mesh.triangles().to_vec(), TriMeshFlags::FIX_INTERNAL_EDGES)
        .expect("a mesh of Plumb has triangles")
}

/// What it cannot do of a joint.
pub fn lacks(joint: &Joint) -> Option<&'static str> {
    let Joint { kind, motor, limits, .. } = joint;
    match kind {
        JointKindSpec::Distance(DistanceLaw::Range { min, .. }) if *min > 0.0 => Some("least distances"),
        _ if (motor.is_some() || limits.is_some_and(|limits| limits.swing.is_none())) && axis_of(joint).is_none() => {
            Some("motors and limits of swings and distances")
        }
        _ => None,
    }
}

/// Share of its lag that a motor which follows a motion makes good in a step: with less, it lags by more in `arm`.
const MADE_GOOD: f64 = 1.0;

/// Damping of a motor that asks for a speed, in units of what it moves, 1/s: it gets there within a substep.
const RIGID: f32 = 1e10;

fn joint_of(joint: &Joint) -> GenericJoint {
    let mut made = GenericJoint::new(locked(&joint.kind));
    made.set_local_frame1(Pose::from_parts(vector(joint.anchor_a), rotation(joint.frame_a)))
        .set_local_frame2(Pose::from_parts(vector(joint.anchor_b), rotation(joint.frame_b)))
        .set_contacts_enabled(joint.collide);
    limit(&mut made, joint);
    if let (Some(motor), Some(axis)) = (joint.motor, axis_of(joint)) {
        if let Some(speed) = speed_of(&motor) {
            made.set_motor_velocity(axis, speed as f32, RIGID);
        } else if let Drive::Spring { target, stiffness, damping } = motor.drive {
            made.set_motor_position(axis, target as f32, stiffness as f32, damping as f32);
            made.set_motor_model(axis, MotorModel::ForceBased);
        }
        made.set_motor_max_force(axis, finite(motor.max_force));
    }
    made
}

fn limit(made: &mut GenericJoint, joint: &Joint) {
    if let JointKindSpec::Distance(DistanceLaw::Range { max, .. }) = joint.kind {
        made.coupled_axes = JointAxesMask::LIN_AXES;
        made.set_limits(JointAxis::LinX, [0.0, finite(max)]);
    }
    let Some(range) = joint.range() else { return };
    if let Some(swing) = joint.limits.and_then(|limits| limits.swing).filter(|swing| swing.is_finite()) {
        // Its limit of two coupled angles is of the one between the axes; a least one below zero is none.
        made.coupled_axes = JointAxesMask::ANG_Y | JointAxesMask::ANG_Z;
        made.set_limits(JointAxis::AngY, [-1.0, swing as f32]);
    }
    made.set_limits(axis_of(joint).unwrap_or(JointAxis::AngX), range.map(finite));
}

fn locked(kind: &JointKindSpec) -> JointAxesMask {
    match kind {
        JointKindSpec::Ball => JointAxesMask::LOCKED_SPHERICAL_AXES,
        JointKindSpec::Hinge => JointAxesMask::LOCKED_REVOLUTE_AXES,
        JointKindSpec::Slider => JointAxesMask::LOCKED_PRISMATIC_AXES,
        JointKindSpec::Fixed => JointAxesMask::LOCKED_FIXED_AXES,
        JointKindSpec::Distance(_) => JointAxesMask::empty(),
        JointKindSpec::Generic { translations, rotations, .. } => {
            let held = translations.iter().chain(rotations).enumerate().filter(|(_, held)| **held);
            // x, y and z, then the twist and the swings about y and z: its own order.
            JointAxesMask::from_bits_truncate(held.fold(0, |mask, (axis, _)| mask | 1 << axis))
        }
    }
}

/// The axis that a motor and limits act on, where it has that one.
fn axis_of(joint: &Joint) -> Option<JointAxis> {
    match joint.axis()? {
        Coordinate::X => Some(JointAxis::LinX),
        Coordinate::Y => Some(JointAxis::LinY),
        Coordinate::Z => Some(JointAxis::LinZ),
        Coordinate::Twist => Some(JointAxis::AngX),
        Coordinate::Swing | Coordinate::Distance => None,
    }
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
