//! How far apart two bodies may be that already get contact points.

use nalgebra::Vector3;

use crate::physics::body::Body;
use crate::physics::settings::{ContactModel, SolverSettings};

/// Gaps up to this share of the bounding radii count as touching: rounding could have made them
/// of a gap of zero.
pub(super) const CONTACT_TOLERANCE: f64 = 1e-9;

/// The gap over a half-space up to which a body already gets contact points, m: as far as it can
/// fall in one step at its present velocity. The points' negative depth lets the solver stop it at
/// the plane instead of finding it a step's way below. Not where the 2009 contacts are asked for,
/// and not where the pair bounces: a speculative contact takes the approach away that a bounce needs.
pub(super) fn speculative_gap(plane: &Body, body: &Body, normal: &Vector3<f64>, settings: &SolverSettings) -> f64 {
    let bounces = plane.material.pair(body.material).restitution > 0.0;
    if settings.contact_model() != ContactModel::Clipping || bounces {
        return 0.0;
    }
    let approach = (plane.linear - body.linear).dot(normal).max(0.0) + body.angular.norm() * body.radius;
    approach * settings.step()
}

/// How far apart two bodies of the exact method may be that get contact points, m: as far as they can come together in
/// a step at their velocities and under the forces on them.
pub(super) fn reachable_gap(a: &Body, b: &Body, settings: &SolverSettings) -> f64 {
    own_reach(a, settings) + own_reach(b, settings)
}

/// A body's own part of that.
pub(super) fn own_reach(body: &Body, settings: &SolverSettings) -> f64 {
    let h = settings.step();
    own_reachable_gap(body, settings) + body.inverse_mass.component_mul(&body.force).norm() * h * h
}

/// Share of the smaller bounding radius within which surfaces that do not touch get contact points.
pub(super) const MARGIN: f64 = 0.01;

/// The most that two bodies can come together, m/s.
pub(crate) fn fastest_approach(a: &Body, b: &Body) -> f64 {
    (a.linear - b.linear).norm() + turning_speed(a) + turning_speed(b)
}

/// A body's own part of that: those of two bodies together are no less than their gap.
pub(super) fn own_reachable_gap(body: &Body, settings: &SolverSettings) -> f64 {
    let margin = if body.radius.is_finite() { MARGIN * body.radius } else { 0.0 };
    margin + (body.linear.norm() + turning_speed(body)) * settings.step()
}

/// Greatest speed that turning gives a point of the body, m/s; on a half-space, one that reaches far.
pub(super) fn turning_speed(body: &Body) -> f64 {
    body.angular.norm() * body.radius.min(1e6)
}
