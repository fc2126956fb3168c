//! Contacts that nobody could foresee. Pairs are looked for before the step, as far as the bodies can come by themselves
//! ([`own_reach`]). What is hit goes further, and may lie in something at the end that was out of its reach, or have passed through
//! it. So where a body went further, what it overlaps there is looked for, and what it meets on a straight way from its start
//! ([`course`]), and the groups of both are to be taken through the step again, as one that has the pair.

use nalgebra::Vector3;

use super::bodies::{on_its_way, state_of};
use super::constants::UNFORESEEN;
use super::exact_group::{ExactGroup, LeftParts};
use super::mechanism::MemberState;
use crate::physics::body::{Bodies, Body};
use crate::physics::collision::{
    ContactPoint, Course, Pair, PairKey, PairSearch, PartPair, course, fastest_approach, may_collide, own_reach,
    parts_within, pass_by, touch,
};
use crate::physics::joint::JoinedPairs;
use crate::physics::settings::SolverSettings;

/// The search and its buffers.
#[derive(Default)]
pub(super) struct UnforeseenPairs {
    /// What was found.
    pairs: Vec<PairKey>,
    /// Where each body is at the end.
    ends: Vec<MemberState>,
    /// Those that went further than they could by themselves.
    far: Vec<u32>,
    parts: Vec<PartPair>,
    search: PairSearch,
    points: Vec<ContactPoint>,
}

impl UnforeseenPairs {
    /// Looks for the pairs that overlap at the end of the step, or have met before, and are in no group. Whether there are any.
    pub fn find(
        &mut self,
        groups: &[ExactGroup],
        bodies: &Bodies,
        joined: &JoinedPairs,
        settings: &SolverSettings,
    ) -> bool {
        let Self { pairs, far, ends, .. } = self;
        pairs.clear();
        far.clear();
        let of_groups = groups.iter().flat_map(ExactGroup::ends);
        far.extend(of_groups.clone().filter_map(|(body, end)| {
            let start = &bodies.list[body as usize];
            (!start.touches_nothing() && way(start, end) > own_reach(start, settings)).then_some(body)
        }));
        if far.is_empty() {
            return false;
        }
        far.sort_unstable();
        ends.clear();
        ends.extend(bodies.list.iter().map(|body| {
            let mut state = state_of(body);
            if !body.is_dynamic() {
                state.drift(settings.step());
            }
            state
        }));
        of_groups.for_each(|(body, end)| ends[body as usize] = *end);
        for at in 0..self.far.len() {
            self.find_about(self.far[at], groups, bodies, joined, settings.step());
        }
        self.pairs.sort_unstable_by_key(|key| (key.pair, key.parts));
        !self.pairs.is_empty()
    }

    /// Makes one group of those that each of the pairs is between, which has the pair. It is to be planned anew.
    pub fn join(&self, groups: &mut [ExactGroup], left: &mut LeftParts) {
        for &PairKey { pair, .. } in &self.pairs {
            let of = |body: u32| groups.iter().position(|group| group.has_body(body));
            if let (Some(one), Some(other)) = (of(pair.a), of(pair.b))
                && one != other
            {
                let (first, last) = groups.split_at_mut(one.max(other));
                first[one.min(other)].take_up(&mut last[0], left);
            }
        }
        for group in groups {
            let is_own = |key: &&PairKey| group.has_body(key.pair.a) || group.has_body(key.pair.b);
            let own: Vec<PairKey> = self.pairs.iter().filter(is_own).copied().collect();
            if !own.is_empty() {
                group.take_up_pairs(&own, left);
            }
        }
    }

    /// The pairs of one of the bodies that went far.
    fn find_about(&mut self, body: u32, groups: &[ExactGroup], bodies: &Bodies, joined: &JoinedPairs, h: f64) {
        let (own, end) = (&bodies.list[body as usize], self.ends[body as usize].position);
        for (other, there) in (0..).zip(&bodies.list) {
            let is_known = self.far.binary_search(&other).is_ok() && other < body;
            let from = there.position - own.position;
            let way = self.ends[other as usize].position - end - from;
            let is_near = !pass_by(&from, &way, own.radius + there.radius);
            let may_meet = other != body && !is_known && is_near && !bodies.asleep.contains(other);
            if !may_meet || there.touches_nothing() || !may_collide([own, there], joined, [body, other]) {
                continue;
            }
            let pair = if there.is_dynamic() && (body < other) {
                Pair { a: body, b: other }
            } else {
                Pair { a: other, b: body }
            };
            self.find_between(pair, groups, bodies, h);
        }
    }

    /// The parts of a pair of bodies, or the two, that overlap or have met and are in no group.
    fn find_between(&mut self, pair: Pair, groups: &[ExactGroup], bodies: &Bodies, h: f64) {
        let Self { ends, parts: near, search, points, pairs, .. } = self;
        let both = [pair.a, pair.b].map(|body| (&bodies.list[body as usize], &ends[body as usize]));
        let [on_way_a, on_way_b] = both.map(|(body, end)| on_its_way(body, [&state_of(body), end], h));
        let [a, b] = both.map(|(body, end)| at(body, end));
        parts_within(&on_way_a, &on_way_b, fastest_approach(&on_way_a, &on_way_b) * h, near);
        for &parts in &*near {
            if groups.iter().any(|group| group.has_pair(pair, parts)) {
                continue;
            }
            (search.last, search.is_exact) = (None, true);
            points.clear();
            let overlaps = touch([&a, &b], parts, 0.0, search, points).is_some();
            let is_in = overlaps && points.iter().any(|point| point.depth > UNFORESEEN);
            if is_in || matches!(course([&on_way_a, &on_way_b], parts, h, search, points), Course::Impact(_)) {
                pairs.push(PairKey { slot: None, pair, parts });
            }
        }
    }
}

/// How far the points of a body went at most, m: a turn by θ takes one on the unit sphere by 2 sin θ/2, no more than twice
/// the way of the quaternion.
fn way(body: &Body, end: &MemberState) -> f64 {
    let (from, to) = (body.rotation.coords, end.rotation.coords);
    let turned = (to - from).norm().min((to + from).norm());
    (end.position - body.position).norm() + 2.0 * turned * body.radius
}

/// A body where it ended.
fn at(body: &Body, end: &MemberState) -> Body {
    let (linear, angular) = (Vector3::zeros(), Vector3::zeros());
    Body { position: end.position, rotation: end.rotation, linear, angular, ..body.clone() }
}
