//! Broad phase: *sweep and sort*, as in the 2009 engine.
//!
//! 1. Bounding spheres are projected on x and sorted by where they begin; ties by body.
//! 2. A body's bucket is itself and those after it that overlap it on x; buckets of one vanish.
//! 3. A bucket is projected on z (y is up) and pruned of what does not overlap its first body.
//! 4. Each survivor is paired with the first, so that each pair is found once.
//!
//! There is no test on y unless the settings ask for it: a column of n bodies gives n(n − 1)/2
//! pairs. Half-spaces stand outside the sweep: each is paired, before all else, with every
//! dynamic body whose sphere reaches its plane. Bodies that share a joint, whose layers do not
//! interact, or of which neither is dynamic make no pair.
//!
//! The order is kept from step to step and mended by insertion, for bodies move little in a
//! step; it is always the one order by (begin, body), so that nothing depends on the past.

use bevy::prelude::*;
use nalgebra::Vector3;

use crate::physics::collision::constants::{BUCKETS_A_BLOCK, CONTACT_TOLERANCE, MOVES_A_BODY};
use crate::physics::{
    Bodies, Body, CollisionLayers, Geometry, JoinedPairs, Pair, Refill, SolverSettings, StepStats, for_each_of,
};

/// What the sweep keeps from step to step: the order of the bodies, and buffers.
#[derive(Default)]
pub(crate) struct SweepAndSort {
    order: Vec<(i64, u32)>,
    spheres: Vec<Projection>,
    /// Pairs of each run of buckets.
    found: Vec<Vec<Pair>>,
}

/// A bounding sphere, projected. Intervals are closed: touching is overlapping.
#[derive(Clone, Copy)]
struct Projection {
    x: [f64; 2],
    z: [f64; 2],
    y: [f64; 2],
    body: u32,
    dynamic: bool,
    layers: CollisionLayers,
}

/// The pairs that the sweep found in this step, half-space pairs first.
#[derive(Resource, Default, Clone)]
pub(crate) struct SweptPairs(pub Vec<Pair>);

/// Finds the pairs of this step.
pub(crate) fn sweep(
    bodies: Res<Bodies>,
    joined: Res<JoinedPairs>,
    settings: Res<SolverSettings>,
    mut sweep: Local<SweepAndSort>,
    mut pairs: ResMut<SweptPairs>,
    mut stats: ResMut<StepStats>,
) {
    let pairs = &mut pairs.bypass_change_detection().0;
    pairs.clear();
    sweep.find_pairs(&bodies.list, &joined, &settings, pairs);
    stats.pairs = pairs.len() as u32;
}

/// Whether a body has a bounding sphere that may touch something.
fn is_swept(body: &Body) -> bool {
    body.geometry.as_ref().is_some_and(|geometry| !matches!(geometry, Geometry::HalfSpace)) && !body.touches_nothing()
}

/// The bounding radius, and what rounding may take from a gap of zero.
fn reach(body: &Body) -> f64 {
    body.radius * (1.0 + CONTACT_TOLERANCE)
}

/// Where a body's sphere begins on x, by a number that sorts like it; then the body.
pub(in crate::physics::collision) fn begin(bodies: &[Body], body: u32) -> (i64, u32) {
    let at = &bodies[body as usize];
    let bits = (at.position.x - reach(at)).to_bits() as i64;
    // Of what is below zero, all bits but the sign count the other way.
    (bits ^ ((bits >> 63) as u64 >> 1) as i64, body)
}

