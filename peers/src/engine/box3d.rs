//! Box3D through its C interface: its default definitions, with sleep off unless it is asked for.
#![allow(unsafe_code)]

use std::f64::consts::FRAC_1_SQRT_2;
use std::ffi::c_int;

use bevy::math::{DQuat, DVec3};
use box3d_sys::*;
use plumb::lab::BodyState;
use plumb::physics::{DistanceLaw, MassProperties, RigidBody as Kind, Shape, TriangleMesh};
use plumb::scene::JointKindSpec;

use super::{Engine, Follower, NO_HULL, finite, speed_of};
use crate::joint::{Drive, Joint, Motor, frequency_and_ratio};
use crate::scene::{Body, Scene};

/// A scene in a Box3D world, which dies with it.
pub struct Box3d {
    world: b3WorldId,
    bodies: Vec<b3BodyId>,
    /// Its shapes refer to them; each dies once, after the world.
    meshes: Vec<*mut b3MeshData>,
    /// Bodies with a force and torque that last; Box3D clears both at each step.
    pushed: Vec<(b3BodyId, b3Vec3, b3Vec3)>,
    followers: Vec<Follower<b3JointId>>,
    hz: f64,
    substeps: c_int,
    steps: u64,
}

impl Box3d {
    pub fn new(scene: &Scene, hz: f64, substeps: u32, threads: u32, sleep: bool) -> Self {
        // SAFETY: default definitions are valid, and only public fields are changed.
        let world = unsafe {
            let mut definition = b3DefaultWorldDef();
            definition.gravity = vector(scene.spec.gravity);
            definition.enableSleep = sleep;
            definition.workerCount = threads;
            b3CreateWorld(&definition)
        };
        let ground = ground_half_extent(scene);
        let mut meshes = Meshes::default();
        let bodies: Vec<b3BodyId> =
            scene.bodies.iter().map(|body| create_body(world, body, ground, &mut meshes)).collect();
        let joints: Vec<b3JointId> =
            scene.joints.iter().map(|joint| create_joint(world, joint, &bodies, &scene.bodies)).collect();
        let followers = Follower::of(&scene.joints, &joints);
        let pushed = scene.bodies.iter().zip(&bodies).filter(|(body, _)| body.is_pushed());
        let pushed = pushed.map(|(body, &id)| (id, vector(body.force.force), vector(body.force.torque))).collect();
        Self { world, bodies, meshes: meshes.made, pushed, followers, hz, substeps: substeps as c_int, steps: 0 }
    }

    fn state(&self, body: usize) -> BodyState {
        let body = self.bodies[body];
        // SAFETY: the body lives as long as self.
        let (position, rotation, linear, angular) = unsafe {
            (
                b3Body_GetWorldCenter(body),
                b3Body_GetRotation(body),
                b3Body_GetLinearVelocity(body),
                b3Body_GetAngularVelocity(body),
            )
        };
        let b3Quat { v, s } = rotation;
        BodyState {
            position: double(position),
            rotation: DQuat::from_array([v.x, v.y, v.z, s].map(f64::from)).normalize(),
            linear: double(linear),
            angular: double(angular),
        }
    }

    fn follow(&self) {
        let times = [self.steps as f64 / self.hz, self.hz.recip()];
        for follower in &self.followers {
            let speed = follower.speed(times, MADE_GOOD, |body| self.state(body)) as f32;
            // SAFETY: the joint lives as long as self and is of that kind: others have no motors.
            unsafe {
                match follower.joint.kind {
                    JointKindSpec::Slider => b3PrismaticJoint_SetMotorSpeed(follower.handle, speed),
                    _ => b3RevoluteJoint_SetMotorSpeed(follower.handle, speed),
                }
            }
        }
    }
}

impl Engine for Box3d {
    fn step(&mut self) {
        self.follow();
        self.steps += 1;
        // SAFETY: the world and its bodies live as long as self.
        unsafe {
            for &(body, force, torque) in &self.pushed {
                b3Body_ApplyForceToCenter(body, force, true);
                b3Body_ApplyTorque(body, torque, true);
            }
            b3World_Step(self.world, self.hz.recip() as f32, self.substeps);
        }
    }

    fn read(&mut self, states: &mut Vec<BodyState>) {
        states.clear();
        states.extend((0..self.bodies.len()).map(|body| self.state(body)));
    }
}

impl Drop for Box3d {
    fn drop(&mut self) {
        // SAFETY: the world and the meshes were created with self and nothing uses them after this.
        unsafe {
            b3DestroyWorld(self.world);
            self.meshes.iter().for_each(|&mesh| b3DestroyMesh(mesh));
        }
    }
}

/// Of the library, with that of the crate that brings it.
pub fn version() -> String {
    // SAFETY: it only returns numbers.
    let b3Version { major, minor, revision } = unsafe { b3GetVersion() };
    format!("{major}.{minor}.{revision} (box3d-sys {})", super::locked_version("box3d-sys"))
}

