//! Contacts that last: one slot for each pair of bodies that are near each other, kept for as long
//! as they are.
//!
//! A slot's manifold is found again only when the two bodies have moved against each other by more
//! than [`RECYCLING_LIMIT`] of the smaller one's size since it was found; until then its points, fixed to
//! either body, move along with them, which is exact to first order. Impulses stay with the slot
//! and are matched by feature when the manifold is found again.

use bevy::prelude::*;
use nalgebra::{UnitQuaternion, Vector3};

use super::broad::near_pairs::NearPairs;
use super::broad::pair_slots::PairSlot;
use super::continuous::fast_pair::FastPair;
use super::continuous::time_of_impact::{self, Course, Impact};
use super::gap::{contact_gap, fastest_approach};
use super::manifold::{ContactPoint, Contacts, FeatureId, Manifold, Overlap, Pair};
use super::narrow::contact_pair::{self, PairSearch};
use crate::physics::bit_set::{BitSet, ones};
use crate::physics::body::RigidBody;
use crate::physics::body::{Bodies, Body};
use crate::physics::collision::constants::{RECYCLING_LIMIT, SLOTS_A_CHUNK, SUCCESSION_REACH};
use crate::physics::contact::{predecessors, surface, tangents};
use crate::physics::joint::Joints;
use crate::physics::lanes::{Record, WIDTH};
use crate::physics::readings::ContactForces;
use crate::physics::settings::SolverSettings;
use crate::physics::stats::StepStats;
use crate::physics::threads::for_each_of;

/// Stands for a body that is gone, until its pairs are dropped.
pub(crate) const GONE: u32 = u32::MAX;

/// Most points of a manifold.
pub(crate) const POINTS: usize = 4;

/// Records that hold the geometry of one pair's contact.
pub(crate) const GEOMETRY: usize = 4;

/// What the rows of one pair's contact are made from, in the body axes of A (normal, tangent,
/// points on A) and B (points on B): normal, tangent, μ, number of points, then each point on A and
/// on B.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct ContactGeometry {
    pub records: [Record<f32>; GEOMETRY],
}

impl ContactGeometry {
    /// Of points given as (on A, on B).
    pub fn new(
        normal: &Vector3<f64>,
        tangent: &Vector3<f64>,
        friction: f64,
        count: usize,
        points: impl Iterator<Item = (Vector3<f64>, Vector3<f64>)>,
    ) -> Self {
        let mut numbers = [0.0_f32; GEOMETRY * WIDTH];
        let head = normal.iter().chain(tangent.iter()).copied().chain([friction, count as f64]);
        let tail = points.flat_map(|(a, b)| [a.x, a.y, a.z, b.x, b.y, b.z]);
        for (number, value) in numbers.iter_mut().zip(head.chain(tail)) {
            *number = value as f32;
        }
        let (records, _) = numbers.as_chunks::<WIDTH>();
        Self { records: std::array::from_fn(|index| Record(records[index])) }
    }

    /// Points of the patch.
    pub fn point_count(&self) -> usize {
        self.records[0].0[7] as usize
    }

    /// μ of the pair.
    pub fn friction(&self) -> f32 {
        self.records[0].0[6]
    }

    fn vector(&self, first: usize) -> Vector3<f64> {
        Vector3::from_fn(|axis, _| f64::from(self.records[(first + axis) / WIDTH].0[(first + axis) % WIDTH]))
    }

    /// Unit, from A to B, body axes of A.
    pub fn normal(&self) -> Vector3<f64> {
        self.vector(0)
    }

    /// Across the normal, body axes of A.
    pub fn tangent(&self) -> Vector3<f64> {
        self.vector(3)
    }

    /// A point on A and on B, each in that body's axes.
    pub fn point(&self, index: usize) -> (Vector3<f64>, Vector3<f64>) {
        (self.vector(8 + 6 * index), self.vector(11 + 6 * index))
    }
}

/// What the solver reads and writes of one pair's contact.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct ContactState {
    pub geometry: ContactGeometry,
    /// Four points, two tangents, twist, N·s of a substep.
    pub impulses: Record<f32>,
}

