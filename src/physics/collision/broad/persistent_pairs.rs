//! Broad phase: *persistent pairs*, whose cost follows what moves.
//!
//! The pairs that may touch are kept from step to step: two bodies are a pair while their fat
//! boxes (see [`super::fat_box`]) overlap and the caller lets them. In a step
//!
//! 1. each body that may have moved is asked whether it is still in its [`Room`], a few flops;
//! 2. one that is not gets its tight box computed, and if that has left the fat box a new fat box;
//! 3. pairs of such bodies whose fat boxes no longer overlap go;
//! 4. the [`BoundingTree`] is asked what overlaps their new fat boxes, and what did not before is a
//!    new pair.
//!
//! Whether a pair is there already is not looked up: it is if the *previous* fat boxes overlapped,
//! and a body that is new has an empty previous box. So `may_pair` is asked once, when two fat boxes
//! begin to overlap, and its answer holds until they part or [`PersistentPairs::renew`] or
//! [`PersistentPairs::reconsider`] is called.
//!
//! Half-spaces stand outside the tree: each is paired with every body whose fat box reaches below
//! its plane. One that moved is tested against all bodies.
//!
//! The pairs, and the slots they get, depend on the order of the calls and on nothing else: new
//! pairs are sorted for each body, so that the shape of the tree cannot be seen.

use nalgebra::Vector3;

use super::bounding_tree::{BoundingBox, BoundingTree, Leaf};
use super::fat_box::{Extent, Placement, Room};
use super::pair_slots::{PairSlot, PairSlots};
use crate::physics::collision::constants::{BODIES_A_CHUNK, MOVED_A_CHUNK};
use crate::physics::collision::manifold::{Pair, PartPair};
use crate::physics::refill::Refill;
use crate::physics::threads::for_each_of;

/// What the broad phase asks about the bodies, which are numbered from 0.
pub(crate) trait BoundedBodies: Sync {
    /// Asked of each body that may have moved and has a box that moves, in every step: to be answered from packed
    /// arrays.
    fn placement(&self, body: u32) -> Placement;

    /// Asked of a body that has left its [`Room`].
    fn bounds(&self, body: u32) -> Bounds;

    /// Whether two bodies may touch: one of them is dynamic, their layers interact, no joint keeps
    /// them from colliding. Symmetric; see the module's documentation for when it is asked.
    fn may_pair(&self, a: u32, b: u32) -> bool;
}

/// The space a body takes in the world.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Bounds {
    /// It touches nothing.
    None,
    Within(Extent),
    /// All that is below a plane.
    HalfSpace {
        /// Unit, outwards.
        normal: Vector3<f64>,
        /// On it.
        point: Vector3<f64>,
    },
}

/// What became of the pairs in one update.
#[derive(Clone, Debug, Default)]
pub(crate) struct PairChanges {
    /// To be worked through first: a slot may be given away again in the same update.
    pub removed: Vec<(PairSlot, Pair)>,
    pub added: Vec<PairSlot>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct HalfSpace {
    body: u32,
    normal: Vector3<f64>,
    point: Vector3<f64>,
    /// Its pairs are to be found anew.
    moved: bool,
}

impl HalfSpace {
    /// Whether any of the box is in it; nothing of an empty box is.
    fn reaches(&self, bounds: &BoundingBox) -> bool {
        let mut height = 0.0;
        for axis in 0..3 {
            let n = self.normal[axis];
            let lowest = if n > 0.0 { bounds.low[axis] } else { bounds.high[axis] };
            height += n * (lowest - self.point[axis]);
        }
        height <= 0.0
    }
}

/// The pairs, and what it takes to keep them.
#[derive(Clone, Debug, Default)]
pub(crate) struct PersistentPairs {
    pairs: PairSlots,
    pub(super) tree: BoundingTree,
    half_spaces: Vec<HalfSpace>,
    // One of each per body.
    rooms: Vec<Room>,
    pub(super) fat: Vec<BoundingBox>,
    /// Equal to `fat` but while pairs are sought. Empty: the body is new.
    pub(super) previous: Vec<BoundingBox>,
    pub(super) leaves: Vec<Option<Leaf>>,
    /// Has a new fat box in this update.
    pub(super) has_moved: Vec<bool>,
    to_renew: Vec<u32>,
    to_reconsider: Vec<(u32, u32)>,
    pub(super) moved: Vec<u32>,
    // Scratch.
    moving: Vec<u32>,
    findings: Vec<Finding>,
    pub(super) is_paired: Vec<bool>,
}

/// What one thread finds of a run of bodies.
#[derive(Clone, Debug, Default)]
struct Finding {
    /// Those that have left their room, and the space that they take.
    leaving: Vec<(u32, Bounds)>,
    /// New pairs.
    pairs: Vec<Pair>,
    // Scratch.
    stack: Vec<u32>,
    hits: Vec<u32>,
}

impl PersistentPairs {
    /// The pairs as they are.
    pub fn pairs(&self) -> &PairSlots {
        &self.pairs
    }

