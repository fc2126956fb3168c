//! Joints of every kind: made by two clicks, cut, deleted, changed, and all of it taken back.

use std::f64::consts::TAU;

use bevy::math::DVec3;
use bevy::prelude::*;
use plumb::physics::{
    BallJoint, Breakable, DistanceJoint, DistanceLaw, FixedJoint, GenericJoint, HingeJoint, JointCoordinate,
    JointFriction, JointLimits, JointMotor, MotorTarget, Position, Quarantined, Rotation, SliderJoint, Velocity,
};
use plumb::sandbox::{JoinKind, JointChange, Notice, SandboxAction, Selection};
use plumb::scene::MotorKeys;

use crate::stage::Stage;

/// Two blocks without weight, seen from in front.
const BLOCKS: &str = r#"(
    gravity: (0, 0, 0),
    bodies: [
        (name: "wall", kind: Static, shape: Cuboid(size: (1, 1, 1)), position: (-2, 2, 0)),
        (name: "block", shape: Cuboid(size: (1, 1, 1)), mass: 10, position: (0, 2, 0)),
    ],
    view: (eye: (-1, 2, 10), target: (-1, 2, 0)),
)"#;

/// Where the wall and the block are clicked, on their fronts.
const CLICKS: [DVec3; 2] = [DVec3::new(-1.8, 2.2, 0.5), DVec3::new(-0.3, 2.2, 0.5)];

fn click(stage: &mut Stage, place: DVec3) {
    let seen = stage.seen_at(place);
    stage.move_to(seen);
    stage.press();
    stage.release();
}

/// Joins the blocks of [`BLOCKS`] by hand, and gives the second a velocity.
fn joined(kind: JoinKind, velocity: Velocity) -> (Stage, Entity) {
    let mut stage = Stage::open(BLOCKS);
    stage.act(SandboxAction::TogglePause);
    stage.world().insert_resource(kind);
    click(&mut stage, CLICKS[0]);
    stage.hold(KeyCode::ShiftLeft);
    click(&mut stage, CLICKS[1]);
    stage.let_go(KeyCode::ShiftLeft);
    stage.key(KeyCode::KeyJ);
    let notice = stage.world().resource::<Notice>().clone();
    assert!(matches!(&notice, Notice::Info(text) if text.starts_with("joined wall to block")), "{notice:?}");
    let block = stage.body("block");
    *stage.world().get_mut::<Velocity>(block).unwrap() = velocity;
    stage.act(SandboxAction::TogglePause);
    stage.frames(60);
    let world = stage.world();
    assert_eq!(world.query::<&Quarantined>().iter(world).count(), 0);
    (stage, block)
}

fn moving(linear: DVec3, angular: DVec3) -> Velocity {
    Velocity { linear, angular }
}

/// The place of the block that was clicked, now.
fn clicked_place(stage: &mut Stage, block: Entity) -> DVec3 {
    let body = stage.world().entity(block);
    let point = CLICKS[1] - DVec3::new(0.0, 2.0, 0.0);
    body.get::<Position>().unwrap().0 + body.get::<Rotation>().unwrap().0 * point
}

fn only<C: Component + Copy>(stage: &mut Stage) -> C {
    let world = stage.world();
    *world.query::<&C>().single(world).expect("one joint of that kind")
}

#[test]
fn a_ball_joint_holds_a_point() {
    let (mut stage, block) = joined(JoinKind::Ball, moving(DVec3::ZERO, DVec3::new(1.0, 2.0, 3.0)));
    only::<BallJoint>(&mut stage);
    assert!(clicked_place(&mut stage, block).distance(CLICKS[1]) < 0.05);
    let spin = stage.world().get::<Velocity>(block).unwrap().angular;
    assert!(spin.x.abs() + spin.y.abs() > 0.1, "it turns any way: {spin}");
}

#[test]
fn a_hinge_turns_about_the_normal_of_the_face_that_was_hit() {
    let (mut stage, block) = joined(JoinKind::Hinge, moving(DVec3::ZERO, DVec3::new(1.0, 1.0, 2.0)));
    only::<HingeJoint>(&mut stage);
    let spin = stage.world().get::<Velocity>(block).unwrap().angular;
    assert!(spin.z > 0.5 && spin.x.abs() < 1e-3 && spin.y.abs() < 1e-3, "about z alone: {spin}");
    assert!(clicked_place(&mut stage, block).distance(CLICKS[1]) < 0.05);
    assert!(stage.position("block").distance(DVec3::new(0.0, 2.0, 0.0)) > 0.1, "round the place that was clicked");
}

