//! The plugin: systems of all parts in one schedule, run once a fixed step; and the step without an app around it.

use bevy::app::{RunFixedMainLoop, RunFixedMainLoopSystems};
use bevy::ecs::error::{ResultSeverityExt, Severity};
use bevy::ecs::intern::Interned;
use bevy::ecs::message::{MessageRegistry, message_update_system};
use bevy::ecs::schedule::{ScheduleBuildSettings, ScheduleLabel, SingleThreadedExecutor};
use bevy::prelude::*;

use super::diagnostics::{self, MeasuringTime};
use super::rewind::{note_blank, step_and_note};
use super::{
    BodyQuarantined, Collision, ContactEnded, ContactStarted, Gravity, JointBroke, Keep, LimitReached, PhysicsSchedule,
    PhysicsSystems, RenderOrigin, SolverSettings, StepStats, breaking, collision, events, island, phase_times, prepare,
    query, sleep, solver, transform, write_back,
};

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
            .keep_setting::<SolverSettings>()
            .keep_setting::<Gravity>()
            .keep_resource::<StepStats>()
            .keep_look::<Name>()
            .add_message::<ContactStarted>()
            .add_message::<ContactEnded>()
            .add_message::<Collision>()
            .add_message::<BodyQuarantined>()
            .add_message::<JointBroke>()
            .add_message::<LimitReached>()
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
                query::plugin,
                breaking::plugin,
                diagnostics::plugin,
                phase_times::plugin,
            ));
        note_blank(app.world_mut());
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
    let took = step_and_note(world);
    let measuring = std::mem::take(&mut world.resource_mut::<MeasuringTime>().spent);
    world.resource_mut::<StepStats>().step_seconds = took.saturating_sub(measuring).as_secs_f64();
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
