//! The rule of the gap: how far apart two bodies may be that already get contact points, m ([`contact_gap`]).
//!
//! Contacts are found once a step, at the poses of its start. One that is found only when it overlaps is found up to a
//! step's way too late; one across a gap has a negative depth, and its row lets the gap close and no more.
//!
//! - **Extreme vertices**, one or all: 0. The 2009 engine's contacts are of what overlaps.
//! - **Force-level rows with `contacts_ahead`, over a half-space, without restitution**: how far the body falls to the
//!   plane in the step. A plane has one normal. What bounces needs the approach that a row across the gap would take
//!   away.
//! - **Force-level rows, all others**: 0. The normal across a gap between bodies that pass beside each other would stop
//!   them.
//! - **Contacts that last**: [`SPECULATIVE_MARGIN`] of the smaller radius, and what both can close in the step, with what
//!   springs at their points may add; of parts those of the parts ([`Near`]). The
//!   manifold is used until the pair has moved against each other. Where something may stop one of two unequal ones,
//!   or of two in a row, within the step, or throw back one that bounces, what they move ([`gap_if_stopped`]).
//! - **`exact`**: the same margin of each radius, and what each can move in the step, forces included. What is in reach
//!   goes by another step than what is not, and that must be known before.

use nalgebra::Vector3;

use super::manifold::PartPair;
use super::parts::{PartShape, Placed, has_parts, is_mesh};
use crate::physics::body::Body;
use crate::physics::collision::constants::{LONGEST_ARM, SPECULATIVE_MARGIN, UNEQUAL_MASSES};
use crate::physics::contact::may_bounce;
use crate::physics::settings::{ContactModel, Method, SolverSettings};
use crate::physics::shape::Geometry;

/// The gap up to which a pair gets contact points, m; of parts where contacts last [`lasting_gap`]. A half-space comes first.
pub(super) fn contact_gap(a: &Body, b: &Body, settings: &SolverSettings) -> f64 {
    let h = settings.step();
    if settings.method == Method::Exact {
        return own_reach(a, settings) + own_reach(b, settings);
    }
    if settings.method.keeps_contacts() {
        return lasting_gap(a, b, &Near::of_bodies(a, b), h);
    }
    let is_over_plane = matches!(a.geometry, Some(Geometry::HalfSpace));
    let is_ahead = settings.sweeps.contacts == ContactModel::Clipping && settings.sweeps.contacts_ahead;
    if !is_over_plane || !is_ahead || may_bounce(a, b) {
        return 0.0;
    }
    let normal = a.rotation * Vector3::y();
    ((a.linear - b.linear).dot(&normal).max(0.0) + b.angular.norm() * b.radius) * h
}

/// Likewise where contacts last, of two bodies, or parts of them, that are near each other there, before a step of h, s.
pub(super) fn lasting_gap(a: &Body, b: &Body, near: &Near, h: f64) -> f64 {
    SPECULATIVE_MARGIN * near.size + way_ahead(a, b, near, h)
}

/// The gap within which two bodies that move along with each other may meet in a step in which something stops one of them,
/// which is much heavier or lighter than the other or in a row with it, or throws back one that bounces, m, where contacts
/// last; none where that is no more than [`contact_gap`].
pub(super) fn gap_if_stopped(a: &Body, b: &Body, is_row: bool, settings: &SolverSettings) -> Option<f64> {
    let is_unequal = a.mass.max(b.mass) >= UNEQUAL_MASSES * a.mass.min(b.mass);
    let bounces = may_bounce(a, b);
    if !(is_unequal || is_row || bounces) || !a.is_dynamic() || !b.is_dynamic() {
        return None;
    }
    let speeds = [a, b].map(|body| body.linear.norm());
    // What is thrown back comes as fast as it went.
    let fastest = if bounces { speeds[0] + speeds[1] } else { speeds[0].max(speeds[1]) };
    let margin = SPECULATIVE_MARGIN * a.radius.min(b.radius);
    let gap = margin + (fastest + turning_speed(a) + turning_speed(b)) * settings.step();
    (fastest * fastest > (a.linear - b.linear).norm_squared()).then_some(gap)
}

/// A body's own part of the gap of force-level and exact methods, m: those of two bodies together are no less than the
/// gap. With `exact` they are no less than what the two can come together in a step under the forces on them.
pub(crate) fn own_reach(body: &Body, settings: &SolverSettings) -> f64 {
    let h = settings.step();
    let moved = (body.linear.norm() + turning_speed(body)) * h;
    if settings.method != Method::Exact {
        return moved;
    }
    let reaches_far = !body.radius.is_finite() || is_mesh(body);
    let margin = if reaches_far { 0.0 } else { SPECULATIVE_MARGIN * body.radius };
    margin + moved + pull(body) * h * h
}

