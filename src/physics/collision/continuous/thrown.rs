//! Holds bodies back that were thrown farther in a step than anybody looked for what they might meet.
//!
//! Pairs, and which of them are fast, are told by the velocities before the step. What is hit in it goes on as fast as what hit it,
//! into what it was too slow to reach, or through that. So a body that has gone farther than it could by itself, and farther than
//! it is thick, is followed after the solve on the straight way from where it was. Where its [`core`] meets something it is held
//! back, as those of fast pairs are.
//!
//! A body on joints does not go on as it moved before the step: where one end of a chain stops, the other whips on. So all of these
//! are followed that go farther than they are thick. One of them is held back with its whole mechanism: its bodies go to where they
//! were on their ways at the time of the meeting, and are put together there, where such ways have parted their joints
//! (`solver/exact/held_mechanisms.rs`).

use bevy::prelude::*;
use nalgebra::Vector3;

use super::fast_pair::Start;
use super::hold_back::{core, hold, stop};
use super::mechanisms::Mechanisms;
use super::time_of_impact::{Course, Impact, course, inner_radius};
use crate::physics::collision::broad::bounding_tree::BoundingBox;
use crate::physics::collision::broad::in_step::may_collide;
use crate::physics::collision::broad::near_pairs::NearPairs;
use crate::physics::collision::constants::{CORE_SHARE, HELD_CORE_SHARE, SPECULATIVE_MARGIN};
use crate::physics::collision::gap::{fastest_approach, pull, turning_speed};
use crate::physics::collision::manifold::PartPair;
use crate::physics::collision::narrow::contact_pair::PairSearch;
use crate::physics::collision::parts::parts_within;
use crate::physics::contact::restitution_threshold;
use crate::physics::joint::{JoinedPairs, Joints};
use crate::physics::{Bodies, Body, ContactGraph, ContactPoint, Geometry, SolverSettings};

/// Buffers of the search.
#[derive(Default)]
pub(crate) struct Buffers {
    search: PairSearch,
    points: Vec<ContactPoint>,
    /// Of the first impact.
    first_points: Vec<ContactPoint>,
    /// Of the impact of a core further out.
    outer_points: Vec<ContactPoint>,
    thrown: Vec<u32>,
    others: Vec<u32>,
    parts: Vec<PartPair>,
    stack: Vec<u32>,
}

/// What a body meets first.
struct Meeting {
    pair: [usize; 2],
    paths: [Body; 2],
    impact: Impact,
}

/// Follows what was thrown, in the order of the bodies.
pub(crate) fn hold_thrown_back(
    graph: Res<ContactGraph>,
    near: Res<NearPairs>,
    joints: Res<Joints>,
    joined: Res<JoinedPairs>,
    settings: Res<SolverSettings>,
    mut bodies: ResMut<Bodies>,
    mut buffers: Local<Buffers>,
    mut mechanisms: ResMut<Mechanisms>,
) {
    let h = settings.step();
    let mut thrown = std::mem::take(&mut buffers.thrown);
    thrown.clear();
    let is_joined = |body: u32| joints.joined.contains(body);
    let is_followed = |&body: &u32| went_far(&graph, &bodies.list[body as usize], body, is_joined(body), h);
    thrown.extend(bodies.awake().filter(is_followed));
    mechanisms.begin_step();
    if thrown.iter().any(|&body| is_joined(body)) {
        mechanisms.update(&bodies.list, &joints);
    }
    for &body in &thrown {
        let mates = is_joined(body).then_some(&*mechanisms);
        let Some(met) = first_meeting(body, mates, &graph, &near, &joined, &bodies.list, h, &mut buffers) else {
            continue;
        };
        let Meeting { pair, paths, impact } = met;
        let bodies = &mut bodies.list;
        if is_joined(body) {
            let other = usize::from(pair[0] == body as usize);
            let met = pair[other] as u32;
            let way = |end: &Body, member: u32| way(&graph, end, member, h);
            mechanisms.hold(bodies, [body, met], &paths[other], way, impact.time);
        } else {
            hold(bodies, pair, &paths, pair.map(|end| end == body as usize), impact.time);
        }
        stop(bodies, pair, &impact, &buffers.first_points, restitution_threshold(&settings));
    }
    buffers.thrown = thrown;
}

