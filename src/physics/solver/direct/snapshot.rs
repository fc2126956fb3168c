//! A body as a step found or left it: what tells whether anybody has changed it since.

use nalgebra::{UnitQuaternion, Vector3};

use crate::physics::body::Body;

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Snapshot {
    position: Vector3<f64>,
    rotation: UnitQuaternion<f64>,
    linear: Vector3<f64>,
    angular: Vector3<f64>,
    force: Vector3<f64>,
    torque: Vector3<f64>,
    mass: f64,
    inverse_inertia_body: Vector3<f64>,
}

impl Snapshot {
    pub fn of(body: &Body) -> Self {
        let &Body { position, rotation, linear, angular, force, torque, mass, inverse_inertia_body, .. } = body;
        Self { position, rotation, linear, angular, force, torque, mass, inverse_inertia_body }
    }
}
