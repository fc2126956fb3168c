//! Two shapes to be tested against each other, and the lengths by which that is judged.

use nalgebra::Vector3;

use super::{Convex, Frame};
use crate::physics::collision::constants::{
    BOUND_SLACK, CONTACT_TOLERANCE, EXACT_RIVAL_MARGIN, EXACT_ROUNDING, FACE_MARGIN, RIVAL_MARGIN, RIVAL_SHARE,
};

/// Two shapes, about the origins of their own axes.
pub(crate) struct ShapePair<'t, A, B> {
    pub a: &'t A,
    pub b: &'t B,
    pub b_in_a: &'t Frame,
    pub scale: &'t Scale,
}

impl<'t, A: Convex, B: Convex> ShapePair<'t, A, B> {
    /// The same pair in B's axes.
    pub fn swapped(&self, a_in_b: &'t Frame) -> ShapePair<'t, B, A> {
        ShapePair { a: self.b, b: self.a, b_in_a: a_in_b, scale: self.scale }
    }

    /// The overlap along a unit direction out of A.
    pub fn depth_along(&self, normal: &Vector3<f64>) -> f64 {
        self.a.reach(normal) + self.b.reach(&-self.b_in_a.enter(normal)) - normal.dot(&self.b_in_a.center)
    }

    /// A normal of B's, out of A.
    pub fn out_of_a(&self, normal: Vector3<f64>) -> Vector3<f64> {
        -(self.b_in_a.rotation * normal)
    }
}

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
    /// How far from the centre of one a point of the other may be that matters.
    pub reach: f64,
    slack: f64,
    /// Gap that is rounded to zero.
    rounding: f64,
    /// Whether no axis is preferred to one of less depth by more than rounding.
    is_exact: bool,
    /// Whether faces are kept all the same where what is over them is nearly as deep.
    pub keeps_faces: bool,
}

impl Scale {
    /// Of the bounding radii of two shapes (that of a half-space counts nothing), and the gap asked for.
    pub fn new(radius_a: f64, radius_b: f64, gap: f64) -> Self {
        let sum = if radius_a.is_finite() { radius_a + radius_b } else { radius_b };
        let tolerance = CONTACT_TOLERANCE * sum;
        Self {
            tolerance,
            gap: gap.max(tolerance),
            size: radius_a.min(radius_b),
            reach: 2.0 * sum + gap,
            slack: BOUND_SLACK * sum,
            rounding: tolerance,
            is_exact: false,
            keeps_faces: false,
        }
    }

    /// The same; if `is_exact`, no axis is preferred to one of less depth by more than rounding, and gaps are told down to
    /// rounding.
    pub fn exact(self, is_exact: bool) -> Self {
        let share = if is_exact { EXACT_ROUNDING } else { 1.0 };
        Self { is_exact, rounding: share * self.tolerance, ..self }
    }

    /// Whether gaps are told down to rounding.
    pub fn is_exact(&self) -> bool {
        self.is_exact
    }

    /// The same; if so, faces are preferred to rivals of somewhat less depth for all that.
    pub fn keeping_faces(self, keeps_faces: bool) -> Self {
        Self { keeps_faces, ..self }
    }

    /// Whether points that only may touch are asked for.
    pub fn is_speculative(&self) -> bool {
        self.gap > self.tolerance
    }

    /// Whether a depth along some axis tells that two shapes are farther apart than the gap.
    pub fn separates(&self, depth: f64) -> bool {
        depth < -self.gap
    }

    /// Whether a point of that depth is one where shapes touch that overlap by a little: what reaches over an edge may be that
    /// much deeper than all that is over the face.
    pub fn touches(&self, depth: f64) -> bool {
        depth >= -self.tolerance || self.keeps_faces
    }

    /// The depth; zero if rounding could have made it of that.
    pub fn rounded(&self, depth: f64) -> f64 {
        if depth >= -self.rounding { depth.max(0.0) } else { depth }
    }

    /// The depth under which a rival axis is preferred to one of that depth.
    pub fn limit(&self, depth: f64) -> f64 {
        let depth = self.rounded(depth);
        if self.keeps_faces {
            return depth - FACE_MARGIN * self.size;
        }
        if self.is_exact {
            return depth - EXACT_RIVAL_MARGIN * self.size;
        }
        let share = if depth < 0.0 { depth / RIVAL_SHARE } else { RIVAL_SHARE * depth };
        share - RIVAL_MARGIN * self.size
    }

    /// What is certain to be deeper than this can be left out: it neither is below `limit` nor
    /// separates.
    pub fn bound(&self, limit: f64) -> f64 {
        limit.max(-self.gap) + self.slack
    }
}
