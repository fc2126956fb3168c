//! Copies: beside what is picked, and by way of the clipboard, as text of a scene file.

use bevy::math::DVec3;
use bevy::prelude::*;
use plumb::physics::{
    Breakable, Collider, HingeJoint, JointMotor, MotorTarget, PlacedCollider, Position, RigidBody, Rotation,
};
use plumb::sandbox::{Clipboard, Notice, Page, SandboxAction, Selection};
use plumb::scene::SceneSpec;

use crate::eyes::{open_eyes, text_with};
use crate::stage::Stage;

/// A crank on the ground with an arm on it, and a box beside them.
const SCENE: &str = r#"(
    bodies: [
        (name: "ground", kind: Static, shape: HalfSpace),
        (name: "crank", shape: Cuboid(size: (0.2, 1, 0.2)), position: (0, 1.5, 0), density: 700, color: (1, 0, 0)),
        (name: "arm 2", shape: Cuboid(size: (1, 0.2, 0.2)), position: (0.6, 2, 0)),
        (name: "box", shape: Cuboid(size: (0.5, 0.5, 0.5)), position: (3, 0.25, 0)),
    ],
    joints: [
        (body_a: "ground", body_b: "crank", kind: Hinge, at: (0, 1, 0), axis: (0, 0, 1)),
        (body_a: "crank", body_b: "arm 2", kind: Hinge, at: (0.1, 2, 0), axis: (0, 0, 1)),
        (body_a: "world", body_b: "box", at: (3, 2, 0)),
    ],
    view: (eye: (0, 2, 12), target: (0, 1.5, 0)),
)"#;

fn open() -> Stage {
    let mut stage = Stage::open_paused(SCENE);
    leave_picture(&mut stage);
    stage
}

/// The pointer is off the picture.
fn leave_picture(stage: &mut Stage) {
    let window = stage.window();
    stage.world().get_mut::<Window>(window).expect("a window").set_cursor_position(None);
    stage.frames(2);
}

fn pick(stage: &mut Stage, names: &[&str]) {
    let bodies: Vec<Entity> = names.iter().map(|name| stage.body(name)).collect();
    stage.world().insert_resource(Selection::of_bodies(bodies));
}

fn names(stage: &mut Stage) -> Vec<String> {
    let world = stage.world();
    let mut query = world.query_filtered::<&Name, With<RigidBody>>();
    let mut names: Vec<String> = query.iter(world).map(ToString::to_string).collect();
    names.sort();
    names
}

fn named(stage: &mut Stage, name: &str) -> Entity {
    let world = stage.world();
    let mut query = world.query_filtered::<(Entity, &Name), With<RigidBody>>();
    query.iter(world).find(|(_, found)| found.as_str() == name).map(|(entity, _)| entity).expect("a body of that name")
}

fn at(stage: &mut Stage, name: &str) -> DVec3 {
    let body = named(stage, name);
    stage.world().get::<Position>(body).expect("a pose").0
}

fn hinges(stage: &mut Stage) -> usize {
    let world = stage.world();
    world.query::<&HingeJoint>().iter(world).count()
}

fn said(stage: &mut Stage) -> String {
    match stage.world().resource::<Notice>() {
        Notice::Error(said) => said.clone(),
        other => panic!("no error: {other:?}"),
    }
}

/// The deepest that two bodies of these names overlap, m.
fn overlap(stage: &mut Stage, one: &str, other: &str) -> Option<f64> {
    let bodies = [one, other].map(|name| named(stage, name));
    let world = stage.world();
    let colliders = bodies.map(|body| world.get::<Collider>(body).expect("a shape").clone());
    let placed = [0, 1].map(|end| PlacedCollider {
        collider: &colliders[end],
        position: *world.get::<Position>(bodies[end]).expect("a pose"),
        rotation: *world.get::<Rotation>(bodies[end]).expect("a pose"),
    });
    placed[0].overlap(&placed[1])
}

