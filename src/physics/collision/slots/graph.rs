//! All slots, and the system that brings them up to date.

use bevy::platform::collections::HashMap;
use bevy::prelude::*;
use nalgebra::Vector3;

use super::record::{ContactState, POINTS};
use super::slot::Slot;
use super::watch::{Known, Travels, Watch};
use crate::physics::bit_set::{BitSet, ones};
use crate::physics::body::{Bodies, Body};
use crate::physics::collision::broad::near_pairs::NearPairs;
use crate::physics::collision::broad::pair_slots::PairSlot;
use crate::physics::collision::constants::{PAIRS_IN_ROW, SLOTS_A_CHUNK};
use crate::physics::collision::continuous::fast_pair::FastPair;
use crate::physics::collision::gap::{gap_if_stopped, lasting_gap};
use crate::physics::collision::manifold::{ContactPoint, FeatureId, Pair, PairKey, PartPair};
use crate::physics::collision::narrow::contact_pair::PairSearch;
use crate::physics::collision::narrow::feature_sat::Feature;
use crate::physics::collision::pose::Pose;
use crate::physics::contact::namesake;
use crate::physics::joint::Joints;
use crate::physics::lanes::Record;
use crate::physics::settings::SolverSettings;
use crate::physics::stats::StepStats;
use crate::physics::threads::for_each_of;

/// Stands for a body that is gone, until its pairs are dropped.
pub(crate) const GONE: u32 = u32::MAX;

/// All pairs near each other, slot by slot. A slot's index stays the same for its life.
#[derive(Resource, Default, Clone)]
pub(crate) struct ContactGraph {
    pub slots: Vec<Slot>,
    pub states: Vec<ContactState>,
    pub(super) watches: Vec<Watch>,
    travels: Travels,
    /// Slots of bodies that move along with each other and are left to look at, and the bodies that touch something.
    pub(super) together: Vec<u32>,
    pub(super) touched: BitSet,
    /// In how many pairs each body is.
    pub(super) pair_counts: Vec<u32>,
    /// Instead of states, where manifolds are found anew in each step.
    pub carried: Vec<Carried>,
    /// What points of pairs without a slot carried in the last solve, by pair, and the forces on B there, N, world axes.
    without_slot: Vec<((Pair, PartPair), FeatureId, Vector3<f64>)>,
    /// Counts every change of which pairs touch.
    pub version: u64,
    /// Counts updates.
    pub(super) updates: u64,
    /// Slots of which [`ContactStarted`](crate::physics::ContactStarted) was sent, and the end not yet.
    pub started: BitSet,
    /// Whether that may be out of date.
    pub starts_changed: bool,
    /// Slots with contact points.
    touching: BitSet,
    /// The slots that a step looks at: not those of pairs in which nothing awake can be moved.
    active: BitSet,
    /// Slots of pairs that fell asleep in this step.
    pub fell_asleep: Vec<u32>,
    /// Pairs that touch, and their points; of the latter, those of slots that sleep.
    manifolds: i64,
    point_count: i64,
    points_asleep: i64,
    /// Pairs in which a body may move farther than it is thick in this step, by slot.
    pub fast: Vec<FastPair>,
    /// Pairs that pushed each other until they were no pairs any more, and whether they were of parts.
    pub parted: Vec<((Entity, Entity), bool)>,
    /// Of how many slots of parts of the same bodies it was told that they push, the lower entity first.
    pub started_parts: HashMap<(Entity, Entity), i32>,
    /// While somebody reads contact forces.
    pub recording: Option<Recording>,
}

/// What a slot keeps of a manifold that is found anew in each step: which features touch, and the forces.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Carried {
    /// The axis that the pair's test ended with: the next one begins there. Contacts do not depend on it.
    pub(in crate::physics::collision) axis: Option<Feature>,
    /// Contact points of the last solve, and the forces on B there, N, world axes.
    points: [(FeatureId, Vector3<f64>); POINTS],
}

/// What the forces at contact points are computed from.
#[derive(Clone, Default)]
pub(crate) struct Recording {
    /// What each slot's contact pushed in all substeps, N·s.
    pub totals: Vec<Record<f32>>,
    /// The first tangent of each manifold that was exported, world axes.
    pub(super) tangents: Vec<Vector3<f64>>,
}

/// What one thread needs to find contacts, and what it counts.
#[derive(Default)]
pub(in crate::physics::collision) struct Finder {
    search: PairSearch,
    points: Vec<ContactPoint>,
    /// Slots that began or ceased to touch.
    turned: Vec<u32>,
    /// Change of the number of touching pairs, and of their points.
    manifolds: i64,
    point_count: i64,
    fast: Vec<FastPair>,
    /// Slots of bodies that move along with each other, in case something stops one of them.
    pub(super) together: Vec<u32>,
}

