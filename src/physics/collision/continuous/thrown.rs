//! Holds bodies back that were thrown farther in a step than anybody looked for what they might meet.
//!
//! Pairs, and which of them are fast, are told by the velocities before the step. What is hit in it goes on as fast as what hit it,
//! into what it was too slow to reach, or through that. So a body that has gone farther than it could by itself, and farther than
//! it is thick, is followed after the solve on the straight way from where it was. Where its [`core`] meets something it is held
//! back, as those of fast pairs are.

use bevy::prelude::*;
use nalgebra::Vector3;

use super::fast_pair::Start;
use super::hold_back::{core, hold, stop};
use super::time_of_impact::{Course, Impact, course, inner_radius};
use crate::physics::collision::broad::bounding_tree::BoundingBox;
use crate::physics::collision::broad::in_step::may_collide;
use crate::physics::collision::broad::near_pairs::NearPairs;
use crate::physics::collision::constants::SPECULATIVE_MARGIN;
use crate::physics::collision::gap::{fastest_approach, pull};
use crate::physics::collision::manifold::PartPair;
use crate::physics::collision::narrow::contact_pair::PairSearch;
use crate::physics::collision::parts::parts_within;
use crate::physics::contact::restitution_threshold;
use crate::physics::joint::{JoinedPairs, Joints};
use crate::physics::{Bodies, Body, ContactGraph, ContactPoint, SolverSettings};

/// Buffers of the search.
#[derive(Default)]
pub(crate) struct Buffers {
    search: PairSearch,
    points: Vec<ContactPoint>,
    /// Of the first impact.
    first_points: Vec<ContactPoint>,
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
) {
    let h = settings.step();
    let mut thrown = std::mem::take(&mut buffers.thrown);
    thrown.clear();
    // One held back on a joint would tear it open.
    let may_be_held =
        |&body: &u32| !joints.joined.contains(body) && is_thrown(&graph, &bodies.list[body as usize], body, h);
    thrown.extend(bodies.awake().filter(may_be_held));
    for &body in &thrown {
        let Some(met) = first_meeting(body, &graph, &near, &joined, &bodies.list, h, &mut buffers) else { continue };
        let Meeting { pair, paths, impact } = met;
        let bodies = &mut bodies.list;
        hold(bodies, pair, &paths, pair.map(|end| end == body as usize), impact.time);
        stop(bodies, pair, &impact, &buffers.first_points, restitution_threshold(&settings));
    }
    buffers.thrown = thrown;
}

/// Whether a body went farther than it could by itself, and than it is thick.
fn is_thrown(graph: &ContactGraph, body: &Body, index: u32, h: f64) -> bool {
    if !body.is_dynamic() || body.touches_nothing() {
        return false;
    }
    let way = (body.position - graph.start(index).offset).norm();
    way > inner_radius(body) && way > graph.own_way(index) + pull(body) * h * h + SPECULATIVE_MARGIN * body.radius
}

/// What a body that was thrown meets first on its way; the points there are left in the buffers.
fn first_meeting(
    body: u32,
    graph: &ContactGraph,
    near: &NearPairs,
    joined: &JoinedPairs,
    bodies: &[Body],
    h: f64,
    buffers: &mut Buffers,
) -> Option<Meeting> {
    let path = |body: u32| {
        let start = graph.start(body);
        Start::at(start.offset, start.rotation).path_to(&bodies[body as usize], 0.0, h)
    };
    let own = path(body);
    let (from, to) = (own.position, bodies[body as usize].position);
    let reach = Vector3::repeat(own.radius);
    let around = BoundingBox { low: from.inf(&to) - reach, high: from.sup(&to) + reach };
    let Buffers { search, points, first_points, others, parts: near_parts, stack, .. } = buffers;
    near.in_box(&around, stack, others);
    let mut first: Option<Meeting> = None;
    for &other in &*others {
        let there = &bodies[other as usize];
        let may_meet = other != body && !there.touches_nothing();
        if !may_meet || !may_collide([&bodies[body as usize], there], joined, [body, other]) {
            continue;
        }
        let is_first = there.is_dynamic() && body < other;
        let place = |own, other| if is_first { [own, other] } else { [other, own] };
        let paths = place(own.clone(), path(other));
        let cores = place(core(own.clone()), path(other));
        let [a, b] = [&cores[0], &cores[1]];
        parts_within(a, b, fastest_approach(a, b) * h, near_parts);
        for &parts in &*near_parts {
            search.last = None;
            let Course::Impact(impact) = course([a, b], parts, h, search, points) else { continue };
            if first.as_ref().is_none_or(|known| impact.time < known.impact.time) {
                first_points.clone_from(points);
                let pair = if is_first { [body, other] } else { [other, body] }.map(|end| end as usize);
                first = Some(Meeting { pair, paths: paths.clone(), impact });
            }
        }
    }
    first
}
