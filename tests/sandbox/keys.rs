//! Keys do what the help says.

use std::collections::HashSet;

use bevy::prelude::*;
use plumb::physics::RigidBody;
use plumb::sandbox::controls::{BINDINGS, Binding};
use plumb::sandbox::{Notice, Playback, SandboxAction};

use crate::stage::Stage;

const BALL: &str = r#"(bodies: [(name: "ball", shape: Sphere(radius: 0.3))])"#;

/// What was written since the last look.
#[derive(Resource, Default)]
struct Written(Vec<SandboxAction>);

#[test]
fn every_key_writes_its_action_once() {
    let mut stage = Stage::open(BALL);
    stage.app.init_resource::<Written>().add_systems(
        Last,
        |mut actions: MessageReader<SandboxAction>, mut written: ResMut<Written>| {
            written.0.extend(actions.read().cloned());
        },
    );
    stage.frames(2);
    stage.world().resource_mut::<Written>().0.clear();
    for binding in BINDINGS {
        for &key in binding.keys {
            for (control, shift) in [(false, false), (true, false), (false, true), (true, true)] {
                if shift {
                    stage.hold(KeyCode::ShiftLeft);
                }
                if control {
                    stage.key_with_control(key)
                } else {
                    stage.key(key)
                }
                if shift {
                    stage.let_go(KeyCode::ShiftLeft);
                }
                let written = std::mem::take(&mut stage.world().resource_mut::<Written>().0);
                let bound = |with_shift: bool| {
                    BINDINGS.iter().find(|other| {
                        other.with_control == control && other.with_shift == with_shift && other.keys.contains(&key)
                    })
                };
                let expected = bound(shift).or_else(|| bound(false)).map(|binding| binding.action.clone());
                remove_recording(&mut stage);
                assert_eq!(written, Vec::from_iter(expected), "{key:?}, Ctrl {control}, Shift {shift}");
            }
        }
    }
}

#[test]
fn no_two_actions_share_a_key() {
    let mut seen = HashSet::new();
    let pressed =
        |binding: &'static Binding| binding.keys.iter().map(|key| (key, binding.with_control, binding.with_shift));
    for pressed in BINDINGS.iter().flat_map(pressed) {
        assert!(seen.insert(pressed), "{pressed:?} is bound twice");
    }
}

/// The file that Ctrl+R has just written.
fn remove_recording(stage: &mut Stage) {
    if let Notice::Info(said) = stage.world().resource::<Notice>()
        && let Some(path) = said.strip_prefix("recorded ").and_then(|rest| rest.split(" steps to ").nth(1))
    {
        std::fs::remove_file(path.rsplit_once(", ").expect("a size after it").0).unwrap();
        stage.world().insert_resource(Notice::None);
    }
}

#[test]
fn space_pauses_but_not_while_typing() {
    let mut stage = Stage::open(BALL);
    stage.key(KeyCode::Space);
    assert!(stage.world().resource::<Playback>().paused);
    stage.key(KeyCode::Space);
    assert!(!stage.world().resource::<Playback>().paused);

    stage.type_into_a_form();
    stage.key(KeyCode::Space);
    assert!(!stage.world().resource::<Playback>().paused, "the key went to the text field");
}

#[test]
fn a_key_that_is_pressed_and_let_go_within_a_frame_acts() {
    let mut stage = Stage::open(BALL);
    stage.tap(KeyCode::Space);
    assert!(stage.world().resource::<Playback>().paused);
}

#[test]
fn ctrl_and_a_key_within_a_frame_act_as_both() {
    let mut stage = Stage::open(BALL);
    stage.act(SandboxAction::SpawnBody);
    let bodies = |stage: &mut Stage| {
        let world = stage.world();
        world.query::<&RigidBody>().iter(world).count()
    };
    assert_eq!(bodies(&mut stage), 2);
    stage.tap_together(&[KeyCode::ControlLeft, KeyCode::KeyZ]);
    assert_eq!(bodies(&mut stage), 1);
    // Without Ctrl again: Z alone undoes nothing, and A adds.
    stage.tap(KeyCode::KeyA);
    stage.tap(KeyCode::KeyZ);
    assert_eq!(bodies(&mut stage), 2);
}
