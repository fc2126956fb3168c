//! Nonlinear projection, which the 2009 document planned: poses are moved out of their errors on their own, after the
//! step has moved them, and no velocity changes.
//!
//! Nonlinear Gauss–Seidel: with J a row of the poses as they are by now and C its error, an update moves the bodies by
//! M⁻¹Jᵀ(−m β C), m = 1/(J M⁻¹Jᵀ) and β the share `baumgarte`. C is min(0, slop − depth) of a contact point, whose
//! normal stays that of the step; of a joint's row all that its bound does not leave open. Springs, rates, and drives
//! with a largest force have none: they are no errors but forces.

use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};

use super::local::{LocalBody, LocalJoint, LocalManifold, LocalPoint};
use super::step_terms::StepTerms;
use crate::physics::constraint::row::{BodyTerms, RowPair, Twist};
use crate::physics::joint::{BodyState, JointRow};

/// Moves an island's bodies out of the errors of their contacts and of their joints at a time, s. Returns how many rows
/// it updated.
pub(super) fn project(
    bodies: &mut [LocalBody],
    (manifolds, points): (&[LocalManifold], &[LocalPoint]),
    joints: &[LocalJoint],
    terms: &StepTerms,
    time: f64,
    rows: &mut Vec<JointRow<f64>>,
) -> u64 {
    let mut updates = 0;
    for _ in 0..terms.settings.iterations {
        for manifold in manifolds {
            for point in &points[manifold.points.clone()] {
                project_point(bodies, manifold, point, terms);
            }
            updates += manifold.points.len() as u64;
        }
        for joint in joints {
            updates += project_joint(bodies, joint, terms, time, rows);
        }
    }
    updates
}

fn project_point(bodies: &mut [LocalBody], manifold: &LocalManifold, point: &LocalPoint, terms: &StepTerms) {
    let ends = [manifold.a, manifold.b].map(|body| &bodies[body as usize].body);
    let error = terms.settings.slop - point.depth_between(ends, &manifold.found.normal);
    if error < 0.0 {
        let [arm_a, arm_b] = [ends[0].rotation * point.body_arm_a, ends[1].rotation * point.body_arm_b];
        let jacobian = RowPair::along(manifold.found.normal, arm_a, arm_b);
        move_by(bodies, [manifold.a, manifold.b], &jacobian, error, terms);
    }
}

/// Returns how many rows it updated.
fn project_joint(
    bodies: &mut [LocalBody],
    joint: &LocalJoint,
    terms: &StepTerms,
    time: f64,
    rows: &mut Vec<JointRow<f64>>,
) -> u64 {
    let ends = [joint.a, joint.b].map(|body| &bodies[body as usize].body);
    let states = ends.map(|body| BodyState::new(&body.position, &body.rotation, [&body.linear, &body.angular]));
    rows.clear();
    joint.definition.rows_at(&states, time, rows);
    // What the rows before it have moved since these were made.
    let mut moved = [Twist::zero(); 2];
    let mut updates = 0;
    for row in rows.iter().filter(|row| is_projected(row)) {
        let error = row.error - row.bound.open(row.error) + row.jacobian.dot(&moved[0], &moved[1]);
        let steps = move_by(bodies, [joint.a, joint.b], &row.jacobian, error, terms);
        moved = [0, 1].map(|end| moved[end].plus(&steps[end], 1.0));
        updates += 1;
    }
    updates
}

/// Whether its error is mended by moving the poses, and not by its force.
pub(super) fn is_projected(row: &JointRow<f64>) -> bool {
    row.spring.is_none() && !row.is_rate && !row.bound.is_boxed()
}

/// Moves two bodies along a row by the share of its error that a sweep mends. Returns by how much.
fn move_by(
    bodies: &mut [LocalBody],
    ends: [u32; 2],
    jacobian: &RowPair<f64>,
    error: f64,
    terms: &StepTerms,
) -> [Twist<f64>; 2] {
    let [a, b] = ends.map(|end| inverse_masses(&bodies[end as usize]));
    let response = jacobian.response(&a, &b);
    let diagonal = jacobian.diagonal(&response);
    if diagonal <= 0.0 {
        return [Twist::zero(); 2];
    }
    let most = terms.correction_speed * terms.h;
    let mended = (-terms.settings.sweeps.baumgarte * error).clamp(-most, most);
    [0, 1].map(|end| {
        let step = Twist::zero().plus(&response.of(end), mended / diagonal);
        displace(&mut bodies[ends[end] as usize], &step);
        step
    })
}

fn inverse_masses(local: &LocalBody) -> BodyTerms<f64> {
    let inverse_inertia: Matrix3<f64> = local.inverse_inertia;
    BodyTerms { inverse_mass: local.body.inverse_mass, inverse_inertia, free: Twist::zero() }
}

/// x ← x + δ, q ← normalize(q + ½ θ q).
fn displace(local: &mut LocalBody, step: &Twist<f64>) {
    let body = &mut local.body;
    body.position += step.linear;
    if step.angular != Vector3::zeros() {
        let q = body.rotation.into_inner();
        body.rotation = UnitQuaternion::new_normalize(q + Quaternion::from_imag(step.angular) * q * 0.5);
        local.update_inverse_inertia();
    }
}
