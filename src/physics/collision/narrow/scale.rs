//! The lengths by which the tests of one pair are judged.

use crate::physics::collision::gap::CONTACT_TOLERANCE;

/// An edge–edge axis (or a face of B) is taken only where its depth is below this share of the
/// depth along the best face (of A) …
const RIVAL_SHARE: f64 = 0.95;

/// … (apart: where it is farther apart than the face by the inverse of that share) and below it by
/// this share of the smaller bounding radius as well, for depths near zero.
const RIVAL_MARGIN: f64 = 1e-4;

/// Bounds leave out what is worse by this share of the bounding radii: far more than rounding.
const BOUND_SLACK: f64 = 1e-9;

/// Lengths that a pair's sizes and its gap set.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scale {
    /// Distance up to which two shapes count as touching.
    pub tolerance: f64,
    /// Distance up to which two shapes, and single points of them, get contact points: the gap
    /// asked for, but at least the tolerance.
    pub gap: f64,
    /// The smaller bounding radius.
    pub size: f64,
    slack: f64,
}

impl Scale {
    /// Of the bounding radii of two shapes, and the gap asked for.
    pub fn new(radius_a: f64, radius_b: f64, gap: f64) -> Self {
        let sum = radius_a + radius_b;
        let tolerance = CONTACT_TOLERANCE * sum;
        Self { tolerance, gap: gap.max(tolerance), size: radius_a.min(radius_b), slack: BOUND_SLACK * sum }
    }

    /// Whether points that only may touch are asked for.
    pub fn is_speculative(&self) -> bool {
        self.gap > self.tolerance
    }

    /// Whether a depth along some axis tells that two shapes are farther apart than the gap.
    pub fn separates(&self, depth: f64) -> bool {
        depth < -self.gap
    }

    /// The depth; zero if rounding could have made it of that.
    pub fn rounded(&self, depth: f64) -> f64 {
        if depth >= -self.tolerance { depth.max(0.0) } else { depth }
    }

    /// The depth under which a rival axis is preferred to one of that depth.
    pub fn limit(&self, depth: f64) -> f64 {
        let depth = self.rounded(depth);
        let share = if depth < 0.0 { depth / RIVAL_SHARE } else { RIVAL_SHARE * depth };
        share - RIVAL_MARGIN * self.size
    }

    /// What is certain to be deeper than this can be left out: it neither is below `limit` nor
    /// separates.
    pub fn bound(&self, limit: f64) -> f64 {
        limit.max(-self.gap) + self.slack
    }
}
