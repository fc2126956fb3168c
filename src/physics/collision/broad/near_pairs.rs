//! The broad phase by a bounding tree: keeps the [`PersistentPairs`] of the bodies, for contacts that last and, if the
//! settings ask for it, for those of force-level methods.
//!
//! Tells them what a change of a body or joint means, and bounds each shape by its own box.

use bevy::prelude::*;
use nalgebra::Vector3;

use super::bounding_tree::BoundingBox;
use super::fat_box::{Extent, Placement};
use super::pair_slots::PairSlot;
use super::persistent_pairs::{BoundedBodies, Bounds, PairChanges, PersistentPairs};
use crate::physics::body::{Bodies, Body, RigidBody};
use crate::physics::collision::constants::CONTACT_TOLERANCE;
use crate::physics::collision::manifold::{CandidatePairs, Pair};
use crate::physics::joint::{JoinedPairs, Joints};
use crate::physics::settings::SolverSettings;
use crate::physics::shape::Geometry;
use crate::physics::stats::StepStats;

/// Pairs near each other, and what changed about them in this step.
#[derive(Resource, Default)]
pub(crate) struct NearPairs {
    pairs: PersistentPairs,
    pub changes: PairChanges,
    /// Pairs of bodies that are gone, under the indices they had.
    dropped: Vec<(PairSlot, Pair)>,
    /// Steps up to which the pairs are known; bodies that changed in a step without are not.
    known_steps: Option<u64>,
    joined: JoinedPairs,
    joints_version: u64,
}

impl NearPairs {
    /// Follows bodies to their new indices.
    pub fn remap(&mut self, new_index: &[Option<u32>]) {
        self.pairs.remap(new_index, &mut self.dropped);
        self.joined.remap(new_index);
    }
}

/// The same for contacts that do not last: a tree of its own, since those that last take in every change of theirs.
#[derive(Resource, Default)]
pub(crate) struct CandidateTree(NearPairs);

impl CandidateTree {
    /// Follows bodies to their new indices.
    pub fn remap(&mut self, new_index: &[Option<u32>]) {
        self.0.remap(new_index);
    }
}

/// The bodies as the broad phase asks for them.
pub(crate) struct InStep<'a> {
    pub bodies: &'a [Body],
    pub joined: &'a JoinedPairs,
    /// s.
    pub h: f64,
}

impl BoundedBodies for InStep<'_> {
    fn placement(&self, body: u32) -> Placement {
        let body = &self.bodies[body as usize];
        Placement {
            position: body.position,
            rotation: body.rotation,
            travel: body.linear * self.h,
            turn: body.angular.norm() * self.h,
        }
    }

    fn bounds(&self, body: u32) -> Bounds {
        let body = &self.bodies[body as usize];
        if body.layers.touch_nothing() {
            return Bounds::None;
        }
        let axes = body.rotation.to_rotation_matrix().into_inner();
        let reach = match &body.geometry {
            None => return Bounds::None,
            Some(Geometry::HalfSpace) => return Bounds::HalfSpace { normal: axes.column(1).into_owned() },
            Some(Geometry::Sphere { radius }) => [Vector3::repeat(-radius), Vector3::repeat(*radius)],
            Some(Geometry::Cuboid { half }) => {
                let reach = axes.abs() * half;
                [-reach, reach]
            }
            Some(Geometry::Cone { radius, height, .. }) => {
                // The apex, and the disc of the base.
                let axis = axes.column(1);
                let disc = axis.map(|along| radius * (1.0 - along * along).max(0.0).sqrt());
                let (apex, base) = (axis * (0.75 * height), axis * (-0.25 * height));
                [apex.inf(&(base - disc)), apex.sup(&(base + disc))]
            }
            Some(Geometry::Hull(hull)) => {
                let start = [Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY)];
                hull.vertices
                    .iter()
                    .map(|vertex| axes * vertex)
                    .fold(start, |[low, high], v| [low.inf(&v), high.sup(&v)])
            }
        };
        let slack = Vector3::repeat(CONTACT_TOLERANCE * body.radius);
        let [low, high] = [body.position + reach[0] - slack, body.position + reach[1] + slack];
        let moves = body.kind != RigidBody::Static;
        Bounds::Within(Extent { bounds: BoundingBox { low, high }, radius: body.radius, moves })
    }

    fn may_pair(&self, a: u32, b: u32) -> bool {
        let (one, other) = (&self.bodies[a as usize], &self.bodies[b as usize]);
        (one.is_dynamic() || other.is_dynamic()) && one.layers.interact(other.layers) && !self.joined.contains(a, b)
    }
}

/// Brings the pairs of contacts that last up to date with the bodies.
pub(crate) fn update_pairs(
    bodies: Res<Bodies>,
    joints: Res<Joints>,
    joined: Res<JoinedPairs>,
    settings: Res<SolverSettings>,
    mut near: ResMut<NearPairs>,
    stats: Res<StepStats>,
) {
    near.bypass_change_detection().update(&bodies, &joints, &joined, &settings, stats.steps);
}

/// Brings the pairs of contacts that do not last up to date with the bodies, and lists them: half-spaces first, then by
/// index, so that contacts do not depend on the slots, which depend on the past.
pub(crate) fn find_candidate_pairs(
    bodies: Res<Bodies>,
    joints: Res<Joints>,
    joined: Res<JoinedPairs>,
    settings: Res<SolverSettings>,
    mut tree: ResMut<CandidateTree>,
    mut candidates: ResMut<CandidatePairs>,
    mut stats: ResMut<StepStats>,
) {
    let tree = &mut tree.bypass_change_detection().0;
    tree.update(&bodies, &joints, &joined, &settings, stats.steps);
    let is_half_space = |body: u32| matches!(bodies.list[body as usize].geometry, Some(Geometry::HalfSpace));
    let pairs = &mut candidates.bypass_change_detection().pairs;
    pairs.clear();
    pairs.extend(tree.pairs.pairs().iter().map(|(_, pair)| pair));
    pairs.sort_unstable_by_key(|pair| (!is_half_space(pair.a), *pair));
    stats.pairs = pairs.len() as u32;
}

impl NearPairs {
    fn update(
        &mut self,
        bodies: &Bodies,
        joints: &Joints,
        joined: &JoinedPairs,
        settings: &SolverSettings,
        steps: u64,
    ) {
        let Self { pairs, changes, dropped, known_steps, joined: joined_before, joints_version } = self;
        if known_steps.replace(steps + 1) == Some(steps) {
            bodies.renewed.iter().for_each(|&body| pairs.renew(body));
        } else {
            (0..bodies.list.len() as u32).for_each(|body| pairs.renew(body));
        }
        if *joints_version != joints.version {
            *joints_version = joints.version;
            joined.differences(joined_before, |a, b| pairs.reconsider(a, b));
            joined_before.clone_from(joined);
        }
        let in_step = InStep { bodies: &bodies.list, joined, h: settings.step() };
        pairs.update(&in_step, bodies.awake(), changes);
        if !dropped.is_empty() {
            dropped.append(&mut changes.removed);
            std::mem::swap(dropped, &mut changes.removed);
        }
    }

    /// The pair of a slot.
    pub fn pair(&self, slot: PairSlot) -> Option<Pair> {
        self.pairs.pairs().get(slot)
    }

    /// The pairs of a body: slots, and who is at the other end.
    pub fn of_body(&self, body: u32) -> impl Iterator<Item = (PairSlot, u32)> {
        self.pairs.pairs().of_body(body)
    }

    /// How many slots there are, free ones included.
    pub fn slot_count(&self) -> usize {
        self.pairs.pairs().slot_count()
    }
}
