//! Rows of one island from its present poses: contacts first (normal row, then friction, point by
//! point), joints after, as the 2009 engine ordered them.

use crate::physics::scalar::Scalar;
use nalgebra::Vector3;

use super::local::{LocalBody, LocalJoint, LocalManifold, LocalPoint};
use super::projection;
use super::step_terms::StepTerms;
use crate::physics::body::Body;
use crate::physics::collision::Manifold;
use crate::physics::constraint::row::{BodyTerms, Bounds, Row, Spring, Twist};
use crate::physics::contact::{PointConstraint, penetration_bias, rebound, restitution_threshold, tangents};
use crate::physics::joint::{BodyState, Bound, JointRow};
use crate::physics::settings::FrictionModel;

/// Slip under which no friction direction can be told, m/s.
const LEAST_SLIP: f64 = 1e-6;

/// Slip under which a body counts as resting and its two tangents hang on the normal alone, m/s:
/// along what little the solver leaves of a resting body's slip they would turn with the rounding.
const LEAST_SLIDE: f64 = 1e-3;

fn vector<N: Scalar>(v: &Vector3<f64>) -> Vector3<N> {
    v.map(N::of)
}

/// What rows need of each body; `h` is the time over which the forces of this solve act.
pub(super) fn body_terms<N: Scalar>(bodies: &[LocalBody], h: f64, terms: &mut Vec<BodyTerms<N>>) {
    terms.clear();
    terms.extend(bodies.iter().map(|local| {
        let (body, free) = (&local.body, local.free_acceleration());
        BodyTerms {
            inverse_mass: vector(&body.inverse_mass),
            inverse_inertia: local.inverse_inertia.map(N::of),
            free: Twist {
                linear: vector(&(body.linear / h + free.linear)),
                angular: vector(&(body.angular / h + free.angular)),
            },
        }
    }));
}

/// The rows of one contact manifold.
pub(super) fn contact_rows<N: Scalar>(
    bodies: &[LocalBody],
    terms: &[BodyTerms<N>],
    manifold: &LocalManifold,
    points: &mut [LocalPoint],
    step: &StepTerms,
    h: f64,
    rows: &mut Vec<Row<N>>,
) {
    let [a, b] = [manifold.a, manifold.b].map(|body| &bodies[body as usize]);
    let h_scalar = N::of(h);
    let Manifold { normal, friction, restitution, .. } = &manifold.found;
    for point in points {
        point.first_row = rows.len();
        let (arm_a, arm_b) = (&point.arm_a, &point.arm_b);
        let site = PointConstraint {
            a: (manifold.a, &terms[manifold.a as usize]),
            b: (manifold.b, &terms[manifold.b as usize]),
            arm_a: vector(arm_a),
            arm_b: vector(arm_b),
            normal: vector(normal),
        };
        let velocity = b.body.point_velocity(arm_b) - a.body.point_velocity(arm_a);
        let greatest = step.greatest_push(point.depth);
        let mut bias = penetration_bias(point.depth, step.settings.slop, step.bias_rate, greatest, step.h);
        let approach = -normal.dot(&velocity);
        let parting = rebound(*restitution, approach, restitution_threshold(step.settings));
        if parting > 0.0 {
            bias = bias.max(parting);
        }
        rows.push(site.normal_row(N::of(bias), h_scalar, N::of(f64::MAX)));
        if *friction == 0.0 {
            continue;
        }
        match step.settings.friction {
            FrictionModel::Off => {}
            FrictionModel::OneTangent => {
                let slip = velocity - normal * normal.dot(&velocity);
                let speed = slip.norm();
                if speed >= LEAST_SLIP {
                    let limit = N::of(friction * mean_mass(&a.body, &b.body) * step.gravity);
                    let tangent = vector(&(slip / speed));
                    rows.push(site.friction_row(tangent, h_scalar, Bounds::Fixed(-limit, limit)));
                }
            }
            FrictionModel::TwoTangents => {
                let directions = slip_frame([a, b], [arm_a, arm_b], &velocity, normal, h);
                for (back, tangent) in (1..).zip(&directions) {
                    let coefficient = N::of(*friction);
                    let bounds = Bounds::Friction { coefficient, normal_rows_back: back };
                    rows.push(site.friction_row(vector(tangent), h_scalar, bounds));
                }
            }
        }
    }
}