    /// Adds the half-spaces, and the bodies whose fat boxes overlap a box.
    pub fn in_box(&self, bounds: &BoundingBox, stack: &mut Vec<u32>, found: &mut Vec<u32>) {
        found.extend(self.half_spaces.iter().map(|plane| plane.body));
        self.tree.query(bounds, stack, |body| found.push(body));
    }

    /// Adds a pair of parts of two bodies that are a pair. It goes when that goes.
    pub fn insert_parts(&mut self, pair: Pair, parts: PartPair) -> PairSlot {
        self.pairs.insert_parts(pair, parts)
    }

    /// Takes out a pair of parts.
    pub fn remove_parts(&mut self, slot: PairSlot) -> Pair {
        self.pairs.remove(slot)
    }

    /// To be called when a body is new, was teleported, or changed its shape, its layers or its
    /// kind: in the next update its pairs go, and are found again, in other slots.
    pub fn renew(&mut self, body: u32) {
        self.to_renew.push(body);
    }

    /// To be called when the answer of `may_pair` for these two may have changed: a joint came or
    /// went. Other pairs of theirs stay.
    pub fn reconsider(&mut self, a: u32, b: u32) {
        self.to_reconsider.push((a, b));
    }

    /// To be called when bodies were despawned and the others renumbered in the same order: their
    /// new indices, None for what is gone. Pairs of the gone are reported under the old indices.
    pub fn remap(&mut self, new_index: &[Option<u32>], removed: &mut Vec<(PairSlot, Pair)>) {
        let known = self.fat.len().min(new_index.len());
        for gone in (0..known).filter(|&body| new_index[body].is_none()) {
            self.pairs.drop_all_of(gone as u32, removed);
            self.withdraw(gone as u32);
        }
        let renamed = |body: u32| new_index.get(body as usize).copied().flatten();
        for (body, leaf) in self.leaves.iter().enumerate() {
            if let (Some(leaf), Some(new)) = (leaf, renamed(body as u32)) {
                self.tree.set_item(*leaf, new);
            }
        }
        self.half_spaces.retain_mut(|plane| renamed(plane.body).map(|new| plane.body = new).is_some());
        self.to_renew = self.to_renew.iter().filter_map(|&body| renamed(body)).collect();
        let both = |&(a, b): &(u32, u32)| Some((renamed(a)?, renamed(b)?));
        self.to_reconsider = self.to_reconsider.iter().filter_map(both).collect();
        self.pairs.remap(&new_index[..known]);
        keep(&mut self.rooms, new_index);
        keep(&mut self.fat, new_index);
        keep(&mut self.previous, new_index);
        keep(&mut self.leaves, new_index);
        self.has_moved.truncate(self.fat.len());
        self.is_paired.truncate(self.fat.len());
    }

    /// Brings the pairs up to date. `moving` are the bodies that may have moved or changed their
    /// velocity since the last update, each once, in an order that the results depend on; those
    /// renewed need not be among them. Results do not depend on how many threads may work on it.
    pub fn update(
        &mut self,
        bodies: &impl BoundedBodies,
        moving: impl IntoIterator<Item = u32>,
        threads: u32,
        changes: &mut PairChanges,
    ) {
        changes.removed.clear();
        changes.added.clear();
        self.moved.clear();
        self.renew_bodies(bodies, &mut changes.removed);
        self.moving.refill(moving);
        self.place_leaving(bodies, threads);
        self.find_pairs_of_moved_half_spaces(bodies, changes);
        self.find_pairs_of_moved(bodies, threads, changes);
        self.reconsider_pairs(bodies, changes);
    }

    /// Gives what has left its room a new one.
    fn place_leaving(&mut self, bodies: &impl BoundedBodies, threads: u32) {
        let (mut findings, moving) = (std::mem::take(&mut self.findings), std::mem::take(&mut self.moving));
        let chunks = moving.chunks(BODIES_A_CHUNK);
        if findings.len() < chunks.len() {
            findings.resize(chunks.len(), Finding::default());
        }
        let count = chunks.len();
        let (rooms, has_moved) = (&self.rooms, &self.has_moved);
        for_each_of(threads, chunks.zip(&mut findings), |(bodies_of_chunk, finding)| {
            find_leaving(rooms, has_moved, bodies, bodies_of_chunk, &mut finding.leaving);
        });
        for finding in &mut findings[..count] {
            for (body, bounds) in finding.leaving.drain(..) {
                self.place(body, &bodies.placement(body), bounds);
            }
        }
        (self.findings, self.moving) = (findings, moving);
    }