/// A body where the step began, with the constant velocities that take it to its end in the step of h, s.
fn way(graph: &ContactGraph, end: &Body, index: u32, h: f64) -> Body {
    let start = graph.start(index);
    Start::at(start.offset, start.rotation).path_to(end, 0.0, h)
}

/// Whether a body without joints went farther than it could by itself, and than it is thick; one on joints, which has no pair that
/// is fast, than it is thick, its turn included.
fn went_far(graph: &ContactGraph, body: &Body, index: u32, is_joined: bool, h: f64) -> bool {
    if !body.is_dynamic() || body.touches_nothing() {
        return false;
    }
    let way = (body.position - graph.start(index).offset).norm();
    if is_joined {
        return way + turning_speed(body) * h > inner_radius(body);
    }
    way > inner_radius(body) && way > graph.own_way(index) + pull(body) * h * h + SPECULATIVE_MARGIN * body.radius
}

/// How much farther two bodies go into each other in the step of h, s, from where they meet, m.
fn way_into(paths: &[Body; 2], impact: &Impact, points: &[ContactPoint], h: f64) -> f64 {
    let Some(point) = points.first() else { return 0.0 };
    let speed = |one: usize| paths[one].point_velocity(&(point.point - impact.at[one]));
    (speed(0) - speed(1)).dot(&impact.overlap.normal) * (h - impact.time)
}

/// What a body meets first on its way; of one on joints, which has mates, none of these. The points there are left in the buffers.
fn first_meeting(
    body: u32,
    mates: Option<&Mechanisms>,
    graph: &ContactGraph,
    near: &NearPairs,
    joined: &JoinedPairs,
    bodies: &[Body],
    h: f64,
    buffers: &mut Buffers,
) -> Option<Meeting> {
    let path = |body: u32| way(graph, &bodies[body as usize], body, h);
    let own = path(body);
    let (from, to) = (own.position, bodies[body as usize].position);
    let reach = Vector3::repeat(own.radius);
    let around = BoundingBox { low: from.inf(&to) - reach, high: from.sup(&to) + reach };
    let Buffers { search, points, first_points, outer_points, others, parts: near_parts, stack, .. } = buffers;
    near.in_box(&around, stack, others);
    let mut first: Option<Meeting> = None;
    for &other in &*others {
        let there = &bodies[other as usize];
        let is_mate = mates.is_some_and(|mechanisms| mechanisms.are_joined(body, other));
        let may_meet = other != body && !is_mate && !there.touches_nothing();
        if !may_meet || !may_collide([&bodies[body as usize], there], joined, [body, other]) {
            continue;
        }
        let is_first = there.is_dynamic() && body < other;
        let place = |own, other| if is_first { [own, other] } else { [other, own] };
        let paths = place(own.clone(), path(other));
        let with_core = |share| place(core(own.clone(), share), path(other));
        let inner = with_core(CORE_SHARE);
        let [a, b] = [&inner[0], &inner[1]];
        parts_within(a, b, fastest_approach(a, b) * h, near_parts);
        for &parts in &*near_parts {
            search.last = None;
            let Course::Impact(mut impact) = course([a, b], parts, h, search, points) else { continue };
            if mates.is_some() {
                // A compound is all core: where contacts let it in by less than half of what is thinnest, it may be.
                let is_all_core = matches!(own.geometry, Some(Geometry::Parts(_)));
                if is_all_core && way_into(&paths, &impact, points, h) < CORE_SHARE * inner_radius(&own) {
                    continue;
                }
                search.last = None;
                let [a, b] = &with_core(HELD_CORE_SHARE);
                if let Course::Impact(before) = course([a, b], parts, h, search, outer_points) {
                    impact = before;
                    std::mem::swap(points, outer_points);
                }
            }
            if first.as_ref().is_none_or(|known| impact.time < known.impact.time) {
                first_points.clone_from(points);
                let pair = if is_first { [body, other] } else { [other, body] }.map(|end| end as usize);
                first = Some(Meeting { pair, paths: paths.clone(), impact });
            }
        }
    }
    first
}