impl ContactState {
    /// Whether the bodies pushed each other in the last step.
    pub fn pushes(&self) -> bool {
        self.impulses.0[..POINTS].iter().any(|&impulse| impulse > 0.0)
    }
}

/// How B lies to A, in A's axes.
#[derive(Clone, Copy, Debug)]
struct RelativePose {
    offset: Vector3<f64>,
    rotation: UnitQuaternion<f64>,
}

impl RelativePose {
    fn of(a: &Body, b: &Body) -> Self {
        Self {
            offset: a.rotation.inverse_transform_vector(&(b.position - a.position)),
            rotation: a.rotation.rotation_to(&b.rotation),
        }
    }

    /// An upper bound of how far a point within `reach` of B's centre has moved in A's axes.
    fn moved(&self, other: &Self, reach: f64) -> f64 {
        // The chord between unit quaternions is half the angle, to third order.
        let (one, two) = (self.rotation.coords, other.rotation.coords);
        let chord = (one - two).norm_squared().min((one + two).norm_squared()).sqrt();
        (self.offset - other.offset).norm() + 2.0 * chord * reach
    }
}

/// One pair.
#[derive(Clone, Debug)]
pub(crate) struct Slot {
    pub pair: Pair,
    /// Whether there are contact points.
    pub touching: bool,
    /// Whether [`crate::physics::ContactStarted`] was said, and not yet that it ended.
    pub is_pressed: bool,
    pub entities: (Entity, Entity),
    pub restitution: f32,
    /// In which of the graph's updates the manifold was found.
    pub found_in: u64,
    /// How B moves to A until the contact found ahead, world axes, m: its points are where they will touch then.
    pub ahead: Vector3<f64>,
    features: [FeatureId; POINTS],
    found_at: Option<RelativePose>,
    /// Up to which gap it was looked for, m.
    found_within: f64,
    /// Smaller bounding radius.
    size: f64,
    /// Bounding radius of B, or what its points can be from its centre.
    reach: f64,
    /// Where A's axes have their origin for this contact: at its centre of mass, or, as A may be
    /// a ground that reaches far, near B where A does not move.
    origin: Vector3<f64>,
    /// Whether there is a pair.
    is_used: bool,
}

impl Default for Slot {
    fn default() -> Self {
        Self {
            pair: Pair { a: 0, b: 0 },
            touching: false,
            is_pressed: false,
            entities: (Entity::PLACEHOLDER, Entity::PLACEHOLDER),
            restitution: 0.0,
            found_in: 0,
            ahead: Vector3::zeros(),
            features: [FeatureId::default(); POINTS],
            found_at: None,
            found_within: 0.0,
            size: 0.0,
            reach: 0.0,
            origin: Vector3::zeros(),
            is_used: false,
        }
    }
}

/// All pairs near each other, slot by slot. A slot's index stays the same for its life.
#[derive(Resource, Default)]
pub(crate) struct ContactGraph {
    pub slots: Vec<Slot>,
    pub states: Vec<ContactState>,
    /// Counts every change of which pairs touch.
    pub version: u64,
    /// Counts updates.
    updates: u64,
    /// Whether any slot's `is_pressed` may be out of date.
    pub presses_changed: bool,
    /// The slots that a step looks at: not those of pairs in which nothing awake can be moved.
    active: BitSet,
    /// Slots that fell asleep in this step.
    pub settled: Vec<u32>,
    /// Pairs that touch, and their points; of the latter, those of slots that sleep.
    manifolds: i64,
    point_count: i64,
    points_asleep: i64,
    /// Pairs in which a body may move farther than it is thick in this step, by slot.
    pub fast: Vec<FastPair>,
    /// Pairs that pressed on each other until they were no pairs any more.
    pub parted: Vec<(Entity, Entity)>,
    /// While somebody reads contact forces.
    pub recording: Option<Recording>,
}

