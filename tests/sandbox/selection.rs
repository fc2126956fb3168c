//! What is picked: several bodies by a box or with Shift held, and a joint by a click on it.

use bevy::math::DVec3;
use bevy::prelude::*;
use plumb::physics::{BallJoint, HingeJoint, RigidBody};
use plumb::sandbox::{Notice, Page, SandboxAction, Selection, Tool};

use crate::eyes::{open_eyes, reads};
use crate::stage::Stage;

/// Three boxes side by side and a bar that hangs on the last by a hinge, looked at along -z.
const SCENE: &str = r#"(
    bodies: [
        (name: "ground", kind: Static, shape: HalfSpace),
        (name: "a", shape: Cuboid(size: (0.8, 0.8, 0.8)), position: (-3, 0.4, 0)),
        (name: "b", shape: Cuboid(size: (0.8, 0.8, 0.8)), position: (-1.5, 0.4, 0)),
        (name: "c", shape: Cuboid(size: (0.8, 0.8, 0.8)), position: (1, 0.4, 0)),
        (name: "bar", shape: Cuboid(size: (2, 0.2, 0.2)), position: (2.4, 0.4, 0)),
    ],
    joints: [(body_a: "c", body_b: "bar", kind: Hinge, at: (1.4, 0.4, 0), axis: (0, 0, 1))],
    view: (eye: (0, 2, 12), target: (0, 1.5, 0)),
)"#;

fn open() -> Stage {
    Stage::open_paused(SCENE)
}

/// Presses at a place, goes to another, and lets go there.
fn stroke(stage: &mut Stage, from: Vec2, to: Vec2) {
    stage.jump_to(from);
    stage.frames(2);
    stage.press();
    stage.jump_to(to);
    stage.frames(2);
    stage.release();
    stage.frames(2);
}

/// A box around points of the world, a little larger.
fn box_around(stage: &mut Stage, points: &[DVec3]) {
    let seen: Vec<Vec2> = points.iter().map(|point| stage.seen_at(*point)).collect();
    let bounds = seen.iter().fold(Rect::from_corners(seen[0], seen[0]), |rect, point| rect.union_point(*point));
    stroke(stage, bounds.min - 45.0, bounds.max + 45.0);
}

fn picked(stage: &mut Stage) -> Vec<String> {
    let bodies: Vec<Entity> = stage.world().resource::<Selection>().bodies().collect();
    let mut names: Vec<String> =
        bodies.into_iter().map(|body| stage.world().get::<Name>(body).expect("a name").to_string()).collect();
    names.sort();
    names
}

fn count<C: Component>(stage: &mut Stage) -> usize {
    let world = stage.world();
    world.query::<&C>().iter(world).count()
}

#[test]
fn a_box_picks_what_has_its_centre_in_it() {
    for tool in [Tool::Drag, Tool::Move] {
        let mut stage = open();
        stage.act(SandboxAction::ChooseTool(tool));
        let [a, b, c] = ["a", "b", "c"].map(|name| stage.position(name));
        box_around(&mut stage, &[a, b]);
        assert_eq!(picked(&mut stage), ["a", "b"], "{tool:?}");
        // With Shift it adds, without it begins anew.
        stage.hold(KeyCode::ShiftLeft);
        box_around(&mut stage, &[c]);
        stage.let_go(KeyCode::ShiftLeft);
        assert_eq!(picked(&mut stage), ["a", "b", "c"], "{tool:?}");
        box_around(&mut stage, &[b]);
        assert_eq!(picked(&mut stage), ["b"], "{tool:?}");
        // A click beside all picks none.
        let sky = stage.seen_at(DVec3::new(0.0, 3.0, 0.0));
        stroke(&mut stage, sky, sky);
        assert_eq!(picked(&mut stage), [""; 0], "{tool:?}");
    }
}

