//! `Transform` in and out, and what decides when a step runs.

use std::time::Duration;

use bevy::math::{DQuat, DVec3};
use bevy::prelude::*;
use bevy::time::{TimePlugin, TimeUpdateStrategy};
use plumb::prelude::*;

use crate::rig::*;

/// An app whose frames last `frame` seconds, after its first, in which no time passes.
fn app_with(plugin: PhysicsPlugin, frame: f64) -> App {
    start_pool();
    let mut app = App::new();
    app.add_plugins((TaskPoolPlugin::default(), TimePlugin, plugin))
        .insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_secs_f64(frame)))
        .insert_resource(Gravity(DVec3::ZERO));
    app.finish();
    app.cleanup();
    app.update();
    app
}

fn moving(app: &mut App, position: DVec3, velocity: DVec3) -> Entity {
    let velocity = Velocity { linear: velocity, angular: DVec3::ZERO };
    app.world_mut().spawn((RigidBody::Dynamic, Collider::sphere(0.5), Position(position), velocity)).id()
}

fn transform(app: &App, body: Entity) -> Transform {
    *app.world().get::<Transform>(body).unwrap()
}

fn assert_at(transform: Transform, expected: DVec3, tolerance: f64) {
    assert_near(transform.translation.as_dvec3(), expected, tolerance);
}

#[test]
fn transforms_run_one_step_behind_time_smoothly() {
    // Frames of 7 ms against steps of 1/60 s: some frames step, most do not.
    let mut app = app_with(PhysicsPlugin::default(), 0.007);
    let ball = moving(&mut app, DVec3::ZERO, DVec3::X * 10.0);
    app.world_mut().get_mut::<Transform>(ball).unwrap().scale = Vec3::splat(3.0);
    for frame in 1..100 {
        app.update();
        let time = f64::from(frame) * 0.007;
        // Before the first step there is nothing to interpolate.
        let shown = if time < 1.0 / 60.0 { 0.0 } else { 10.0 * (time - 1.0 / 60.0) };
        // `Time<Fixed>` counts whole nanoseconds: 1e-8 m a step here.
        assert_at(transform(&app, ball), DVec3::X * shown, 1e-5);
    }
    assert_eq!(transform(&app, ball).scale, Vec3::splat(3.0), "scale is the user's");
}

#[test]
fn a_transform_changed_in_any_bit_teleports() {
    let mut app = app_with(PhysicsPlugin::default(), 1.0 / 60.0 + 1e-6);
    let ball = moving(&mut app, DVec3::ZERO, DVec3::X);
    for _ in 0..10 {
        app.update();
    }
    let turn = Quat::from_rotation_z(0.5);
    *app.world_mut().get_mut::<Transform>(ball).unwrap() = Transform::from_xyz(5.0, 6.0, 7.0).with_rotation(turn);
    app.update();
    let there = position(app.world(), ball);
    assert_near(there, DVec3::new(5.0 + 1.0 / 60.0, 6.0, 7.0), 1e-6);
    assert_eq!(velocity(app.world(), ball), DVec3::X, "velocity is kept");
    let rotation = app.world().get::<Rotation>(ball).unwrap().0;
    assert!(rotation.angle_between(turn.as_dquat()) < 1e-6);
    // Not a picture of it on its way from where it was.
    assert!(transform(&app, ball).translation.x > 4.999, "{}", transform(&app, ball).translation);

    // One bit of one coordinate.
    let shown = transform(&app, ball).translation.z;
    let nudged = f32::from_bits(shown.to_bits() + 1);
    app.world_mut().get_mut::<Transform>(ball).unwrap().translation.z = nudged;
    app.update();
    assert_eq!(position(app.world(), ball).z, f64::from(nudged));

    // A new scale alone moves nothing.
    let before = position(app.world(), ball);
    app.world_mut().get_mut::<Transform>(ball).unwrap().scale = Vec3::splat(2.0);
    app.update();
    assert_near(position(app.world(), ball), before + DVec3::X / 60.0, 1e-12);
}