/// Takes in which pairs are near and finds their contacts.
pub(in crate::physics::collision) fn update_graph(
    bodies: Res<Bodies>,
    near: Res<NearPairs>,
    joints: Res<Joints>,
    settings: Res<SolverSettings>,
    mut graph: ResMut<ContactGraph>,
    mut finders: Local<Vec<Finder>>,
    mut stats: ResMut<StepStats>,
) {
    let graph = graph.bypass_change_detection();
    graph.carried.clear();
    graph.without_slot.clear();
    graph.take_pairs(&near, &bodies.list);
    graph.forget_renewed(&bodies.renewed);
    if settings.is_changed() {
        graph.slots.iter_mut().for_each(Slot::forget);
        graph.watches.iter_mut().for_each(Watch::end);
    }
    graph.travels.follow(&bodies, settings.step(), settings.threads);
    let chunks = graph.slots.len().div_ceil(SLOTS_A_CHUNK);
    finders.resize_with(chunks, Finder::default);
    graph.updates += 1;
    let (active, update, travels) = (&graph.active, graph.updates, &graph.travels);
    let pair_counts = &graph.pair_counts[..];
    let slots = graph
        .slots
        .chunks_mut(SLOTS_A_CHUNK)
        .zip(graph.states.chunks_mut(SLOTS_A_CHUNK))
        .zip(graph.watches.chunks_mut(SLOTS_A_CHUNK))
        .zip(finders.iter_mut())
        .enumerate();
    let work = slots.map(|(chunk, (((slots, states), watches), finder))| {
        let active = active.words(chunk * SLOTS_A_CHUNK, SLOTS_A_CHUNK);
        let first = (chunk * SLOTS_A_CHUNK) as u32;
        Chunk { first, slots, states, watches, active, update, travels, pair_counts, joined: &joints.joined, finder }
    });
    for_each_of(settings.threads, work, |mut chunk| chunk.update(&bodies.list, &settings));
    stats.axes_tested = 0;
    graph.fast.clear();
    graph.take_found(&mut finders, &mut stats);
    if graph.find_behind_impacts(&bodies.list, &joints.joined, &settings, &mut finders) {
        graph.take_found(&mut finders, &mut stats);
    }
    stats.pairs = graph.active.len();
    stats.manifolds = graph.manifolds as u32;
    stats.contact_points = graph.point_count as u32;
}

impl ContactGraph {
    /// Takes in what was found.
    fn take_found(&mut self, finders: &mut [Finder], stats: &mut StepStats) {
        for finder in finders {
            stats.axes_tested += u64::from(std::mem::take(&mut finder.search.axes));
            self.version += u64::from(!finder.turned.is_empty());
            self.starts_changed |= !finder.turned.is_empty();
            for slot in finder.turned.drain(..) {
                self.touching.set(slot, self.slots[slot as usize].touching);
            }
            self.manifolds += std::mem::take(&mut finder.manifolds);
            self.point_count += std::mem::take(&mut finder.point_count);
            self.fast.append(&mut finder.fast);
        }
    }

    /// Follows bodies to their new indices. Pairs of the gone are dropped in the next step.
    pub fn remap(&mut self, new_index: &[Option<u32>]) {
        self.without_slot.clear();
        for slot in self.slots.iter_mut().filter(|slot| slot.entities.is_some()) {
            let of = |body: u32| new_index.get(body as usize).copied().flatten();
            slot.pair = Pair { a: of(slot.pair.a).unwrap_or(GONE), b: of(slot.pair.b).unwrap_or(GONE) };
        }
        self.pair_counts.clear();
        for slot in self.slots.iter().filter(|slot| slot.entities.is_some()) {
            count_pair(&mut self.pair_counts, slot.pair, true);
        }
        self.travels.clear();
        self.watches.iter_mut().zip(&self.slots).for_each(|(watch, slot)| *watch = Watch::new(slot.pair));
    }

    /// Where a body was before the step.
    pub(in crate::physics::collision) fn start(&self, body: u32) -> Pose {
        self.travels.start(body)
    }

    /// How far a body could move in the step at its velocities before it, m.
    pub(in crate::physics::collision) fn own_way(&self, body: u32) -> f64 {
        self.travels.own_way(body)
    }

    /// Whether a step looks at a slot.
    pub fn is_active(&self, slot: PairSlot) -> bool {
        self.active.contains(slot.0)
    }

