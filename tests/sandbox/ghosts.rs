//! Ghosts: a second method or the reference answer beside the scene.

use bevy::prelude::*;
use plumb::lab::truth;
use plumb::lab::vary::Assignment;
use plumb::physics::{Position, SolverSettings};
use plumb::sandbox::{CurrentScene, GhostChoice, GhostDistance, SandboxAction};

use crate::eyes::{click_on, open_eyes, point_at, reads, rewrite, seen};
use crate::stage::Stage;

fn open(scene: &str) -> Stage {
    let mut stage = Stage::open("(bodies: [])");
    stage.act(SandboxAction::LoadScene { scene: scene.to_owned(), parameters: Vec::new() });
    stage.frames(3);
    stage
}

fn distance(stage: &mut Stage) -> Option<f64> {
    stage.world().resource::<GhostDistance>().0.map(|apart| apart.distance)
}

fn ghosts(stage: &mut Stage) -> Vec<Vec3> {
    let world = stage.world();
    let mut ghosts = world.query::<(&Name, &Transform)>();
    ghosts.iter(world).filter(|(name, _)| name.as_str() == "ghost").map(|(_, pose)| pose.translation).collect()
}

#[test]
fn a_ghost_of_the_same_method_stays_with_its_body() {
    let mut stage = open("chain");
    assert_eq!(distance(&mut stage), None);
    // The first of the series is the default preset, but that nothing sleeps in it.
    let mut default = SolverSettings::default();
    default.impulse.sleep_speed = None;
    assert_eq!((plumb::lab::chart::SERIES[0].base)(), default);
    stage.world().insert_resource(GhostChoice::Method(0));
    stage.frames(60);
    assert_eq!(distance(&mut stage), Some(0.0));
    assert_eq!(ghosts(&mut stage).len(), 11);
    stage.world().insert_resource(GhostChoice::Off);
    stage.frames(3);
    assert_eq!(distance(&mut stage), None);
    assert!(ghosts(&mut stage).is_empty());
}

#[test]
fn a_ghost_of_another_method_goes_its_own_way() {
    let mut stage = open("chain");
    stage.world().insert_resource(GhostChoice::Method(1));
    stage.frames(60);
    let apart = distance(&mut stage).unwrap();
    assert!(apart > 1e-3 && apart < 5.0, "{apart} m apart");
}

#[test]
fn bodies_that_turn_apart_in_one_place_are_apart() {
    let mut stage = open("top");
    stage.world().insert_resource(GhostChoice::Method(1));
    stage.frames(300);
    let [at, turned] = {
        let body = stage.world().resource::<CurrentScene>().entities.bodies[0];
        let pose = stage.world().get::<Transform>(body).unwrap();
        [pose.translation.length(), pose.rotation.to_axis_angle().1]
    };
    assert!(at < 1e-6 && turned > 0.0, "its centre stays where it is");
    let apart = stage.world().resource::<GhostDistance>().0.unwrap();
    // Half the diagonal of the box, 0.59 m, turned by that angle at most.
    assert!(apart.angle > 0.01, "{apart:?}");
    assert!(apart.distance > 0.2 * apart.angle && apart.distance < 0.6 * apart.angle, "{apart:?}");
}

#[test]
fn a_ghost_at_another_rate_keeps_the_time() {
    let mut stage = open("pendulum");
    stage.world().resource_mut::<SolverSettings>().hz = 240.0;
    stage.world().insert_resource(GhostChoice::Method(0));
    stage.frames(60);
    // At most a step of 1/60 s behind or before, at no more than 5.4 m/s of the tip's half-way point.
    let apart = distance(&mut stage).unwrap();
    assert!(apart > 0.0 && apart < 0.1, "{apart} m apart");
}

/// It has the settings on view when the scene starts, none of the presets.
#[test]
fn a_ghost_with_one_thing_changed_has_all_else_of_the_present_settings() {
    let mut stage = open("chain");
    let mut settings = SolverSettings { hz: 90.0, ..SolverSettings::classic() };
    settings.sweeps.baumgarte = 0.2;
    let changed = |text: &str| GhostChoice::Changed(Assignment::parse(text, None).unwrap());
    *stage.world().resource_mut::<SolverSettings>() = settings;
    stage.world().insert_resource(changed("iterations=4"));
    stage.frames(60);
    assert_eq!(distance(&mut stage), Some(0.0), "four sweeps are what the settings have");
    stage.world().insert_resource(changed("iterations=40"));
    stage.frames(60);
    let apart = distance(&mut stage).unwrap();
    assert!(apart > 1e-3 && apart < 5.0, "{apart} m apart");
    // A start later the ghost has the settings of then.
    stage.world().resource_mut::<SolverSettings>().iterations = 40;
    stage.act(SandboxAction::Reset);
    stage.frames(60);
    assert_eq!(distance(&mut stage), Some(0.0));
}

