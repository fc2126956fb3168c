//! Contacts found anew in each step, of what is in slots or what the 2009 way found.
//!
//! Pairs are split into blocks of a fixed number, each with buffers of its own, which are joined
//! in order: the contacts do not depend on the number of threads.

use bevy::prelude::*;

use super::broad::near_pairs::NearPairs;
use super::classic::extreme_vertices;
use super::classic::sat::AxisBuffers;
use super::classic::sweep_and_sort::{SweptPairs, begin};
use super::gap::contact_gap;
use super::manifold::{ContactPoint, Contacts, Manifold, Overlap, Pair, PairKey, PartPair};
use super::narrow::contact_pair::{self, PairSearch};
use super::narrow::feature_sat::Feature;
use super::parts::{is_mesh, parts_within};
use super::slots::graph::{Carried, ContactGraph};
use crate::physics::body::{Bodies, Body};
use crate::physics::collision::constants::{CONTACT_TOLERANCE, PAIRS_A_BLOCK};
use crate::physics::contact::surface;
use crate::physics::refill::Refill;
use crate::physics::settings::{ContactModel, Method, SolverSettings};
use crate::physics::shape::Geometry;
use crate::physics::stats::StepStats;
use crate::physics::threads::for_each_of;

/// The contacts found in a run of pairs, and buffers.
#[derive(Default)]
pub(super) struct Block {
    manifolds: Vec<Manifold>,
    points: Vec<ContactPoint>,
    /// The axis that the test of each slot's pair ended with.
    axes: Vec<(u32, Option<Feature>)>,
    buffers: Buffers,
}

/// Buffers of one pair's tests, kept from pair to pair.
#[derive(Default)]
pub(super) struct Buffers {
    axes: AxisBuffers,
    pub search: PairSearch,
}

/// Fills [`Contacts`] for the present poses.
pub(super) fn find_contacts(
    bodies: Res<Bodies>,
    near: Res<NearPairs>,
    swept: Res<SweptPairs>,
    settings: Res<SolverSettings>,
    mut graph: ResMut<ContactGraph>,
    (mut candidates, mut near_parts, mut begins): (Local<Vec<PairKey>>, Local<Vec<PartPair>>, Local<Vec<i64>>),
    mut blocks: Local<Vec<Block>>,
    mut contacts: ResMut<Contacts>,
    mut stats: ResMut<StepStats>,
) {
    let (contacts, graph) = (contacts.bypass_change_detection(), graph.bypass_change_detection());
    candidates.clear();
    graph.forget_renewed(&bodies.renewed);
    if settings.contact_model() == ContactModel::Clipping {
        graph.take_pairs(&near, &bodies.list);
        graph.carried.resize(graph.slots.len(), Carried::default());
        let slots = graph.active().map(|slot| (slot, &graph.slots[slot as usize]));
        candidates.extend(slots.map(|(index, slot)| PairKey { slot: Some(index), pair: slot.pair, parts: slot.parts }));
        sort_along_x(&mut candidates, &bodies.list, &mut begins);
        stats.pairs = candidates.len() as u32;
    } else {
        for &pair in &swept.0 {
            let [a, b] = [pair.a, pair.b].map(|body| &bodies.list[body as usize]);
            parts_within(a, b, contact_gap(a, b, &settings), &mut near_parts);
            candidates.extend(near_parts.iter().map(|&parts| PairKey { slot: None, pair, parts }));
        }
    }
    contacts.time = stats.time;
    contacts.manifolds.clear();
    contacts.points.clear();
    let block_count = candidates.len().div_ceil(PAIRS_A_BLOCK);
    if blocks.len() < block_count {
        blocks.resize_with(block_count, Block::default);
    }
    let blocks = &mut blocks[..block_count];
    let work = candidates.chunks(PAIRS_A_BLOCK).zip(blocks.iter_mut());
    let carried = &graph.carried;
    for_each_of(settings.threads, work, |(pairs, block)| block.find(&bodies.list, pairs, &settings, carried));
    stats.axes_tested = 0;
    for block in blocks {
        stats.axes_tested += u64::from(block.buffers.axes.axes) + u64::from(block.buffers.search.axes);
        block.axes.iter().for_each(|&(slot, axis)| graph.carried[slot as usize].axis = axis);
        let first = contacts.points.len() as u32;
        contacts.points.extend_from_slice(&block.points);
        contacts.manifolds.extend(
            block.manifolds.iter().map(|manifold| Manifold { first_point: first + manifold.first_point, ..*manifold }),
        );
    }
    stats.manifolds = contacts.manifolds.len() as u32;
    stats.contact_points = contacts.points.len() as u32;
}

