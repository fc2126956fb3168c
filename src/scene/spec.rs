//! The data of a scene. Plain numbers in SI; [`SceneSpec::validate`] says what they may be.

use bevy::math::{DQuat, DVec3};

use crate::physics::{CollisionLayers, LockedAxes, RigidBody, Softness};

/// A whole scene.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneSpec {
    /// What it is called: the built-in name, or the file's stem.
    pub name: String,
    /// m/s².
    pub gravity: DVec3,
    /// Bodies, in the order in which they are spawned.
    pub bodies: Vec<BodySpec>,
    /// Joints between them.
    pub joints: Vec<JointSpec>,
    /// Where a camera best looks from.
    pub view: Option<ViewSpec>,
}

/// One body.
#[derive(Clone, Debug, PartialEq)]
pub struct BodySpec {
    /// Unique in the scene; joints refer to it.
    pub name: String,
    /// Dynamic, kinematic or static.
    pub kind: RigidBody,
    /// None: a point to pin things to (static or kinematic only, unless mass and inertia are given).
    pub shape: Option<ShapeSpec>,
    /// kg/m³; the mass wins where both are given.
    pub density: f64,
    /// kg.
    pub mass: Option<f64>,
    /// Principal moments, kg·m².
    pub inertia: Option<DVec3>,
    /// Centre of mass, m.
    pub position: DVec3,
    /// Orientation of the principal axes.
    pub rotation: DQuat,
    /// m/s.
    pub linear_velocity: DVec3,
    /// rad/s, world axes.
    pub angular_velocity: DVec3,
    /// N, lasts.
    pub force: DVec3,
    /// N·m, lasts.
    pub torque: DVec3,
    /// Surface.
    pub material: MaterialSpec,
    /// What it touches.
    pub layers: CollisionLayers,
    /// World axes it does not move along or about.
    pub locked: LockedAxes,
    /// Factor on gravity.
    pub gravity_scale: f64,
    /// Linear and angular drag, 1/s.
    pub damping: (f64, f64),
    /// sRGB colour in the picture, 0 to 1 each; none: chosen from the shape.
    pub color: Option<[f32; 3]>,
}

/// A body's shape; full sizes, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ShapeSpec {
    /// The ground: all below the plane through the body's position, normal +y in body axes.
    HalfSpace,
    /// A ball.
    Sphere {
        /// Radius.
        radius: f64,
    },
    /// A box.
    Cuboid {
        /// Full extents.
        size: DVec3,
    },
    /// A cone, apex up.
    Cone {
        /// Base radius.
        radius: f64,
        /// Height.
        height: f64,
    },
}

/// Friction and restitution of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MaterialSpec {
    /// μ ≥ 0.
    pub friction: f64,
    /// e, 0 to 1.
    pub restitution: f64,
}

/// A ball joint between two bodies.
#[derive(Clone, Debug, PartialEq)]
pub struct JointSpec {
    /// Name of body A.
    pub body_a: String,
    /// Name of body B.
    pub body_b: String,
    /// The joint's point from A's centre of mass, body axes, m.
    pub anchor_a: DVec3,
    /// The joint's point from B's centre of mass, body axes, m.
    pub anchor_b: DVec3,
    /// Whether the two collide.
    pub collide: bool,
    /// A damped spring instead of a rigid joint.
    pub softness: Option<Softness>,
}

/// A camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ViewSpec {
    /// Where it is, m.
    pub eye: DVec3,
    /// What it looks at, m.
    pub target: DVec3,
}

impl BodySpec {
    /// A dynamic body of that name, shape and centre of mass, all else at its default.
    pub fn new(name: impl Into<String>, shape: ShapeSpec, position: DVec3) -> Self {
        Self {
            name: name.into(),
            kind: RigidBody::Dynamic,
            shape: Some(shape),
            density: 1000.0,
            mass: None,
            inertia: None,
            position,
            rotation: DQuat::IDENTITY,
            linear_velocity: DVec3::ZERO,
            angular_velocity: DVec3::ZERO,
            force: DVec3::ZERO,
            torque: DVec3::ZERO,
            material: MaterialSpec { friction: 0.6, restitution: 0.0 },
            layers: CollisionLayers::ALL,
            locked: LockedAxes::default(),
            gravity_scale: 1.0,
            damping: (0.0, 0.0),
            color: None,
        }
    }
}
