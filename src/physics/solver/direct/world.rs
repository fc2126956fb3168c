//! The world as islands read it.

use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use super::constants::RIMS;
use crate::physics::body::Body;
use crate::physics::collision::{ContactState, Slot};
use crate::physics::constraint::row::Twist;
use crate::physics::joint::{BodyState, Joint};
use crate::physics::solver::exact::MemberState;

/// The world as an island reads it.
pub(crate) trait World {
    fn body(&self, index: u32) -> &Body;
    fn slot(&self, index: u32) -> &Slot;
    fn state(&self, slot: u32) -> &ContactState;
    fn joint(&self, index: u32) -> &Joint;
}

/// Where a body is and how it moves.
pub(super) fn state_of(body: &Body) -> MemberState {
    let BodyState { linear, angular, .. } = BodyState::of(body);
    let (position, rotation) = (body.position, body.rotation);
    MemberState { position, rotation, linear: linear.into(), angular: angular.into() }
}

/// How far from its centre a body's points count as, m.
pub(super) fn rim(body: &Body) -> f64 {
    body.radius.clamp(RIMS[0], RIMS[1])
}

/// The place of a body among the members, or behind them among the partners.
pub(super) fn place_among([members, partners]: [&[u32]; 2], body: u32) -> u32 {
    match members.binary_search(&body) {
        Ok(place) => place as u32,
        Err(_) => (members.len() + partners.binary_search(&body).unwrap_or(0)) as u32,
    }
}

/// The share of moves of bodies by which no point of one goes further than `most`, m; not finite where they are not.
pub(super) fn share_within<'b>(most: f64, moves: impl Iterator<Item = (&'b Body, Twist<f64>)>) -> f64 {
    let reach = |(body, moved): (&Body, Twist<f64>)| moved.linear.norm() + moved.angular.norm() * rim(body);
    let furthest = moves.map(reach).fold(0.0, f64::max);
    if furthest > most { most / furthest } else { 1.0 }
}

/// Whether nothing of it is locked.
pub(super) fn moves_freely(body: &Body) -> bool {
    body.rotation_freedom == Vector3::repeat(1.0)
        && body.inverse_mass.min() > 0.0
        && body.inverse_inertia_body.min() > 0.0
}

/// World inertia of a body that moves freely.
pub(super) fn world_inertia(body: &Body) -> Matrix3<f64> {
    inertia_at(&body.rotation, &body.inverse_inertia_body)
}

/// World inertia of a body that is turned so.
pub(super) fn inertia_at(rotation: &UnitQuaternion<f64>, inverse_inertia_body: &Vector3<f64>) -> Matrix3<f64> {
    let principal = inverse_inertia_body.map(f64::recip);
    if principal.x == principal.y && principal.y == principal.z {
        return Matrix3::from_diagonal(&principal);
    }
    let axes = rotation.to_rotation_matrix().into_inner();
    axes * Matrix3::from_diagonal(&principal) * axes.transpose()
}
