//! Holds fast bodies back that a solve has taken through others.
//!
//! The contacts of a step are found on the paths that bodies would take alone. A body that a contact or a joint turns
//! aside, or that spins on about the corner it struck with, may get beyond a body that was not in its path. So of each
//! fast pair (see [`time_of_impact`]) the path that was taken is followed after the solve, with the *core* of each fast
//! body in its place: the shape with half of its thickness taken off. The path has constant velocities up to the first
//! impact of either body, as it was found, and constant velocities again from there to the pose after the solve. Where
//! a core touches, the body is held back: its approach goes out of its velocity, or comes back as its restitution says,
//! and the next step finds a contact.
//! Bodies on joints make no fast pairs: one held back by itself would tear its joints open, and what closes them again
//! would throw it. They are held back with all that joints hold to them ([`thrown`](super::thrown)).

use bevy::prelude::*;
use nalgebra::Vector3;

use super::fast_pair::FastPair;
use super::time_of_impact::{self, Course, Impact, advanced, inner_radius, pass_by};
use crate::physics::collision::constants::{CORE_SHARE, IMPACT_TOLERANCE};
use crate::physics::collision::narrow::contact_pair::PairSearch;
use crate::physics::contact::{rebound, restitution_threshold};
use crate::physics::{Bodies, Body, ContactGraph, ContactPoint, Geometry, Pair, SolverSettings, world_inverse_inertia};

/// The body with its core of that share of its thickness for its shape; a compound is all core.
pub(super) fn core(body: Body, share: f64) -> Body {
    if matches!(body.geometry, Some(Geometry::Parts(_))) {
        return body;
    }
    let inner = inner_radius(&body);
    let geometry = match &body.geometry {
        Some(Geometry::Cuboid { half }) => Geometry::Cuboid { half: half.add_scalar((share - 1.0) * inner) },
        Some(Geometry::Cone { radius, height, hull }) => {
            Geometry::Cone { radius: share * radius, height: share * height, hull: hull.clone() }
        }
        Some(Geometry::Cylinder { radius, half, hull }) => {
            let thinner = (1.0 - share) * inner;
            Geometry::Cylinder { radius: radius - thinner, half: half - thinner, hull: hull.clone() }
        }
        Some(Geometry::Capsule { half, hull, .. }) => {
            Geometry::Capsule { radius: share * inner, half: *half, hull: hull.clone() }
        }
        _ => Geometry::Sphere { radius: share * inner },
    };
    let radius = match &geometry {
        Geometry::Cuboid { half } => half.norm(),
        Geometry::Sphere { radius } => *radius,
        Geometry::Capsule { radius, half, .. } => radius + half,
        Geometry::Cylinder { radius, half, .. } => radius.hypot(*half),
        _ => share * body.radius,
    };
    Body { geometry: Some(geometry), radius, ..body }
}

