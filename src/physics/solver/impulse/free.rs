//! Bodies that nothing holds or touches: in flight exactly, spinning with energy and angular
//! momentum kept.

use nalgebra::{UnitQuaternion, Vector3};

use crate::physics::bodies::{Body, rotation_by, world_inverse_inertia};
use crate::physics::integrator::gyroscopic;

/// What turning by a time h does to the angular velocity of a body that is not round, and the turn,
/// both in world axes; none where that needs no look.
pub(crate) fn free_rotation(body: &Body, h: f64) -> Option<(Vector3<f64>, UnitQuaternion<f64>)> {
    let can_turn = body.inverse_inertia_body.min() > 0.0 && body.rotation_freedom == Vector3::repeat(1.0);
    if !can_turn || gyroscopic::is_isotropic(&body.inverse_inertia_body) || body.angular == Vector3::zeros() {
        return None;
    }
    let spin = body.rotation.inverse_transform_vector(&body.angular);
    let turned = gyroscopic::rotate(&body.inverse_inertia_body.map(f64::recip), &spin, h);
    let rotation = body.rotation * turned.turn;
    Some((rotation * turned.angular, rotation))
}

/// A step of `substeps` of length `h`, s.
pub(crate) fn fly(body: &mut Body, h: f64, substeps: u32) {
    let push = body.inverse_mass.component_mul(&body.force) * h;
    for _ in 0..substeps {
        body.position += (body.linear + push * 0.5) * h;
        body.linear = (body.linear + push) / (1.0 + body.drag.0 * h);
        if body.torque != Vector3::zeros() {
            let inverse = world_inverse_inertia(&body.inverse_inertia_body, &body.rotation, &body.rotation_freedom);
            body.angular += inverse * body.torque * h;
        }
        match free_rotation(body, h) {
            Some((angular, rotation)) => (body.angular, body.rotation) = (angular, rotation),
            None if body.angular != Vector3::zeros() => {
                body.rotation = rotation_by(&(body.angular * h)) * body.rotation;
            }
            None => {}
        }
        body.angular /= 1.0 + body.drag.1 * h;
    }
    body.rotation.renormalize_fast();
    body.has_stepped = true;
}