    fn renew_bodies(&mut self, bodies: &impl BoundedBodies, removed: &mut Vec<(PairSlot, Pair)>) {
        let mut renewed = std::mem::take(&mut self.to_renew);
        renewed.sort_unstable();
        renewed.dedup();
        if let Some(&last) = renewed.last() {
            self.grow(last as usize + 1);
        }
        for body in renewed.drain(..) {
            self.pairs.drop_all_of(body, removed);
            let bounds = bodies.bounds(body);
            if !matches!(bounds, Bounds::Within(_)) || self.leaves[body as usize].is_none() {
                self.withdraw(body);
            }
            self.fat[body as usize] = BoundingBox::EMPTY;
            self.previous[body as usize] = BoundingBox::EMPTY;
            self.place(body, &bodies.placement(body), bounds);
        }
        self.to_renew = renewed;
    }

    fn grow(&mut self, count: usize) {
        if count > self.fat.len() {
            self.rooms.resize(count, Room::UNBOUNDED);
            self.fat.resize(count, BoundingBox::EMPTY);
            self.previous.resize(count, BoundingBox::EMPTY);
            self.leaves.resize(count, None);
            self.has_moved.resize(count, false);
            self.is_paired.resize(count, false);
            self.pairs.set_body_count(count);
        }
    }

    /// Takes a body out of the tree and the half-spaces.
    fn withdraw(&mut self, body: u32) {
        if let Some(leaf) = self.leaves[body as usize].take() {
            self.tree.remove(leaf);
        }
        self.half_spaces.retain(|plane| plane.body != body);
    }

    /// Gives a body its room, and a new fat box if it has left the one it has.
    fn place(&mut self, body: u32, placement: &Placement, bounds: Bounds) {
        let index = body as usize;
        match bounds {
            Bounds::None => self.rooms[index] = Room::UNBOUNDED,
            Bounds::HalfSpace { normal, point } => {
                self.rooms[index] = Room::NONE;
                let new = HalfSpace { body, normal, point, moved: true };
                match self.half_spaces.iter_mut().find(|plane| plane.body == body) {
                    Some(old) if old.normal == new.normal && old.point == new.point => {}
                    Some(old) => *old = new,
                    None => self.half_spaces.push(new),
                }
            }
            Bounds::Within(extent) => {
                if !self.fat[index].contains(&extent.swept(placement)) {
                    let fat = extent.fat(placement);
                    self.fat[index] = fat;
                    match self.leaves[index] {
                        Some(leaf) => self.tree.update(leaf, fat),
                        None => self.leaves[index] = Some(self.tree.insert(fat, body)),
                    }
                    self.has_moved[index] = true;
                    self.moved.push(body);
                }
                self.rooms[index] =
                    if extent.moves { Room::new(&self.fat[index], &extent, placement) } else { Room::UNBOUNDED };
            }
        }
    }

    fn find_pairs_of_moved_half_spaces(&mut self, bodies: &impl BoundedBodies, changes: &mut PairChanges) {
        for index in 0..self.half_spaces.len() {
            let plane = self.half_spaces[index];
            if !plane.moved {
                continue;
            }
            self.drop_parted(plane.body, &mut changes.removed);
            for (_, other) in self.pairs.of_body(plane.body) {
                self.is_paired[other as usize] = true;
            }
            for body in 0..self.fat.len() as u32 {
                let is_paired = std::mem::take(&mut self.is_paired[body as usize]);
                if !is_paired && plane.reaches(&self.fat[body as usize]) && bodies.may_pair(plane.body, body) {
                    changes.added.push(self.pairs.insert(Pair { a: plane.body, b: body }));
                }
            }
        }
    }

    /// Pairs of what has a new fat box.
    fn find_pairs_of_moved(&mut self, bodies: &impl BoundedBodies, threads: u32, changes: &mut PairChanges) {
        for index in 0..self.moved.len() {
            self.drop_parted(self.moved[index], &mut changes.removed);
        }
        let mut findings = std::mem::take(&mut self.findings);
        let chunks = self.moved.chunks(MOVED_A_CHUNK);
        let count = chunks.len();
        if findings.len() < count {
            findings.resize(count, Finding::default());
        }
        for_each_of(threads, chunks.zip(&mut findings), |(moved, finding)| {
            moved.iter().for_each(|&body| self.find_new_pairs(bodies, body, finding));
        });
        for pair in findings[..count].iter_mut().flat_map(|finding| finding.pairs.drain(..)) {
            changes.added.push(self.pairs.insert(pair));
        }
        self.findings = findings;
        for &body in &self.moved {
            self.previous[body as usize] = self.fat[body as usize];
            self.has_moved[body as usize] = false;
        }
        for plane in &mut self.half_spaces {
            plane.moved = false;
        }
    }

