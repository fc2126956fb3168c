//! Pairs of parts: what stands for a pair of bodies of which one has parts.
//!
//! The broad phase pairs bodies. Such a pair has a slot there that nobody else sees, and of its parts those pairs have slots
//! that may meet within a step, and a margin. They are looked for anew when the bodies may have moved against each other by
//! the margin, or move so much faster; what is there already keeps its slot.

use nalgebra::Vector3;

use super::in_step::InStep;
use super::pair_slots::PairSlot;
use super::persistent_pairs::{PairChanges, PersistentPairs};
use crate::physics::bit_set::BitSet;
use crate::physics::body::{Body, RigidBody};
use crate::physics::collision::constants::{FAT_MARGIN, LASTING_SHARE, LONGEST_ARM, SPECULATIVE_MARGIN};
use crate::physics::collision::gap::{Motion, own_reach, turning_speed, way_gained, way_of};
use crate::physics::collision::manifold::{Pair, PartPair};
use crate::physics::collision::parts::{Way, has_parts, least_radius, near_parts};
use crate::physics::collision::pose::Pose;
use crate::physics::refill::Refill;

/// What is known of a pair of bodies.
#[derive(Clone, Debug, Default)]
struct Known {
    /// Its parts, sorted, and their slots.
    parts: Vec<(PartPair, PairSlot)>,
    /// None: they were not looked for.
    seen: Option<Seen>,
}

/// How two bodies lay and moved when their parts were looked for.
#[derive(Clone, Debug)]
struct Seen {
    pose: Pose,
    motions: [Motion; 2],
    /// The step then, s.
    h: f64,
    /// By how much more than they moved in that step the parts were looked for, m; zero where that is used up soon.
    margin: f64,
}

/// The pairs of parts of each pair.
#[derive(Clone, Debug, Default)]
pub(super) struct PartPairs {
    /// The slots of pairs of bodies that are looked at part by part.
    whole: BitSet,
    /// By such a slot.
    known: Vec<Known>,
    // Scratch.
    found: Vec<PartPair>,
    merged: Vec<(PartPair, PairSlot)>,
    to_find: Vec<u32>,
}

impl PartPairs {
    /// Whether a slot is that of a pair of bodies whose parts have slots instead.
    pub fn is_whole(&self, slot: PairSlot) -> bool {
        self.whole.contains(slot.0)
    }

    /// Takes those pairs of bodies out of a list of what was removed, from a place on, that nobody has seen.
    pub fn forget(&mut self, removed: &mut Vec<(PairSlot, Pair)>, first: usize) {
        let mut index = 0;
        removed.retain(|(slot, _)| {
            index += 1;
            let is_whole = index > first && self.is_whole(*slot);
            if is_whole {
                self.whole.set(slot.0, false);
                let known = &mut self.known[slot.0 as usize];
                known.parts.clear();
                known.seen = None;
            }
            !is_whole
        });
    }

    /// Follows what became of pairs of bodies, of which those are awake.
    pub fn update(
        &mut self,
        pairs: &mut PersistentPairs,
        in_step: &InStep,
        is_awake: impl Fn(u32) -> bool,
        changes: &mut PairChanges,
    ) {
        self.forget(&mut changes.removed, 0);
        let ends = |pair: Pair| [pair.a, pair.b].map(|body| &in_step.bodies[body as usize]);
        let added = changes.added.len();
        changes.added.retain(|&slot| {
            let is_whole = ends(pairs.pairs().get(slot).expect("a new pair")).into_iter().any(has_parts);
            self.whole.set(slot.0, is_whole);
            !is_whole
        });
        if self.whole.is_empty() {
            return;
        }
        if changes.added.len() < added {
            self.known.resize_with(pairs.pairs().slot_count(), Known::default);
        }
        let mut to_find = std::mem::take(&mut self.to_find);
        to_find.refill(self.whole.iter());
        for &slot in &to_find {
            let pair = pairs.pairs().get(PairSlot(slot)).expect("a pair of this step");
            let known = &self.known[slot as usize];
            let (is_new, ends) = (known.seen.is_none(), ends(pair));
            if is_new || (is_awake(pair.a) || is_awake(pair.b)) && !known.holds(ends, in_step) {
                self.find(slot, pair, ends, pairs, in_step, changes);
            }
        }
        self.to_find = to_find;
    }