impl SweepAndSort {
    pub fn find_pairs(
        &mut self,
        bodies: &[Body],
        joined: &JoinedPairs,
        settings: &SolverSettings,
        pairs: &mut Vec<Pair>,
    ) {
        let swept = bodies.iter().filter(|body| is_swept(body)).count();
        if swept == 0 {
            return;
        }
        half_space_pairs(bodies, joined, pairs);
        self.sort(bodies, swept);
        self.project(bodies);
        let block_count = self.spheres.len().div_ceil(BUCKETS_A_BLOCK);
        self.found.resize_with(block_count, Vec::new);
        let spheres = &self.spheres;
        let prune_y = settings.sweeps.prune_y;
        for_each_of(settings.threads, self.found.iter_mut().enumerate(), |(block, found)| {
            found.clear();
            let first = block * BUCKETS_A_BLOCK;
            for first in first..(first + BUCKETS_A_BLOCK).min(spheres.len()) {
                pair_bucket(spheres, first, prune_y, joined, found);
            }
        });
        for found in &self.found {
            pairs.extend_from_slice(found);
        }
    }

    /// Brings the order of the bodies on x up to date.
    fn sort(&mut self, bodies: &[Body], swept: usize) {
        self.order.retain(|&(_, body)| bodies.get(body as usize).is_some_and(is_swept));
        if self.order.len() != swept {
            self.order.clear();
            let all = (0..).zip(bodies).filter(|(_, body)| is_swept(body));
            self.order.extend(all.map(|(index, _)| (0, index)));
        }
        self.order.iter_mut().for_each(|at| *at = begin(bodies, at.1));
        if !sort_by_insertion(&mut self.order, MOVES_A_BODY * bodies.len()) {
            self.order.sort_unstable();
        }
    }

    fn project(&mut self, bodies: &[Body]) {
        self.spheres.refill(self.order.iter().map(|&(_, index)| {
            let body = &bodies[index as usize];
            let reach = reach(body);
            let interval = |middle: f64| [middle - reach, middle + reach];
            Projection {
                x: interval(body.position.x),
                z: interval(body.position.z),
                y: interval(body.position.y),
                body: index,
                dynamic: body.is_dynamic(),
                layers: body.layers,
            }
        }));
    }
}

fn half_space_pairs(bodies: &[Body], joined: &JoinedPairs, pairs: &mut Vec<Pair>) {
    let is_half_space = |body: &Body| matches!(body.geometry, Some(Geometry::HalfSpace));
    for (a, plane) in (0..).zip(bodies).filter(|(_, body)| is_half_space(body) && !body.touches_nothing()) {
        let normal = plane.rotation * Vector3::y();
        for (b, body) in (0..).zip(bodies) {
            if is_swept(body)
                && body.is_dynamic()
                && normal.dot(&(body.position - plane.position)) <= reach(body)
                && plane.layers.interact(body.layers)
                && !joined.contains(a, b)
            {
                pairs.push(Pair { a, b });
            }
        }
    }
}

/// Pairs the first body of a bucket with those that survive the pruning.
fn pair_bucket(spheres: &[Projection], first: usize, prune_y: bool, joined: &JoinedPairs, pairs: &mut Vec<Pair>) {
    let one = &spheres[first];
    let overlap = |a: [f64; 2], b: [f64; 2]| a[0] <= b[1] && b[0] <= a[1];
    for other in spheres[first + 1..].iter().take_while(|other| other.x[0] <= one.x[1]) {
        if overlap(one.z, other.z)
            && (!prune_y || overlap(one.y, other.y))
            && (one.dynamic || other.dynamic)
            && one.layers.interact(other.layers)
            && !joined.contains(one.body, other.body)
        {
            pairs.push(Pair { a: one.body.min(other.body), b: one.body.max(other.body) });
        }
    }
}

/// Sorts what is nearly sorted; gives up, with false, after more than that many moves.
fn sort_by_insertion(order: &mut [(i64, u32)], mut moves_left: usize) -> bool {
    for sorted in 1..order.len() {
        let begin = order[sorted];
        let mut place = sorted;
        while place > 0 && order[place - 1] > begin {
            if moves_left == 0 {
                order[place] = begin;
                return false;
            }
            moves_left -= 1;
            order[place] = order[place - 1];
            place -= 1;
        }
        order[place] = begin;
    }
    true
}
