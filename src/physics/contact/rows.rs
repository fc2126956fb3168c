//! Non-penetration and friction at one contact point.
//!
//! With n the unit normal from A to B and r the arm from each centre of mass,
//! J = [−nᵀ, −(r_A×n)ᵀ, nᵀ, (r_B×n)ᵀ] gives the speed at which B's point leaves A's. Friction rows
//! have a unit tangent in the place of n. (Catto 2005, p. 6; Erleben 2005, p. 67.)

use nalgebra::{SimdRealField, Vector3};

use crate::physics::constraint::row::{BodyTerms, Bounds, Row, RowPair};

/// One contact point between two bodies, given by index and terms.
pub(crate) struct PointConstraint<'a, N> {
    pub a: (u32, &'a BodyTerms<N>),
    pub b: (u32, &'a BodyTerms<N>),
    /// From A's centre of mass to the point.
    pub arm_a: Vector3<N>,
    pub arm_b: Vector3<N>,
    /// Unit, from A to B.
    pub normal: Vector3<N>,
}

impl<N: SimdRealField + Copy> PointConstraint<'_, N> {
    fn along(&self, direction: Vector3<N>) -> RowPair<N> {
        RowPair::along(direction, self.arm_a, self.arm_b)
    }

    /// The non-penetration row: λ pushes only.
    pub fn normal_row(&self, bias: N, h: N, unbounded: N) -> Row<N> {
        Row::rigid(self.a, self.b, self.along(self.normal), bias, h, Bounds::Fixed(N::zero(), unbounded))
    }

    /// A friction row along a unit tangent.
    pub fn friction_row(&self, tangent: Vector3<N>, h: N, bounds: Bounds<N>) -> Row<N> {
        Row::rigid(self.a, self.b, self.along(tangent), N::zero(), h, bounds)
    }
}

/// Position error to velocity bias, m/s.
///
/// `rate` is β in 1/s. Depth beyond the slop is pushed out at β(depth − slop), at most at
/// `greatest`; less depth leaves β(slop − depth) of approach, as in the 2009 engine; and a gap that
/// opened since the contact was found may close within `h`.
pub(crate) fn penetration_bias(depth: f64, slop: f64, rate: f64, greatest: f64, h: f64) -> f64 {
    let overlap = depth.max(0.0);
    let gap = depth.min(0.0);
    (rate * (overlap - slop)).min(greatest) + gap / h
}

/// Two unit vectors that with the unit vector n make a right-handed orthonormal frame
/// (Duff et al. 2017, without a branch on the direction).
pub(crate) fn tangents(n: &Vector3<f64>) -> [Vector3<f64>; 2] {
    let sign = 1.0_f64.copysign(n.z);
    let a = -1.0 / (sign + n.z);
    let b = n.x * n.y * a;
    [Vector3::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x), Vector3::new(b, sign + n.y * n.y * a, -n.y)]
}