    /// Looks for the pairs of parts of two bodies that are a pair in that slot.
    fn find(
        &mut self,
        slot: u32,
        pair: Pair,
        ends: [&Body; 2],
        pairs: &mut PersistentPairs,
        in_step: &InStep,
        changes: &mut PairChanges,
    ) {
        let looked = Seen::new(ends, in_step);
        let share = if looked.margin > 0.0 { FAT_MARGIN } else { SPECULATIVE_MARGIN };
        self.found.clear();
        let growth = |body: &Body, place: &Vector3<f64>, radius| growth(body, place, radius, in_step, share);
        let way = |body: &Body, place: &Vector3<f64>, radius| way_of(body, place, radius, in_step.h);
        // Others find contacts anew in each step, and want the mesh itself.
        let by_cluster = in_step.reach.is_none().then_some(&way as &Way);
        near_parts(ends, by_cluster, growth, &mut self.found);
        self.found.sort_unstable();
        let Known { parts: known, seen } = &mut self.known[slot as usize];
        *seen = Some(looked);
        // Both lists are sorted.
        let mut found = self.found.iter().peekable();
        known.retain(|&(parts, slot)| {
            while found.next_if(|&&found| found < parts).is_some() {}
            let stays = found.peek() == Some(&&parts);
            if !stays {
                changes.removed.push((slot, pairs.remove_parts(slot)));
            }
            stays
        });
        self.merged.clear();
        let mut known_before = known.drain(..).peekable();
        for &parts in &self.found {
            let slot = known_before.next_if(|(known, _)| *known == parts).map(|(_, slot)| slot);
            let slot = slot.unwrap_or_else(|| {
                let slot = pairs.insert_parts(pair, parts);
                changes.added.push(slot);
                slot
            });
            self.merged.push((parts, slot));
        }
        drop(known_before);
        known.extend_from_slice(&self.merged);
    }
}

impl Known {
    /// Whether the parts found are still all that may meet in this step.
    fn holds(&self, [a, b]: [&Body; 2], in_step: &InStep) -> bool {
        let h = in_step.h;
        in_step.reach.is_none() && self.seen.as_ref().is_some_and(|seen| seen.h == h && seen.gone([a, b]) < seen.margin)
    }
}

impl Seen {
    fn new(ends: [&Body; 2], in_step: &InStep) -> Self {
        let (h, may_move) = (in_step.h, |body: &&Body| body.kind != RigidBody::Static);
        let least = ends.into_iter().filter(may_move).map(least_radius).fold(f64::INFINITY, f64::min);
        let margin = (FAT_MARGIN - SPECULATIVE_MARGIN) * least;
        let way = |body: &Body| (body.linear.norm() + turning_speed(body) + body.pulled * h) * h;
        // What uses it up in few steps is looked at in each, and has fewer parts without it.
        let lasts = ends.map(way).iter().sum::<f64>() < LASTING_SHARE * margin;
        Self { pose: Self::pose(ends), motions: ends.map(Motion::of), h, margin: if lasts { margin } else { 0.0 } }
    }

    /// The smaller in the axes of the other.
    fn pose([a, b]: [&Body; 2]) -> Pose {
        if a.radius < b.radius { Pose::relative(b, a) } else { Pose::relative(a, b) }
    }

    /// By how much the bodies have come nearer since, and move farther in a step than then, at most, m.
    fn gone(&self, [a, b]: [&Body; 2]) -> f64 {
        let h = self.h;
        let (smaller, larger) = (a.radius.min(b.radius), a.radius.max(b.radius).min(LONGEST_ARM));
        let moved = Self::pose([a, b]).moved(&self.pose, smaller);
        // What turns with a body moves another way than then.
        let turned = 1.0 + (a.angular.norm() + b.angular.norm()) * h;
        let gained = |body, before| way_gained(body, before, 2.0 * (smaller + larger), h);
        moved * turned + gained(a, &self.motions[0]) + gained(b, &self.motions[1])
    }
}

