//! Ghosts: a second method or the reference answer beside the scene.

use bevy::prelude::*;
use plumb::lab::truth;
use plumb::lab::vary::Assignment;
use plumb::physics::{Position, SolverSettings, StepStats};
use plumb::sandbox::{CurrentScene, GhostChoice, GhostReadings, Ghosts, Page, SandboxAction, Selection};

use crate::eyes::{click_on, open_eyes, point_at, reads, rewrite, seen};
use crate::stage::Stage;

fn open(scene: &str) -> Stage {
    let mut stage = Stage::open("(bodies: [])");
    stage.act(SandboxAction::LoadScene { scene: scene.to_owned(), parameters: Vec::new() });
    stage.frames(3);
    stage
}

/// Has one be the only ghost, and all begin anew.
fn from_the_start(stage: &mut Stage, choice: GhostChoice) {
    stage.world().insert_resource(Ghosts(vec![choice]));
    stage.act(SandboxAction::Reset);
}

fn distance(stage: &mut Stage) -> Option<f64> {
    stage.world().resource::<GhostReadings>().ghosts.first().map(|ghost| ghost.apart.distance)
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
    from_the_start(&mut stage, GhostChoice::Method(0));
    stage.frames(60);
    assert_eq!(distance(&mut stage), Some(0.0));
    assert_eq!(ghosts(&mut stage).len(), 11);
    stage.world().insert_resource(Ghosts::default());
    stage.frames(3);
    assert_eq!(distance(&mut stage), None);
    assert!(ghosts(&mut stage).is_empty());
}

#[test]
fn a_ghost_of_another_method_goes_its_own_way() {
    let mut stage = open("chain");
    from_the_start(&mut stage, GhostChoice::Method(1));
    stage.frames(60);
    let apart = distance(&mut stage).unwrap();
    assert!(apart > 1e-3 && apart < 5.0, "{apart} m apart");
}

#[test]
fn bodies_that_turn_apart_in_one_place_are_apart() {
    let mut stage = open("top");
    from_the_start(&mut stage, GhostChoice::Method(1));
    stage.frames(300);
    let [at, turned] = {
        let body = stage.world().resource::<CurrentScene>().entities.bodies[0];
        let pose = stage.world().get::<Transform>(body).unwrap();
        [pose.translation.length(), pose.rotation.to_axis_angle().1]
    };
    assert!(at < 1e-6 && turned > 0.0, "its centre stays where it is");
    let apart = stage.world().resource::<GhostReadings>().ghosts[0].apart;
    // Half the diagonal of the box, 0.59 m, turned by that angle at most.
    assert!(apart.angle > 0.01, "{apart:?}");
    assert!(apart.distance > 0.2 * apart.angle && apart.distance < 0.6 * apart.angle, "{apart:?}");
}

#[test]
fn a_ghost_at_another_rate_keeps_the_time() {
    let mut stage = open("pendulum");
    stage.world().resource_mut::<SolverSettings>().hz = 240.0;
    from_the_start(&mut stage, GhostChoice::Method(0));
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
    from_the_start(&mut stage, changed("iterations=4"));
    stage.frames(60);
    assert_eq!(distance(&mut stage), Some(0.0), "four sweeps are what the settings have");
    from_the_start(&mut stage, changed("iterations=40"));
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
    open_eyes(&mut stage, Page::Analyse);
    click_on(&mut stage, "Side by side", "");
    click_on(&mut stage, "none", "Side by side");
    // The last of the list, which is longer than its window.
    let list = seen(&mut stage, "game f32", "Side by side");
    point_at(&mut stage, list);
    (0..5).for_each(|_| stage.wheel(-10.0));
    stage.frames(30);
    click_on(&mut stage, "these settings, but for", "Side by side");
    click_on(&mut stage, "…", "Side by side");
    click_on(&mut stage, "iterations", "Side by side");
    let changed = |text: &str| GhostChoice::Changed(Assignment::parse(text, None).unwrap());
    assert_eq!(stage.world().resource::<Ghosts>().0, [changed("iterations=16")], "another value is suggested");
    stage.frames(60);
    assert!(distance(&mut stage).unwrap() > 1e-3);

    rewrite(&mut stage, "16", "Side by side", "0");
    assert!(reads(&mut stage, "iterations: 0 is out of range, must be at least 1"));
    assert_eq!(stage.world().resource::<Ghosts>().0, [changed("iterations=16")]);
    rewrite(&mut stage, "0", "Side by side", "4");
    assert_eq!(stage.world().resource::<Ghosts>().0, [changed("iterations=4")]);
    stage.frames(60);
    assert_eq!(distance(&mut stage), Some(0.0), "four sweeps are what the settings have");
}

