//! How long each phase of a step took, by the clock, while somebody looks.

use std::time::Instant;

use bevy::prelude::*;

use super::schedule::{PhysicsSchedule, PhysicsSystems};

/// Wall-clock time of each phase of the last step, s: of its systems and of what runs between it and the next. Filled in
/// while present. No part of the state of a world: going back does not bring it back.
#[derive(Resource, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Resource, Debug, Default, PartialEq)]
pub struct PhaseTimes {
    /// In the order of [`Self::NAMES`], s.
    pub seconds: [f64; Self::COUNT],
}

impl PhaseTimes {
    /// How many phases are timed: all but measuring.
    pub const COUNT: usize = 7;
    /// What they are called.
    pub const NAMES: [&str; Self::COUNT] =
        ["gather", "broad phase", "narrow phase", "islands", "solve", "write-back", "events"];
}

/// When the phase at hand began; none outside of a timed step.
#[derive(Resource, Default)]
struct PhaseClock(Option<Instant>);

/// Reads of the clock between the phases: one condition for all of them.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Timing;

pub(super) fn plugin(app: &mut App) {
    use PhysicsSystems::{BroadPhase, Diagnose, Events, Islands, NarrowPhase, Prepare, Solve, WriteBack};
    app.init_resource::<PhaseClock>()
        .configure_sets(PhysicsSchedule, Timing.run_if(resource_exists::<PhaseTimes>))
        .add_systems(
            PhysicsSchedule,
            (
                start.before(Prepare),
                end::<0>.after(Prepare).before(BroadPhase),
                end::<1>.after(BroadPhase).before(NarrowPhase),
                end::<2>.after(NarrowPhase).before(Islands),
                end::<3>.after(Islands).before(Solve),
                end::<4>.after(Solve).before(WriteBack),
                end::<5>.after(WriteBack).before(Events),
                end::<6>.after(Events).before(Diagnose),
            )
                .in_set(Timing),
        );
}

fn start(mut clock: ResMut<PhaseClock>) {
    clock.0 = Some(Instant::now());
}

/// The end of a phase, and the start of the next.
fn end<const PHASE: usize>(mut clock: ResMut<PhaseClock>, mut times: ResMut<PhaseTimes>) {
    let now = Instant::now();
    if let Some(start) = clock.0.replace(now) {
        times.seconds[PHASE] = (now - start).as_secs_f64();
    }
}