#[test]
fn a_duplicate_has_the_joints_too_and_stands_beside_as_near_as_it_can() {
    let mut stage = open();
    let motor = {
        let world = stage.world();
        let mut query = world.query::<(Entity, &HingeJoint)>();
        let crank = query.iter(world).map(|(entity, _)| entity).min().expect("hinges");
        let parts = (JointMotor::new(MotorTarget::Speed(1.0)).with_max_force(50.0), Breakable::at_force(1e4));
        world.entity_mut(crank).insert(parts);
        crank
    };
    let before = names(&mut stage);
    pick(&mut stage, &["crank", "arm 2"]);
    stage.key_with_control(KeyCode::KeyD);
    let mut expected = before.clone();
    expected.extend(["crank 2", "arm 3", "world:pin"].map(str::to_owned));
    expected.sort();
    assert_eq!(names(&mut stage), expected);
    assert_eq!(hinges(&mut stage), 4);
    let way = at(&mut stage, "crank 2") - at(&mut stage, "crank");
    assert!(way.y == 0.0 && way.z == 0.0, "to the right: {way}");
    // From -0.1 to 1.1 they reach: with a gap of some hundredths, and no more.
    assert!(way.x > 1.2 && way.x < 1.26, "{way}");
    assert!((at(&mut stage, "arm 3") - at(&mut stage, "arm 2")).abs_diff_eq(way, 1e-12));
    assert!((at(&mut stage, "world:pin") - DVec3::new(0.0, 1.0, 0.0)).abs_diff_eq(way, 1e-12), "the pin comes along");
    for (one, other) in [("crank 2", "arm 2"), ("crank 2", "crank"), ("arm 3", "box")] {
        assert_eq!(overlap(&mut stage, one, other), None);
    }
    let picked: Vec<Entity> = stage.world().resource::<Selection>().bodies().collect();
    assert_eq!(picked, [named(&mut stage, "crank 2"), named(&mut stage, "arm 3")], "the copy is picked");
    let world = stage.world();
    let motors: Vec<(Entity, &JointMotor)> =
        world.query_filtered::<(Entity, &JointMotor), With<Breakable>>().iter(world).collect();
    assert_eq!(motors.len(), 2);
    assert_eq!(motors[0].1, motors[1].1);
    assert!(motors.iter().any(|(joint, _)| *joint != motor));
    // One deed.
    stage.act(SandboxAction::Undo);
    assert_eq!((names(&mut stage), hinges(&mut stage)), (before, 2));
    stage.act(SandboxAction::Redo);
    assert_eq!((names(&mut stage), hinges(&mut stage)), (expected, 4));
    stage.act(SandboxAction::TogglePause);
    stage.frames(60);
    stage.replays();
}

#[test]
fn a_duplicate_goes_on_beyond_what_is_in_its_way() {
    let mut stage = Stage::open(
        r#"(
            bodies: [
                (name: "ground", kind: Static, shape: HalfSpace),
                (name: "box", shape: Cuboid(size: (1, 1, 1)), position: (0, 0.5, 0)),
                (name: "next", shape: Cuboid(size: (1, 1, 1)), position: (1.3, 0.5, 0)),
            ],
            view: (eye: (0, 2, 12), target: (0, 1.5, 0)),
        )"#,
    );
    stage.act(SandboxAction::TogglePause);
    pick(&mut stage, &["box"]);
    stage.act(SandboxAction::Duplicate);
    let x = at(&mut stage, "box 2").x;
    assert!(x > 2.3 && x < 2.5, "{x}");
    assert!((at(&mut stage, "box 2").y - at(&mut stage, "box").y).abs() < 1e-12, "as high");
}