/// What the forces at contact points are told from.
#[derive(Default)]
pub(crate) struct Recording {
    /// What each slot's contact pushed in all substeps, N·s.
    pub totals: Vec<Record<f32>>,
    /// The first tangent of each manifold of [`Contacts`], world axes, and its slot.
    tangents: Vec<(Vector3<f64>, u32)>,
}

/// What one thread needs to find contacts, and what it counts.
#[derive(Default)]
pub(super) struct Finder {
    search: PairSearch,
    points: Vec<ContactPoint>,
    /// Whether any pair began or ceased to touch.
    changed: bool,
    /// Change of the number of touching pairs, and of their points.
    manifolds: i64,
    point_count: i64,
    fast: Vec<FastPair>,
}

/// Takes in which pairs are near and finds their contacts.
pub(super) fn update_graph(
    bodies: Res<Bodies>,
    near: Res<NearPairs>,
    joints: Res<Joints>,
    settings: Res<SolverSettings>,
    mut graph: ResMut<ContactGraph>,
    mut finders: Local<Vec<Finder>>,
    mut stats: ResMut<StepStats>,
) {
    let graph = graph.bypass_change_detection();
    graph.take_pairs(&near, &bodies.list);
    graph.forget_renewed(&bodies.renewed);
    if settings.is_changed() {
        graph.slots.iter_mut().for_each(|slot| slot.found_at = None);
    }
    let chunks = graph.slots.len().div_ceil(SLOTS_A_CHUNK);
    finders.resize_with(chunks, Finder::default);
    graph.updates += 1;
    let (active, update) = (&graph.active, graph.updates);
    let slots = graph
        .slots
        .chunks_mut(SLOTS_A_CHUNK)
        .zip(graph.states.chunks_mut(SLOTS_A_CHUNK))
        .zip(finders.iter_mut())
        .enumerate();
    let work = slots.map(|(chunk, ((slots, states), finder))| {
        let active = active.words(chunk * SLOTS_A_CHUNK, SLOTS_A_CHUNK);
        Chunk { slots, states, active, update, joined: &joints.joined, finder }
    });
    for_each_of(settings.threads, work, |mut chunk| chunk.update(&bodies.list, &settings));
    stats.axes_tested = 0;
    graph.fast.clear();
    for finder in finders.iter_mut() {
        stats.axes_tested += u64::from(std::mem::take(&mut finder.search.axes));
        let changed = std::mem::take(&mut finder.changed);
        graph.version += u64::from(changed);
        graph.presses_changed |= changed;
        graph.manifolds += std::mem::take(&mut finder.manifolds);
        graph.point_count += std::mem::take(&mut finder.point_count);
        graph.fast.append(&mut finder.fast);
    }
    stats.pairs = graph.active.len();
    stats.manifolds = graph.manifolds as u32;
    stats.contact_points = graph.point_count as u32;
}

impl ContactGraph {
    /// Follows bodies to their new indices. Pairs of the gone are dropped in the next step.
    pub fn remap(&mut self, new_index: &[Option<u32>]) {
        for slot in self.slots.iter_mut().filter(|slot| slot.is_used) {
            let of = |body: u32| new_index.get(body as usize).copied().flatten();
            slot.pair = Pair { a: of(slot.pair.a).unwrap_or(GONE), b: of(slot.pair.b).unwrap_or(GONE) };
        }
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
        let touching = self.active.iter().filter(|&slot| self.slots[slot as usize].touching);
        touching.map(|slot| (slot, (self.slots[slot as usize].pair.a, self.slots[slot as usize].pair.b)))
    }

    /// Contact points of slots that are looked at.
    pub fn active_points(&self) -> u32 {
        (self.point_count - self.points_asleep) as u32
    }

    /// Has contacts found anew of bodies of which something else than their motion changed.
    fn forget_renewed(&mut self, renewed: &[u32]) {
        if renewed.is_empty() {
            return;
        }
        let mut among = BitSet::default();
        renewed.iter().for_each(|&body| among.set(body, true));
        for slot in self.slots.iter_mut().filter(|slot| slot.is_used) {
            if among.contains(slot.pair.a) || among.contains(slot.pair.b) {
                slot.found_at = None;
            }
        }
    }