/// The most that two bodies can come together in a time h, s, at their velocities and under the forces on them, m.
pub(crate) fn closing_distance(a: &Body, b: &Body, h: f64) -> f64 {
    (fastest_approach(a, b) + (pull(a) + pull(b)) * h) * h
}

/// The most that two bodies, or those parts of them, can come together in a time h, s, at their velocities and as springs
/// pull them, m.
pub(super) fn way_ahead(a: &Body, b: &Body, near: &Near, h: f64) -> f64 {
    (near.fastest_approach([a, b], h) + (a.pulled + b.pulled) * h) * h
}

/// The most that points of a body within a radius of a place, m, move in a time h, s, at its velocity and as springs pull
/// it, m.
pub(super) fn way_of(body: &Body, place: &Vector3<f64>, radius: f64, h: f64) -> f64 {
    let arm = place - body.position;
    let turning = body.angular.norm();
    let straight = body.point_velocity(&arm).norm() + turning * radius + bend(body, &arm, radius, h);
    let speed = straight.min(body.linear.norm() + turning * (arm.norm() + radius));
    (speed + body.pulled * h) * h
}

/// What a body moves by in a step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Motion {
    linear: Vector3<f64>,
    angular: Vector3<f64>,
    pulled: f64,
}

impl Motion {
    /// Of a body.
    pub fn of(&Body { linear, angular, pulled, .. }: &Body) -> Self {
        Self { linear, angular, pulled }
    }
}

/// By how much more than at another motion points of a body that are within a reach of its middle, m, move in a time h, s, at
/// most ([`way_of`]).
pub(super) fn way_gained(body: &Body, before: &Motion, reach: f64, h: f64) -> f64 {
    let bent = 0.5 * h * (body.angular.norm_squared() - before.angular.norm_squared()).max(0.0);
    let turning = ((body.angular - before.angular).norm() + bent) * reach;
    ((body.linear - before.linear).norm() + turning + (body.pulled - before.pulled).max(0.0) * h) * h
}

/// Speed by which a circle departs in the mean over a time h, s, from its tangent, of points within a radius of an arm, m/s.
fn bend(body: &Body, arm: &Vector3<f64>, radius: f64, h: f64) -> f64 {
    0.5 * h * body.angular.norm_squared() * (arm.norm() + radius)
}

/// Where two bodies may meet: anywhere, or about one of two parts, which may be much smaller than its body, and far from the
/// middle about which that turns.
///
/// Points within a radius r of the middle c of that part come together no faster than
///
/// |u| + |ω_a − ω_b| r + ½ h Σ |ω|² (|c − x| + r),  u = v_a + ω_a × (c − x_a) − v_b − ω_b × (c − x_b),
///
/// in the mean over a step of h: what moves along with what turns keeps its distance. What ω_a adds across the gap itself is
/// less than the margin.
#[derive(Clone, Copy, Debug)]
pub(super) struct Near {
    /// Smaller bounding radius, m.
    pub size: f64,
    /// Of one part: where its middle is, and its bounding radius, m.
    pub part: Option<(Vector3<f64>, f64)>,
}

impl Near {
    /// Of two bodies, or those parts of them.
    pub fn of([a, b]: [&Body; 2], parts: PartPair) -> Self {
        if !has_parts(a) && !has_parts(b) {
            return Self::of_bodies(a, b);
        }
        let solids = [(a, parts.a), (b, parts.b)].map(|(body, part)| Placed::of(body, part));
        let solids = solids.iter().flatten().filter(|placed| matches!(placed.shape, PartShape::Solid(_)));
        match solids.min_by(|one, other| one.radius.total_cmp(&other.radius)) {
            Some(placed) => Self { size: placed.radius, part: Some((placed.position, placed.radius)) },
            None => Self::of_bodies(a, b),
        }
    }

    /// Of two bodies without parts.
    pub fn of_bodies(a: &Body, b: &Body) -> Self {
        Self { size: a.radius.min(b.radius), part: None }
    }

    /// The most that the two can come together in the mean over a time h, s, m/s.
    pub fn fastest_approach(&self, [a, b]: [&Body; 2], h: f64) -> f64 {
        let Some((middle, radius)) = self.part else { return fastest_approach(a, b) };
        let arms = [a, b].map(|body| middle - body.position);
        let together = (a.point_velocity(&arms[0]) - b.point_velocity(&arms[1])).norm();
        let bent: f64 = [a, b].into_iter().zip(&arms).map(|(body, arm)| bend(body, arm, radius, h)).sum();
        let along = together + (a.angular - b.angular).norm() * radius + bent;
        let turning = |body: &Body, arm: &Vector3<f64>| body.angular.norm() * (arm.norm() + radius);
        along.min((a.linear - b.linear).norm() + turning(a, &arms[0]) + turning(b, &arms[1]))
    }

