//! What was undone comes again.

use bevy::prelude::*;
use plumb::lab::state_hash;
use plumb::physics::{BallJoint, History, StepStats};
use plumb::sandbox::{CurrentScene, Notice, Page, Playback, SandboxAction, Selection};

use crate::eyes::{click_on, open_eyes, reads};
use crate::stage::Stage;

/// A box that has fallen and a ball that hangs, over a ground on which things are added.
const SCENE: &str = r#"(
    bodies: [
        (name: "ground", kind: Static, shape: HalfSpace, position: (0, -1, 0)),
        (name: "box", shape: Cuboid(size: (1, 1, 1)), mass: 10, position: (-1.5, -0.4, 0)),
        (name: "bob", shape: Sphere(radius: 0.5), mass: 10, position: (2, 1, 0)),
    ],
    joints: [(body_a: "world", body_b: "bob", at: (1, 2, 0))],
    view: (eye: (0, 0, 10), target: (0, 0, 0)),
)"#;

fn step(stage: &mut Stage) -> u64 {
    stage.world().resource::<StepStats>().steps
}

fn last(stage: &mut Stage) -> u64 {
    stage.world().resource::<History>().reach()[1]
}

fn hash(stage: &mut Stage) -> u64 {
    // With what was done since the last step.
    History::take_in(stage.world());
    state_hash(stage.world())
}

fn named(stage: &mut Stage, name: &str) -> Option<Entity> {
    let world = stage.world();
    let mut names = world.query::<(Entity, &Name)>();
    names.iter(world).find(|(_, found)| found.as_str() == name).map(|(entity, _)| entity)
}

fn joints(stage: &mut Stage) -> usize {
    let world = stage.world();
    world.query::<&BallJoint>().iter(world).count()
}

/// At once.
fn pause(stage: &mut Stage, paused: bool) {
    stage.world().resource_mut::<Playback>().paused = paused;
    let mut time = stage.world().resource_mut::<Time<Virtual>>();
    if paused { time.pause() } else { time.unpause() }
}

/// So many steps on, and stands still there. The state after each.
fn play(stage: &mut Stage, steps: u64) -> Vec<u64> {
    let mut hashes = Vec::new();
    for _ in 0..steps {
        stage.act(SandboxAction::StepOnce);
        hashes.push(state_hash(stage.world()));
    }
    hashes
}

/// Adds a box where nothing is yet.
fn add(stage: &mut Stage, x: f32) {
    stage.move_to(Vec2::new(x, 420.0));
    stage.key(KeyCode::KeyA);
}

fn delete(stage: &mut Stage, name: &str) {
    let body = named(stage, name).expect(name);
    stage.world().insert_resource(Selection::of(body));
    stage.tap(KeyCode::Delete);
}

fn undo(stage: &mut Stage) {
    stage.key_with_control(KeyCode::KeyZ);
}

fn redo(stage: &mut Stage) {
    stage.hold(KeyCode::ShiftLeft);
    stage.key_with_control(KeyCode::KeyZ);
    stage.let_go(KeyCode::ShiftLeft);
}

fn said(stage: &mut Stage) -> String {
    match stage.world().resource::<Notice>().clone() {
        Notice::None => String::new(),
        Notice::Info(text) | Notice::Error(text) => text,
    }
}

/// The scene at rest, paused, with a box that was added and has come to lie on the ground.
fn built() -> Stage {
    let mut stage = Stage::open(SCENE);
    pause(&mut stage, true);
    play(&mut stage, 10);
    add(&mut stage, 640.0);
    assert!(named(&mut stage, "box 2").is_some(), "{}", said(&mut stage));
    play(&mut stage, 30);
    stage
}

#[test]
fn what_was_undone_comes_again_to_the_last_bit() {
    let mut stage = built();
    delete(&mut stage, "bob");
    let (at, before) = (step(&mut stage), hash(&mut stage));
    let on = play(&mut stage, 20);
    stage.act(SandboxAction::GoTo { step: at });
    assert_eq!(hash(&mut stage), before);
    stage.tap(KeyCode::End);
    // At the last moment, where nothing is to come that would come otherwise.
    let (at, before) = (step(&mut stage), hash(&mut stage));
    undo(&mut stage);
    assert!(named(&mut stage, "bob").is_some());
    undo(&mut stage);
    assert!(named(&mut stage, "box 2").is_none());
    assert_ne!(hash(&mut stage), before);
    redo(&mut stage);
    assert_eq!(said(&mut stage), "redid adding box 2");
    stage.key_with_control(KeyCode::KeyY);
    assert_eq!(said(&mut stage), "redid deleting bob");
    assert_eq!((step(&mut stage), hash(&mut stage)), (at, before));
    assert_eq!((named(&mut stage, "bob"), joints(&mut stage)), (None, 0));
    assert!(named(&mut stage, "box 2").is_some());
    redo(&mut stage);
    assert_eq!(said(&mut stage), "nothing to redo");

    // Undone and done again once more, it goes on as it would have.
    let without = play(&mut stage, 20);
    stage.act(SandboxAction::GoTo { step: at });
    undo(&mut stage);
    redo(&mut stage);
    assert_eq!(last(&mut stage), at + 20, "what was to come is again");
    assert_eq!(play(&mut stage, 20), without);
    assert_eq!(on.len(), 20);
    stage.replays();
}

