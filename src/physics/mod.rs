//! The headless physics plugin: components, the step and its solver, on Bevy's ECS alone.
//!
//! A step runs [`PhysicsSchedule`], whose sets ([`PhysicsSystems`]) are, in order:
//! 1. `Prepare`: gather what changed into packed arrays, sum forces;
//! 2. `BroadPhase`: which bodies may touch;
//! 3. `NarrowPhase`: where they touch;
//! 4. `Islands`: which bodies can influence each other in this step;
//! 5. `Solve`: rows, substeps, the chosen method, integration;
//! 6. `WriteBack`: poses, velocities, joint loads;
//! 7. `Events`: messages and entity events;
//! 8. `Diagnose`: energy, momentum, errors, only where somebody reads them.
//!
//! The schedule runs on the single-threaded executor, because starting systems on several
//! threads costs more than most scenes take; threads are used inside the heavy phases.

mod bit_set;
mod bodies;
mod body;
pub mod collider;
mod collision;
mod columns;
mod constraint;
pub mod diagnostics;
mod disjoint_sets;
mod events;
mod integrator;
mod island;
pub mod joint;
mod lanes;
mod messages;
mod prepare;
mod settings;
mod sleep;
mod solver;
#[cfg(test)]
mod testing;
mod threads;
mod transform;
mod write_back;

#[cfg(feature = "lab")]
pub(crate) use body::BodySlot;
pub use body::{
    CollisionLayers, Damping, Density, ExternalForce, GravityScale, Inertia, LockedAxes, Mass, ObserveContacts,
    Position, QuarantineReason, Quarantined, ReportCollisions, RigidBody, Rotation, Sleeping, SurfaceMaterial,
    Velocity,
};
pub use collider::{Collider, ConvexHull, HullError, MassProperties, Shape};
pub use collision::PlacedCollider;
pub use diagnostics::{ContactForce, ContactForces, Diagnostics, JointForce, JointForces, StepStats};
pub use joint::{BallJoint, JointLoad, Softness};
pub use messages::{BodyQuarantined, Collision, ContactEnded, ContactStarted};
pub use settings::{
    BroadPhase, ContactModel, FrictionModel, Gravity, Integrator, Method, Precision, SettingValue, SettingsError,
    SolverSettings,
};
pub use transform::RenderOrigin;

use std::time::Instant;

use bevy::app::{RunFixedMainLoop, RunFixedMainLoopSystems};
use bevy::ecs::error::{ResultSeverityExt, Severity};
use bevy::ecs::intern::Interned;
use bevy::ecs::message::{MessageRegistry, message_update_system};
use bevy::ecs::schedule::{ScheduleBuildSettings, ScheduleLabel, SingleThreadedExecutor};
use bevy::prelude::*;

use diagnostics::MeasuringTime;

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

/// Rigid bodies for a Bevy app: adds [`PhysicsSchedule`] and runs it once a fixed step.
pub struct PhysicsPlugin {
    schedule: Interned<dyn ScheduleLabel>,
}

impl Default for PhysicsPlugin {
    /// Steps in `FixedPostUpdate`, so that game code in `FixedUpdate` acts before the step.
    fn default() -> Self {
        Self::in_schedule(FixedPostUpdate)
    }
}

impl PhysicsPlugin {
    /// Steps once whenever `schedule` runs. Transforms are interpolated where it is one of the
    /// fixed main loop's, and written right after the step where it is not.
    pub fn in_schedule(schedule: impl ScheduleLabel) -> Self {
        Self { schedule: schedule.intern() }
    }
}

impl Plugin for PhysicsPlugin {
    fn build(&self, app: &mut App) {
        use PhysicsSystems::{BroadPhase, Diagnose, Events, Islands, NarrowPhase, Prepare, Solve, WriteBack};
        app.init_resource::<SolverSettings>()
            .init_resource::<Gravity>()
            .init_resource::<RenderOrigin>()
            .init_resource::<StepStats>()
            .add_message::<ContactStarted>()
            .add_message::<ContactEnded>()
            .add_message::<Collision>()
            .add_message::<BodyQuarantined>()
            .init_schedule(PhysicsSchedule)
            .edit_schedule(PhysicsSchedule, |schedule| {
                schedule.set_executor(SingleThreadedExecutor::new());
                schedule.set_build_settings(ScheduleBuildSettings { auto_insert_apply_deferred: false, ..default() });
                schedule.configure_sets(
                    (Prepare, BroadPhase, NarrowPhase, Islands, Solve, WriteBack, Events, Diagnose).chain(),
                );
            })
            .add_systems(self.schedule, (report_bad_settings, run_step).chain())
            .add_plugins((
                prepare::plugin,
                collision::plugin,
                island::plugin,
                sleep::plugin,
                solver::plugin,
                write_back::plugin,
                events::plugin,
                diagnostics::plugin,
            ));
        let fixed = [
            FixedFirst.intern(),
            FixedPreUpdate.intern(),
            FixedUpdate.intern(),
            FixedPostUpdate.intern(),
            FixedLast.intern(),
        ];
        if fixed.contains(&self.schedule) {
            app.add_systems(
                RunFixedMainLoop,
                (
                    set_fixed_timestep.in_set(RunFixedMainLoopSystems::BeforeFixedMainLoop),
                    transform::write_interpolated.in_set(RunFixedMainLoopSystems::AfterFixedMainLoop),
                ),
            );
        } else {
            app.add_systems(self.schedule, transform::write_latest.after(run_step));
        }
    }
}

/// An error in the log each time the settings change to what [`SolverSettings::validate`] refuses.
fn report_bad_settings(settings: Res<SolverSettings>) -> Result {
    if settings.is_changed() {
        settings.validate().with_severity(Severity::Error)?;
    }
    Ok(())
}

/// Runs the schedule and times it, the ECS included, measuring left out. With settings out of range nothing moves: a
/// step of 0 Hz would spoil every state.
fn run_step(world: &mut World) {
    if world.resource::<SolverSettings>().validate().is_err() {
        return;
    }
    let start = Instant::now();
    world.run_schedule(PhysicsSchedule);
    let measuring = std::mem::take(&mut world.resource_mut::<MeasuringTime>().spent);
    world.resource_mut::<StepStats>().step_seconds = start.elapsed().saturating_sub(measuring).as_secs_f64();
}

/// `Time<Fixed>` only decides when to step; the step itself is `1/hz`.
fn set_fixed_timestep(settings: Res<SolverSettings>, fixed: Option<ResMut<Time<Fixed>>>) {
    if settings.is_changed()
        && settings.validate().is_ok()
        && let Some(mut fixed) = fixed
    {
        fixed.set_timestep_seconds(settings.step());
    }
}

/// An app with the physics plugin and nothing else: no window, no clock. Drive it with [`step`].
pub fn headless_app() -> App {
    let mut app = App::new();
    app.add_plugins((TaskPoolPlugin::default(), PhysicsPlugin::default()));
    app.finish();
    app.cleanup();
    app
}

/// One physics step of a headless world, with the housekeeping that Bevy's main loop would do:
/// message buffers advance and change trackers are cleared (without it both grow for ever).
pub fn step(world: &mut World) {
    run_step(world);
    if world.contains_resource::<MessageRegistry>() {
        let _ = world.run_system_cached(message_update_system);
    }
    world.clear_trackers();
}
