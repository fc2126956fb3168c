//! Pairs that need not be looked at, told by two numbers of each body.
//!
//! Two bodies that were apart by d come no nearer than d less what the points of either have gone since then. Where a
//! body's points have gone sₐ(t) at most since some beginning, in the world's axes, a pair apart by d at time t₀ is apart
//! by more than a gap g for as long as
//!
//! sₐ(t) + s_b(t) + g ≤ d + sₐ(t₀) + s_b(t₀),
//!
//! whose right side is a number of the pair. The gap is a margin and what the two can close in the step, which is no more
//! than what each can move: sₐ and that together are a number of the body. So most pairs of a heap, which are near each
//! other and do not touch, cost a step 24 bytes and an addition.
//!
//! Of bodies that touch the manifold is kept until they have moved against each other by some way
//! ([`Slot`](super::slot::Slot)), which is no more than what the two have gone: what lies still costs no more than what
//! is apart.
//!
//! Bodies that fly side by side use up their way without coming nearer. Then the pair is looked at, and how they have
//! moved against each other tells how much of d is left.

use crate::physics::body::Bodies;
use crate::physics::collision::constants::{BODIES_A_CHUNK, LONGEST_ARM, SPECULATIVE_MARGIN};
use crate::physics::collision::gap::turning_speed;
use crate::physics::collision::manifold::Pair;
use crate::physics::collision::pose::Pose;
use crate::physics::threads::for_each_of;

/// How far the points of a body have gone at most, m.
#[derive(Clone, Copy, Debug, Default)]
struct Way {
    /// Since the body was first seen.
    gone: f64,
    /// That, and what they can move in the step at the body's velocities.
    ahead: f64,
}

/// How far each body has gone.
#[derive(Clone, Default)]
pub(super) struct Travels {
    /// Where each body was last seen.
    seen: Vec<Pose>,
    ways: Vec<Way>,
}

impl Travels {
    /// Forgets all bodies: their indices changed.
    pub fn clear(&mut self) {
        self.seen.clear();
        self.ways.clear();
    }

    /// Where a body was before the step.
    pub fn start(&self, body: u32) -> Pose {
        self.seen[body as usize]
    }

    /// How far it could move in the step at its velocities then, m.
    pub fn own_way(&self, body: u32) -> f64 {
        let Way { gone, ahead } = self.ways[body as usize];
        ahead - gone
    }

    /// Follows the bodies to where they are now, before a step of h, s.
    pub fn follow(&mut self, bodies: &Bodies, h: f64, threads: u32) {
        let known = self.seen.len();
        self.seen.extend(bodies.list.iter().skip(known).map(Pose::of));
        self.ways.resize(self.seen.len(), Way::default());
        let runs = self.seen.chunks_mut(BODIES_A_CHUNK).zip(self.ways.chunks_mut(BODIES_A_CHUNK)).enumerate();
        for_each_of(threads, runs, |(chunk, (seen, ways))| {
            let first = chunk * BODIES_A_CHUNK;
            let run = first as u32..(first + seen.len()) as u32;
            for index in bodies.asleep.in_neither(&bodies.fixed, run) {
                let (seen, way) = (&mut seen[index as usize - first], &mut ways[index as usize - first]);
                let body = &bodies.list[index as usize];
                let now = Pose::of(body);
                way.gone += now.moved(seen, body.radius.min(LONGEST_ARM));
                way.ahead = way.gone + (body.linear.norm() + turning_speed(body) + body.pulled * h) * h;
                *seen = now;
            }
        });
    }
}

/// One pair, as long as what is known of it holds: that it is apart, or of one that touches, its manifold.
#[derive(Clone, Copy, Debug)]
pub(super) struct Watch {
    a: u32,
    b: u32,
    /// The sum of what the two have gone, of bodies that are apart with what they can move, up to which it holds, m.
    until: f64,
    touches: bool,
}

impl Watch {
    /// Of a pair of which nothing is known.
    pub fn new(Pair { a, b }: Pair) -> Self {
        Self { a, b, until: f64::NEG_INFINITY, touches: false }
    }

    /// Whose it is.
    pub fn pair(&self) -> Pair {
        Pair { a: self.a, b: self.b }
    }

    /// Has the pair looked at.
    pub fn end(&mut self) {
        self.until = f64::NEG_INFINITY;
    }

    /// Whether the pair is apart by more than the gap for certain, or its manifold as good as when it was found.
    #[inline]
    pub fn holds(&self, travels: &Travels) -> bool {
        let [a, b] = [self.a, self.b].map(|body| travels.ways[body as usize]);
        let way = if self.touches { a.gone + b.gone } else { a.ahead + b.ahead };
        way <= self.until
    }

    /// Takes in what is known of the pair; `size` is the smaller bounding radius.
    pub fn begin(&mut self, known: Known, size: f64, travels: &Travels) {
        let gone = travels.ways[self.a as usize].gone + travels.ways[self.b as usize].gone;
        (self.touches, self.until) = match known {
            Known::Nothing => (false, f64::NEG_INFINITY),
            Known::Apart(distance) => (false, gone + distance - SPECULATIVE_MARGIN * size),
            Known::Manifold(left) => (true, gone + left),
        };
    }
}

/// What is known of a pair that was looked at.
#[derive(Clone, Copy, Debug)]
pub(super) enum Known {
    Nothing,
    /// It is apart by so much at least, m.
    Apart(f64),
    /// It has a manifold that is good until the bodies have moved against each other by so much more, m.
    Manifold(f64),
}