/// Follows the fast pairs of this step, in the order of their slots. A body that is held back is there for the pairs
/// that follow.
pub(crate) fn hold_back(
    graph: Res<ContactGraph>,
    mut bodies: ResMut<Bodies>,
    settings: Res<SolverSettings>,
    mut search: Local<PairSearch>,
    mut points: Local<Vec<ContactPoint>>,
    mut first_impacts: Local<Vec<(u32, f64)>>,
) {
    if graph.fast.is_empty() {
        return;
    }
    let h = settings.step();
    first_impacts.clear();
    let both = |fast: &FastPair| fast.impact.map(|time| [(fast.pair.a, time), (fast.pair.b, time)]);
    first_impacts.extend(graph.fast.iter().filter_map(both).flatten());
    first_impacts.sort_unstable_by(|one, other| one.0.cmp(&other.0).then(one.1.total_cmp(&other.1)));
    let first_impact = |body: u32| {
        let first = first_impacts.partition_point(|&(known, _)| known < body);
        first_impacts.get(first).filter(|(known, _)| *known == body).map_or(h, |(_, time)| *time)
    };
    for &FastPair { pair: Pair { a, b }, parts, starts, fast, .. } in &graph.fast {
        let turned_aside = first_impact(a).min(first_impact(b));
        let since = if turned_aside < h { turned_aside } else { 0.0 };
        let pair = [a as usize, b as usize];
        let [from, to] =
            [[0, 1].map(|one: usize| starts[one].after(since)), pair.map(|body| bodies.list[body].position)]
                .map(|[a, b]: [Vector3<f64>; 2]| b - a);
        let reach: f64 = pair.iter().map(|&body| bodies.list[body].radius).sum();
        if pass_by(&from, &(to - from), (1.0 + IMPACT_TOLERANCE) * reach) {
            continue;
        }
        let paths: [Body; 2] =
            std::array::from_fn(|one| starts[one].path_to(&bodies.list[pair[one]], since, h - since));
        let [one, other] =
            std::array::from_fn(
                |one| if fast[one] { core(paths[one].clone(), CORE_SHARE) } else { paths[one].clone() },
            );
        search.last = None;
        let course = time_of_impact::course([&one, &other], parts, h - since, &mut search, &mut points);
        if let Course::Impact(impact) = course {
            hold(&mut bodies.list, pair, &paths, fast, impact.time);
            stop(&mut bodies.list, pair, &impact, &points, restitution_threshold(&settings));
        }
    }
}

/// Puts the fast bodies of two where they are on their paths at a time, s. A body that is not fast, or is kinematic,
/// ends where it was, and takes along what it has met.
pub(super) fn hold(bodies: &mut [Body], pair: [usize; 2], paths: &[Body; 2], fast: [bool; 2], time: f64) {
    let held = [0, 1].map(|one| fast[one] && bodies[pair[one]].is_dynamic());
    for one in (0..2).filter(|&one| held[one]) {
        let (mut position, mut rotation) = advanced(&paths[one], time);
        let other = 1 - one;
        if !held[other] {
            let (met_at, met_turned) = advanced(&paths[other], time);
            let end = &bodies[pair[other]];
            let turned = end.rotation * met_turned.inverse();
            (position, rotation) = (end.position + turned * (position - met_at), turned * rotation);
        }
        let body = &mut bodies[pair[one]];
        (body.position, body.rotation) = (position, rotation);
    }
}

/// Takes the approach out of two bodies where they met, by an impulse along the normal at the first point, or has them
/// bounce from over the `threshold`, m/s: what is left of it would push soft contacts in by as much as a core is thick.
pub(super) fn stop(bodies: &mut [Body], pair: [usize; 2], impact: &Impact, points: &[ContactPoint], threshold: f64) {
    let (Some(point), n) = (points.first(), impact.overlap.normal) else { return };
    let arms = impact.at.map(|center| point.point - center);
    let turning = |one: usize| {
        let body = &bodies[pair[one]];
        world_inverse_inertia(&body.inverse_inertia_body, &body.rotation, &body.rotation_freedom) * arms[one].cross(&n)
    };
    let (turns, pushes) = ([turning(0), turning(1)], pair.map(|body| bodies[body].inverse_mass.component_mul(&n)));
    let give: f64 = (0..2).map(|one| n.dot(&(pushes[one] + turns[one].cross(&arms[one])))).sum();
    let [a, b] = std::array::from_fn(|one| bodies[pair[one]].point_velocity(&arms[one]).dot(&n));
    if a > b && give > 0.0 {
        let restitution = bodies[pair[0]].material.pair(bodies[pair[1]].material).restitution;
        let change = (a - b + rebound(restitution, a - b, threshold)) / give;
        for (one, impulse) in [-change, change].into_iter().enumerate() {
            bodies[pair[one]].linear += pushes[one] * impulse;
            bodies[pair[one]].angular += turns[one] * impulse;
        }
    }
}