#[test]
fn the_panel_changes_one_thing_in_the_ghost_and_says_what_it_cannot() {
    let mut stage = open("chain");
    *stage.world().resource_mut::<SolverSettings>() = SolverSettings::classic();
    open_eyes(&mut stage);
    click_on(&mut stage, "Ghost", "");
    click_on(&mut stage, "none", "Ghost");
    // The last of the list, which is longer than its window.
    let list = seen(&mut stage, "game f32", "Ghost");
    point_at(&mut stage, list);
    (0..5).for_each(|_| stage.wheel(-10.0));
    stage.frames(30);
    click_on(&mut stage, "these settings, but for", "Ghost");
    click_on(&mut stage, "…", "Ghost");
    click_on(&mut stage, "iterations", "Ghost");
    let changed = |text: &str| GhostChoice::Changed(Assignment::parse(text, None).unwrap());
    assert_eq!(*stage.world().resource::<GhostChoice>(), changed("iterations=16"), "another value is suggested");
    stage.frames(60);
    assert!(distance(&mut stage).unwrap() > 1e-3);

    rewrite(&mut stage, "16", "Ghost", "0");
    assert!(reads(&mut stage, "iterations: 0 is out of range, must be at least 1"));
    assert_eq!(*stage.world().resource::<GhostChoice>(), changed("iterations=16"));
    rewrite(&mut stage, "0", "Ghost", "4");
    assert_eq!(*stage.world().resource::<GhostChoice>(), changed("iterations=4"));
    stage.frames(60);
    assert_eq!(distance(&mut stage), Some(0.0), "four sweeps are what the settings have");
}

#[test]
fn the_reference_answer_shows_how_far_off_a_method_is() {
    let mut stage = open("pendulum");
    stage.world().insert_resource(GhostChoice::Reference);
    stage.frames(30);
    let apart = distance(&mut stage).unwrap();
    assert!(apart > 0.0 && apart < 0.05, "{apart} m apart");
    // A rest position is its own answer; its motion is what the ghost tells.
    // At fitted effort there would be next to none.
    let mut stage = open("stack");
    stage.world().resource_mut::<SolverSettings>().impulse.fitted_effort = false;
    stage.world().insert_resource(GhostChoice::Reference);
    stage.frames(30);
    let top = stage.position("cube 9");
    let fallen = 9.5 - top.y;
    assert!(fallen > 1e-3 && (distance(&mut stage).unwrap() - fallen).abs() < 0.2 * fallen, "{fallen} m");
}

/// At the start, every answer has every body where the scene has it.
#[test]
fn reference_poses_begin_at_the_start() {
    for info in plumb::scene::catalog() {
        let scene = info.make(&info.defaults()).unwrap();
        let Some(poses) = truth::poses(&scene) else { continue };
        for (index, position, rotation) in poses(0.0) {
            let body = &scene.bodies[index];
            assert!(body.position.distance(position) < 1e-12, "{}: {}", scene.name, body.name);
            assert!(body.principal_rotation().dot(rotation).abs() > 1.0 - 1e-12, "{}: {}", scene.name, body.name);
        }
    }
}

/// Derivatives of the reference poses are the velocities that the scene starts with.
#[test]
fn reference_poses_move_as_the_scene_starts() {
    let h = 1e-6;
    for name in ["pendulum", "heavy_top", "incline", "bounce"] {
        let info = plumb::scene::find(name).unwrap();
        let scene = info.make(&info.defaults()).unwrap();
        let poses = truth::poses(&scene).unwrap();
        for ((index, start, from), (_, later, to)) in poses(0.0).into_iter().zip(poses(h)) {
            let body = &scene.bodies[index];
            let linear = (later - start) / h;
            let angular = (to * from.inverse()).to_scaled_axis() / h;
            // Accelerations are some tens of m/s² and thousands of rad/s².
            assert!(linear.distance(body.linear_velocity) < 1e-4, "{name}: {linear}");
            assert!(angular.distance(body.angular_velocity) < 1e-2, "{name}: {angular}");
        }
    }
}

#[test]
fn deleting_a_body_leaves_its_ghost_harmless() {
    let mut stage = open("pendulum");
    stage.world().insert_resource(GhostChoice::Method(0));
    stage.frames(5);
    let rod = stage.world().resource::<CurrentScene>().entities.bodies.clone();
    for body in rod {
        stage.world().despawn(body);
    }
    stage.frames(10);
    let world = stage.world();
    assert_eq!(world.query::<&Position>().iter(world).count(), 0);
    stage.act(SandboxAction::Reset);
    stage.frames(5);
    assert_eq!(distance(&mut stage), Some(0.0));
}
