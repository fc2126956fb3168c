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
}

impl Body {
    /// Whether contacts and joints can move it.
    pub fn is_dynamic(&self) -> bool {
        self.kind == RigidBody::Dynamic
    }

    /// Brings `inverse_inertia` up to date with the rotation: R I⁻¹ Rᵀ, locked axes zeroed.
    pub fn update_inverse_inertia(&mut self) {
        let principal = self.inverse_inertia_body;
        let isotropic = principal.x == principal.y && principal.y == principal.z;
        self.inverse_inertia = if isotropic {
            Matrix3::from_diagonal(&principal)
        } else {
            let r = self.rotation.to_rotation_matrix().into_inner();
            r * Matrix3::from_diagonal(&principal) * r.transpose()
        };
        if self.rotation_freedom != Vector3::repeat(1.0) {
            let free = Matrix3::from_diagonal(&self.rotation_freedom);
            self.inverse_inertia = free * self.inverse_inertia * free;
        }
    }

    /// Velocity of the material point at `arm` from the centre of mass.
    pub fn point_velocity(&self, arm: &Vector3<f64>) -> Vector3<f64> {
        self.linear + self.angular.cross(arm)
    }
}

/// All bodies, in an order that does not change while bodies live.
#[derive(Resource, Default)]
pub(crate) struct Bodies {
    pub list: Vec<Body>,
}
