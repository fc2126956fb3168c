//! What a solve is given, and what it reports.

use nalgebra::{Matrix3, SMatrix, Vector3};

/// A body that moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ConeBody {
    /// Along the world's axes, 1/kg; zero along those it cannot move along.
    pub inverse_mass: Vector3<f64>,
    /// About the centre of mass, in the world's axes, 1/(kg m²); positive semi-definite.
    pub inverse_inertia: Matrix3<f64>,
}

/// A contact point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ConeContact {
    /// A and B, by index; none is immovable.
    pub bodies: [Option<u32>; 2],
    /// From the centres of mass of A and B to the point, m; an immovable side's is not read.
    pub arms: [Vector3<f64>; 2],
    /// n: unit, from A to B.
    pub normal: Vector3<f64>,
    /// μ ≥ 0; at 0 the contact has one unknown.
    pub friction: f64,
}

/// The velocity of a point along three axes for the velocity of one body, linear and angular.
pub(crate) type PointJacobian = SMatrix<f64, 3, 6>;

/// Up to three bilateral rows of a joint, along axes of the world or its own; rows that it has not are zero. A joint of
/// more rows is several of these, and so is one some of whose rows have bounds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ConeJoint {
    /// A and B, by index; none is immovable.
    pub bodies: [Option<u32>; 2],
    /// J of A and B; an immovable side's is not read.
    pub jacobians: [PointJacobian; 2],
    /// What the impulse may be, N·s: where that is not all, the first row is its only one.
    pub bounds: (f64, f64),
}

#[cfg(test)]
impl ConeJoint {
    /// A ball joint, with the arms from the centres of mass of A and B, m.
    pub fn ball(bodies: [Option<u32>; 2], arms: &[Vector3<f64>; 2]) -> Self {
        Self { bodies, jacobians: relative_velocity(arms), bounds: (f64::NEG_INFINITY, f64::INFINITY) }
    }
}

/// J of A and of B for the velocity of B's point relative to A's, in the world's axes.
pub(super) fn relative_velocity(arms: &[Vector3<f64>; 2]) -> [PointJacobian; 2] {
    [(-1.0, &arms[0]), (1.0, &arms[1])].map(|(sign, arm)| {
        let mut jacobian = PointJacobian::zeros();
        jacobian.fixed_columns_mut::<3>(0).fill_diagonal(sign);
        jacobian.fixed_columns_mut::<3>(3).copy_from(&(arm.cross_matrix() * -sign));
        jacobian
    })
}

/// Linear, m/s, and angular, rad/s.
pub(crate) type Velocity = [Vector3<f64>; 2];

/// What is known at contacts and at joints: a bias or an impulse of each, in the world's axes.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct PerPoint {
    pub contacts: Vec<Vector3<f64>>,
    pub joints: Vec<Vector3<f64>>,
}

/// How a solve ended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum ConeEnd {
    /// The residual is within the tolerance.
    Converged,
    /// The residual is what rounding of impulses as large as these makes of it: |λ|/ρ is some 10⁵ m/s or more.
    Rounding,
    /// The residual fell no more, but is no more than 10⁻⁸ m/s: points contradict each other by that much.
    Enough,
    /// The bounds are met; the residual is what was reached.
    #[default]
    Bounded,
    /// Time was over; the residual is what was reached.
    Late,
    /// The impulses grow without an effect on the motion: most likely no motion obeys all points.
    NoRigidSolution,
}

/// What a solve reached.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct ConeOutcome {
    pub end: ConeEnd,
    /// The residual that was asked for, m/s, at the speeds of the problem.
    pub tolerance: f64,
    /// Largest |r| of a point, the natural map's at contacts and |u| at joints, m/s.
    pub residual: f64,
    /// Newton iterations, with a factorisation each.
    pub steps: u32,
    /// Proximal points.
    pub stages: u32,
}
