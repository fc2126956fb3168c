//! How true the last step was: energy, momentum, errors, forces. Each of these resources is filled in only while it
//! exists: insert it to read it.

use bevy::math::DVec3;
use bevy::prelude::*;

/// Conserved quantities and errors of the state after the last step. Filled in while present.
#[derive(Resource, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Resource, Debug, Default)]
pub struct Diagnostics {
    /// Σ ½mv² + ½ωᵀIω of dynamic bodies, J.
    pub kinetic_energy: f64,
    /// −Σ m g·x of dynamic bodies (with their gravity scale), J, relative to the world's origin.
    pub potential_energy: f64,
    /// Σ m v of dynamic bodies, kg·m/s.
    pub linear_momentum: DVec3,
    /// Σ x × m v + I ω of dynamic bodies about the world's origin, kg·m²/s.
    pub angular_momentum: DVec3,
    /// Largest distance between the two anchors of a rigid joint, m.
    pub joint_error: f64,
    /// Largest depth of a contact found in the last step, m; of `accurate`, at its end.
    pub penetration: f64,
}

impl Diagnostics {
    /// Kinetic plus potential, J.
    pub fn energy(&self) -> f64 {
        self.kinetic_energy + self.potential_energy
    }
}

/// The contact points of the last step with the forces that the solver found. Filled in while
/// present.
#[derive(Resource, Reflect, Clone, Debug, Default, PartialEq)]
#[reflect(Resource, Debug, Default)]
pub struct ContactForces(pub Vec<ContactForce>);

/// One contact point and the force through it.
#[derive(Reflect, Clone, Copy, Debug, PartialEq)]
pub struct ContactForce {
    /// One body.
    pub a: Entity,
    /// The other.
    pub b: Entity,
    /// World position, m, where the step found it; with the exact method, where it is at the step's end.
    pub point: DVec3,
    /// Unit normal from A to B.
    pub normal: DVec3,
    /// Overlap, m.
    pub depth: f64,
    /// Force on B: normal and friction, N, world axes; mean over the step's substeps.
    pub force: DVec3,
    /// Force on B that the step's last solve found, N, world axes; none where that was not of this point.
    pub last_force: Option<DVec3>,
}

/// The joints with the forces that the last step's solves found. Filled in while present.
#[derive(Resource, Reflect, Clone, Debug, Default, PartialEq)]
#[reflect(Resource, Debug, Default, PartialEq)]
pub struct JointForces(pub Vec<JointForce>);

/// One joint and the force through it.
#[derive(Reflect, Clone, Copy, Debug, PartialEq)]
pub struct JointForce {
    /// The joint.
    pub joint: Entity,
    /// Force on its body B, N, world axes; mean over the step's substeps.
    pub force: DVec3,
    /// Torque on its body B about B's anchor, N·m, world axes; mean over the step's substeps.
    pub torque: DVec3,
}