fn create_body(world: b3WorldId, body: &Body, ground: f64, meshes: &mut Meshes) -> b3BodyId {
    // SAFETY: the world exists, the default definition is valid, and only public fields are changed.
    let id = unsafe {
        let mut definition = b3DefaultBodyDef();
        definition.type_ = match body.kind {
            Kind::Dynamic => b3BodyType_b3_dynamicBody,
            Kind::Kinematic => b3BodyType_b3_kinematicBody,
            Kind::Static => b3BodyType_b3_staticBody,
        };
        definition.position = vector(body.position);
        definition.rotation = quaternion(body.rotation);
        definition.linearVelocity = vector(body.velocity.linear);
        definition.angularVelocity = vector(body.velocity.angular);
        definition.linearDamping = body.damping.linear as f32;
        definition.angularDamping = body.damping.angular as f32;
        definition.gravityScale = body.gravity_scale as f32;
        b3CreateBody(world, &definition)
    };
    if let Some(collider) = &body.collider {
        create_shapes(id, body, collider.shape(), ground, meshes);
    }
    if let Some(MassProperties { mass, inertia }) = body.mass {
        let [cx, cy, cz] = [inertia.x * DVec3::X, inertia.y * DVec3::Y, inertia.z * DVec3::Z].map(vector);
        let mass = b3MassData { mass: mass as f32, center: vector(DVec3::ZERO), inertia: b3Matrix3 { cx, cy, cz } };
        // SAFETY: the body was just created.
        unsafe { b3Body_SetMassData(id, mass) }
    }
    id
}

fn create_shapes(id: b3BodyId, body: &Body, shape: &Shape, ground: f64, meshes: &mut Meshes) {
    // SAFETY: the default definition is valid, and only public fields are changed; the body exists; a mesh lives as long as
    // the world.
    unsafe {
        let mut definition = b3DefaultShapeDef();
        definition.baseMaterial.friction = body.material.friction as f32;
        definition.baseMaterial.restitution = body.material.restitution as f32;
        definition.filter.categoryBits = u64::from(body.layers.memberships);
        definition.filter.maskBits = u64::from(body.layers.filters);
        // The body has its mass from elsewhere.
        definition.updateBodyMass = false;
        match shape {
            // Its own compounds are for static bodies: a body has as many shapes as parts.
            Shape::Compound(compound) => {
                for child in compound.children() {
                    create_shape(id, &definition, child.collider.shape(), child.position, child.rotation);
                }
            }
            Shape::Mesh(mesh) => {
                b3CreateMeshShape(id, &definition, meshes.of(mesh), vector(DVec3::ONE));
            }
            // It has no half-space.
            Shape::HalfSpace => {
                let size = 2.0 * DVec3::new(ground, GROUND_HALF_DEPTH, ground);
                let place = -GROUND_HALF_DEPTH * DVec3::Y;
                create_shape(id, &definition, &Shape::Cuboid { size }, place, DQuat::IDENTITY);
            }
            _ => create_shape(id, &definition, shape, DVec3::ZERO, DQuat::IDENTITY),
        }
    }
}

/// A solid at that place of its body.
fn create_shape(id: b3BodyId, definition: &b3ShapeDef, shape: &Shape, place: DVec3, turn: DQuat) {
    let at = |point: DVec3| vector(place + turn * point);
    // SAFETY: the body exists; what the calls read outlives them, since Box3D copies it.
    unsafe {
        match shape {
            Shape::Sphere { radius } => {
                let sphere = b3Sphere { center: at(DVec3::ZERO), radius: *radius as f32 };
                b3CreateSphereShape(id, definition, &sphere);
            }
            Shape::Cuboid { size } => {
                let half = vector(*size / 2.0);
                let place = b3Transform { p: vector(place), q: quaternion(turn) };
                let hull = b3MakeTransformedBoxHull(half.x, half.y, half.z, place);
                b3CreateHullShape(id, definition, &hull.base);
            }
            Shape::Capsule { radius, length } => {
                let [center1, center2] = [-0.5, 0.5].map(|end| at(DVec3::Y * (end * length)));
                let capsule = b3Capsule { center1, center2, radius: *radius as f32 };
                b3CreateCapsuleShape(id, definition, &capsule);
            }
            Shape::Cylinder { radius, height } => {
                create_hull(id, definition, &cylinder_points(*radius, *height).map(at).collect::<Vec<_>>());
            }
            Shape::Cone { radius, height } => {
                create_hull(id, definition, &cone_points(*radius, *height).map(at).collect::<Vec<_>>());
            }
            Shape::Hull(hull) => create_hull(id, definition, &hull.vertices().map(at).collect::<Vec<_>>()),
            Shape::HalfSpace | Shape::Compound(_) | Shape::Mesh(_) => unreachable!("no solids"),
        }
    }
}