    /// Adds the pairs that the new fat box of a body makes.
    fn find_new_pairs(&self, bodies: &impl BoundedBodies, body: u32, Finding { pairs, stack, hits, .. }: &mut Finding) {
        let (fat, previous) = (self.fat[body as usize], self.previous[body as usize]);
        for plane in self.half_spaces.iter().filter(|plane| !plane.moved) {
            if plane.reaches(&fat) && !plane.reaches(&previous) && bodies.may_pair(plane.body, body) {
                pairs.push(Pair { a: plane.body, b: body });
            }
        }
        hits.clear();
        self.tree.query(&fat, stack, |other| {
            // Of two that both moved, the one of lower index finds the pair.
            let is_its_business = other > body || (other < body && !self.has_moved[other as usize]);
            if is_its_business && !previous.overlaps(&self.previous[other as usize]) {
                hits.push(other);
            }
        });
        hits.sort_unstable();
        let allowed = hits.iter().filter(|&&other| bodies.may_pair(body, other));
        pairs.extend(allowed.map(|&other| Pair { a: body.min(other), b: body.max(other) }));
    }

    /// Removes those pairs of a body whose fat boxes do not overlap.
    fn drop_parted(&mut self, body: u32, removed: &mut Vec<(PairSlot, Pair)>) {
        let mut next = self.pairs.first_of(body);
        while let Some(at) = next {
            next = self.pairs.after(at);
            if !self.meet(body, at.other) {
                removed.push((at.slot, self.pairs.remove(at.slot)));
            }
        }
    }

    /// Whether the fat boxes of two bodies overlap, or one reaches into the other's half-space.
    #[inline]
    fn meet(&self, a: u32, b: u32) -> bool {
        // A half-space's own box is empty.
        self.fat[a as usize].overlaps(&self.fat[b as usize]) || self.meet_at_plane(a, b)
    }

    fn meet_at_plane(&self, a: u32, b: u32) -> bool {
        self.half_spaces.iter().any(|plane| {
            (plane.body == a && plane.reaches(&self.fat[b as usize]))
                || (plane.body == b && plane.reaches(&self.fat[a as usize]))
        })
    }

    fn reconsider_pairs(&mut self, bodies: &impl BoundedBodies, changes: &mut PairChanges) {
        for (a, b) in std::mem::take(&mut self.to_reconsider) {
            if a == b || a.max(b) as usize >= self.fat.len() {
                continue;
            }
            let may_pair = self.meet(a, b) && bodies.may_pair(a, b);
            match self.pairs.find(a, b) {
                // Pairs of parts as well.
                Some(_) if !may_pair => {
                    while let Some(slot) = self.pairs.find(a, b) {
                        let pair = self.pairs.remove(slot);
                        // A pair that this very update made was never seen.
                        match changes.added.iter().position(|&added| added == slot) {
                            Some(place) => _ = changes.added.remove(place),
                            None => changes.removed.push((slot, pair)),
                        }
                    }
                }
                None if may_pair => {
                    let b_is_first = self.leaves[b as usize].is_none() || (self.leaves[a as usize].is_some() && b < a);
                    let pair = if b_is_first { Pair { a: b, b: a } } else { Pair { a, b } };
                    changes.added.push(self.pairs.insert(pair));
                }
                _ => {}
            }
        }
    }
}

/// The bodies that are no longer certain to be in their fat boxes and have none that is new, with the space that they
/// take. All that most steps do: kept apart, so that the loop has the registers to itself.
#[inline(never)]
fn find_leaving(
    rooms: &[Room],
    has_moved: &[bool],
    bodies: &impl BoundedBodies,
    moving: &[u32],
    leaving: &mut Vec<(u32, Bounds)>,
) {
    leaving.clear();
    for &body in moving {
        let room = &rooms[body as usize];
        if !room.is_unbounded() && !room.holds(&bodies.placement(body)) && !has_moved[body as usize] {
            leaving.push((body, bodies.bounds(body)));
        }
    }
}

/// Keeps the items of bodies that have a new index.
fn keep<T>(items: &mut Vec<T>, new_index: &[Option<u32>]) {
    let mut new_index = new_index.iter();
    items.retain(|_| new_index.next().is_some_and(Option::is_some));
}