#[test]
fn what_is_copied_is_the_text_of_a_scene_and_can_be_pasted_anywhere() {
    let mut stage = open();
    pick(&mut stage, &["crank", "arm 2"]);
    stage.key_with_control(KeyCode::KeyC);
    let text = stage.world().resource_mut::<Clipboard>().get().expect("a text");
    let scene = SceneSpec::from_ron(&text, "copied").expect("a scene");
    assert_eq!((scene.bodies.len(), scene.joints.len()), (3, 2), "{text}");
    assert!(text.contains(r#"body_a: "world""#), "{text}");
    // Where something is by now that is in the way: beside it.
    stage.key_with_control(KeyCode::KeyV);
    let way = at(&mut stage, "crank 2") - at(&mut stage, "crank");
    assert!(way.x > 1.2 && way.x < 1.3 && way.y == 0.0, "{way}");
    // At the pointer, where it is on the picture; what hangs on the world keeps its height.
    let place = stage.seen_at(DVec3::new(-3.0, 0.0, 0.0));
    stage.jump_to(place);
    stage.frames(2);
    stage.act(SandboxAction::Paste);
    let [crank, arm] = ["crank 3", "arm 4"].map(|name| at(&mut stage, name));
    assert!((0.5 * (crank.x - 0.1 + arm.x + 0.5) + 3.0).abs() < 0.05, "{crank} {arm}");
    assert!((crank.y - at(&mut stage, "crank").y).abs() < 1e-12);
    // Into another scene.
    stage.load(r#"(bodies: [(name: "crank", shape: Sphere(radius: 0.3), position: (9, 0, 0))])"#);
    leave_picture(&mut stage);
    stage.act(SandboxAction::Paste);
    assert_eq!(names(&mut stage), ["arm 2", "crank", "crank 2", "world:pin"]);
    assert_eq!(at(&mut stage, "crank 2"), scene.bodies[0].position, "where it was, since nothing is there");
    assert_eq!(hinges(&mut stage), 2);
}

#[test]
fn what_is_cut_out_comes_back_where_it_was() {
    let mut stage = open();
    let before = names(&mut stage);
    let place = at(&mut stage, "box");
    pick(&mut stage, &["box"]);
    stage.key_with_control(KeyCode::KeyX);
    assert_eq!(names(&mut stage).len(), before.len() - 1);
    stage.key_with_control(KeyCode::KeyV);
    assert_eq!(at(&mut stage, "box"), place);
    assert_eq!(names(&mut stage).len(), before.len() + 1, "with what holds it to the world");
    stage.act(SandboxAction::Undo);
    stage.act(SandboxAction::Undo);
    assert_eq!(names(&mut stage), before);
}

#[test]
fn a_text_from_elsewhere_is_pasted_or_its_flaw_is_named() {
    let mut stage = open();
    let paste = |stage: &mut Stage, text: &str| {
        stage.world().resource_mut::<Clipboard>().set(text.to_owned());
        stage.act(SandboxAction::Paste);
    };
    // A whole scene with a ground of its own stands on this one.
    let bodies = names(&mut stage).len();
    let text = r#"(
        bodies: [
            (name: "ground", shape: HalfSpace),
            (name: "post", shape: Cuboid(size: (0.2, 1, 0.2)), position: (-5, 0.5, 0)),
        ],
        joints: [(body_a: "ground", body_b: "post", kind: Fixed, at: (-5, 0, 0))],
    )"#;
    paste(&mut stage, text);
    assert_eq!(names(&mut stage).len(), bodies + 2, "the post, and where it is fixed");
    let bodies = names(&mut stage);
    for (text, says) in [
        ("hello", "clipboard"),
        ("(\n    bodies: [(name: \"x\", shape: Sphere(radius: -1))],\n)", "2:48"),
        ("(\n    bodies: [(name: \"x\", shope: 3)],\n)", "2"),
        ("(bodies: [])", "without bodies"),
    ] {
        paste(&mut stage, text);
        let said = said(&mut stage);
        assert!(said.contains("cannot be pasted") && said.contains(says) && !said.contains('\n'), "{said}");
        assert_eq!(names(&mut stage), bodies);
    }
    stage.act(SandboxAction::Escape);
    for (action, says) in [(SandboxAction::Duplicate, "pick"), (SandboxAction::Copy, "pick")] {
        stage.act(action);
        assert!(said(&mut stage).contains(says));
    }
}

#[test]
fn keys_copy_nothing_while_somebody_types() {
    let mut stage = open();
    pick(&mut stage, &["box"]);
    let before = names(&mut stage);
    stage.type_into_a_form();
    for key in [KeyCode::KeyD, KeyCode::KeyC, KeyCode::KeyX, KeyCode::KeyV] {
        stage.key_with_control(key);
    }
    assert_eq!(names(&mut stage), before);
    assert_eq!(stage.world().resource_mut::<Clipboard>().get(), None);
}

#[test]
fn copies_that_no_step_has_seen_have_their_mass() {
    let mut stage = open();
    pick(&mut stage, &["crank", "arm 2"]);
    stage.act(SandboxAction::Duplicate);
    open_eyes(&mut stage, Page::Build);
    let told = text_with(&mut stage, "of what moves");
    assert_eq!(told.as_deref(), Some("68.0 kg of what moves"));
}
