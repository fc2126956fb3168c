//! The broad phase of contacts that last: keeps the [`PersistentPairs`] or [`SweptPairs`] of the bodies.
//!
//! Tells them what a change of a body or joint means, and bounds each shape by its own box.

use bevy::prelude::*;
use nalgebra::Vector3;

use super::bounding_tree::BoundingBox;
use super::fat_box::{Extent, Placement};
use super::gap::CONTACT_TOLERANCE;
use super::manifold::Pair;
use super::pair_slots::{PairSlot, PairSlots};
use super::persistent_pairs::{BoundedBodies, Bounds, PairChanges, PersistentPairs};
use super::swept_pairs::SweptPairs;
use crate::physics::body::RigidBody;
use crate::physics::body::{Bodies, Body};
use crate::physics::joint::JoinedPairs;
use crate::physics::joint::Joints;
use crate::physics::settings::{BroadPhase, SolverSettings};
use crate::physics::shape::Geometry;
use crate::physics::stats::StepStats;

/// Who keeps the pairs.
enum Search {
    Tree(PersistentPairs),
    Sweep(SweptPairs),
}

impl Default for Search {
    fn default() -> Self {
        Self::of(BroadPhase::default())
    }
}

impl Search {
    fn of(broad_phase: BroadPhase) -> Self {
        match broad_phase {
            BroadPhase::BoundingTree => Self::Tree(PersistentPairs::default()),
            BroadPhase::SweepAndSort => Self::Sweep(SweptPairs::default()),
        }
    }

    fn kind(&self) -> BroadPhase {
        match self {
            Self::Tree(_) => BroadPhase::BoundingTree,
            Self::Sweep(_) => BroadPhase::SweepAndSort,
        }
    }

    fn pairs(&self) -> &PairSlots {
        match self {
            Self::Tree(tree) => tree.pairs(),
            Self::Sweep(sweep) => sweep.pairs(),
        }
    }

    fn renew(&mut self, body: u32) {
        match self {
            Self::Tree(tree) => tree.renew(body),
            Self::Sweep(sweep) => sweep.renew(body),
        }
    }
}

/// Pairs near each other, and what changed about them in this step.
#[derive(Resource, Default)]
pub(crate) struct NearPairs {
    search: Search,
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
        match &mut self.search {
            Search::Tree(tree) => tree.remap(new_index, &mut self.dropped),
            Search::Sweep(sweep) => sweep.remap(new_index, &mut self.dropped),
        }
        self.joined.remap(new_index);
    }
}

/// The bodies as the broad phase asks for them.
pub(super) struct InStep<'a> {
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

/// Brings the pairs up to date with the bodies.
pub(super) fn update_pairs(
    bodies: Res<Bodies>,
    joints: Res<Joints>,
    joined: Res<JoinedPairs>,
    settings: Res<SolverSettings>,
    mut near: ResMut<NearPairs>,
    stats: Res<StepStats>,
) {
    let near = near.bypass_change_detection();
    let NearPairs { search, changes, dropped, known_steps, joined: joined_before, joints_version } = near;
    if search.kind() != settings.broad_phase {
        dropped.extend(search.pairs().iter());
        *search = Search::of(settings.broad_phase);
        *known_steps = None;
    }
    if known_steps.replace(stats.steps + 1) == Some(stats.steps) {
        bodies.renewed.iter().for_each(|&body| search.renew(body));
    } else {
        (0..bodies.list.len() as u32).for_each(|body| search.renew(body));
    }
    if *joints_version != joints.version {
        *joints_version = joints.version;
        if let Search::Tree(tree) = search {
            joined.differences(joined_before, |a, b| tree.reconsider(a, b));
        }
        joined_before.clone_from(&joined);
    }
    match search {
        Search::Tree(tree) => {
            let in_step = InStep { bodies: &bodies.list, joined: &joined, h: settings.step() };
            tree.update(&in_step, bodies.awake(), changes);
        }
        Search::Sweep(sweep) => sweep.update(&bodies.list, &joined, &settings, changes),
    }
    if !dropped.is_empty() {
        dropped.append(&mut changes.removed);
        std::mem::swap(dropped, &mut changes.removed);
    }
}

impl NearPairs {
    /// The pair of a slot.
    pub fn pair(&self, slot: PairSlot) -> Option<Pair> {
        self.search.pairs().get(slot)
    }

    /// The pairs of a body: slots, and who is at the other end.
    pub fn of_body(&self, body: u32) -> impl Iterator<Item = (PairSlot, u32)> {
        self.search.pairs().of_body(body)
    }

    /// How many slots there are, free ones included.
    pub fn slot_count(&self) -> usize {
        self.search.pairs().slot_count()
    }
}