#[test]
fn the_reference_answer_shows_how_far_off_a_method_is() {
    let mut stage = open("pendulum");
    from_the_start(&mut stage, GhostChoice::Reference);
    stage.frames(30);
    let apart = distance(&mut stage).unwrap();
    assert!(apart > 0.0 && apart < 0.05, "{apart} m apart");
    // A rest position is its own answer; its motion is what the ghost tells.
    // At fitted effort there would be next to none.
    let mut stage = open("stack");
    stage.world().resource_mut::<SolverSettings>().impulse.fitted_effort = false;
    from_the_start(&mut stage, GhostChoice::Reference);
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
    from_the_start(&mut stage, GhostChoice::Method(0));
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

fn act_frames(stage: &mut Stage, action: SandboxAction, frames: usize) {
    stage.act(action);
    stage.frames(frames);
}

fn step(stage: &mut Stage) -> u64 {
    stage.world().resource::<StepStats>().steps
}

fn parted(stage: &mut Stage) -> Vec<Option<u64>> {
    stage.world().resource::<GhostReadings>().ghosts.iter().map(|ghost| ghost.parted).collect()
}

/// What was thrown runs on too; who parts does so at the same step once more.
#[test]
fn ghosts_run_on_from_the_moment_on_view() {
    let mut stage = open("stack");
    stage.frames(30);
    stage.act(SandboxAction::ThrowBall);
    stage.frames(2);
    let [game, classic, accurate] = ["game f32", "classic f32", "accurate f64"]
        .map(|name| plumb::lab::chart::SERIES.iter().position(|series| series.name == name).unwrap());
    let start = step(&mut stage);
    stage.world().insert_resource(Ghosts([game, classic, accurate].map(GhostChoice::Method).to_vec()));
    stage.frames(1);
    let readings = stage.world().resource::<GhostReadings>().clone();
    assert!((readings.start * 60.0 - start as f64).abs() < 2.5, "{} s, step {start}", readings.start);
    assert!(readings.ghosts.iter().all(|ghost| ghost.apart.distance < 1e-3 && ghost.parted.is_none()), "{readings:?}");
    assert_eq!(ghosts(&mut stage).len(), 3 * 11, "ten cubes and the ball, three times");
    stage.frames(240);
    let first = parted(&mut stage);
    let there = first[1].expect("classic loses ten cubes that a ball hits");
    assert!(there > start && there < step(&mut stage), "{first:?}");
    let readings = stage.world().resource::<GhostReadings>().clone();
    for ghost in &readings.ghosts {
        let reading = ghost.reading.as_ref().unwrap();
        assert!(reading.step_seconds > 0.0 && reading.energy != 0.0, "{ghost:?}");
    }
    assert!(readings.scene.step_seconds > 0.0 && readings.scene.failed.is_none(), "{:?}", readings.scene);
    // What is gone back behind has not happened yet, and then does once more.
    let to = there - 1;
    act_frames(&mut stage, SandboxAction::GoTo { step: to }, 1);
    assert_eq!(parted(&mut stage)[1], None);
    act_frames(&mut stage, SandboxAction::StepOnce, 1);
    assert_eq!(parted(&mut stage)[1], Some(there));
    // From here on by others, which have not parted.
    stage.world().insert_resource(Ghosts(vec![GhostChoice::Method(classic)]));
    act_frames(&mut stage, SandboxAction::StepOnce, 1);
    assert_eq!(parted(&mut stage), [None]);
    assert_eq!(ghosts(&mut stage).len(), 11);
}

#[test]
fn who_fails_and_when_is_told() {
    let mut stage = open("sandwich");
    let classic = plumb::lab::chart::SERIES.iter().position(|series| series.name == "classic f32").unwrap();
    from_the_start(&mut stage, GhostChoice::Method(classic));
    stage.frames(300);
    let readings = stage.world().resource::<GhostReadings>().clone();
    assert_eq!(readings.scene.failed, None, "game holds it");
    let failed = readings.ghosts[0].reading.as_ref().unwrap().failed.clone();
    let (time, why) = failed.expect("classic does not hold 1000 kg on 1 kg");
    assert!(time > 0.0 && time < 5.0 && why.contains("overlap"), "{time} s: {why}");
    open_eyes(&mut stage, Page::Analyse);
    click_on(&mut stage, "Side by side", "");
    stage.frames(5);
    assert!(reads(&mut stage, &format!("at {time:.2} s")));
    assert!(reads(&mut stage, "apart at") && reads(&mut stage, "joint gap"));
}

/// It stands as it was left, and so do its ghosts.
#[test]
fn ghosts_begin_with_a_scene_that_came_back() {
    let mut stage = open("stack");
    stage.world().insert_resource(Ghosts(vec![GhostChoice::Method(0)]));
    let top = stage.body("cube 9");
    stage.world().insert_resource(Selection::of(top));
    stage.act(SandboxAction::DeletePicked);
    stage.act(SandboxAction::ThrowBall);
    stage.frames(30);
    stage.load("(bodies: [])");
    stage.frames(3);
    stage.act(SandboxAction::Undo);
    stage.frames(3);
    assert_eq!(ghosts(&mut stage).len(), 10, "nine cubes and the ball");
    assert!(distance(&mut stage).unwrap() < 1e-6);
}