    /// The slots that a step looks at, ascending.
    pub fn active(&self) -> impl Iterator<Item = u32> + Clone + '_ {
        self.active.iter()
    }

    /// Has steps look at a slot, or not.
    pub fn set_active(&mut self, PairSlot(slot): PairSlot, is_active: bool) {
        if self.active.contains(slot) == is_active {
            return;
        }
        self.active.set(slot, is_active);
        let points = self.states.get(slot as usize).map_or(0, |state| state.geometry.point_count() as i64);
        self.points_asleep += if is_active { -points } else { points };
    }

    /// The pairs that touch and are looked at, by slot, ascending.
    pub fn touching(&self) -> impl Iterator<Item = (u32, (u32, u32))> + Clone + '_ {
        self.active.both(&self.touching).map(|slot| {
            let Pair { a, b } = self.watches[slot as usize].pair();
            (slot, (a, b))
        })
    }

    /// Of the slots that a step looks at, those with contact points and those of which a start was told, ascending.
    pub fn touching_or_started(&self) -> impl Iterator<Item = u32> + Clone + '_ {
        self.active.with_either(&self.touching, &self.started)
    }

    /// Contact points of slots that are looked at.
    pub fn active_points(&self) -> u32 {
        (self.point_count - self.points_asleep) as u32
    }

    /// The force that a pair's point carried, zero where it is new.
    pub fn force(&self, PairKey { slot, pair, parts }: PairKey, feature: FeatureId) -> Vector3<f64> {
        if let Some(slot) = slot {
            let Some(carried) = self.carried.get(slot as usize) else { return Vector3::zeros() };
            let known = carried.points.iter().map(|(feature, _)| *feature);
            return namesake(known, feature).map_or_else(Vector3::zeros, |at| carried.points[at].1);
        }
        let first = self.without_slot.partition_point(|(known, ..)| *known < (pair, parts));
        let known = self.without_slot[first..].iter().take_while(|(known, ..)| *known == (pair, parts));
        let found = namesake(known.map(|&(_, feature, _)| feature), feature);
        found.map_or_else(Vector3::zeros, |at| self.without_slot[first + at].2)
    }

    /// Keeps the forces of pairs' points for the next step, and no others.
    pub fn keep_forces<P: Iterator<Item = (FeatureId, Vector3<f64>)>>(
        &mut self,
        pairs: impl Iterator<Item = (PairKey, P)>,
    ) {
        self.carried.iter_mut().for_each(|carried| carried.points = Default::default());
        self.without_slot.clear();
        for (PairKey { slot, pair, parts }, points) in pairs {
            match slot.map(|slot| self.carried.get_mut(slot as usize)) {
                Some(Some(carried)) => carried.points.iter_mut().zip(points).for_each(|(kept, point)| *kept = point),
                Some(None) => {}
                None => self.without_slot.extend(points.map(|(feature, force)| ((pair, parts), feature, force))),
            }
        }
        // Of one pair, points stay in their order.
        self.without_slot.sort_by_key(|&(of, ..)| of);
    }

    /// All forces kept, by slot or pair.
    pub fn forces(&self) -> impl Iterator<Item = &Vector3<f64>> {
        let in_slots = self.carried.iter().flat_map(|carried| carried.points.iter().map(|(_, force)| force));
        in_slots.chain(self.without_slot.iter().map(|(.., force)| force))
    }

    /// Has contacts found anew of bodies of which something else than their motion changed.
    pub(in crate::physics::collision) fn forget_renewed(&mut self, renewed: &[u32]) {
        if renewed.is_empty() {
            return;
        }
        let mut among = BitSet::default();
        renewed.iter().for_each(|&body| among.set(body, true));
        for (index, slot) in self.slots.iter_mut().enumerate().filter(|(_, slot)| slot.entities.is_some()) {
            if among.contains(slot.pair.a) || among.contains(slot.pair.b) {
                slot.forget();
                self.watches.get_mut(index).into_iter().for_each(Watch::end);
                self.carried.get_mut(index).into_iter().for_each(|carried| *carried = Carried::default());
            }
        }
        self.without_slot.retain(|((pair, _), ..)| !among.contains(pair.a) && !among.contains(pair.b));
    }

    /// Takes in which pairs came and went.
    pub(in crate::physics::collision) fn take_pairs(&mut self, near: &NearPairs, bodies: &[Body]) {
        for (PairSlot(index), _) in &near.changes.removed {
            self.set_active(PairSlot(*index), true);
            self.active.set(*index, false);
            if let Some(slot) = self.slots.get_mut(*index as usize) {
                if slot.touching {
                    self.version += 1;
                    self.manifolds -= 1;
                    self.point_count -= self.states[*index as usize].geometry.point_count() as i64;
                }
                if self.started.contains(*index) {
                    self.parted.extend(slot.entities.map(|entities| (entities, slot.is_of_parts)));
                    self.started.set(*index, false);
                }
                self.touching.set(*index, false);
                count_pair(&mut self.pair_counts, slot.pair, false);
                *slot = Slot::default();
                self.states[*index as usize] = ContactState::default();
            }
        }
        self.slots.resize(near.slot_count(), Slot::default());
        self.states.resize(near.slot_count(), ContactState::default());
        self.watches.resize(near.slot_count(), Watch::new(Pair::default()));
        for &slot in &near.changes.added {
            let Some(Pair { a, b }) = near.pair(slot) else { continue };
            // What does not move comes first.
            let parts = near.parts(slot);
            let is_in_order = bodies[b as usize].is_dynamic();
            let (pair, parts) =
                if is_in_order { (Pair { a, b }, parts) } else { (Pair { a: b, b: a }, parts.swapped()) };
            let (a, b) = (&bodies[pair.a as usize], &bodies[pair.b as usize]);
            let index = slot.0 as usize;
            self.slots[index] = Slot::new(pair, parts, a, b);
            self.states[index] = ContactState::default();
            self.watches[index] = Watch::new(pair);
            count_pair(&mut self.pair_counts, pair, true);
            if let Some(carried) = self.carried.get_mut(index) {
                *carried = Carried::default();
            }
            self.active.set(slot.0, true);
        }
    }
}