    fn take_pairs(&mut self, near: &NearPairs, bodies: &[Body]) {
        for (PairSlot(index), _) in &near.changes.removed {
            self.set_active(PairSlot(*index), true);
            self.active.set(*index, false);
            if let Some(slot) = self.slots.get_mut(*index as usize) {
                if slot.touching {
                    self.version += 1;
                    self.manifolds -= 1;
                    self.point_count -= self.states[*index as usize].geometry.point_count() as i64;
                }
                if slot.is_pressed {
                    self.parted.push(slot.entities);
                }
                *slot = Slot::default();
                self.states[*index as usize] = ContactState::default();
            }
        }
        self.slots.resize(near.slot_count(), Slot::default());
        self.states.resize(near.slot_count(), ContactState::default());
        for &slot in &near.changes.added {
            let Some(Pair { a, b }) = near.pair(slot) else { continue };
            // What does not move comes first.
            let pair = if bodies[b as usize].is_dynamic() { Pair { a, b } } else { Pair { a: b, b: a } };
            let (a, b) = (&bodies[pair.a as usize], &bodies[pair.b as usize]);
            let index = slot.0 as usize;
            self.slots[index] = Slot {
                pair,
                entities: (a.entity, b.entity),
                is_used: true,
                size: a.radius.min(b.radius),
                reach: b.radius,
                ..Slot::default()
            };
            self.states[index] = ContactState::default();
            self.active.set(slot.0, true);
        }
    }
}

/// A run of slots.
struct Chunk<'a> {
    slots: &'a mut [Slot],
    states: &'a mut [ContactState],
    active: &'a [u64],
    /// Which one of the graph's this is.
    update: u64,
    /// The bodies that joints hold.
    joined: &'a BitSet,
    finder: &'a mut Finder,
}

impl Chunk<'_> {
    fn update(&mut self, bodies: &[Body], settings: &SolverSettings) {
        let Finder { search, points, changed, manifolds, point_count, fast } = &mut *self.finder;
        for index in ones(self.active) {
            let (slot, state) = (&mut self.slots[index as usize], &mut self.states[index as usize]);
            let (a, b) = (&bodies[slot.pair.a as usize], &bodies[slot.pair.b as usize]);
            let pose = RelativePose::of(a, b);
            if slot.found_at.is_some_and(|found| found.moved(&pose, slot.reach) <= RECYCLING_LIMIT * slot.size)
                && (slot.touching
                    || fastest_approach(a, b) * settings.step() <= slot.found_within - RECYCLING_LIMIT * slot.size)
            {
                continue;
            }
            slot.found_at = Some(pose);
            slot.found_in = self.update;
            points.clear();
            let (touched, had) = (slot.touching, state.geometry.point_count());
            fast.extend(slot.find(state, a, b, self.joined, settings, search, points));
            *changed |= slot.touching != touched;
            *manifolds += i64::from(slot.touching) - i64::from(touched);
            *point_count += state.geometry.point_count() as i64 - had as i64;
        }
    }
}

impl Slot {
    /// From the centre of mass of A, world axes.
    pub fn origin_in_world(&self, a: &Body) -> Vector3<f64> {
        a.rotation * self.origin
    }

    /// Finds the manifold for the present poses or, if the pair is fast, those at its impact. Returns it if it is.
    fn find(
        &mut self,
        state: &mut ContactState,
        a: &Body,
        b: &Body,
        joined: &BitSet,
        settings: &SolverSettings,
        search: &mut PairSearch,
        points: &mut Vec<ContactPoint>,
    ) -> Option<FastPair> {
        let h = settings.step();
        self.found_within = contact_gap(a, b, settings);
        search.last = None;
        // One on a joint will not go on as it moves now.
        let is_free = !joined.contains(self.pair.a) && !joined.contains(self.pair.b);
        let is_fast = is_free && (time_of_impact::moves_far(a, b, h) || time_of_impact::moves_far(b, a, h));
        let course = if is_fast { time_of_impact::course(a, b, h, search, points) } else { Course::Touching };
        let meeting =
            match course {
                Course::Touching => contact_pair::touch(a, b, self.found_within, search, points)
                    .map(|overlap| Impact { time: 0.0, at: [a.position, b.position], overlap }),
                Course::Impact(impact) => {
                    // To be found again in the next step, however little is left of the approach.
                    self.found_at = None;
                    Some(impact)
                }
                Course::Apart => None,
            };
        if let Some(meeting) = &meeting {
            points.truncate(POINTS);
            self.take_in(state, a, b, meeting, settings, points);
        } else {
            *state = ContactState::default();
        }
        self.touching = meeting.is_some();
        is_fast.then(|| FastPair::new(self.pair, a, b, h, meeting.map(|meeting| meeting.time)))
    }