#[test]
fn while_time_goes_on_what_was_undone_comes_again_at_the_moment_on_view() {
    let mut stage = built();
    let added = named(&mut stage, "box 2");
    delete(&mut stage, "bob");
    play(&mut stage, 5);
    undo(&mut stage);
    undo(&mut stage);
    let bob = named(&mut stage, "bob");
    pause(&mut stage, false);
    stage.frames(20);
    let at = step(&mut stage);
    redo(&mut stage);
    stage.frames(5);
    redo(&mut stage);
    assert_eq!(said(&mut stage), "redid deleting bob");
    assert!(step(&mut stage) > at, "time goes on");
    assert_eq!(named(&mut stage, "box 2"), added, "the same entity");
    assert_eq!((named(&mut stage, "bob"), joints(&mut stage)), (None, 0));
    stage.frames(10);
    undo(&mut stage);
    assert_eq!((named(&mut stage, "bob"), joints(&mut stage)), (bob, 1));
    undo(&mut stage);
    assert!(named(&mut stage, "box 2").is_none());
    stage.frames(10);
    stage.replays();
}

#[test]
fn a_new_deed_ends_what_could_be_redone() {
    let mut stage = built();
    undo(&mut stage);
    add(&mut stage, 600.0);
    redo(&mut stage);
    assert_eq!(said(&mut stage), "nothing to redo");
    // And so does a reset.
    undo(&mut stage);
    stage.act(SandboxAction::Reset);
    redo(&mut stage);
    assert_eq!(said(&mut stage), "nothing to redo");
}

#[test]
fn what_was_undone_later_than_the_moment_on_view_is_not_undone_there() {
    let mut stage = built();
    let added = step(&mut stage) - 30;
    undo(&mut stage);
    let undone = step(&mut stage);
    play(&mut stage, 10);
    stage.act(SandboxAction::GoTo { step: added + 5 });
    assert!(named(&mut stage, "box 2").is_some());
    redo(&mut stage);
    assert_eq!(said(&mut stage), "nothing to redo");
    stage.tap(KeyCode::End);
    assert!(named(&mut stage, "box 2").is_none());
    redo(&mut stage);
    assert!(named(&mut stage, "box 2").is_some());
    // Another box later, this one is undone in the past: that ends what was to come, and redo has it come.
    play(&mut stage, 10);
    add(&mut stage, 500.0);
    play(&mut stage, 10);
    let (end, before) = (step(&mut stage), hash(&mut stage));
    stage.act(SandboxAction::GoTo { step: undone + 15 });
    undo(&mut stage);
    assert_eq!(last(&mut stage), undone + 15);
    redo(&mut stage);
    assert_eq!((step(&mut stage), last(&mut stage)), (undone + 15, end));
    stage.tap(KeyCode::End);
    assert_eq!(hash(&mut stage), before);
    undo(&mut stage);
    assert_eq!(said(&mut stage), "undid adding box 3");
    assert!(named(&mut stage, "box 3").is_none() && named(&mut stage, "box 2").is_some());
}

#[test]
fn what_was_done_in_the_past_and_what_was_to_come_change_places() {
    let mut stage = built();
    let end = (step(&mut stage), hash(&mut stage));
    stage.act(SandboxAction::GoTo { step: end.0 - 10 });
    stage.act(SandboxAction::ThrowBall);
    play(&mut stage, 5);
    add(&mut stage, 500.0);
    play(&mut stage, 20);
    let otherwise = (step(&mut stage), hash(&mut stage));
    undo(&mut stage);
    assert!(named(&mut stage, "box 3").is_none() && named(&mut stage, "thrown ball").is_some());
    undo(&mut stage);
    assert!(named(&mut stage, "thrown ball").is_none());
    undo(&mut stage);
    assert_eq!((step(&mut stage), last(&mut stage)), (end.0 - 10, end.0));
    stage.tap(KeyCode::End);
    assert_eq!((step(&mut stage), hash(&mut stage)), end);
    for again in 0..2 {
        redo(&mut stage);
        assert_eq!(said(&mut stage), "redid what was done in the past");
        assert!(named(&mut stage, "thrown ball").is_none() && named(&mut stage, "box 3").is_none());
        redo(&mut stage);
        assert!(named(&mut stage, "thrown ball").is_some() && named(&mut stage, "box 3").is_none());
        redo(&mut stage);
        assert_eq!((step(&mut stage), hash(&mut stage)), otherwise, "time {again}");
        redo(&mut stage);
        assert_eq!(said(&mut stage), "nothing to redo");
        undo(&mut stage);
        undo(&mut stage);
        undo(&mut stage);
        stage.tap(KeyCode::End);
        assert_eq!((step(&mut stage), hash(&mut stage)), end, "time {again}");
    }
    redo(&mut stage);
    redo(&mut stage);
    redo(&mut stage);
    stage.replays();
}

#[test]
fn a_scene_that_was_left_for_another_is_left_again() {
    let mut stage = built();
    stage.act(SandboxAction::LoadScene { scene: "pendulum".into(), parameters: Vec::new() });
    let on_view = |stage: &mut Stage| stage.world().resource::<CurrentScene>().scene.clone();
    play(&mut stage, 5);
    undo(&mut stage);
    assert!(on_view(&mut stage) != "pendulum" && named(&mut stage, "box 2").is_some());
    redo(&mut stage);
    assert!(on_view(&mut stage) == "pendulum" && named(&mut stage, "box 2").is_none(), "{}", said(&mut stage));
    play(&mut stage, 5);
    undo(&mut stage);
    assert!(on_view(&mut stage) != "pendulum" && named(&mut stage, "box 2").is_some());
    play(&mut stage, 5);
    stage.replays();
}

#[test]
fn the_panel_names_what_comes_again() {
    let mut stage = built();
    undo(&mut stage);
    open_eyes(&mut stage, Page::Build);
    assert!(reads(&mut stage, "Redo adding box 2"));
    click_on(&mut stage, "⮫ Redo adding box 2", "Build");
    assert!(named(&mut stage, "box 2").is_some());
    assert!(reads(&mut stage, "Undo adding box 2") && !reads(&mut stage, "Redo adding box 2"));
}
