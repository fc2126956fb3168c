//! Tools: what a press in the picture does with each, and what is drawn of it before.

use bevy::math::DVec3;
use bevy::prelude::*;
use plumb::physics::{BallJoint, Breakable, HingeJoint, JointMotor, MotorTarget, Position, RigidBody, Velocity};
use plumb::sandbox::{JoinKind, Notice, Page, SandboxAction, Selection, Tool, Tracks};

use crate::eyes::{click_on, open_eyes, reads, texts};
use crate::stage::Stage;

/// A box and a ball apart on the ground, looked at along -z.
const SCENE: &str = r#"(
    bodies: [
        (name: "ground", kind: Static, shape: HalfSpace),
        (name: "box", shape: Cuboid(size: (1, 1, 1)), mass: 10, position: (-2, 0.5, 0)),
        (name: "ball", shape: Sphere(radius: 0.5), mass: 10, position: (2, 0.5, 0)),
    ],
    view: (eye: (0, 2, 12), target: (0, 1.5, 0)),
)"#;

fn open() -> Stage {
    Stage::open_paused(SCENE)
}

/// Presses at a point of the world with a tool, moves to another, and lets go there.
fn use_tool(stage: &mut Stage, tool: Tool, from: DVec3, to: DVec3) {
    if *stage.world().resource::<Tool>() != tool {
        stage.act(SandboxAction::ChooseTool(tool));
    }
    for (point, is_press) in [(from, true), (to, false)] {
        let place = stage.seen_at(point);
        stage.jump_to(place);
        stage.frames(2);
        if is_press {
            stage.press()
        } else {
            stage.release()
        }
        stage.frames(2);
    }
}

fn click(stage: &mut Stage, tool: Tool, point: DVec3) {
    use_tool(stage, tool, point, point);
}

fn count<C: Component>(stage: &mut Stage) -> usize {
    let world = stage.world();
    world.query::<&C>().iter(world).count()
}

/// On the side of the box, of the ball and of the ground that one sees.
const ON_BOX: DVec3 = DVec3::new(-2.0, 0.5, 0.5);
const ON_BALL: DVec3 = DVec3::new(2.0, 0.5, 0.5);

#[test]
fn a_push_kicks_along_the_view_and_drags_nothing() {
    let mut stage = open();
    click(&mut stage, Tool::Push, ON_BOX);
    let body = stage.body("box");
    let velocity = *stage.world().get::<Velocity>(body).unwrap();
    assert!((velocity.linear.length() - 4.0).abs() < 1e-6 && velocity.linear.z < -3.5, "{velocity:?}");
    // Off its centre it turns: at the right side, to the left about y.
    click(&mut stage, Tool::Push, ON_BOX + DVec3::X * 0.4);
    let spin = stage.world().get::<Velocity>(body).unwrap().angular;
    assert!(spin.y > 1.0, "{spin}");
    click(&mut stage, Tool::Push, DVec3::new(0.0, 0.0, 1.0));
    let Notice::Error(said) = stage.world().resource::<Notice>() else { panic!("the ground is not pushed") };
    assert!(said.contains("does not move"), "{said}");
}

#[test]
fn each_click_throws_or_adds_one() {
    let mut stage = open();
    let before = count::<RigidBody>(&mut stage);
    click(&mut stage, Tool::Throw, DVec3::new(0.0, 2.0, 0.0));
    click(&mut stage, Tool::Add, DVec3::new(0.0, 0.0, 1.0));
    assert_eq!(count::<RigidBody>(&mut stage), before + 2);
    stage.act(SandboxAction::Undo);
    stage.act(SandboxAction::Undo);
    assert_eq!(count::<RigidBody>(&mut stage), before, "both can be undone");
}

#[test]
fn two_clicks_join_and_the_tool_stays_in_hand() {
    let mut stage = open();
    stage.world().insert_resource(JoinKind::Ball);
    click(&mut stage, Tool::Join, ON_BOX);
    assert_eq!(count::<BallJoint>(&mut stage), 0);
    click(&mut stage, Tool::Join, ON_BALL);
    assert_eq!(count::<BallJoint>(&mut stage), 1);
    assert_eq!(*stage.world().resource::<Selection>(), Selection::default());
    assert_eq!(*stage.world().resource::<Tool>(), Tool::Join);
    // A body to the ground, where the ground is clicked.
    click(&mut stage, Tool::Join, ON_BOX);
    click(&mut stage, Tool::Join, DVec3::new(-1.0, 0.0, 1.0));
    assert_eq!(count::<BallJoint>(&mut stage), 2);
    stage.act(SandboxAction::Escape);
    assert_eq!(*stage.world().resource::<Tool>(), Tool::Drag);
}

#[test]
fn a_pin_and_a_cut_are_a_click_each() {
    let mut stage = open();
    click(&mut stage, Tool::Pin, ON_BOX);
    assert_eq!(count::<BallJoint>(&mut stage), 1);
    click(&mut stage, Tool::Cut, ON_BOX);
    assert_eq!(count::<BallJoint>(&mut stage), 0);
}

#[test]
fn a_tape_is_two_clicks() {
    let mut stage = open();
    click(&mut stage, Tool::Measure, ON_BOX);
    click(&mut stage, Tool::Measure, ON_BALL);
    assert_eq!(stage.world().resource::<Tracks>().tracks.len(), 1);
}

