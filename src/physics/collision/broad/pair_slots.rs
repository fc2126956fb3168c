//! The pairs that exist, each in a slot that is its own for as long as it lives, so that what
//! others keep of a pair stands in arrays indexed by slot.
//!
//! Each pair hangs in two doubly linked lists, that of its body A and that of its body B: a body's
//! pairs are walked without a look at any other's, and a pair leaves both in constant time however
//! many the bodies have (a floor has thousands). A *pair end* 2 s + k is the pair of slot s seen
//! from A (k = 0) or B (k = 1).

use crate::physics::collision::manifold::{Pair, PartPair};

const NONE: u32 = u32::MAX;

/// Where a pair's data stand.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) struct PairSlot(pub u32);

#[derive(Clone, Copy, Debug)]
struct Link {
    /// In the first end of a free slot: the next free slot.
    next: u32,
    previous: u32,
}

/// One body's view of a pair.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PairEnd {
    pub slot: PairSlot,
    pub other: u32,
    end: u32,
}

/// A slab of pairs with a list per body.
#[derive(Clone, Debug)]
pub(crate) struct PairSlots {
    /// A of a free slot is NONE.
    pairs: Vec<Pair>,
    /// Which parts of the two shapes each is of.
    parts: Vec<PartPair>,
    /// Two a slot.
    links: Vec<Link>,
    /// First pair end of each body.
    heads: Vec<u32>,
    free: u32,
}

impl Default for PairSlots {
    fn default() -> Self {
        Self { pairs: Vec::new(), parts: Vec::new(), links: Vec::new(), heads: Vec::new(), free: NONE }
    }
}

impl PairSlots {
    /// One more than the highest slot ever used: the length of arrays indexed by slot.
    pub fn slot_count(&self) -> usize {
        self.pairs.len()
    }

    /// The pair in a slot, if there is one.
    pub fn get(&self, slot: PairSlot) -> Option<Pair> {
        self.pairs.get(slot.0 as usize).copied().filter(|pair| pair.a != NONE)
    }

    /// The parts of the shapes that a slot is of.
    pub fn parts(&self, slot: PairSlot) -> PartPair {
        self.parts[slot.0 as usize]
    }

    /// The slots of the pairs of one body, and the bodies at the other end; the youngest pair first.
    pub fn of_body(&self, body: u32) -> impl Iterator<Item = (PairSlot, u32)> {
        let first = self.first_of(body);
        std::iter::successors(first, |at| self.after(*at)).map(|at| (at.slot, at.other))
    }

    /// Looks for a pair of two bodies in the shorter of their lists.
    pub fn find(&self, a: u32, b: u32) -> Option<PairSlot> {
        let (mut of_a, mut of_b) = (self.first_of(a), self.first_of(b));
        while let (Some(at_a), Some(at_b)) = (of_a, of_b) {
            if at_a.other == b {
                return Some(at_a.slot);
            }
            if at_b.other == a {
                return Some(at_b.slot);
            }
            (of_a, of_b) = (self.after(at_a), self.after(at_b));
        }
        None
    }

    pub(crate) fn set_body_count(&mut self, count: usize) {
        self.heads.resize(count, NONE);
    }

    pub(crate) fn first_of(&self, body: u32) -> Option<PairEnd> {
        self.at(self.heads[body as usize])
    }

    pub(crate) fn after(&self, at: PairEnd) -> Option<PairEnd> {
        self.at(self.links[at.end as usize].next)
    }

    fn at(&self, end: u32) -> Option<PairEnd> {
        if end == NONE {
            return None;
        }
        let pair = self.pairs[end as usize / 2];
        let other = if end & 1 == 0 { pair.b } else { pair.a };
        Some(PairEnd { slot: PairSlot(end / 2), other, end })
    }

    /// Adds a pair that is not there yet.
    pub(crate) fn insert(&mut self, pair: Pair) -> PairSlot {
        self.insert_parts(pair, PartPair::default())
    }

    /// Adds one of parts. The two bodies then have several slots.
    pub(crate) fn insert_parts(&mut self, pair: Pair, parts: PartPair) -> PairSlot {
        let slot = self.free;
        let slot = if slot == NONE {
            self.pairs.push(pair);
            self.parts.push(parts);
            self.links.extend([Link { next: NONE, previous: NONE }; 2]);
            self.pairs.len() as u32 - 1
        } else {
            self.free = self.links[2 * slot as usize].next;
            self.pairs[slot as usize] = pair;
            self.parts[slot as usize] = parts;
            slot
        };
        for (end, body) in [(2 * slot, pair.a), (2 * slot + 1, pair.b)] {
            let next = std::mem::replace(&mut self.heads[body as usize], end);
            self.links[end as usize] = Link { next, previous: NONE };
            if next != NONE {
                self.links[next as usize].previous = end;
            }
        }
        PairSlot(slot)
    }

    /// Takes a pair out; its slot is the next to be given away.
    pub(crate) fn remove(&mut self, slot: PairSlot) -> Pair {
        let index = slot.0 as usize;
        let pair = self.pairs[index];
        for (end, body) in [(2 * index, pair.a), (2 * index + 1, pair.b)] {
            let Link { next, previous } = self.links[end];
            if previous == NONE {
                self.heads[body as usize] = next;
            } else {
                self.links[previous as usize].next = next;
            }
            if next != NONE {
                self.links[next as usize].previous = previous;
            }
        }
        self.pairs[index].a = NONE;
        self.links[2 * index].next = self.free;
        self.free = slot.0;
        pair
    }

    /// Takes out all pairs of a body.
    pub(crate) fn drop_all_of(&mut self, body: u32, removed: &mut Vec<(PairSlot, Pair)>) {
        while let Some(at) = self.first_of(body) {
            removed.push((at.slot, self.remove(at.slot)));
        }
    }

    /// Renames the bodies; those without a new name must have no pairs. The order of names stays.
    pub(crate) fn remap(&mut self, new_index: &[Option<u32>]) {
        let renamed = |body: u32| new_index[body as usize].unwrap_or(NONE);
        for pair in self.pairs.iter_mut().filter(|pair| pair.a != NONE) {
            *pair = Pair { a: renamed(pair.a), b: renamed(pair.b) };
        }
        let mut kept = new_index.iter();
        self.heads.retain(|_| kept.next().is_some_and(Option::is_some));
    }
}