#[test]
fn all_that_is_picked_goes_and_comes_back_at_once() {
    let mut stage = open();
    stage.key_with_control(KeyCode::KeyA);
    assert_eq!(picked(&mut stage), ["a", "b", "bar", "c"], "all but the ground");
    stage.act(SandboxAction::DeletePicked);
    assert_eq!((count::<RigidBody>(&mut stage), count::<HingeJoint>(&mut stage)), (1, 0));
    stage.act(SandboxAction::Undo);
    assert_eq!((count::<RigidBody>(&mut stage), count::<HingeJoint>(&mut stage)), (5, 1));
    stage.act(SandboxAction::TogglePause);
    stage.frames(30);
    stage.replays();
}

#[test]
fn clicks_with_shift_pick_more_and_the_last_is_what_the_first_is_joined_to() {
    let mut stage = open();
    for (name, adds) in [("a", false), ("b", true), ("c", true)] {
        if adds {
            stage.hold(KeyCode::ShiftLeft);
        }
        let at = stage.position(name) + DVec3::Z * 0.4;
        let at = stage.seen_at(at);
        stroke(&mut stage, at, at);
        if adds {
            stage.let_go(KeyCode::ShiftLeft);
        }
    }
    assert_eq!(picked(&mut stage), ["a", "b", "c"]);
    let clicked: Vec<Entity> = stage.world().resource::<Selection>().picks().map(|picked| picked.entity).collect();
    assert_eq!(clicked, [stage.body("a"), stage.body("c")]);
    stage.act(SandboxAction::JoinPicked);
    assert_eq!(count::<BallJoint>(&mut stage), 1, "{:?}", stage.world().resource::<Notice>());
    // What is gone is picked no longer, and the others still are.
    stage.act(SandboxAction::Undo);
    let first = stage.body("a");
    stage.world().despawn(first);
    stage.frames(2);
    assert_eq!(picked(&mut stage), ["b", "c"]);
}

#[test]
fn a_click_on_a_joint_picks_it_and_a_drag_from_there_does_not() {
    let mut stage = open();
    let joint = {
        let world = stage.world();
        world.query_filtered::<Entity, With<HingeJoint>>().single(world).expect("one hinge")
    };
    let at = stage.seen_at(DVec3::new(1.4, 0.4, 0.0));
    // Nothing shows where it is: the click is one on the body.
    stroke(&mut stage, at, at);
    assert_eq!(stage.world().resource::<Selection>().joint, None);
    // A body that it holds is picked now, and its dot is there.
    stroke(&mut stage, at, at);
    assert_eq!(*stage.world().resource::<Selection>(), Selection::of_joint(joint));
    stage.jump_to(Vec2::new(5.0, 5.0));
    open_eyes(&mut stage, Page::Play);
    stage.frames(5);
    assert!(reads(&mut stage, "hinge") && reads(&mut stage, "c to bar"), "it is inspected");
    assert!(reads(&mut stage, "breaks"), "with all that can be changed of it");
    // A press that moves drags the body.
    let place = stage.seen_at(DVec3::new(1.4, 0.4, 0.0));
    stroke(&mut stage, place, place - Vec2::Y * 60.0);
    let selection = stage.world().resource::<Selection>().clone();
    assert!(selection.joint.is_none() && selection.body.is_some(), "{selection:?}");
    // Deleting the picked joint cuts it; one that is gone is picked no longer.
    stage.act(SandboxAction::PickJoint(joint));
    stage.act(SandboxAction::DeletePicked);
    assert_eq!((count::<HingeJoint>(&mut stage), count::<RigidBody>(&mut stage)), (0, 5));
    assert_eq!(*stage.world().resource::<Selection>(), Selection::default());
    stage.act(SandboxAction::Undo);
    stage.act(SandboxAction::PickJoint(joint));
    stage.act(SandboxAction::Cut(joint));
    stage.frames(2);
    assert_eq!(*stage.world().resource::<Selection>(), Selection::default());
}