/// Whether two bodies stand in a row, by how many pairs each has.
pub(super) fn is_row(pair_counts: &[u32], pair: [u32; 2]) -> bool {
    pair.iter().all(|&body| pair_counts.get(body as usize).is_some_and(|&count| count <= PAIRS_IN_ROW))
}

/// Counts a pair that comes, or goes, for each of its bodies.
fn count_pair(counts: &mut Vec<u32>, pair: Pair, comes: bool) {
    for body in [pair.a, pair.b].into_iter().filter(|&body| body != GONE) {
        if counts.len() <= body as usize {
            counts.resize(body as usize + 1, 0);
        }
        let count = &mut counts[body as usize];
        *count = if comes { *count + 1 } else { count.saturating_sub(1) };
    }
}

/// A run of slots.
struct Chunk<'a> {
    /// Index of the first.
    first: u32,
    slots: &'a mut [Slot],
    states: &'a mut [ContactState],
    watches: &'a mut [Watch],
    active: &'a [u64],
    /// Which one of the graph's this is.
    update: u64,
    travels: &'a Travels,
    pair_counts: &'a [u32],
    /// The bodies that joints hold.
    joined: &'a BitSet,
    finder: &'a mut Finder,
}

impl Chunk<'_> {
    fn update(&mut self, bodies: &[Body], settings: &SolverSettings) {
        for index in ones(self.active) {
            let watch = &mut self.watches[index as usize];
            if watch.holds(self.travels) {
                continue;
            }
            let (slot, state) = (&mut self.slots[index as usize], &mut self.states[index as usize]);
            let (a, b) = (&bodies[slot.pair.a as usize], &bodies[slot.pair.b as usize]);
            let before = (slot.touching, state.geometry.point_count());
            let known = if let Some(known) = slot.find_balls(state, a, b, settings) {
                slot.found_in = self.update;
                self.finder.note(self.first + index, slot, state, before);
                known
            } else {
                let pose = slot.pose(a, b);
                let near = slot.near(b);
                let held = slot.moved(&pose).filter(|&moved| slot.holds_after(moved, a, b, &near, settings.step()));
                if held.is_none() {
                    let place = (pose, lasting_gap(a, b, &near, settings.step()));
                    let found = (self.first + index, &mut *slot, state);
                    self.finder.find([a, b], place, found, self.update, self.joined, settings);
                }
                slot.known_after(held.unwrap_or(0.0))
            };
            watch.begin(known, slot.size(), self.travels);
            if let Known::Apart(distance) = known
                && gap_if_stopped(a, b, is_row(self.pair_counts, [slot.pair.a, slot.pair.b]), settings)
                    .is_some_and(|gap| gap > distance)
            {
                self.finder.together.push(self.first + index);
            }
        }
    }
}

impl Finder {
    /// Finds the manifold of a slot of that index at a relative pose within a gap, m, in that of the graph's updates.
    pub(super) fn find(
        &mut self,
        [a, b]: [&Body; 2],
        place: (Pose, f64),
        (index, slot, state): (u32, &mut Slot, &mut ContactState),
        update: u64,
        joined: &BitSet,
        settings: &SolverSettings,
    ) {
        let Self { search, points, fast, .. } = self;
        slot.found_in = update;
        points.clear();
        let before = (slot.touching, state.geometry.point_count());
        fast.extend(slot.find(place, state, a, b, joined, settings, search, points));
        self.note(index, slot, state, before);
    }

    /// Takes in what has become of a slot of that index that touched before, or not, with so many points.
    fn note(&mut self, index: u32, slot: &Slot, state: &ContactState, (touched, had): (bool, usize)) {
        self.turned.extend((slot.touching != touched).then_some(index));
        self.manifolds += i64::from(slot.touching) - i64::from(touched);
        self.point_count += state.geometry.point_count() as i64 - had as i64;
    }
}
