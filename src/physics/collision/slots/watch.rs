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
//! other and do not touch, cost a step 16 bytes and an addition.
//!
//! Bodies that fly side by side use up their way without coming nearer. Then the pair is looked at, and how they have
//! moved against each other tells how much of d is left.

use nalgebra::{UnitQuaternion, Vector3};

use crate::physics::body::{Bodies, Body};
use crate::physics::collision::constants::{LONGEST_ARM, SPECULATIVE_MARGIN};
use crate::physics::collision::gap::turning_speed;
use crate::physics::collision::manifold::Pair;

/// Where a body was last seen.
#[derive(Clone, Copy, Debug)]
struct Seen {
    position: Vector3<f64>,
    rotation: UnitQuaternion<f64>,
}

impl Seen {
    fn of(body: &Body) -> Self {
        Self { position: body.position, rotation: body.rotation }
    }

    /// An upper bound of how far a point of the body has gone since.
    fn way_to(&self, body: &Body) -> f64 {
        // The chord between unit quaternions is half the angle, to third order.
        let (one, two) = (self.rotation.coords, body.rotation.coords);
        let chord = (one - two).norm_squared().min((one + two).norm_squared()).sqrt();
        (body.position - self.position).norm() + 2.0 * chord * body.radius.min(LONGEST_ARM)
    }
}

/// How far each body has gone.
#[derive(Default)]
pub(super) struct Travels {
    seen: Vec<Seen>,
    /// m, since the body was first seen.
    gone: Vec<f64>,
    /// That, and what the body can move in the step at its velocities.
    ahead: Vec<f64>,
}

impl Travels {
    /// Forgets all bodies: their indices changed.
    pub fn clear(&mut self) {
        self.seen.clear();
        self.gone.clear();
        self.ahead.clear();
    }

    /// Follows the bodies to where they are now, before a step of h, s.
    pub fn follow(&mut self, bodies: &Bodies, h: f64) {
        let known = self.seen.len();
        self.seen.extend(bodies.list.iter().skip(known).map(Seen::of));
        self.gone.resize(self.seen.len(), 0.0);
        self.ahead.resize(self.seen.len(), 0.0);
        for index in bodies.awake() {
            let (index, body) = (index as usize, &bodies.list[index as usize]);
            self.gone[index] += self.seen[index].way_to(body);
            self.seen[index] = Seen::of(body);
            self.ahead[index] = self.gone[index] + (body.linear.norm() + turning_speed(body)) * h;
        }
    }
}

/// One pair, as long as it is apart.
#[derive(Clone, Copy, Debug)]
pub(super) struct Watch {
    a: u32,
    b: u32,
    /// The sum of what the two have gone, and can move, up to which they are apart by more than the gap, m.
    until: f64,
}

impl Watch {
    /// Of a pair of which nothing is known.
    pub fn new(Pair { a, b }: Pair) -> Self {
        Self { a, b, until: f64::NEG_INFINITY }
    }

    /// Has the pair looked at.
    pub fn end(&mut self) {
        self.until = f64::NEG_INFINITY;
    }

    /// Whether the pair is apart by more than the gap for certain.
    #[inline]
    pub fn holds(&self, travels: &Travels) -> bool {
        travels.ahead[self.a as usize] + travels.ahead[self.b as usize] <= self.until
    }

    /// Takes in how far apart the bodies are at least, m; none, if they may touch. `size` is the smaller bounding radius.
    pub fn begin(&mut self, apart: Option<f64>, size: f64, travels: &Travels) {
        let margin = SPECULATIVE_MARGIN * size;
        let gone = travels.gone[self.a as usize] + travels.gone[self.b as usize];
        self.until = apart.map_or(f64::NEG_INFINITY, |apart| gone + apart - margin);
    }
}
