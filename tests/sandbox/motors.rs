//! Motors that keys drive.

use std::process::Command;

use bevy::prelude::*;
use plumb::physics::{HingeJoint, JointCoordinate, JointMotor, RigidBody};
use plumb::sandbox::{CurrentScene, Notice, SandboxAction};

use crate::stage::Stage;
use crate::startup::assert_one_line;

/// A wheel that two keys turn.
fn wheel(forward: &str, back: &str) -> String {
    format!(
        r#"(
    gravity: (0, 0, 0),
    bodies: [
        (name: "wall", kind: Static, shape: Cuboid(size: (1, 1, 1)), position: (0, 2, -1)),
        (name: "wheel", shape: Sphere(radius: 0.4), mass: 5, position: (0, 2, 0)),
    ],
    joints: [
        (body_a: "wall", body_b: "wheel", at: (0, 2, 0), kind: Hinge, axis: (0, 0, 1),
         motor: (target: Speed(0), keys: (forward: "{forward}", back: "{back}", values: (3, -2)))),
    ],
)"#
    )
}

/// rad/s.
fn rate(stage: &mut Stage) -> f64 {
    let world = stage.world();
    world.query::<&JointCoordinate>().single(world).expect("one hinge").rate
}

#[test]
fn a_motor_turns_while_its_key_is_held() {
    let mut stage = Stage::open(&wheel("ArrowUp", "ArrowDown"));
    for (key, expected) in [(KeyCode::ArrowUp, 3.0), (KeyCode::ArrowDown, -2.0)] {
        stage.hold(key);
        stage.frames(20);
        assert!((rate(&mut stage) - expected).abs() < 1e-3, "{key:?} held: {} rad/s", rate(&mut stage));
        stage.let_go(key);
        stage.frames(20);
        assert!(rate(&mut stage).abs() < 1e-3, "let go: {} rad/s", rate(&mut stage));
    }
    stage.hold(KeyCode::ArrowUp);
    stage.hold(KeyCode::ArrowDown);
    stage.frames(20);
    assert!(rate(&mut stage).abs() < 1e-3, "both held, they cancel: {} rad/s", rate(&mut stage));
}

#[test]
fn a_tap_drives_for_a_step() {
    let mut stage = Stage::open(&wheel("ArrowUp", "ArrowDown"));
    stage.frames(2);
    stage.tap(KeyCode::ArrowUp);
    assert!(rate(&mut stage) > 1.0, "{} rad/s", rate(&mut stage));
    stage.frames(20);
    assert!(rate(&mut stage).abs() < 1e-3, "{} rad/s", rate(&mut stage));
}

#[test]
fn a_motor_is_written_to_only_when_a_key_is_pressed_or_let_go() {
    #[derive(Resource, Default)]
    struct Writes(usize);
    let mut stage = Stage::open(&wheel("ArrowUp", "ArrowDown"));
    stage.frames(2);
    stage
        .app
        .init_resource::<Writes>()
        .add_systems(PostUpdate, |motors: Query<(), Changed<JointMotor>>, mut writes: ResMut<Writes>| {
            writes.0 += motors.iter().count()
        });
    stage.frames(1);
    stage.world().resource_mut::<Writes>().0 = 0;
    stage.hold(KeyCode::ArrowUp);
    stage.frames(10);
    stage.let_go(KeyCode::ArrowUp);
    stage.frames(10);
    assert_eq!(stage.world().resource::<Writes>().0, 2);
}

#[test]
fn a_key_that_drives_does_nothing_else_and_does_again_in_the_next_scene() {
    let bodies = |stage: &mut Stage| {
        let world = stage.world();
        world.query::<&RigidBody>().iter(world).count()
    };
    let mut stage = Stage::open(&wheel("KeyA", "KeyB"));
    stage.hold(KeyCode::KeyA);
    stage.frames(20);
    assert!((rate(&mut stage) - 3.0).abs() < 1e-3);
    stage.let_go(KeyCode::KeyA);
    assert_eq!(bodies(&mut stage), 2, "A adds no body here");

    stage.act(SandboxAction::Reset);
    stage.frames(1);
    stage.key(KeyCode::KeyB);
    assert_eq!(bodies(&mut stage), 2, "nor does B throw one after a reset");

    stage.load(&wheel("ArrowUp", "ArrowDown"));
    stage.frames(2);
    stage.key(KeyCode::KeyB);
    assert_eq!(bodies(&mut stage), 3, "where it drives nothing, it throws a ball");
}

#[test]
fn a_key_that_there_is_not_is_named_and_the_old_scene_stays() {
    let mut stage = Stage::open(&wheel("ArrowUp", "ArrowDown"));
    let before = stage.world().resource::<CurrentScene>().scene.clone();
    stage.load(&wheel("ArrowUp", "Down"));
    let Notice::Error(said) = stage.world().resource::<Notice>().clone() else { panic!("it was taken") };
    for words in ["joints[0]", "'wall' to 'wheel'", "'Down'", "ArrowUp"] {
        assert!(said.contains(words), "'{words}' in: {said}");
    }
    assert_eq!(said.lines().count(), 1);
    assert_eq!(stage.world().resource::<CurrentScene>().scene, before);
    let world = stage.world();
    assert_eq!(world.query::<&HingeJoint>().iter(world).count(), 1);
}

#[test]
fn the_world_goes_by_the_name_that_the_file_gives_it() {
    let mut stage = Stage::open(&wheel("ArrowUp", "ArrowDown"));
    stage.load(&wheel("ArrowUp", "Down").replace("body_a: \"wall\"", "body_a: \"world\""));
    let Notice::Error(said) = stage.world().resource::<Notice>().clone() else { panic!("it was taken") };
    assert!(said.contains("('world' to 'wheel')"), "{said}");
}

#[test]
fn on_the_command_line_it_is_said_before_any_window_opens() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("wheel.ron");
    std::fs::write(&path, wheel("ArrowUp", "Down")).unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_plumb")).arg(&path).output().unwrap();
    assert_one_line(&output, &["wheel.ron", "joints[0]", "'Down'", "ArrowUp"]);
}