#[test]
fn a_slider_slides_along_the_normal_of_the_face_that_was_hit() {
    let (mut stage, block) = joined(JoinKind::Slider, moving(DVec3::new(0.5, 0.5, 1.0), DVec3::splat(0.5)));
    only::<SliderJoint>(&mut stage);
    let Velocity { linear, angular } = *stage.world().get::<Velocity>(block).unwrap();
    assert!((linear.z - 1.0).abs() < 1e-3, "nothing holds it along z: {linear}");
    assert!(linear.x.abs() < 1e-3 && linear.y.abs() < 1e-3 && angular.length() < 1e-3, "{linear}, {angular}");
}

#[test]
fn a_fixed_joint_holds_all() {
    let (mut stage, block) = joined(JoinKind::Fixed, moving(DVec3::ONE, DVec3::ONE));
    only::<FixedJoint>(&mut stage);
    let Velocity { linear, angular } = *stage.world().get::<Velocity>(block).unwrap();
    assert!(linear.length() < 1e-3 && angular.length() < 1e-3, "{linear}, {angular}");
}

#[test]
fn rods_ropes_and_springs_join_the_two_places_that_were_clicked() {
    let apart = CLICKS[0].distance(CLICKS[1]);
    let towards = moving(DVec3::new(-0.2, 0.0, 0.0), DVec3::ZERO);
    for (kind, gap) in [(JoinKind::Rod, apart), (JoinKind::Rope, apart - 0.2)] {
        let (mut stage, block) = joined(kind, towards);
        let joint = only::<DistanceJoint>(&mut stage);
        let DistanceLaw::Range { max, .. } = joint.length else { panic!("{joint:?}") };
        assert!((max - apart).abs() < 0.02, "{kind:?}: {max} m long");
        let now = clicked_place(&mut stage, block).distance(CLICKS[0]);
        assert!((now - gap).abs() < 0.03, "{kind:?}: {now} m apart after a second at 0.2 m/s");
    }
    let (mut stage, _) = joined(JoinKind::Spring, towards);
    let DistanceLaw::Spring { rest, stiffness, .. } = only::<DistanceJoint>(&mut stage).length else { panic!() };
    assert!((rest - apart).abs() < 0.02);
    // The wall does not move: the block alone swings, five times a second.
    let frequency = (stiffness / 10.0).sqrt() / TAU;
    assert!((frequency - 5.0).abs() < 1e-9, "{frequency} Hz");
}

#[test]
fn a_joint_of_the_same_kind_at_the_same_place_is_refused_and_of_another_is_not() {
    let (mut stage, _) = joined(JoinKind::Hinge, Velocity::default());
    stage.act(SandboxAction::JoinPicked);
    assert!(matches!(stage.world().resource::<Notice>(), Notice::Error(text) if text.contains("already")));
    stage.world().insert_resource(JoinKind::Rod);
    stage.act(SandboxAction::JoinPicked);
    assert!(matches!(stage.world().resource::<Notice>(), Notice::Info(text) if text.contains("rod")));
    for _ in 0..2 {
        stage.key_with_control(KeyCode::KeyZ);
    }
    let world = stage.world();
    assert_eq!(world.query::<&HingeJoint>().iter(world).count(), 0);
    assert_eq!(world.query::<&DistanceJoint>().iter(world).count(), 0);
}

