//! The solver's packed copy of the bodies, gathered from the ECS at the start of each step and
//! written back at its end. A private cache: never the only copy of anything.

use bevy::prelude::*;
use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use super::body::{CollisionLayers, RigidBody, SurfaceMaterial};
use super::collider::Geometry;

/// One body as the step sees it. World axes and SI unless stated.
#[derive(Clone, Debug)]
pub(crate) struct Body {
    pub entity: Entity,
    /// A quarantined body counts as static.
    pub kind: RigidBody,
    pub position: Vector3<f64>,
    pub rotation: UnitQuaternion<f64>,
    pub linear: Vector3<f64>,
    pub angular: Vector3<f64>,
    /// Force and torque of this step, gravity included.
    pub force: Vector3<f64>,
    pub torque: Vector3<f64>,
    /// 0 for what the solver does not move.
    pub mass: f64,
    /// Per world axis; zero for static and kinematic bodies and along locked axes.
    pub inverse_mass: Vector3<f64>,
    /// Principal, body axes; zero like `inverse_mass`.
    pub inverse_inertia_body: Vector3<f64>,
    /// World axes, locked axes zeroed, for the present rotation.
    pub inverse_inertia: Matrix3<f64>,
    /// 0 about a locked world axis, 1 else.
    pub rotation_freedom: Vector3<f64>,
    /// Drag, 1/s, linear and angular, the settings' included.
    pub drag: (f64, f64),
    /// None: the body touches nothing.
    pub geometry: Option<Geometry>,
    /// Bounding sphere about the centre of mass, m; infinite for a half-space, 0 without geometry.
    pub radius: f64,
    pub material: SurfaceMaterial,
    pub layers: CollisionLayers,
    /// Wants [`super::Collision`] messages.
    pub reports: bool,
    /// Mass and inertia that Plumb computed itself, to be computed again when the shape changes.
    pub computed_mass: Option<f64>,
    pub computed_inertia: Option<Vector3<f64>>,
    /// Collider, density or mass changed since they were computed.
    pub mass_is_stale: bool,
}

impl Body {
    /// A body of that entity, at rest at the origin, touching nothing.
    pub fn new(entity: Entity) -> Self {
        Self {
            entity,
            kind: RigidBody::Static,
            position: Vector3::zeros(),
            rotation: UnitQuaternion::identity(),
            linear: Vector3::zeros(),
            angular: Vector3::zeros(),
            force: Vector3::zeros(),
            torque: Vector3::zeros(),
            mass: 0.0,
            inverse_mass: Vector3::zeros(),
            inverse_inertia_body: Vector3::zeros(),
            inverse_inertia: Matrix3::zeros(),
            rotation_freedom: Vector3::repeat(1.0),
            drag: (0.0, 0.0),
            geometry: None,
            radius: 0.0,
            material: SurfaceMaterial::default(),
            layers: CollisionLayers::ALL,
            reports: false,
            computed_mass: None,
            computed_inertia: None,
            mass_is_stale: false,
        }
    }

    /// Whether contacts and joints can move it.
    pub fn is_dynamic(&self) -> bool {
        self.kind == RigidBody::Dynamic
    }

    /// Brings `inverse_inertia` up to date with the rotation.
    pub fn update_inverse_inertia(&mut self) {
        self.inverse_inertia =
            world_inverse_inertia(&self.inverse_inertia_body, &self.rotation, &self.rotation_freedom);
    }

    /// Velocity of the material point at `arm` from the centre of mass.
    pub fn point_velocity(&self, arm: &Vector3<f64>) -> Vector3<f64> {
        self.linear + self.angular.cross(arm)
    }
}

/// R I⁻¹ Rᵀ with the locked world axes zeroed; isotropic bodies skip the rotation.
pub(crate) fn world_inverse_inertia(
    principal: &Vector3<f64>,
    rotation: &UnitQuaternion<f64>,
    freedom: &Vector3<f64>,
) -> Matrix3<f64> {
    let isotropic = principal.x == principal.y && principal.y == principal.z;
    let world = if isotropic {
        Matrix3::from_diagonal(principal)
    } else {
        let r = rotation.to_rotation_matrix().into_inner();
        r * Matrix3::from_diagonal(principal) * r.transpose()
    };
    if *freedom == Vector3::repeat(1.0) {
        world
    } else {
        let free = Matrix3::from_diagonal(freedom);
        free * world * free
    }
}

/// All bodies, in the order in which they became bodies.
#[derive(Resource, Default)]
pub(crate) struct Bodies {
    pub list: Vec<Body>,
}

/// One joint as the step sees it.
#[derive(Clone, Debug)]
pub(crate) struct Joint {
    pub entity: Entity,
    /// Indices into [`Bodies`].
    pub a: u32,
    pub b: u32,
    /// From the centres of mass, body axes.
    pub anchor_a: Vector3<f64>,
    pub anchor_b: Vector3<f64>,
    pub softness: Option<super::joint::Softness>,
    /// Force on B in the last step, world axes, mean over its substeps, N.
    pub force: Vector3<f64>,
}

/// All joints, in the order in which they were made.
#[derive(Resource, Default)]
pub(crate) struct Joints {
    pub list: Vec<Joint>,
}
