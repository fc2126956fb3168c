//! Rows of single coordinates q, and of the laws of them. Translations and the twist are as above; besides,
//!
//! *swing*, the angle σ between a = a_x and b = b_x, with c = a × b, n = c/|c|:
//!
//! q = atan2(|c|, a · b),  u = n,  J̇v = Ω · (ċ − n (n · ċ))/|c|,  ċ = (ω_A × a) × b + a × (ω_B × b);
//!
//! where the axes are parallel, n has no direction, and the row is zero; *distance* ℓ = |d|, n = d/ℓ:
//!
//! J = [−n, −r_A × n, n, r_B × n],  J̇v = n · swirl + (|ḋ|² − ℓ̇²)/ℓ;
//!
//! *turning* about an axis a_k of A, of which there is a rate alone: u = a_k, J̇v = Ω · (ω_A × a_k).
//!
//! A limit has C = q − bound, a motion C = q − q(t) with ∂C/∂t = −q̇(t) and d/dt ∂C/∂t = −q̈(t), a rate C = 0 with
//! ∂C/∂t = −rate, a spring C = q − rest.

use std::f64::consts::TAU;

use nalgebra::Vector3;

use super::{Bound, JointRow, JointState};
use crate::physics::constraint::row::RowPair;
use crate::physics::joint::law::{CoordinateLaw, JointAxis, LawAxis, LawPart};
use crate::physics::joint::softness::SpringConstants;

/// Sine of a swing, and distance in m, under which they have no direction.
const NO_DIRECTION: f64 = 1e-9;

/// The row of a law at that time, s; the twist is the value nearest to `turned`.
pub(super) fn row(law: &CoordinateLaw, state: &JointState<f64>, turned: f64, time: f64) -> JointRow<f64> {
    let coordinate = match law.axis {
        LawAxis::Coordinate(axis) => coordinate(axis, state, turned),
        LawAxis::Turning(axis) => turning(axis, state),
    };
    let within = if law.most.is_finite() { Bound::Within(-law.most, law.most) } else { Bound::None };
    match law.part {
        LawPart::Limit { bound, is_upper, restitution } => {
            let pushes = if is_upper { (f64::NEG_INFINITY, 0.0) } else { (0.0, f64::INFINITY) };
            let error = coordinate.error - bound;
            JointRow { error, bound: Bound::Within(pushes.0, pushes.1), restitution, ..coordinate }
        }
        LawPart::Rate(rate) => {
            let (rate, time_rate) = (coordinate.rate - rate, -rate);
            JointRow { error: 0.0, rate, time_rate, is_rate: true, bound: within, ..coordinate }
        }
        LawPart::Motion(motion) => {
            let [q, rate, acceleration] = motion.at_time(time);
            JointRow {
                error: coordinate.error - q,
                rate: coordinate.rate - rate,
                time_rate: -rate,
                velocity_term: coordinate.velocity_term - acceleration,
                bound: within,
                ..coordinate
            }
        }
        LawPart::Spring { rest, stiffness, damping } => JointRow {
            error: coordinate.error - rest,
            spring: Some(SpringConstants::Given { stiffness, damping }),
            bound: Bound::Norm { most: law.most, place: 0, count: 1 },
            ..coordinate
        },
    }
}

/// The row whose error is a coordinate.
pub(super) fn coordinate(axis: JointAxis, state: &JointState<f64>, turned: f64) -> JointRow<f64> {
    match axis {
        JointAxis::X => translation(state, 0),
        JointAxis::Y => translation(state, 1),
        JointAxis::Z => translation(state, 2),
        JointAxis::Twist => {
            let row = state.twist(&state.rotations.map(|rotation| rotation.to_rotation_matrix().into_inner()));
            JointRow { error: row.error + TAU * ((turned - row.error) / TAU).round(), ..row }
        }
        JointAxis::Swing => swing(state),
        JointAxis::Distance => distance(state),
    }
}

fn translation(state: &JointState<f64>, axis: usize) -> JointRow<f64> {
    state.along(state.rotations[0].to_rotation_matrix().into_inner().column(axis).into())
}

fn swing(state: &JointState<f64>) -> JointRow<f64> {
    let [a, b] = state.rotations.map(|rotation| rotation * Vector3::x());
    let [of_a, of_b] = state.velocities.map(|velocity| velocity.angular);
    let (across, omega) = (a.cross(&b), of_b - of_a);
    let sine = across.norm();
    let angle = sine.atan2(a.dot(&b));
    if sine < NO_DIRECTION {
        return state.rotation(Vector3::zeros(), angle, 0.0);
    }
    let about = across / sine;
    let change = of_a.cross(&a).cross(&b) + a.cross(&of_b.cross(&b));
    state.rotation(about, angle, omega.dot(&(change - about * about.dot(&change))) / sine)
}

fn distance(state: &JointState<f64>) -> JointRow<f64> {
    let d = state.separation;
    let length = d.norm();
    let [a, b] = &state.velocities;
    let along = if length > NO_DIRECTION { d / length } else { Vector3::zeros() };
    let jacobian = RowPair::along(along, state.arms[0], state.arms[1]);
    let parting = b.linear + b.angular.cross(&state.arms[1]) - a.linear - a.angular.cross(&state.arms[0]);
    let across = parting.norm_squared() - along.dot(&parting).powi(2);
    let velocity_term = along.dot(&state.swirl()) + if length > NO_DIRECTION { across / length } else { 0.0 };
    state.translation(jacobian, length, velocity_term)
}

fn turning(axis: usize, state: &JointState<f64>) -> JointRow<f64> {
    let along: Vector3<f64> = state.rotations[0].to_rotation_matrix().into_inner().column(axis).into();
    let [a, b] = &state.velocities;
    let velocity_term = (b.angular - a.angular).dot(&a.angular.cross(&along));
    state.rotation(along, 0.0, velocity_term)
}
