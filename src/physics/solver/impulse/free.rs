//! Bodies that nothing holds or touches: in flight exactly, spinning with energy and angular
//! momentum kept.

use nalgebra::{UnitQuaternion, Vector3};

use crate::physics::bodies::{Body, rotation_by, world_inverse_inertia};
use crate::physics::integrator::gyroscopic;

/// The angular velocity, world axes, and the rotation after a time h of a body that is not round; none
/// where the angular velocity stays what it is.
pub(super) fn free_rotation(
    rotation: &UnitQuaternion<f64>,
    angular: &Vector3<f64>,
    inverse_inertia_body: &Vector3<f64>,
    rotation_freedom: &Vector3<f64>,
    h: f64,
) -> Option<(Vector3<f64>, UnitQuaternion<f64>)> {
    let can_turn = inverse_inertia_body.min() > 0.0 && *rotation_freedom == Vector3::repeat(1.0);
    if !can_turn || gyroscopic::is_isotropic(inverse_inertia_body) || *angular == Vector3::zeros() {
        return None;
    }
    let spin = rotation.inverse_transform_vector(angular);
    let turned = gyroscopic::rotate(&inverse_inertia_body.map(f64::recip), &spin, h);
    let rotation = rotation * turned.turn;
    Some((rotation * turned.angular, rotation))
}

/// Turns a body without torque over a time h.
pub(super) fn turn_freely(
    rotation: &mut UnitQuaternion<f64>,
    angular: &mut Vector3<f64>,
    inverse_inertia_body: &Vector3<f64>,
    rotation_freedom: &Vector3<f64>,
    h: f64,
) {
    match free_rotation(rotation, angular, inverse_inertia_body, rotation_freedom, h) {
        Some(turned) => (*angular, *rotation) = turned,
        None if *angular != Vector3::zeros() => *rotation = rotation_by(&(*angular * h)) * *rotation,
        None => {}
    }
}

/// A step of `substeps` of length `h`, s.
pub(super) fn fly(body: &mut Body, h: f64, substeps: u32) {
    let push = body.inverse_mass.component_mul(&body.force) * h;
    for _ in 0..substeps {
        body.position += (body.linear + push * 0.5) * h;
        body.linear = (body.linear + push) / (1.0 + body.drag.0 * h);
        let Body { rotation, angular, inverse_inertia_body, rotation_freedom, torque, .. } = body;
        if *torque != Vector3::zeros() {
            *angular += world_inverse_inertia(inverse_inertia_body, rotation, rotation_freedom) * *torque * h;
        }
        turn_freely(rotation, angular, inverse_inertia_body, rotation_freedom, h);
        body.angular /= 1.0 + body.drag.1 * h;
    }
    body.rotation.renormalize_fast();
    body.has_stepped = true;
}
