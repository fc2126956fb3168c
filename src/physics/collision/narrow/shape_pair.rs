//! Two shapes to be tested against each other.

use nalgebra::Vector3;

use super::{Convex, Frame, Scale};

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