#[test]
fn a_teleport_between_steps_waits_for_the_next_step() {
    let mut app = app_with(PhysicsPlugin::default(), 0.004);
    let ball = moving(&mut app, DVec3::ZERO, DVec3::ZERO);
    for _ in 0..6 {
        app.update(); // 24 ms: the next step is due at 33 ms
    }
    app.world_mut().get_mut::<Transform>(ball).unwrap().translation = Vec3::splat(9.0);
    app.update();
    assert_eq!(transform(&app, ball).translation, Vec3::splat(9.0), "overwritten before a step saw it");
    for _ in 0..6 {
        app.update();
    }
    assert_eq!(position(app.world(), ball), DVec3::splat(9.0));
    assert_eq!(transform(&app, ball).translation, Vec3::splat(9.0));
}

#[test]
fn a_transform_set_before_the_first_frame_counts() {
    let mut app = app_with(PhysicsPlugin::default(), 0.02);
    let from_transform = app.world_mut().spawn((RigidBody::Kinematic, Transform::from_xyz(1.0, 2.0, 3.0))).id();
    let moved_after = app.world_mut().spawn((RigidBody::Kinematic, Transform::from_xyz(1.0, 2.0, 3.0))).id();
    *app.world_mut().get_mut::<Transform>(moved_after).unwrap() = Transform::from_xyz(4.0, 5.0, 6.0);
    let elsewhere = (RigidBody::Kinematic, Transform::from_xyz(1.0, 2.0, 3.0), Position(DVec3::splat(7.0)));
    let from_position = app.world_mut().spawn(elsewhere).id();
    app.update();
    assert_eq!(position(app.world(), from_transform), DVec3::new(1.0, 2.0, 3.0));
    assert_eq!(position(app.world(), moved_after), DVec3::new(4.0, 5.0, 6.0));
    assert_eq!(position(app.world(), from_position), DVec3::splat(7.0), "a position wins");
    assert_eq!(transform(&app, from_position).translation, Vec3::splat(7.0));
}

#[test]
fn the_render_origin_is_subtracted_going_out_and_added_coming_in() {
    let far = DVec3::new(1e7, -2e7, 3e6);
    let mut app = app_with(PhysicsPlugin::default(), 1.0 / 60.0 + 1e-6);
    app.insert_resource(RenderOrigin(far));
    let ball = moving(&mut app, far + DVec3::new(0.25, 0.5, 0.0), DVec3::ZERO);
    let spawned = app.world_mut().spawn((RigidBody::Kinematic, Transform::from_xyz(1.0, 0.0, 0.0))).id();
    app.update();
    // Exact to f64 there: 4e-9 m.
    assert_at(transform(&app, ball), DVec3::new(0.25, 0.5, 0.0), 1e-8);
    assert_eq!(position(app.world(), spawned), far + DVec3::X);
    app.world_mut().get_mut::<Transform>(ball).unwrap().translation = Vec3::new(2.0, 0.0, 0.0);
    app.update();
    assert_eq!(position(app.world(), ball), far + DVec3::X * 2.0);
    // The origin may move without moving a body.
    app.insert_resource(RenderOrigin(far - DVec3::Y));
    app.update();
    assert_eq!(position(app.world(), ball), far + DVec3::X * 2.0);
    assert_at(transform(&app, ball), DVec3::new(2.0, 1.0, 0.0), 1e-8);
}

#[test]
fn outside_edits_of_pose_and_velocity_survive() {
    let mut world = weightless(SolverSettings::steady());
    let ball = body(&mut world, Collider::sphere(0.5), DVec3::ZERO);
    step(&mut world);
    world.get_mut::<Position>(ball).unwrap().0 = DVec3::splat(3.0);
    world.get_mut::<Rotation>(ball).unwrap().0 = DQuat::from_rotation_x(1.0);
    world.get_mut::<Velocity>(ball).unwrap().linear = DVec3::Y * 6.0;
    step(&mut world);
    assert_near(position(&world, ball), DVec3::new(3.0, 3.1, 3.0), 1e-12);
    assert!(world.get::<Rotation>(ball).unwrap().angle_between(DQuat::from_rotation_x(1.0)) < 1e-7);
}

