//! How many steps a frame makes.

use std::time::Duration;

use bevy::time::TimeUpdateStrategy;
use plumb::physics::{SolverSettings, StepStats};
use plumb::sandbox::StepBudget;

use crate::stage::Stage;

const BALL: &str = r#"(bodies: [(name: "ball", shape: Sphere(radius: 0.3))])"#;

/// A ball at 1000 steps a second, and frames of that length, ms.
fn stage(frame: u64) -> Stage {
    let mut stage = Stage::open(BALL);
    stage.world().resource_mut::<SolverSettings>().hz = 1000.0;
    stage.frames(5);
    stage.world().insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_millis(frame)));
    stage.frames(1);
    stage
}

/// Steps of the next frame.
fn steps(stage: &mut Stage) -> u64 {
    let before = stage.world().resource::<StepStats>().steps;
    stage.frames(1);
    stage.world().resource::<StepStats>().steps - before
}

#[test]
fn a_slow_picture_slows_nothing_down() {
    let mut stage = stage(300);
    assert!((299..=301).contains(&steps(&mut stage)));
}

#[test]
fn where_steps_take_too_long_one_is_made_a_frame_and_none_are_owed() {
    let mut stage = stage(16);
    stage.world().insert_resource(StepBudget { least: Duration::ZERO, of_picture: 0.0 });
    for _ in 0..20 {
        assert_eq!(steps(&mut stage), 1);
    }
    stage.world().insert_resource(StepBudget { least: Duration::MAX, of_picture: 0.0 });
    let next = steps(&mut stage);
    assert!((15..=17).contains(&next), "{next} steps in a frame of 16 ms");
}

#[test]
fn a_scene_begins_with_its_first_step_however_long_it_took_to_load() {
    let mut stage = stage(400);
    stage.load(BALL);
    assert_eq!(steps(&mut stage), 1);
    assert_eq!(steps(&mut stage), 1);
    assert!(steps(&mut stage) > 100);
}
