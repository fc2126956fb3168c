//! Narrow phase: takes each candidate pair through the separating axis test and, if the two
//! touch, finds the contact points by the chosen model.
//!
//! Pairs are split into blocks of a fixed number, each with buffers of its own, which are joined
//! in order: the contacts do not depend on the number of threads.

use std::ops::Range;

use bevy::prelude::*;
use nalgebra::Vector3;

use super::clipping::{self, ClipBuffers};
use super::extreme_vertices;
use super::placed::Placed;
use super::sat::{self, AxisBuffers, AxisSearch, Overlap};
use super::{CONTACT_TOLERANCE, CandidatePairs, ContactPoint, Contacts, Manifold, Pair, speculative_gap};
use crate::physics::bodies::{Bodies, Body};
use crate::physics::collider::Geometry;
use crate::physics::diagnostics::StepStats;
use crate::physics::settings::{ContactModel, SolverSettings};
use crate::physics::threads::for_each_block;

/// Pairs that one thread works through at a time.
const BLOCK: usize = 128;

/// A run of pairs, and the contacts found in them.
#[derive(Default)]
pub(super) struct Block {
    pairs: Range<usize>,
    manifolds: Vec<Manifold>,
    points: Vec<ContactPoint>,
    buffers: Buffers,
}

/// Buffers of one pair's tests, kept from pair to pair.
#[derive(Default)]
pub(super) struct Buffers {
    axes: AxisBuffers,
    clip: ClipBuffers,
}

/// Fills [`Contacts`] for the present poses.
pub(super) fn find_contacts(
    bodies: Res<Bodies>,
    candidates: Res<CandidatePairs>,
    settings: Res<SolverSettings>,
    mut blocks: Local<Vec<Block>>,
    mut contacts: ResMut<Contacts>,
    mut stats: ResMut<StepStats>,
) {
    let contacts = contacts.bypass_change_detection();
    contacts.time = stats.time;
    contacts.manifolds.clear();
    contacts.points.clear();
    let pairs = &candidates.pairs;
    let block_count = pairs.len().div_ceil(BLOCK);
    if blocks.len() < block_count {
        blocks.resize_with(block_count, Block::default);
    }
    let blocks = &mut blocks[..block_count];
    for (index, block) in blocks.iter_mut().enumerate() {
        block.pairs = index * BLOCK..((index + 1) * BLOCK).min(pairs.len());
    }
    for_each_block(settings.threads, blocks, |block| block.find(&bodies.list, pairs, &settings));
    for block in blocks {
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
    fn find(&mut self, bodies: &[Body], pairs: &[Pair], settings: &SolverSettings) {
        self.manifolds.clear();
        self.points.clear();
        for &pair in &pairs[self.pairs.clone()] {
            let (a, b) = (&bodies[pair.a as usize], &bodies[pair.b as usize]);
            let first = self.points.len();
            let Some(overlap) = touch(a, b, settings, &mut self.buffers, &mut self.points) else { continue };
            let material = a.material.pair(b.material);
            self.manifolds.push(Manifold {
                pair,
                normal: overlap.normal,
                first_point: first as u32,
                point_count: (self.points.len() - first) as u32,
                friction: material.friction,
                restitution: material.restitution,
            });
        }
    }
}

/// Most candidate pairs end here.
fn are_spheres_apart(a: &Body, b: &Body) -> bool {
    let reach = (a.radius + b.radius) * (1.0 + CONTACT_TOLERANCE);
    (b.position - a.position).norm_squared() > reach * reach
}

/// Adds the contact points of two bodies in world axes, if they touch.
pub(super) fn touch(
    a: &Body,
    b: &Body,
    settings: &SolverSettings,
    buffers: &mut Buffers,
    points: &mut Vec<ContactPoint>,
) -> Option<Overlap> {
    if are_spheres_apart(a, b) {
        return None;
    }
    let clips = settings.contacts == ContactModel::Clipping;
    let plane_gap = match a.geometry {
        Some(Geometry::HalfSpace) => speculative_gap(a, b, &(a.rotation * Vector3::y()), settings),
        _ => 0.0,
    };
    let search = AxisSearch {
        epsilon: settings.axis_epsilon,
        merge_opposites: settings.merge_opposite_axes,
        steady_faces: clips,
        touching_edges: clips,
        plane_gap,
    };
    let origin = a.position;
    let (shape_a, shape_b) = (Placed::new(a, &origin)?, Placed::new(b, &origin)?);
    let overlap = sat::overlap(&shape_a, &shape_b, &search, &mut buffers.axes)?;
    let first = points.len();
    if clips {
        clipping::contact_points(&shape_a, &shape_b, &overlap, plane_gap, &mut buffers.clip, points);
    } else {
        extreme_vertices::contact_points(&shape_a, &shape_b, &overlap, points);
    }
    for point in &mut points[first..] {
        point.point += origin;
    }
    Some(overlap)
}