/// By how much what a body has within a radius of a place may come nearer to something in this step, m, and a share of the
/// radius for a margin: at least that in which it gets contacts ahead.
fn growth(body: &Body, place: &Vector3<f64>, radius: f64, in_step: &InStep, share: f64) -> f64 {
    let h = in_step.h;
    let reach = in_step.reach.map_or_else(|| way_of(body, place, radius, h), |settings| own_reach(body, settings));
    if body.kind == RigidBody::Static { reach } else { reach + share * radius }
}

#[cfg(test)]
mod tests {
    use bevy::math::{DQuat, DVec3};
    use bevy::prelude::Entity;

    use super::*;
    use crate::physics::collision::continuous::time_of_impact::advanced;
    use crate::physics::joint::JoinedPairs;
    use crate::physics::shape::{Collider, CompoundChild, TriangleMesh};
    use crate::physics::testing::Random;

    fn body(collider: &Collider, kind: RigidBody) -> Body {
        let (geometry, radius) = (Some(collider.geometry()), collider.bounding_radius());
        Body { kind, geometry, radius, ..Body::new(Entity::PLACEHOLDER) }
    }

    /// Three bars, one of them far from the middle.
    fn rake() -> Collider {
        let parts = [DVec3::ZERO, DVec3::X * 0.6, DVec3::new(-2.0, 0.3, 0.0)];
        let parts = parts.map(|at| CompoundChild {
            collider: Collider::cuboid(0.2, 0.3, 1.0),
            position: at,
            rotation: DQuat::from_rotation_z(at.x),
        });
        Collider::compound(&parts).expect("a compound")
    }

    #[test]
    fn parts_that_may_meet_are_known_until_the_margin_is_used_up() {
        let mut random = Random::new(61);
        let waves = TriangleMesh::height_field([8.0, 8.0], [100, 100], |x, z| 0.3 * (x + 2.0 * z).sin());
        let ground = Collider::mesh(waves.expect("a field"));
        let ball = Collider::sphere(0.4);
        let (mut held, mut kept, mut lost) = (0, 0, 0);
        for case in 0..1000 {
            let rake = &rake();
            let below = if case % 3 == 0 { rake } else { &ground };
            let (h, speed) = (random.within(0.002, 0.02), [0.05, 0.15, 0.4][case / 3 % 3]);
            let mut ends = [
                body(below, [RigidBody::Static, RigidBody::Kinematic][case % 2]),
                body(if case % 5 == 0 { &ball } else { rake }, RigidBody::Dynamic),
            ];
            for body in &mut ends {
                (body.position, body.rotation) = (random.vector() * 1.5, random.rotation());
                if body.kind != RigidBody::Static {
                    body.linear = random.vector() * speed;
                    body.angular = random.vector() * if case % 2 == 0 { speed } else { 0.0 };
                }
            }
            let parts_of = |ends: &[Body; 2], share: f64| {
                let joined = &JoinedPairs::default();
                let in_step = InStep { bodies: ends, joined, h, reach: None };
                let mut found = Vec::new();
                let growth = |body: &Body, place: &Vector3<f64>, radius| growth(body, place, radius, &in_step, share);
                let way = |body: &Body, place: &Vector3<f64>, radius| way_of(body, place, radius, h);
                near_parts([&ends[0], &ends[1]], Some(&way), growth, &mut found);
                found.sort_unstable();
                (Seen::new([&ends[0], &ends[1]], &in_step), found)
            };
            let (seen, known) = parts_of(&ends, FAT_MARGIN);
            for _ in 0..30 {
                for body in &mut ends {
                    (body.position, body.rotation) = advanced(body, h);
                    if body.kind != RigidBody::Static {
                        body.linear += random.vector() * 0.1 * speed;
                    }
                }
                let (_, now) = parts_of(&ends, SPECULATIVE_MARGIN);
                let is_known = now.iter().all(|parts| known.binary_search(parts).is_ok());
                if seen.gone([&ends[0], &ends[1]]) < seen.margin {
                    assert!(is_known, "case {case}");
                    (held, kept) = (held + 1, kept + now.len());
                } else {
                    lost += u32::from(!is_known);
                }
            }
        }
        assert!(held > 5000 && kept > 50_000 && lost > 50, "{held} held with {kept} parts, {lost} did not");
    }
}