    /// Takes in the points found where the bodies meet.
    fn take_in(
        &mut self,
        state: &mut ContactState,
        a: &Body,
        b: &Body,
        &Impact { time, at, overlap: Overlap { normal, .. } }: &Impact,
        settings: &SolverSettings,
        points: &[ContactPoint],
    ) {
        let surface = surface(a, b, settings.friction);
        let old = std::mem::take(state);
        let normal_in_a = a.rotation.inverse_transform_vector(&normal);
        let [tangent, _] = tangents(&normal_in_a);
        let apart = at[1] - at[0];
        self.ahead = apart - (b.position - a.position);
        self.origin = match a.kind {
            RigidBody::Static => a.rotation.inverse_transform_vector(&apart),
            RigidBody::Dynamic | RigidBody::Kinematic => Vector3::zeros(),
        };
        let origin = self.origin;
        let places = points.iter().map(|point| {
            let [arm_a, arm_b] = at.map(|center| point.point - center);
            // Rows are straight: points that meet later are as far apart now as their speed then will close.
            let approach = (a.point_velocity(&arm_a) - b.point_velocity(&arm_b)).dot(&normal);
            let half = normal * (0.5 * (point.depth - approach.max(0.0) * time));
            let on_a = a.rotation.inverse_transform_vector(&(arm_a + half)) - origin;
            let on_b = b.rotation.inverse_transform_vector(&(arm_b - half));
            (on_a, on_b)
        });
        state.geometry = ContactGeometry::new(&normal_in_a, &tangent, surface.friction, points.len(), places);
        self.restitution = surface.restitution as f32;
        if self.touching {
            self.carry_pushes(&old, state, points);
            self.carry_friction(&old, state);
        }
        for (kept, point) in self.features.iter_mut().zip(points) {
            *kept = point.feature;
        }
    }

    /// Each point takes over what its predecessor pushed.
    fn carry_pushes(&self, old: &ContactState, state: &mut ContactState, points: &[ContactPoint]) {
        let known = &self.features[..old.geometry.point_count()];
        let place = |geometry: &ContactGeometry, index: usize| geometry.point(index).0;
        let apart = |new, known| (place(&old.geometry, known) - place(&state.geometry, new)).norm_squared();
        let new = points.iter().map(|point| point.feature);
        let from: [_; POINTS] = predecessors(known, new, apart, SUCCESSION_REACH * self.size);
        for (impulse, from) in state.impulses.0.iter_mut().zip(from) {
            *impulse = from.map_or(0.0, |known| old.impulses.0[known]);
        }
    }

    /// Friction turns along with the tangents.
    fn carry_friction(&self, old: &ContactState, state: &mut ContactState) {
        let frame = |geometry: &ContactGeometry| {
            let (normal, tangent) = (geometry.normal(), geometry.tangent());
            [tangent, normal.cross(&tangent)]
        };
        let [x, y] = frame(&old.geometry);
        let force = x * f64::from(old.impulses.0[POINTS]) + y * f64::from(old.impulses.0[POINTS + 1]);
        for (impulse, tangent) in state.impulses.0[POINTS..].iter_mut().zip(frame(&state.geometry)) {
            *impulse = force.dot(&tangent) as f32;
        }
        state.impulses.0[POINTS + 2] = old.impulses.0[POINTS + 2];
    }
}

