//! Pairs that pass through each other within a smooth step, so that nothing of it is seen at its end.
//!
//! A pair that is left free, since it bounces, or whose points no forecast has, goes where its bodies go. One that moves by more
//! than it is thick is taken along a straight way from where it was to where it came ([`course`]); where that meets something on
//! the way, the smooth step is to end when the pair is half through: there its overlap is seen.

use super::super::bodies::{displacement, on_its_way};
use super::super::constants::TOUCHING;
use super::super::mechanism::MemberState;
use super::gap_points::{GapPoint, GapPoints, ReachablePair};
use crate::physics::body::Body;
use crate::physics::collision::{ContactPoint, Course, PairSearch, course, overlapping_way};

/// Share of the way through a pair at which a smooth step is to end.
const THROUGH: f64 = 0.5;

/// Buffers of the search.
#[derive(Clone, Default)]
pub(super) struct Crossings {
    search: PairSearch,
    points: Vec<ContactPoint>,
}

/// A smooth step.
pub(super) struct Passage<'a> {
    /// Its length, s.
    pub h: f64,
    /// Of the bodies at its start and at its end.
    pub states: [&'a [MemberState]; 2],
    pub points: [&'a GapPoints; 2],
}

impl Crossings {
    /// The time, s, at which the first of the pairs that have passed through at the end is half through, if there are any. `shapes`
    /// are the bodies, wherever they are.
    pub fn first(&mut self, pairs: &[ReachablePair], free: &[bool], shapes: &[Body], passage: &Passage) -> Option<f64> {
        let times = pairs.iter().enumerate().filter_map(|(index, pair)| {
            let [at_start, at_end] = passage.points.map(|points| points.of(index));
            let touching = at_end.iter().find(|point| point.gap <= TOUCHING);
            let is_held = !free[index] && !at_start.is_empty();
            if touching.is_some() && is_held {
                return None;
            }
            let ends = pair.ends.map(|end| end as usize);
            let through = overlapping_way(ends.map(|end| &shapes[end]), pair.key.parts);
            let [[way_a, turn_a], [way_b, turn_b]] =
                ends.map(|end| displacement(passage.states.map(|states| &states[end])));
            let turning = turn_a.norm() * shapes[ends[0]].radius + turn_b.norm() * shapes[ends[1]].radius;
            let way = (way_a - way_b).norm() + turning;
            if way <= through {
                return None;
            }
            let met = match self.follow(pair, shapes, passage) {
                Course::Apart => return None,
                // What touches at the end may be through as well.
                Course::Impact(impact) if touching.is_some_and(|end| end.normal.dot(&impact.overlap.normal) > 0.0) => {
                    return None;
                }
                Course::Impact(impact) => impact.time,
                Course::Touching if !free[index] => return None,
                Course::Touching => {
                    let closing = |point: &GapPoint| -point.opening(passage.states[0]);
                    let fastest = at_start.iter().map(closing).fold(0.0, f64::max);
                    if fastest * passage.h <= through {
                        return None;
                    }
                    0.0
                }
            };
            let half = met + THROUGH * through / way * passage.h;
            (half < passage.h).then_some(half)
        });
        times.min_by(f64::total_cmp)
    }

    /// Takes a pair straight from its start to its end.
    fn follow(&mut self, pair: &ReachablePair, shapes: &[Body], passage: &Passage) -> Course {
        let bodies = pair.ends.map(|end| {
            let end = end as usize;
            on_its_way(&shapes[end], passage.states.map(|states| &states[end]), passage.h)
        });
        course([&bodies[0], &bodies[1]], pair.key.parts, passage.h, &mut self.search, &mut self.points)
    }
}