#[test]
fn hz_alone_sets_the_step() {
    // A little longer than 24 steps, which `Time<Fixed>` rounds up to whole nanoseconds.
    let mut app = app_with(PhysicsPlugin::default(), 0.1001);
    app.world_mut().resource_mut::<SolverSettings>().hz = 240.0;
    let ball = moving(&mut app, DVec3::ZERO, DVec3::X);
    app.update();
    let fixed = app.world().resource::<Time<Fixed>>();
    assert_eq!(fixed.timestep(), Duration::from_secs_f64(1.0 / 240.0));
    let stats = *app.world().resource::<StepStats>();
    assert_eq!(stats.steps, 24);
    assert_eq!(stats.time, 24.0 / 240.0);
    // Whoever fiddles with `Time<Fixed>` changes when steps run, never how long they are.
    app.world_mut().resource_mut::<Time<Fixed>>().set_timestep(Duration::from_millis(50));
    app.update();
    let stats = *app.world().resource::<StepStats>();
    assert_eq!(stats.steps, 26);
    assert_eq!(stats.time, 26.0 / 240.0);
    assert_near(position(app.world(), ball), DVec3::X * 26.0 / 240.0, 1e-12);
}

#[test]
fn simulated_time_does_not_drift_and_survives_a_change_of_the_step() {
    let mut world = world_with(SolverSettings { hz: 60.0, ..SolverSettings::steady() });
    steps(&mut world, 600);
    assert_eq!(world.resource::<StepStats>().time, 600.0 / 60.0);
    world.resource_mut::<SolverSettings>().hz = 1000.0;
    steps(&mut world, 700);
    assert_close(world.resource::<StepStats>().time, 10.7, 1e-14);
}

#[test]
fn another_schedule_steps_once_a_run_and_shows_the_pose_itself() {
    let mut app = app_with(PhysicsPlugin::in_schedule(Update), 0.001);
    let already = app.world().resource::<StepStats>().steps;
    let ball = moving(&mut app, DVec3::ZERO, DVec3::X * 6.0);
    for frame in 1..=10 {
        app.update();
        assert_eq!(app.world().resource::<StepStats>().steps, already + frame);
        let x = 0.1 * frame as f64;
        assert_near(position(app.world(), ball), DVec3::X * x, 1e-12);
        assert_at(transform(&app, ball), DVec3::X * x, 1e-6);
    }
}

#[test]
fn settings_out_of_range_stop_the_clock_and_spoil_nothing() {
    let mut app = app_with(PhysicsPlugin::default(), 1.0 / 60.0 + 1e-6);
    let ball = moving(&mut app, DVec3::ZERO, DVec3::X * 6.0);
    app.update();
    let good = *app.world().resource::<SolverSettings>();
    let before = position(app.world(), ball);
    for bad in [
        SolverSettings { hz: 0.0, ..good },
        SolverSettings { hz: -60.0, ..good },
        SolverSettings { hz: f64::NAN, ..good },
        SolverSettings { substeps: 0, ..good },
        SolverSettings { sweeps: SweepSettings { baumgarte: f64::INFINITY, ..good.sweeps }, ..good },
    ] {
        *app.world_mut().resource_mut::<SolverSettings>() = bad;
        app.update();
        assert_eq!(position(app.world(), ball), before);
        assert!(app.world().get::<plumb::physics::Quarantined>(ball).is_none());
    }
    *app.world_mut().resource_mut::<SolverSettings>() = good;
    app.update();
    assert_near(position(app.world(), ball), before + DVec3::X * 0.1, 1e-12);
}