/// A block that hangs in joints of all kinds, with all that can stand beside one.
const ALL_KINDS: &str = r#"(
    gravity: (0, 0, 0),
    bodies: [
        (name: "wall", kind: Static, shape: Cuboid(size: (1, 1, 1)), position: (-2, 2, 0)),
        (name: "a", shape: Cuboid(size: (1, 1, 1)), position: (0, 2, 0)),
        (name: "b", shape: Cuboid(size: (1, 1, 1)), position: (2, 2, 0)),
        (name: "c", shape: Cuboid(size: (1, 1, 1)), position: (4, 2, 0)),
        (name: "d", shape: Cuboid(size: (1, 1, 1)), position: (6, 2, 0)),
    ],
    joints: [
        (body_a: "wall", body_b: "a", at: (-1, 2, 0), kind: Hinge, axis: (0, 0, 1), limits: (min: -1, max: 2),
         motor: (target: Speed(0.5), max_force: 40, keys: (forward: "ArrowUp", back: "ArrowDown", values: (3, -3))),
         friction: 0.25, breakable: (force: 5000, torque: 700), coordinate: 0.5),
        (body_a: "a", body_b: "b", at: (1, 2, 0), kind: Slider, axis: (1, 0, 0), limits: (min: -0.2, max: 0.2)),
        (body_a: "a", body_b: "b", at: (1, 2, 0), softness: (frequency: 2, max_force: 100)),
        (body_a: "a", body_b: "c", anchor_a: (0, 0, 0), anchor_b: (0, 0, 0), kind: Spring(rest: 4, stiffness: 30)),
        (body_a: "a", body_b: "c", anchor_a: (0, 0, 0), anchor_b: (0, 0, 0), kind: Distance(max: 5)),
        (body_a: "a", body_b: "d", at: (3, 2, 0), kind: Generic(translations: (false, true, true), axis: X)),
        (body_a: "a", body_b: "d", anchor_a: (0, 0, 0), anchor_b: (0, 0, 0), kind: Rod(length: 6)),
        (body_a: "a", body_b: "c", at: (2, 3, 0), kind: Fixed),
    ],
    view: (eye: (2, 2, 14), target: (2, 2, 0)),
)"#;

/// All that is known of the joints, by their names and kinds.
fn descriptions(stage: &mut Stage) -> Vec<String> {
    let world = stage.world();
    let text = plumb::scene::SceneSpec::of_world(world, "now").joints;
    let mut text: Vec<_> = text.iter().map(|joint| format!("{joint:?}")).collect();
    text.sort();
    text
}

#[test]
fn a_deleted_body_comes_back_with_joints_of_all_kinds_and_what_stands_beside_them() {
    let mut stage = Stage::open(ALL_KINDS);
    stage.act(SandboxAction::TogglePause);
    stage.frames(2);
    let before = descriptions(&mut stage);
    assert_eq!(before.len(), 8);
    let a = stage.body("a");
    *stage.world().resource_mut::<Selection>() = Selection::of(a);
    stage.frames(2);
    stage.act(SandboxAction::DeletePicked);
    stage.act(SandboxAction::StepOnce);
    assert_eq!(descriptions(&mut stage).len(), 0);
    stage.act(SandboxAction::Undo);
    let after = descriptions(&mut stage);
    for (one, other) in before.iter().zip(&after) {
        assert_eq!(one, other);
    }
    assert_eq!(after.len(), 8);
    let world = stage.world();
    let mut hinge =
        world.query_filtered::<(&JointLimits, &JointMotor, &MotorKeys, &JointFriction, &Breakable), With<HingeJoint>>();
    assert!(hinge.single(world).is_ok(), "the hinge has its limits, motor, keys, friction and strength");
    assert_eq!(world.query::<&GenericJoint>().iter(world).count(), 1);
}

#[test]
fn a_joint_of_any_kind_is_cut_and_comes_back() {
    let mut stage = Stage::open(ALL_KINDS);
    stage.act(SandboxAction::TogglePause);
    stage.frames(2);
    let before = descriptions(&mut stage);
    let a = stage.body("a");
    *stage.world().resource_mut::<Selection>() = Selection::of(a);
    for left in (0..8).rev() {
        stage.act(SandboxAction::CutPicked);
        assert_eq!(descriptions(&mut stage).len(), left, "{:?}", stage.world().resource::<Notice>());
    }
    for _ in 0..8 {
        stage.act(SandboxAction::Undo);
    }
    assert_eq!(descriptions(&mut stage), before);
}

/// A wheel on a wall.
const WHEEL: &str = r#"(
    gravity: (0, 0, 0),
    bodies: [
        (name: "wall", kind: Static, shape: Cuboid(size: (1, 1, 1)), position: (0, 2, -1)),
        (name: "wheel", shape: Sphere(radius: 0.4), mass: 5, position: (0, 2, 0)),
    ],
    joints: [(body_a: "wall", body_b: "wheel", at: (0, 2, 0), kind: Hinge, axis: (0, 0, 1))],
)"#;

fn hinge(stage: &mut Stage) -> Entity {
    let world = stage.world();
    world.query_filtered::<Entity, With<HingeJoint>>().single(world).expect("one hinge")
}

