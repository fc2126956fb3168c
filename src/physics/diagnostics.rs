//! What a step did and how true it was: counts, times, energy, momentum, errors, forces.
//!
//! [`StepStats`] is always there. [`Diagnostics`] and [`ContactForces`] are filled in only
//! while the resource exists: insert it to read it.

use bevy::math::DVec3;
use bevy::prelude::*;

/// Counts and times of the last step.
#[derive(Resource, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Resource, Debug, Default)]
pub struct StepStats {
    /// Steps since the world was made.
    pub steps: u64,
    /// Simulation time, s: steps × h.
    pub time: f64,
    /// Wall-clock time of the last step, s.
    pub step_seconds: f64,
    /// Bodies, all kinds.
    pub bodies: u32,
    /// Joints.
    pub joints: u32,
    /// Pairs that the broad phase handed to the narrow phase.
    pub pairs: u32,
    /// Pairs that touch.
    pub manifolds: u32,
    /// Contact points.
    pub contact_points: u32,
    /// Scalar rows solved, in one substep.
    pub rows: u32,
    /// Row updates: rows × iterations × solves, over all substeps.
    pub row_updates: u64,
    /// Groups of bodies that touch or are joined.
    pub islands: u32,
    /// Bodies and joints quarantined now.
    pub quarantined: u32,
}

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
    /// Largest depth of a contact found in the last step, m.
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
    /// World position, m.
    pub point: DVec3,
    /// Unit normal from A to B.
    pub normal: DVec3,
    /// Overlap, m.
    pub depth: f64,
    /// Force on B: normal and friction, N, world axes; mean over the step's substeps.
    pub force: DVec3,
}

pub(super) fn plugin(_app: &mut App) {}