/// Meshes of surfaces, one for all bodies that share one.
#[derive(Default)]
struct Meshes {
    made: Vec<*mut b3MeshData>,
    last: Option<TriangleMesh>,
}

impl Meshes {
    fn of(&mut self, mesh: &TriangleMesh) -> *const b3MeshData {
        if self.last.as_ref() != Some(mesh) {
            self.made.push(create_mesh(mesh));
            self.last = Some(mesh.clone());
        }
        self.made[self.made.len() - 1]
    }
}

fn create_mesh(mesh: &TriangleMesh) -> *mut b3MeshData {
    let mut vertices: Vec<b3Vec3> = mesh.vertices().map(vector).collect();
    let mut indices: Vec<i32> = mesh.triangles().iter().flatten().map(|&index| index as i32).collect();
    let definition = b3MeshDef {
        vertices: vertices.as_mut_ptr(),
        indices: indices.as_mut_ptr(),
        materialIndices: std::ptr::null_mut(),
        weldTolerance: 0.0,
        vertexCount: vertices.len() as c_int,
        triangleCount: mesh.triangles().len() as c_int,
        weldVertices: false,
        useMedianSplit: true,
        identifyEdges: true,
    };
    // SAFETY: as many vertices and triangles as said, which Box3D copies.
    let made = unsafe { b3CreateMesh(&definition, std::ptr::null_mut(), 0) };
    assert!(!made.is_null(), "it makes no mesh of the triangles");
    made
}

fn create_hull(id: b3BodyId, definition: &b3ShapeDef, points: &[b3Vec3]) {
    let count = points.len() as c_int;
    // SAFETY: as many points as said; the hull is used only if it was made, and destroyed once after
    // Box3D has copied it.
    unsafe {
        let hull = b3CreateHull(points.as_ptr(), count, count);
        assert!(!hull.is_null(), "{NO_HULL}");
        b3CreateHullShape(id, definition, hull);
        b3DestroyHull(hull);
    }
}

/// m.
const GROUND_HALF_DEPTH: f64 = 5.0;

/// The ground as a box reaches this far from its middle, m: past all bodies by as much as the widest
/// heap spreads: `convex_pile 80` falls from 320 m.
fn ground_half_extent(scene: &Scene) -> f64 {
    const MARGIN: f64 = 250.0;
    scene.bodies.iter().map(|body| body.position.x.abs().max(body.position.z.abs())).fold(0.0, f64::max) + MARGIN
}

/// Corners of the base and the apex, from the centre of mass.
fn cone_points(radius: f64, height: f64) -> impl Iterator<Item = DVec3> {
    rim_points(radius, -height / 4.0).chain([0.75 * height * DVec3::Y])
}

/// Corners of both ends.
fn cylinder_points(radius: f64, height: f64) -> impl Iterator<Item = DVec3> {
    rim_points(radius, -height / 2.0).chain(rim_points(radius, height / 2.0))
}

/// Corners of a circle at that height. 32 sides are what Box3D allows in its own cones.
fn rim_points(radius: f64, level: f64) -> impl Iterator<Item = DVec3> {
    const SIDES: usize = 32;
    (0..SIDES).map(move |side| {
        let (sin, cos) = (std::f64::consts::TAU * side as f64 / SIDES as f64).sin_cos();
        DVec3::new(radius * cos, level, radius * sin)
    })
}

/// What it cannot do of a joint.
pub fn lacks(joint: &Joint) -> Option<&'static str> {
    let is_spring = |motor: &Motor| matches!(motor.drive, Drive::Spring { .. });
    match joint.kind {
        JointKindSpec::Generic { .. } => Some("generic joints"),
        _ if joint.motor.is_some_and(|motor| is_spring(&motor) && motor.max_force.is_finite()) => {
            Some("springs with a largest force")
        }
        _ => None,
    }
}

