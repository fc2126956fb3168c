//! Simulation time against the clock: pause, slow motion, and no spiral on a slow machine.

use std::time::Duration;

use bevy::prelude::*;

use super::Playback;
use crate::physics::SolverSettings;

/// Least simulated time that a frame may catch up on: at rates above 60 Hz two steps would be
/// less than a frame of an ordinary screen, and time would run slow on any machine.
const LEAST_CATCH_UP: f64 = 1.0 / 30.0;

pub(super) fn plugin(app: &mut App) {
    app.init_resource::<Playback>().add_systems(PreUpdate, (limit_catch_up, apply_playback));
}

/// A frame simulates two steps at most (or [`LEAST_CATCH_UP`]): a machine that cannot keep up
/// shows a slower world, and does not fall further and further behind.
fn limit_catch_up(settings: Res<SolverSettings>, mut time: ResMut<Time<Virtual>>) {
    if settings.is_changed() && settings.validate().is_ok() {
        time.set_max_delta(Duration::from_secs_f64((2.0 * settings.step()).max(LEAST_CATCH_UP)));
    }
}

fn apply_playback(playback: Res<Playback>, mut time: ResMut<Time<Virtual>>) {
    if playback.is_changed() {
        time.set_relative_speed_f64(playback.speed());
        if playback.paused {
            time.pause();
        } else {
            time.unpause();
        }
    }
}