fn change(stage: &mut Stage, change: JointChange, continues: bool) {
    let joint = hinge(stage);
    stage.act(SandboxAction::ChangeJoint { joint, change, continues });
}

fn speed(speed: f64) -> JointChange {
    JointChange::Motor(Some(JointMotor::new(MotorTarget::Speed(speed)).with_max_force(50.0)))
}

/// The hinge's angle, rad, and rate, rad/s.
fn coordinate(stage: &mut Stage) -> JointCoordinate {
    let joint = hinge(stage);
    *stage.world().get::<JointCoordinate>(joint).unwrap()
}

#[test]
fn a_joint_is_changed_while_it_works() {
    let mut stage = Stage::open(WHEEL);
    change(&mut stage, speed(2.0), false);
    stage.frames(30);
    assert!((coordinate(&mut stage).rate - 2.0).abs() < 1e-3, "a motor: {:?}", coordinate(&mut stage));

    change(&mut stage, JointChange::Limits(Some(JointLimits::range(-1.0, 2.5))), false);
    stage.frames(90);
    let JointCoordinate { value, rate } = coordinate(&mut stage);
    assert!((value - 2.5).abs() < 0.02 && rate.abs() < 1e-2, "limits: it stands at {value} rad, turns at {rate} rad/s");

    change(&mut stage, JointChange::Limits(None), false);
    stage.frames(30);
    assert!((coordinate(&mut stage).rate - 2.0).abs() < 1e-3, "no limits: {:?}", coordinate(&mut stage));

    change(&mut stage, JointChange::Motor(None), false);
    change(&mut stage, JointChange::Friction(Some(JointFriction(5.0))), false);
    stage.frames(60);
    assert!(coordinate(&mut stage).rate.abs() < 1e-3, "friction: {:?}", coordinate(&mut stage));
}

#[test]
fn changes_are_undone_and_those_of_one_drag_together() {
    let mut stage = Stage::open(WHEEL);
    change(&mut stage, speed(1.0), false);
    for value in [1.5, 2.0, 3.0] {
        change(&mut stage, speed(value), true);
    }
    change(&mut stage, JointChange::Strength(Some(Breakable::at_force(10.0))), true);
    let joint = hinge(&mut stage);
    let motor = |stage: &mut Stage| stage.world().get::<JointMotor>(joint).and_then(|motor| motor.target.value());
    assert_eq!(motor(&mut stage), Some(3.0));
    stage.key_with_control(KeyCode::KeyZ);
    assert!(stage.world().get::<Breakable>(joint).is_none(), "of another part, it is another deed");
    assert_eq!(motor(&mut stage), Some(3.0));
    stage.key_with_control(KeyCode::KeyZ);
    assert_eq!(motor(&mut stage), None, "back to before the drag");
    assert!(
        matches!(stage.world().resource::<Notice>(), Notice::Info(text) if text.contains("the motor of wall to wheel"))
    );

    // A deed that is older than the joint's deletion means the joint that came back.
    change(&mut stage, speed(1.0), false);
    let wheel = stage.body("wheel");
    *stage.world().resource_mut::<Selection>() = Selection::of(wheel);
    stage.act(SandboxAction::DeletePicked);
    stage.act(SandboxAction::Undo);
    let joint = hinge(&mut stage);
    assert!(stage.world().get::<JointMotor>(joint).is_some());
    stage.act(SandboxAction::Undo);
    assert!(stage.world().get::<JointMotor>(joint).is_none());
}

#[test]
fn changes_that_make_no_sense_are_refused() {
    let mut stage = Stage::open(WHEEL);
    for (wrong, words) in [
        (JointChange::Limits(Some(JointLimits::range(1.0, -1.0))), "limits"),
        (speed(f64::NAN), "motor.target"),
        (JointChange::Strength(Some(Breakable::at_force(0.0))), "breakable"),
    ] {
        change(&mut stage, wrong.clone(), false);
        let Notice::Error(said) = stage.world().resource::<Notice>().clone() else { panic!("{wrong:?} was taken") };
        assert!(said.contains(words) && said.lines().count() == 1, "{said}");
        let joint = hinge(&mut stage);
        let joint = stage.world().entity(joint);
        assert!(!joint.contains::<JointLimits>() && !joint.contains::<JointMotor>() && !joint.contains::<Breakable>());
    }
}