/// m_c of the 2009 engine's friction bound; a partner that does not move counts as heavy as the
/// other.
fn mean_mass(a: &Body, b: &Body) -> f64 {
    match (a.mass > 0.0, b.mass > 0.0) {
        (true, true) => 0.5 * (a.mass + b.mass),
        (true, false) => a.mass,
        _ => b.mass,
    }
}

/// Two tangents, the first along the slip that there would be after `h` without contact: the
/// bound μ λ_n then holds exactly along a slide, whatever its direction, and a body pushed from
/// rest starts the way it is pushed.
fn slip_frame(
    bodies: [&LocalBody; 2],
    arms: [&Vector3<f64>; 2],
    velocity: &Vector3<f64>,
    normal: &Vector3<f64>,
    h: f64,
) -> [Vector3<f64>; 2] {
    let [a, b] = bodies.map(LocalBody::free_acceleration);
    let gained = b.linear + b.angular.cross(arms[1]) - a.linear - a.angular.cross(arms[0]);
    let free = velocity + gained * h;
    let slip = free - normal * normal.dot(&free);
    let speed = slip.norm();
    if speed < LEAST_SLIDE {
        return tangents(normal);
    }
    let along = slip / speed;
    [along, normal.cross(&along)]
}

/// The rows of one joint at a time, for forces that act over `h`; `scratch` is theirs before they know masses.
pub(super) fn joint_rows<N: Scalar>(
    bodies: &[LocalBody],
    terms: &[BodyTerms<N>],
    joint: &mut LocalJoint,
    step: &StepTerms,
    [time, h]: [f64; 2],
    scratch: &mut Vec<JointRow<f64>>,
    rows: &mut Vec<Row<N>>,
) {
    let ends = [joint.a, joint.b].map(|body| &bodies[body as usize].body);
    let states = ends.map(|body| BodyState::new(&body.position, &body.rotation, [&body.linear, &body.angular]));
    scratch.clear();
    joint.definition.rows_at(&states, time, scratch);
    joint.rows = rows.len()..rows.len() + scratch.len();
    joint.arm_b = ends[1].rotation * joint.definition.frames[1].anchor;
    let a = (joint.a, &terms[joint.a as usize]);
    let b = (joint.b, &terms[joint.b as usize]);
    for row in &*scratch {
        let jacobian = row.jacobian.map(N::of);
        let within = |lower, upper| Bounds::Fixed(N::of(lower), N::of(upper));
        let bounds = match row.bound {
            Bound::None => within(f64::MIN, f64::MAX),
            Bound::Within(lower, upper) => within(lower, upper),
            Bound::Norm { most, place, count } => Bounds::Norm { most: N::of(most), place, count },
        };
        rows.push(match row.spring {
            None => {
                let allowed = row.allowed_rate(h, restitution_threshold(step.settings));
                let rate = if projection::is_projected(row) { step.bias_rate } else { step.error_rate };
                let error = rate * (row.error - row.bound.open(row.error));
                let bias = allowed - error.clamp(-step.correction_speed, step.correction_speed) - row.time_rate;
                Row::rigid(a, b, jacobian, N::of(bias), N::of(h), bounds)
            }
            Some(constants) => {
                let mobility = row.jacobian.map(N::of);
                let mobility = mobility.diagonal(&mobility.response(a.1, b.1)).to_f64();
                let [stiffness, damping] =
                    constants.per_mass(if mobility > 0.0 { 1.0 / mobility } else { 0.0 }).map(N::of);
                Row::soft(a, b, jacobian, Spring { stiffness, damping, error: N::of(row.error) }, N::of(h), bounds)
            }
        });
    }
}