/// Three bars between two points of the ground: a motor at the first turns all of them, and nothing parts.
#[test]
fn a_four_bar_is_three_strokes() {
    let mut stage = open();
    let corners =
        [DVec3::new(-0.6, 0.0, 2.0), DVec3::new(-0.6, 0.7, 2.0), DVec3::new(0.8, 1.2, 2.0), DVec3::new(0.8, 0.0, 2.0)];
    for ends in corners.windows(2) {
        use_tool(&mut stage, Tool::Bar, ends[0], ends[1]);
    }
    let world = stage.world();
    let hinges: Vec<(Entity, HingeJoint)> =
        world.query::<(Entity, &HingeJoint)>().iter(world).map(|(entity, hinge)| (entity, *hinge)).collect();
    assert_eq!(hinges.len(), 4, "two to the ground, two between bars");
    let at = |world: &World, body: Entity| world.get::<Position>(body).unwrap().0;
    let is_crank = |(_, hinge): &&(Entity, HingeJoint)| {
        at(world, hinge.body_b).abs_diff_eq(DVec3::new(-0.6, 0.35, 2.0), 0.05) && at(world, hinge.body_a) == DVec3::ZERO
    };
    let &(motor, HingeJoint { body_b: crank, .. }) = hinges.iter().find(is_crank).expect("a crank on the ground");
    let before = at(world, crank);
    world.entity_mut(motor).insert(JointMotor::new(MotorTarget::Speed(2.0)).with_max_force(1e4));
    stage.act(SandboxAction::TogglePause);
    stage.frames(30);
    let world = stage.world();
    let after = at(world, crank);
    assert!(after.distance(before) > 0.1 && (after.z - 2.0).abs() < 0.01, "{before} to {after}");
    let ends = |hinge: &HingeJoint| {
        [(hinge.body_a, hinge.anchor_a), (hinge.body_b, hinge.anchor_b)]
            .map(|(body, anchor)| at(world, body) + world.get::<plumb::physics::Rotation>(body).unwrap().0 * anchor)
    };
    for (_, hinge) in &hinges {
        let [a, b] = ends(hinge);
        assert!(a.distance(b) < 1e-3, "a hinge parts by {}", a.distance(b));
    }
}

/// Ten clicks and strokes: pause, take the bar in hand, three strokes, plot, motor, strength, play.
#[test]
fn a_motorised_breakable_four_bar_with_a_plot_of_its_load_takes_ten_clicks() {
    let mut stage = open(); // the first: pause
    let corners =
        [DVec3::new(0.8, 0.0, 2.0), DVec3::new(0.8, 1.2, 2.0), DVec3::new(-0.6, 0.7, 2.0), DVec3::new(-0.6, 0.0, 2.0)];
    for ends in corners.windows(2) {
        use_tool(&mut stage, Tool::Bar, ends[0], ends[1]);
    }
    stage.jump_to(Vec2::new(5.0, 5.0));
    open_eyes(&mut stage, Page::Play);
    stage.frames(30);
    for part in ["plot", "motor", "breaks"] {
        click_on(&mut stage, part, "hinge to ground");
    }
    let world = stage.world();
    let motors: Vec<&HingeJoint> =
        world.query_filtered::<&HingeJoint, (With<JointMotor>, With<Breakable>)>().iter(world).collect();
    assert_eq!(motors.len(), 1);
    stage.act(SandboxAction::TogglePause);
    stage.frames(60);
    assert!(reads(&mut stage, "joint force, N"), "its load is plotted");
    assert!(!texts(&mut stage).iter().any(|(text, _)| text == "force –"), "and known");
}

#[test]
fn a_stroke_that_goes_nowhere_makes_nothing() {
    let mut stage = open();
    let before = count::<RigidBody>(&mut stage);
    click(&mut stage, Tool::Bar, DVec3::new(0.0, 0.0, 2.0));
    assert_eq!(count::<RigidBody>(&mut stage), before);
    assert!(matches!(stage.world().resource::<Notice>(), Notice::Error(_)));
}

#[test]
fn what_a_joint_will_join_is_said_and_not_any_more_with_another_tool() {
    let mut stage = open();
    let said = |stage: &mut Stage| match stage.world().resource::<Notice>() {
        Notice::Info(said) => said.clone(),
        _ => String::new(),
    };
    stage.world().insert_resource(JoinKind::Hinge);
    let ball = stage.body("ball");
    stage.world().insert_resource(Selection::of_bodies([ball]));
    stage.act(SandboxAction::ChooseTool(Tool::Join));
    let hint = said(&mut stage);
    assert!(hint.contains("joins ball") && hint.contains("axis"), "the body that is picked is the first: {hint}");
    stage.act(SandboxAction::ChooseTool(Tool::Push));
    assert_eq!(said(&mut stage), "");
    stage.world().insert_resource(Selection::default());
    stage.act(SandboxAction::ChooseTool(Tool::Join));
    assert_eq!(said(&mut stage), "");
    click(&mut stage, Tool::Join, ON_BOX);
    let hint = said(&mut stage);
    assert!(hint.contains("joins box"), "{hint}");
}
