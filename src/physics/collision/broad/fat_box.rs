//! How long a body may move before the broad phase has to look at it again.
//!
//! A body's *swept* box encloses where it is and where its present velocity takes it within the
//! step; its *fat* box, which the tree holds and pairs are made of, is larger by a margin m = μ R
//! (R the bounding radius) on all sides and by some steps' travel ahead. Nothing is to be done
//! while the swept box stays in the fat box. To know that seldom needs the swept box:
//!
//! A point of the body at x + r, |r| ≤ R, that moves with the centre by d and turns by θ about it
//! is displaced by d and by at most the chord 2 R sin(θ/2); with unit quaternions q and q₀,
//! |q − q₀| = 2 sin(θ/4), so the chord is R · 4 sin(θ/4) cos(θ/4) ≤ 2 R |q − q₀|. A box displaced
//! by no more than its gap to the fat box is still inside it. The gaps, seen from the centre, are
//! the [`Room`] in which the centre may wander; turning makes it smaller. That costs no rotation of
//! a shape, no square root and no division.
//!
//! Where the box of the bounding sphere fits into the fat box, turning does not matter at all:
//! balls roll for nothing, and what tumbles soon has such a box, as its fat box is grown by what
//! it will turn, though never beyond the sphere.

use nalgebra::{UnitQuaternion, Vector3};

use super::bounding_tree::BoundingBox;
use crate::physics::collision::constants::{FAT_MARGIN, STEPS_AHEAD};

/// What rounding may take: of a coordinate in f64, of the radius in the room's f32.
const COORDINATE_ROUNDING: f64 = 8.0 * f64::EPSILON;
const ROOM_ROUNDING: f64 = 4.0 * f32::EPSILON as f64;

/// Where a body is, and how it will move within the step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Placement {
    /// Centre of the bounding sphere, world axes, m.
    pub position: Vector3<f64>,
    pub rotation: UnitQuaternion<f64>,
    /// Way within the step at the present velocity, m; zero where contacts are not sought ahead.
    pub travel: Vector3<f64>,
    /// Angle turned within the step, rad, ≥ 0; likewise. Infinite: the box is that of the sphere, and no room holds it.
    pub turn: f64,
}

/// The space a body takes where it is.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Extent {
    /// Least box around the body, world axes, m.
    pub bounds: BoundingBox,
    /// Bounding radius about the position, m.
    pub radius: f64,
    /// Whether it may move without being [renewed](super::persistent_pairs::PersistentPairs::renew):
    /// only then has it a margin.
    pub moves: bool,
}

/// Where a body's centre may be with its swept box still in its fat box.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Room {
    centre: Vector3<f64>,
    half: [f32; 4],
    /// The rotation that `half` holds for, and twice the radius that turns.
    rotation: [f32; 4],
    spin: f32,
}

impl Room {
    /// Nothing leaves it.
    pub const UNBOUNDED: Self = Self { half: [f32::INFINITY; 4], ..Self::NONE };
    /// Nothing stays in it.
    pub const NONE: Self =
        Self { centre: Vector3::new(0.0, 0.0, 0.0), half: [-1.0; 4], rotation: [0.0, 0.0, 0.0, 1.0], spin: 0.0 };

    /// The room that a fat box leaves.
    pub fn new(fat: &BoundingBox, extent: &Extent, placement: &Placement) -> Self {
        let at = placement.position;
        let radius = Vector3::repeat(extent.radius);
        let sphere = BoundingBox { low: at - radius, high: at + radius };
        // With less than half the margin left around the sphere, a box may have more room turning.
        let sphere_gap = (sphere.low - fat.low).min().min((fat.high - sphere.high).min());
        let turns = sphere_gap < 0.5 * FAT_MARGIN * extent.radius;
        let inner = if turns { &extent.bounds } else { &sphere };
        let (below, above) = (fat.low - inner.low, fat.high - inner.high);
        let rounding = ROOM_ROUNDING * extent.radius + COORDINATE_ROUNDING * at.amax();
        let half = 0.5 * (above - below) * (1.0 - ROOM_ROUNDING) - Vector3::repeat(rounding);
        Self {
            centre: at + 0.5 * (below + above),
            half: [half.x as f32, half.y as f32, half.z as f32, f32::INFINITY],
            rotation: placement.rotation.coords.map(|component| component as f32).into(),
            spin: if turns { 2.0 * extent.radius as f32 } else { 0.0 },
        }
    }

    /// Whether a body need not be looked at to know that it has not left.
    #[inline(always)]
    pub fn is_unbounded(&self) -> bool {
        self.half[0] == f32::INFINITY
    }

    /// Whether a body placed so has certainly not left.
    #[inline(always)]
    pub fn holds(&self, placement: &Placement) -> bool {
        // Four lanes of f32, the last one idle for vectors: differences are small where it matters.
        let lanes = |v: Vector3<f64>| [v.x as f32, v.y as f32, v.z as f32, 0.0];
        // The swept centre runs from x to x + t: half of t about its middle.
        let half_way = 0.5 * placement.travel;
        let (away, half_way) = (lanes(placement.position + half_way - self.centre), lanes(half_way));
        let q = placement.rotation.coords;
        let q = [q.x as f32, q.y as f32, q.z as f32, q.w as f32];
        let (mut left, mut change) = ([0.0; 4], [0.0; 4]);
        for lane in 0..4 {
            left[lane] = self.half[lane] - away[lane].abs() - half_way[lane].abs();
            change[lane] = (q[lane] - self.rotation[lane]) * (q[lane] - self.rotation[lane]);
        }
        let least = |a: f32, b: f32| if a < b { a } else { b };
        let left = least(least(left[0], left[1]), left[2]) - 0.5 * self.spin * placement.turn as f32;
        let turned = self.spin * self.spin * ((change[0] + change[1]) + (change[2] + change[3]));
        (left >= 0.0) & (turned <= left * left)
    }
}

impl Extent {
    /// The box grown by what turning by an angle may add, which is never beyond the sphere.
    fn turned(&self, at: &Vector3<f64>, angle: f64) -> BoundingBox {
        let Self { bounds, radius, .. } = *self;
        let low = bounds.low.zip_map(at, |low, at| low.min((low - radius * angle).max(at - radius)));
        let high = bounds.high.zip_map(at, |high, at| high.max((high + radius * angle).min(at + radius)));
        BoundingBox { low, high }
    }

    /// The box of the body over the coming step.
    pub fn swept(&self, placement: &Placement) -> BoundingBox {
        let BoundingBox { low, high } = self.turned(&placement.position, placement.turn);
        let travel = placement.travel;
        BoundingBox { low: low + travel.map(|way| way.min(0.0)), high: high + travel.map(|way| way.max(0.0)) }
    }

    /// The box that pairs are made of until the swept box leaves it.
    pub fn fat(&self, placement: &Placement) -> BoundingBox {
        if !self.moves {
            return self.swept(placement);
        }
        let BoundingBox { low, high } = self.turned(&placement.position, STEPS_AHEAD * placement.turn);
        let margin = Vector3::repeat(FAT_MARGIN * self.radius);
        let travel = STEPS_AHEAD * placement.travel;
        BoundingBox {
            low: low - margin + travel.map(|way| way.min(0.0)),
            high: high + margin + travel.map(|way| way.max(0.0)),
        }
    }
}
