//! What a solve is given, and what it reports.

use nalgebra::{Matrix3, Vector3};

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

/// A ball joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ConeJoint {
    /// A and B, by index; none is immovable.
    pub bodies: [Option<u32>; 2],
    /// From the centres of mass of A and B to the joint, m; an immovable side's is not read.
    pub arms: [Vector3<f64>; 2],
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
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ConeEnd {
    /// The residual is within the tolerance.
    Converged,
    /// The residual is what rounding of impulses as large as these makes of it: |λ|/ρ is some 10⁵ m/s or more.
    Rounding,
    /// The bounds are met; the residual is what was reached.
    Bounded,
    /// The impulses grow without an effect on the motion: most likely no motion obeys all points.
    NoRigidSolution,
}

/// What a solve reached.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ConeOutcome {
    pub end: ConeEnd,
    /// Largest |r| of a point, the natural map's at contacts and |u| at joints, m/s.
    pub residual: f64,
    /// Factorisations: Newton steps of all kinds.
    pub steps: u32,
    /// Of these, those of the interior point.
    pub interior: u32,
    /// Proximal points.
    pub stages: u32,
}
