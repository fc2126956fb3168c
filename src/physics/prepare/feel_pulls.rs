//! What springs that hold points may do to the bodies they hold, within the coming step.
//!
//! Contacts are sought as far ahead as bodies can come together at the velocities that they have. A hand that closes on a
//! limb at rest gives it 30 m/s in a step, and the limb would be within a post before the two had a contact. So each such
//! body is told what the pull can make of any point of it. With the force F at the arm r it is at most
//!
//! |F|/m + |I⁻¹ (r × F)| R,
//!
//! R the bounding radius. As the effective mass of what is held is no more than the body's own, for frequency ω, damping
//! ratio ζ, stretch d and rate ḋ
//!
//! |F| ≤ min(F_max, m (ω² |d| + 2ζω |ḋ|)).

use bevy::prelude::*;
use nalgebra::Vector3;

use crate::physics::{Bodies, Body, Joint, Joints, Softness, SolverSettings, world_inverse_inertia};

/// Who was pulled in the step before.
#[derive(Resource, Default, Clone)]
pub(super) struct Pulled {
    bodies: Vec<u32>,
    /// [`Bodies::version`] for which these are their indices.
    version: u64,
}

/// Tells bodies what springs may make of them. Only where contacts last are they sought at what bodies may come to.
pub(super) fn feel_pulls(
    joints: Res<Joints>,
    settings: Res<SolverSettings>,
    mut bodies: ResMut<Bodies>,
    mut pulled: ResMut<Pulled>,
) {
    let sprung = settings.method.keeps_contacts() && !joints.sprung.is_empty();
    if pulled.bodies.is_empty() && !sprung {
        return;
    }
    let version = bodies.version;
    let bodies = &mut bodies.bypass_change_detection().list;
    if std::mem::replace(&mut pulled.version, version) == version {
        pulled.bodies.drain(..).for_each(|body| bodies[body as usize].pulled = 0.0);
    } else {
        pulled.bodies.clear();
        bodies.iter_mut().for_each(|body| body.pulled = 0.0);
    }
    if !sprung {
        return;
    }
    for joint in &joints.list {
        let Some(softness) = joint.softness() else { continue };
        let ends = [joint.a, joint.b];
        let accelerations = pull(ends.map(|body| &bodies[body as usize]), joint, &softness);
        for (body, acceleration) in ends.into_iter().zip(accelerations) {
            if acceleration > 0.0 {
                bodies[body as usize].pulled += acceleration;
                pulled.bodies.push(body);
            }
        }
    }
    // What hangs on a body comes along.
    let held = pulled.bodies.len();
    for joint in joints.list.iter().filter(|joint| joint.softness().is_none()) {
        for [from, to] in [[joint.a, joint.b], [joint.b, joint.a]] {
            if pulled.bodies[..held].contains(&from) && bodies[to as usize].is_dynamic() {
                bodies[to as usize].pulled = bodies[to as usize].pulled.max(bodies[from as usize].pulled);
                pulled.bodies.push(to);
            }
        }
    }
}

/// The greatest acceleration that a spring may give a point of either body, m/s².
fn pull(bodies: [&Body; 2], joint: &Joint, softness: &Softness) -> [f64; 2] {
    let frames = joint.definition.frames;
    let arms: [Vector3<f64>; 2] = std::array::from_fn(|end| bodies[end].rotation * frames[end].anchor);
    let [a, b] = [0, 1].map(|end| bodies[end].position + arms[end]);
    let [va, vb] = [0, 1].map(|end| bodies[end].point_velocity(&arms[end]));
    let omega = std::f64::consts::TAU * softness.frequency;
    let stretch = b - a;
    let Some(direction) = stretch.try_normalize(f64::MIN_POSITIVE) else { return [0.0; 2] };
    let wanted = omega * omega * stretch.norm() + 2.0 * softness.damping_ratio * omega * (vb - va).norm();
    std::array::from_fn(|end| {
        let body = bodies[end];
        if !body.is_dynamic() {
            return 0.0;
        }
        let force = direction * (wanted * body.mass).min(softness.max_force);
        let turning = world_inverse_inertia(&body.inverse_inertia_body, &body.rotation, &body.rotation_freedom)
            * arms[end].cross(&force);
        body.inverse_mass.component_mul(&force).norm() + turning.norm() * body.radius
    })
}