/// Fills [`Contacts`] from the slots, for whoever reads them.
pub(super) fn export_contacts(
    bodies: Res<Bodies>,
    mut graph: ResMut<ContactGraph>,
    stats: Res<StepStats>,
    settings: Res<SolverSettings>,
    forces: Option<Res<ContactForces>>,
    mut contacts: ResMut<Contacts>,
) {
    let contacts = contacts.bypass_change_detection();
    let graph = graph.bypass_change_detection();
    let mut recording = forces.map(|_| graph.recording.take().unwrap_or_else(|| graph.begin_recording(&settings)));
    if let Some(recording) = &mut recording {
        // What touches and is awake is written over in the solve.
        recording.totals.resize(graph.slots.len(), Record::default());
        recording.tangents.clear();
    }
    contacts.time = stats.time;
    contacts.manifolds.clear();
    contacts.points.clear();
    let slots = graph.slots.iter().zip(&graph.states).enumerate();
    for (index, (slot, state)) in slots.filter(|(_, (slot, _))| slot.touching) {
        let (a, b) = (&bodies.list[slot.pair.a as usize], &bodies.list[slot.pair.b as usize]);
        let normal = a.rotation * state.geometry.normal();
        let first = contacts.points.len();
        for index in 0..state.geometry.point_count() {
            let (on_a, on_b) = state.geometry.point(index);
            let apart = b.position - a.position + slot.ahead;
            let (on_a, on_b) = (a.rotation * (on_a + slot.origin), b.rotation * on_b + apart);
            contacts.points.push(ContactPoint {
                point: a.position + (on_a + on_b) * 0.5,
                depth: normal.dot(&(on_a - on_b)),
                feature: slot.features[index],
            });
        }
        if let Some(recording) = &mut recording {
            recording.tangents.push((a.rotation * state.geometry.tangent(), index as u32));
        }
        contacts.manifolds.push(Manifold {
            pair: slot.pair,
            normal,
            first_point: first as u32,
            point_count: (contacts.points.len() - first) as u32,
            friction: f64::from(state.geometry.friction()),
            restitution: f64::from(slot.restitution),
        });
    }
    graph.recording = recording;
}

impl ContactGraph {
    /// A recording that begins: of those that sleep already the last substep stands for all.
    fn begin_recording(&self, settings: &SolverSettings) -> Recording {
        let all = |state: &ContactState| Record(state.impulses.0.map(|impulse| impulse * settings.substeps as f32));
        Recording { totals: self.states.iter().map(all).collect(), tangents: Vec::new() }
    }

    /// The force on B at each contact point, as (manifold, point within it, its mean over a step of `h` and that
    /// of its last substep, of `h_last`, N). Friction of a patch is shared out as the points press.
    pub fn contact_forces(
        &self,
        contacts: &Contacts,
        h: f64,
        h_last: f64,
    ) -> impl Iterator<Item = (u32, usize, [Vector3<f64>; 2])> {
        let recording =
            self.recording.iter().flat_map(|recording| recording.tangents.iter().map(move |t| (recording, t)));
        recording.zip(&contacts.manifolds).enumerate().flat_map(
            move |(index, ((recording, &(tangent, slot)), manifold))| {
                let frame = [manifold.normal, tangent, manifold.normal.cross(&tangent)];
                let forces = [(&recording.totals[slot as usize], h), (&self.states[slot as usize].impulses, h_last)];
                (0..manifold.point_count as usize).map(move |point| {
                    (index as u32, point, forces.map(|(impulses, h)| point_force(impulses, &frame, point) / h))
                })
            },
        )
    }
}

/// What one point of a patch pushes with, N·s.
fn point_force(impulses: &Record<f32>, [normal, x, y]: &[Vector3<f64>; 3], point: usize) -> Vector3<f64> {
    let [push, along_x, along_y] = [point, POINTS, POINTS + 1].map(|index| f64::from(impulses.0[index]));
    let pressed: f64 = impulses.0[..POINTS].iter().map(|&impulse| f64::from(impulse)).sum();
    let share = if pressed > 0.0 { push / pressed } else { 0.0 };
    normal * push + (x * along_x + y * along_y) * share
}
