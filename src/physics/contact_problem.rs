//! One solve of the exact method as data: bodies, contact points and rows of joints in numbers, without a world.
//!
//! v = v_free + M⁻¹Jᵀλ, u = J v + b at each contact point and at each joint; a joint wants u = 0, a contact that u and λ
//! obey Signorini's condition and Coulomb's law.

use bevy::math::{DMat3, DVec3};

/// What one solve is given.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ContactProblem {
    /// Those that move.
    pub bodies: Vec<ProblemBody>,
    /// Contact points.
    pub contacts: Vec<ProblemContact>,
    /// Joints, up to three rows each.
    pub joints: Vec<ProblemJoint>,
}

/// A body that moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProblemBody {
    /// Along the world's axes, 1/kg; zero along those it cannot move along.
    pub inverse_mass: DVec3,
    /// About the centre of mass, in the world's axes, 1/(kg m²).
    pub inverse_inertia: DMat3,
    /// v_free: without impulses at contacts and joints, m/s.
    pub velocity: DVec3,
    /// The same, rad/s.
    pub angular_velocity: DVec3,
}

/// A contact point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProblemContact {
    /// A and B, by index; none is immovable.
    pub bodies: [Option<u32>; 2],
    /// From the centres of mass of A and B to the point, m; an immovable side's is not read.
    pub arms: [DVec3; 2],
    /// n: unit, from A to B.
    pub normal: DVec3,
    /// μ.
    pub friction: f64,
    /// b, m/s: the motion of an immovable side, and along n what the contact may close or is to gain.
    pub bias: DVec3,
    /// Where a solve may start from, N·s on B.
    pub guess: DVec3,
}

/// Up to three bilateral rows of a joint, or one row whose impulse is bounded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProblemJoint {
    /// A and B, by index; none is immovable.
    pub bodies: [Option<u32>; 2],
    /// J of A and of B for the linear and for the angular velocity of each; rows that the joint has not are zero. An
    /// immovable side's is not read.
    pub jacobians: [[DMat3; 2]; 2],
    /// What the impulse may be, N·s: where that is not all, the first row is the only one.
    pub bounds: (f64, f64),
    /// b, m/s or rad/s, along the rows.
    pub bias: DVec3,
    /// Where a solve may start from, N·s or N·m·s, along the rows.
    pub guess: DVec3,
}