/// Half-spaces first, then as the 2009 sweep finds them: rows are swept in this order, and it does not depend on the
/// slots, which depend on the past. `begins` is a buffer.
fn sort_along_x(candidates: &mut [PairKey], bodies: &[Body], begins: &mut Vec<i64>) {
    let is_plane = |body: &Body| matches!(body.geometry, Some(Geometry::HalfSpace));
    begins
        .refill((0..).zip(bodies).map(|(index, body)| if is_plane(body) { i64::MIN } else { begin(bodies, index).0 }));
    let key = |&PairKey { pair: Pair { a, b }, parts, .. }: &PairKey| {
        let [of_a, of_b] = [a, b].map(|body| (begins[body as usize], body));
        let ends = if of_a.0 == i64::MIN { [of_a, (i64::MIN, b)] } else { [of_a.min(of_b), of_a.max(of_b)] };
        (ends, parts)
    };
    candidates.sort_unstable_by_key(key);
}

impl Block {
    fn find(&mut self, bodies: &[Body], candidates: &[PairKey], settings: &SolverSettings, carried: &[Carried]) {
        self.manifolds.clear();
        self.points.clear();
        self.axes.clear();
        self.buffers.axes.axes = 0;
        self.buffers.search.axes = 0;
        for &PairKey { slot, pair, parts } in candidates {
            let (a, b) = (&bodies[pair.a as usize], &bodies[pair.b as usize]);
            if are_spheres_apart(a, b, contact_gap(a, b, settings)) {
                continue;
            }
            let first = self.points.len();
            self.buffers.search.last = slot.and_then(|slot| carried[slot as usize].axis);
            let touching = touch([a, b], parts, settings, &mut self.buffers, &mut self.points);
            self.axes.extend(slot.map(|slot| (slot, self.buffers.search.last)));
            let Some(overlap) = touching else { continue };
            let surface = surface(a, b, settings.friction);
            self.manifolds.push(Manifold {
                slot,
                pair,
                parts,
                normal: overlap.normal,
                first_point: first as u32,
                point_count: (self.points.len() - first) as u32,
                friction: surface.friction,
                restitution: surface.restitution,
            });
        }
    }
}

/// Whether two bodies are farther apart than the gap, by their bounding spheres. Most candidate
/// pairs end here.
fn are_spheres_apart(a: &Body, b: &Body, gap: f64) -> bool {
    let reach = (a.radius + b.radius) * (1.0 + CONTACT_TOLERANCE) + gap;
    (b.position - a.position).norm_squared() > reach * reach
}

/// Adds the contact points of two bodies in world axes, if they touch.
pub(super) fn touch(
    [a, b]: [&Body; 2],
    parts: PartPair,
    settings: &SolverSettings,
    buffers: &mut Buffers,
    points: &mut Vec<ContactPoint>,
) -> Option<Overlap> {
    match settings.contact_model() {
        ContactModel::Clipping => {
            let search = &mut buffers.search;
            let gap = contact_gap(a, b, settings);
            if settings.method != Method::Exact || !(is_mesh(a) || is_mesh(b)) {
                return contact_pair::touch([a, b], parts, gap, search, points);
            }
            // Over a mesh, what `exact` is to look at is told by the test that measures its gaps. A facet over whose inner
            // edge something is on its way may be met in the step, though nothing of it is foremost as yet.
            search.is_exact = true;
            let first = points.len();
            let met = contact_pair::touch([a, b], parts, gap, search, points).or_else(|| {
                search.any_normal = true;
                let near = contact_pair::touch([a, b], parts, gap, search, points);
                search.any_normal = false;
                points.truncate(first);
                near
            });
            search.is_exact = false;
            met
        }
        ContactModel::ExtremeVertices | ContactModel::SinglePoint => {
            extreme_vertices::touch([a, b], parts, settings, &mut buffers.axes, points)
        }
    }
}