fn create_joint(world: b3WorldId, joint: &Joint, ids: &[b3BodyId], bodies: &[Body]) -> b3JointId {
    // SAFETY: world and bodies exist, the default definitions are valid, and only public fields are
    // changed.
    unsafe {
        match joint.kind {
            JointKindSpec::Ball => {
                let mut definition = b3DefaultSphericalJointDef();
                set_base(&mut definition.base, joint, ids, AXIS_OF_HINGES);
                if let (Some(limits), Some([min, max])) = (joint.limits, joint.range()) {
                    definition.enableTwistLimit = true;
                    (definition.lowerTwistAngle, definition.upperTwistAngle) = (min as f32, max as f32);
                    if let Some(swing) = limits.swing.filter(|swing| swing.is_finite()) {
                        (definition.enableConeLimit, definition.coneAngle) = (true, swing as f32);
                    }
                }
                b3CreateSphericalJoint(world, &definition)
            }
            JointKindSpec::Hinge => {
                let mut definition = b3DefaultRevoluteJointDef();
                set_base(&mut definition.base, joint, ids, AXIS_OF_HINGES);
                if let Some([min, max]) = joint.range() {
                    definition.enableLimit = true;
                    (definition.lowerAngle, definition.upperAngle) = (min as f32, max as f32);
                }
                if let Some(motor) = joint.motor {
                    definition.maxMotorTorque = finite(motor.max_force);
                    if let Some(speed) = speed_of(&motor) {
                        (definition.enableMotor, definition.motorSpeed) = (true, speed as f32);
                    }
                    if let Some([target, hertz, ratio]) = spring(&motor.drive, joint, bodies) {
                        (definition.enableSpring, definition.targetAngle) = (true, target);
                        (definition.hertz, definition.dampingRatio) = (hertz, ratio);
                    }
                }
                b3CreateRevoluteJoint(world, &definition)
            }
            JointKindSpec::Slider => {
                let mut definition = b3DefaultPrismaticJointDef();
                set_base(&mut definition.base, joint, ids, DQuat::IDENTITY);
                if let Some(range) = joint.range() {
                    definition.enableLimit = true;
                    [definition.lowerTranslation, definition.upperTranslation] = range.map(finite);
                }
                if let Some(motor) = joint.motor {
                    definition.maxMotorForce = finite(motor.max_force);
                    if let Some(speed) = speed_of(&motor) {
                        (definition.enableMotor, definition.motorSpeed) = (true, speed as f32);
                    }
                    if let Some([target, hertz, ratio]) = spring(&motor.drive, joint, bodies) {
                        (definition.enableSpring, definition.targetTranslation) = (true, target);
                        (definition.hertz, definition.dampingRatio) = (hertz, ratio);
                    }
                }
                b3CreatePrismaticJoint(world, &definition)
            }
            JointKindSpec::Distance(DistanceLaw::Range { min, max }) => {
                let mut definition = b3DefaultDistanceJointDef();
                set_base(&mut definition.base, joint, ids, DQuat::IDENTITY);
                definition.length = min.max(if max.is_finite() { max } else { 0.0 }) as f32;
                if min < max {
                    // Only one that is a spring, of no stiffness, has limits.
                    (definition.enableSpring, definition.hertz, definition.enableLimit) = (true, 0.0, true);
                    (definition.minLength, definition.maxLength) = (min as f32, finite(max));
                }
                b3CreateDistanceJoint(world, &definition)
            }
            JointKindSpec::Fixed | JointKindSpec::Distance(_) | JointKindSpec::Generic { .. } => {
                let mut definition = b3DefaultWeldJointDef();
                set_base(&mut definition.base, joint, ids, DQuat::IDENTITY);
                b3CreateWeldJoint(world, &definition)
            }
        }
    }
}

/// Share of its lag that a motor which follows a motion makes good in a step: from some three quarters on, `arm` shakes,
/// since its joints overshoot the speeds they are asked for.
const MADE_GOOD: f64 = 0.5;

/// Takes z, about which its hinges turn and its ball joints twist, to x, which is a joint's axis here.
const AXIS_OF_HINGES: DQuat = DQuat::from_xyzw(0.0, FRAC_1_SQRT_2, 0.0, FRAC_1_SQRT_2);

fn set_base(base: &mut b3JointDef, joint: &Joint, ids: &[b3BodyId], turn: DQuat) {
    base.bodyIdA = ids[joint.a];
    base.bodyIdB = ids[joint.b];
    base.localFrameA = b3Transform { p: vector(joint.anchor_a), q: quaternion(joint.frame_a * turn) };
    base.localFrameB = b3Transform { p: vector(joint.anchor_b), q: quaternion(joint.frame_b * turn) };
    base.collideConnected = joint.collide;
}

/// Target, frequency, Hz, and damping ratio of a motor that is a spring.
fn spring(drive: &Drive, joint: &Joint, bodies: &[Body]) -> Option<[f32; 3]> {
    let &Drive::Spring { target, stiffness, damping } = drive else { return None };
    let (frequency, ratio) = frequency_and_ratio(stiffness, damping, joint.effective_mass(bodies));
    Some([target, frequency, ratio].map(|number| number as f32))
}

fn vector(v: DVec3) -> b3Vec3 {
    b3Vec3 { x: v.x as f32, y: v.y as f32, z: v.z as f32 }
}

fn quaternion(q: DQuat) -> b3Quat {
    b3Quat { v: vector(q.xyz()), s: q.w as f32 }
}

fn double(v: b3Vec3) -> DVec3 {
    DVec3::new(f64::from(v.x), f64::from(v.y), f64::from(v.z))
}
