//! The schedule of a step and its phases. No types that others need for anything else.

use bevy::ecs::schedule::ScheduleLabel;
use bevy::prelude::*;

/// The schedule of one physics step.
#[derive(ScheduleLabel, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct PhysicsSchedule;

/// The phases of [`PhysicsSchedule`], chained in this order.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PhysicsSystems {
    /// Gathers what changed, sums forces.
    Prepare,
    /// Finds the pairs that may touch.
    BroadPhase,
    /// Finds contacts.
    NarrowPhase,
    /// Finds the groups of bodies that touch or are joined.
    Islands,
    /// Builds and solves rows, integrates.
    Solve,
    /// Writes poses, velocities and joint loads to the ECS.
    WriteBack,
    /// Writes messages, triggers entity events.
    Events,
    /// Measures energy, momentum and errors if somebody reads them.
    Diagnose,
}
