//! Narrow phase: takes each candidate pair through the routine that the contact model names.
//!
//! Pairs are split into blocks of a fixed number, each with buffers of its own, which are joined
//! in order: the contacts do not depend on the number of threads. The axis that each pair's
//! test ended with is kept for the next step's test to begin with; the contacts do not
//! depend on it.

use bevy::platform::collections::HashMap;
use bevy::prelude::*;

use super::classic::extreme_vertices;
use super::classic::sat::AxisBuffers;
use super::gap::contact_gap;
use super::manifold::{CandidatePairs, ContactPoint, Contacts, Manifold, Overlap, Pair};
use super::narrow::contact_pair::{self, PairSearch};
use super::narrow::feature_sat::Feature;
use crate::physics::body::{Bodies, Body};
use crate::physics::collision::constants::{CONTACT_TOLERANCE, PAIRS_A_BLOCK};
use crate::physics::contact::surface;
use crate::physics::settings::{ContactModel, SolverSettings};
use crate::physics::shape::Geometry;
use crate::physics::stats::StepStats;
use crate::physics::threads::for_each_of;

/// The contacts found in a run of pairs, and buffers.
#[derive(Default)]
pub(super) struct Block {
    manifolds: Vec<Manifold>,
    points: Vec<ContactPoint>,
    last_axes: Vec<(Pair, Feature)>,
    buffers: Buffers,
}

/// Buffers of one pair's tests, kept from pair to pair.
#[derive(Default)]
pub(super) struct Buffers {
    axes: AxisBuffers,
    pub search: PairSearch,
}

/// The axis that the test of each pair ended with. A pair that is no candidate any more leaves; one whose bodies were
/// replaced may find the axis of another, which costs one measurement.
#[derive(Default)]
pub(super) struct LastAxes(HashMap<Pair, Feature>);

/// Fills [`Contacts`] for the present poses.
pub(super) fn find_contacts(
    bodies: Res<Bodies>,
    candidates: Res<CandidatePairs>,
    settings: Res<SolverSettings>,
    mut blocks: Local<Vec<Block>>,
    mut last_axes: Local<LastAxes>,
    mut contacts: ResMut<Contacts>,
    mut stats: ResMut<StepStats>,
) {
    let contacts = contacts.bypass_change_detection();
    contacts.time = stats.time;
    contacts.manifolds.clear();
    contacts.points.clear();
    let pairs = &candidates.pairs;
    let block_count = pairs.len().div_ceil(PAIRS_A_BLOCK);
    if blocks.len() < block_count {
        blocks.resize_with(block_count, Block::default);
    }
    let blocks = &mut blocks[..block_count];
    let work = pairs.chunks(PAIRS_A_BLOCK).zip(blocks.iter_mut());
    for_each_of(settings.threads, work, |(pairs, block)| block.find(&bodies.list, pairs, &settings, &last_axes));
    last_axes.0.clear();
    stats.axes_tested = 0;
    for block in blocks {
        stats.axes_tested += u64::from(block.buffers.axes.axes) + u64::from(block.buffers.search.axes);
        last_axes.0.extend(block.last_axes.iter().copied());
        let first = contacts.points.len() as u32;
        contacts.points.extend_from_slice(&block.points);
        contacts.manifolds.extend(
            block.manifolds.iter().map(|manifold| Manifold { first_point: first + manifold.first_point, ..*manifold }),
        );
    }
    stats.manifolds = contacts.manifolds.len() as u32;
    stats.contact_points = contacts.points.len() as u32;
}

impl Block {
    fn find(&mut self, bodies: &[Body], pairs: &[Pair], settings: &SolverSettings, last_axes: &LastAxes) {
        self.manifolds.clear();
        self.points.clear();
        self.last_axes.clear();
        self.buffers.axes.axes = 0;
        self.buffers.search.axes = 0;
        for &pair in pairs {
            let (a, b) = (&bodies[pair.a as usize], &bodies[pair.b as usize]);
            if are_spheres_apart(a, b, contact_gap(a, b, settings)) {
                continue;
            }
            let first = self.points.len();
            let keeps_axis = settings.contact_model() == ContactModel::Clipping && are_searched(a, b);
            self.buffers.search.last = if keeps_axis { last_axes.0.get(&pair).copied() } else { None };
            let touching = touch(a, b, settings, &mut self.buffers, &mut self.points);
            if keeps_axis {
                self.last_axes.extend(self.buffers.search.last.map(|axis| (pair, axis)));
            }
            let Some(overlap) = touching else { continue };
            let surface = surface(a, b, settings.friction);
            self.manifolds.push(Manifold {
                pair,
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

/// Whether the pair's test goes from feature to feature, so that it is worth to remember where it
/// ended. Half-spaces and balls have no such test, and two boxes are tested faster than that is
/// found.
fn are_searched(a: &Body, b: &Body) -> bool {
    let [is_box_a, is_box_b] = [a, b].map(|body| match &body.geometry {
        Some(Geometry::Cuboid { .. }) => Some(true),
        Some(Geometry::Hull(_) | Geometry::Cone { .. }) => Some(false),
        _ => None,
    });
    is_box_a.zip(is_box_b).is_some_and(|boxes| boxes != (true, true))
}

/// Adds the contact points of two bodies in world axes, if they touch.
pub(super) fn touch(
    a: &Body,
    b: &Body,
    settings: &SolverSettings,
    buffers: &mut Buffers,
    points: &mut Vec<ContactPoint>,
) -> Option<Overlap> {
    match settings.contact_model() {
        ContactModel::Clipping => contact_pair::touch(a, b, contact_gap(a, b, settings), &mut buffers.search, points),
        ContactModel::ExtremeVertices => extreme_vertices::touch(a, b, settings, &mut buffers.axes, points),
    }
}
