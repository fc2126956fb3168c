//! Bodies that nothing holds or touches: in flight exactly, spinning with energy and angular
//! momentum kept.

use nalgebra::Vector3;

use super::free_rotation::turn_freely;
use super::{Body, world_inverse_inertia};

/// A step of `substeps` of length `h`, s.
pub(crate) fn fly(body: &mut Body, h: f64, substeps: u32) {
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