    /// Likewise along a unit direction from A to B.
    pub fn approach_along(&self, [a, b]: [&Body; 2], direction: &Vector3<f64>, h: f64) -> f64 {
        let Some((middle, radius)) = self.part else {
            let turning = |body: &Body| body.angular.cross(direction).norm() * body.radius.min(LONGEST_ARM);
            return direction.dot(&(a.linear - b.linear)) + turning(a) + turning(b);
        };
        let arms = [a, b].map(|body| middle - body.position);
        let together = direction.dot(&(a.point_velocity(&arms[0]) - b.point_velocity(&arms[1])));
        // A direction that stays while the bodies turn: twice as much as in the mean over a step.
        let bent: f64 = [a, b].into_iter().zip(&arms).map(|(body, arm)| 2.0 * bend(body, arm, radius, h)).sum();
        let along = together + (a.angular - b.angular).cross(direction).norm() * radius + bent;
        let turning = |body: &Body, arm: &Vector3<f64>| body.angular.cross(direction).norm() * (arm.norm() + radius);
        along.min(direction.dot(&(a.linear - b.linear)) + turning(a, &arms[0]) + turning(b, &arms[1]))
    }
}

/// The most that two bodies can come together, m/s.
pub(crate) fn fastest_approach(a: &Body, b: &Body) -> f64 {
    (a.linear - b.linear).norm() + turning_speed(a) + turning_speed(b)
}

/// Greatest speed that turning gives a point of the body, m/s.
pub(crate) fn turning_speed(body: &Body) -> f64 {
    body.angular.norm() * body.radius.min(LONGEST_ARM)
}

/// Acceleration under the forces on a body, m/s².
pub(super) fn pull(body: &Body) -> f64 {
    body.inverse_mass.component_mul(&body.force).norm()
}

#[cfg(test)]
mod tests {
    use bevy::prelude::*;
    use nalgebra::Vector3;

    use super::Near;
    use crate::physics::Body;
    use crate::physics::collision::continuous::time_of_impact::advanced;
    use crate::physics::testing::Random;

    fn body(random: &mut Random, spin: f64) -> Body {
        let mut body = Body::new(Entity::PLACEHOLDER);
        body.position = random.vector() * 10.0;
        (body.linear, body.angular, body.radius) = (random.vector() * 5.0, random.vector() * spin, 30.0);
        body
    }

    #[test]
    fn no_points_of_parts_come_together_faster_than_told() {
        let (mut random, mut nearly) = (Random::new(52), 0);
        for case in 0..4000 {
            let h = random.within(0.002, 0.03);
            let spin = [0.0, 1.0, 20.0, 300.0][case % 4];
            let pair = [body(&mut random, spin), body(&mut random, spin)];
            let [a, b] = [&pair[0], &pair[1]];
            let (middle, radius) = (b.position + random.vector() * 20.0, random.within(0.1, 2.0));
            let near = Near { size: radius, part: Some((middle, radius)) };
            let fastest = near.fastest_approach([a, b], h);
            let place = middle + random.direction() * radius;
            let direction = random.direction();
            for time in [0.3 * h, h] {
                let [on_a, on_b] = [a, b].map(|body| {
                    let (position, rotation) = advanced(body, time);
                    position + rotation * (place - body.position) - place
                });
                let slack = 1e-9;
                assert!(
                    (on_a - on_b).norm() <= fastest * time + slack,
                    "{case}: {} of {fastest}",
                    (on_a - on_b).norm() / time
                );
                let (along, told) = (direction.dot(&(on_a - on_b)), near.approach_along([a, b], &direction, h));
                assert!(along <= told * time + slack, "{case}: {} of {told}", along / time);
                nearly += u32::from((on_a - on_b).norm() > 0.7 * fastest * time);
            }
        }
        assert!(nearly > 800, "{nearly} are near it");
    }

    #[test]
    fn what_moves_along_with_what_turns_hardly_comes_nearer() {
        let mut random = Random::new(53);
        let (mut a, mut b) = (body(&mut random, 0.0), body(&mut random, 0.0));
        (a.linear, a.angular) = (Vector3::zeros(), Vector3::z() * 0.5);
        b.position = a.position + Vector3::x() * 18.0;
        (b.linear, b.angular) = (a.point_velocity(&(b.position - a.position)), a.angular);
        let near = Near { size: 0.3, part: Some((b.position, 0.3)) };
        let told = near.fastest_approach([&a, &b], 1.0 / 60.0);
        // Not with 9 m/s, as it moves.
        assert!(told < 0.05, "{told} m/s");
    }
}
