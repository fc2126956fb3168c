//! Bad joints: each gets an error of one line that names the place and what would be right.

use std::fs;

use bevy::math::{DQuat, DVec3};
use plumb::physics::{Breakable, JointAxes, JointMotor, MotorTarget};
use plumb::scene::{BodySpec, JointKindSpec, JointSpec, LimitSpec, MotorKeys, SceneSpec, ShapeSpec};

use super::command_line::refuses;

const NO_AXIS: &str = "the joint has no axis of its own: use a Hinge, a Slider, a Distance, or a Generic with an axis";

/// A scene of two balls, a good joint, and, on line 6, one that holds these with `fields` more.
fn with_joint(fields: &str) -> String {
    format!(
        "(bodies: [\n  (name: \"a\", shape: Sphere(radius: 1)),\n  (name: \"b\", shape: Sphere(radius: 1)),\n], joints: \
         [\n  (body_a: \"a\", body_b: \"b\", at: (0, 0, 0)),\n  (body_a: \"a\", body_b: \"b\", at: (0, 0, 0), {fields}),\n])"
    )
}

/// Checks that `plumb run` refuses such a scene with status 2 and one line: the file, `place`, and what is wrong.
#[track_caller]
fn refused_with(fields: &str, place: &str, problem: &str) {
    let text = with_joint(fields);
    let error = SceneSpec::from_ron(&text, "scene.ron").expect_err("it is bad").to_string();
    assert_eq!(error, format!("scene.ron:{place}: {problem}"), "{fields}");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.ron");
    fs::write(&path, text).unwrap();
    let path = path.to_str().unwrap();
    refuses(&["run", path, "--seconds", "0.1"], &[&format!("plumb: {path}:{place}: {problem}")]);
}

/// Of what the parser sees: the place is where `§` stands.
#[track_caller]
fn refused_at(fields: &str, problem: &str) {
    let line = with_joint(fields).lines().nth(5).expect("the joint").to_owned();
    let column = 1 + line.chars().position(|letter| letter == '§').expect("a mark");
    refused_with(&fields.replace('§', ""), &format!("6:{column}"), problem);
}

/// Of what the whole joint shows: a field of the second joint.
#[track_caller]
fn refused(fields: &str, field: &str, problem: &str) {
    refused_with(fields, &format!(" joints[1].{field}"), problem);
}

#[test]
fn an_axis_without_a_direction_is_named() {
    let cure = "must be finite and not (0, 0, 0), is [0, 0, 0]; give a direction";
    refused("kind: Hinge, axis: (0, 0, 0)", "axis", cure);
    refused("kind: Slider, axes: ((1, 0, 0), (0, 0, 0))", "axes", &format!("B's {cure}"));
    refused("kind: Slider, axes: ((0, 0, 0), (1, 0, 0))", "axes", &format!("A's {cure}"));
    refused_at(
        "kind: Fixed, frames: ((0, 0, 0, 0§), (0, 0, 0, 1))",
        "a rotation must not be (0, 0, 0, 0); no rotation is (0, 0, 0, 1)",
    );
    refused_at("kind: Hinge, axis: (0, §NaN, 0)", "must be finite, is NaN");
    refused(
        "kind: Hinge, axis: (0, 0, 1), axes: ((1, 0, 0), (1, 0, 0))",
        "axis",
        "give one of 'axis', 'axes' and 'frames'",
    );
}

#[test]
fn limits_that_make_no_sense_are_named() {
    let order = "must be in order, the least first, are 1 and -1";
    refused("kind: Hinge, limits: (min: 1, max: -1)", "limits.min", order);
    refused("limits: (swing: 1, min: 1, max: -1)", "limits.min", order);
    refused("kind: Fixed, limits: (min: 0, max: 1)", "limits", NO_AXIS);
    refused("kind: Hinge, limits: (swing: 1)", "limits.swing", "is for ball joints; others have min and max");
    refused("limits: (swing: 4)", "limits.swing", "must be greater than 0 and less than π, is 4");
    refused("limits: (swing: 1, min: -4, max: 1)", "limits.min", "a twist must lie between −π and π, is -4 to 1");
    refused_at("kind: Hinge, limits: (min: §NaN)", "must be finite, is NaN");
    refused_at("kind: Hinge, limits: (min: 0, restitution: §2)", "must be 0 to 1, is 2");
    refused_at("kind: Hinge, limits: (§2, 1)", "Expected the name of a field, found `2`");
    refused_at("limits: (swing: §0)", "must be greater than 0, is 0");
}

#[test]
fn lengths_that_make_no_sense_are_named() {
    refused("kind: Distance(min: 2, max: 1)", "kind.max", "must be in order, the least first, are 2 and 1");
    refused_at("kind: Rod(length: §0)", "must be greater than 0, is 0");
    refused_at("kind: Spring(rest: 1, stiffness: §-1)", "must be at least 0, is -1");
}

#[test]
fn a_motor_of_a_joint_without_an_axis_is_named() {
    for kind in ["Ball", "Fixed", "Generic(translations: (true, true, true))"] {
        refused(&format!("kind: {kind}, motor: (target: Speed(1))"), "motor", NO_AXIS);
    }
}

#[test]
fn motors_that_make_no_sense_are_named() {
    refused_at("kind: Hinge, motor: (target: Speed(§NaN))", "must be finite, is NaN");
    refused_at("kind: Hinge, motor: (target: Speed(1), max_force: §-1)", "must be at least 0, is -1");
    refused_at(
        "kind: Hinge, motor: (target: Position(target: 1, frequency: §0, damping_ratio: 1))",
        "must be greater than 0, is 0",
    );
    refused_at(
        "kind: Hinge, motor: (target: Speed(1)), §motor: (target: Speed(2))",
        "Unexpected duplicate field named `motor` in `Joint`",
    );
}

#[test]
fn keys_that_make_no_sense_are_named() {
    let keys = |target: &str, keys: &str| format!("kind: Hinge, motor: (target: {target}, keys: ({keys}))");
    let cure = "name one as Bevy's KeyCode does, such as ArrowUp, KeyW or Space";
    refused(
        &keys("Speed(1)", r#"forward: "up", back: "ArrowDown", values: (1, -1)"#),
        "motor.keys.forward",
        &format!("no key 'up'; {cure}"),
    );
    refused(
        &keys("Speed(1)", r#"forward: "ArrowUp", back: "", values: (1, -1)"#),
        "motor.keys.back",
        &format!("no key ''; {cure}"),
    );
    refused(
        &keys("Speed(1)", r#"forward: "KeyW", back: "KeyW", values: (1, -1)"#),
        "motor.keys.back",
        "'KeyW' is already the key for forward; choose another",
    );
    refused_at(&keys("Speed(1)", r#"forward: "KeyW", back: "KeyS", values: (§NaN, -1)"#), "must be finite, is NaN");
    refused(
        &keys("Ramp(from: 0, rate: 1)", r#"forward: "KeyW", back: "KeyS", values: (1, -1)"#),
        "motor.keys",
        "set a speed or a position: the motor's target must be one",
    );
    refused_at(
        &keys("Speed(1)", r#"forward: "KeyW", back: "KeyS"§"#),
        "Unexpected missing field named `values` in `Keys`",
    );
}

#[test]
fn strength_and_friction_that_make_no_sense_are_named() {
    refused_at("breakable: (force: §0)", "must be greater than 0, is 0");
    refused_at("breakable: (force: §NaN)", "must be finite, is NaN");
    refused_at("breakable: (force: 1, torque: §-1)", "must be greater than 0, is -1");
    refused_at("kind: Hinge, friction: §-1", "must be at least 0, is -1");
    refused("kind: Fixed, friction: 1", "friction", NO_AXIS);
    refused_at("coordinate: §inf", "must be finite, is inf");
}

#[test]
fn a_joint_to_a_body_that_is_not_there_is_named() {
    let text = with_joint("").replace("\"b\", at: (0, 0, 0), )", "\"c\", at: (0, 0, 0))");
    let error = SceneSpec::from_ron(&text, "scene.ron").expect_err("there is no c").to_string();
    assert_eq!(error, "scene.ron: joints[1].body_b: no body 'c'; name one of the scene's bodies, or 'world'");
}

/// A hinge of two balls, to spoil.
fn hinge() -> SceneSpec {
    let mut scene = SceneSpec::new("made", DVec3::ZERO);
    let ball = |name| BodySpec::new(name, ShapeSpec::Sphere { radius: 1.0 }, DVec3::ZERO);
    scene.bodies = vec![ball("a"), ball("b")];
    scene.joints = vec![JointSpec::hinge(&scene.bodies[0], &scene.bodies[1], DVec3::X, DVec3::Z)];
    scene
}

/// What a parser sees in a file, the scene's own check must see in code.
#[test]
fn joints_made_in_code_are_held_to_the_same_rules() {
    assert_eq!(hinge().validate(), Ok(()));
    let position = |frequency| JointMotor::new(MotorTarget::Position { target: 1.0, frequency, damping_ratio: 1.0 });
    let keys = |rest| MotorKeys { keys: ["KeyW".into(), "KeyS".into()], values: [1.0, -1.0], rest };
    let speed = JointMotor::new(MotorTarget::Speed(1.0));
    let limits = LimitSpec { swing: None, min: 0.0, max: f64::NAN, restitution: 0.0 };
    let hinge_joint = &hinge().joints[0];
    let with = |spoil: &dyn Fn(&mut JointSpec)| {
        let mut joint = hinge_joint.clone();
        spoil(&mut joint);
        joint
    };
    let cases = [
        (
            with(&|joint| joint.axes = JointAxes::Frames(DQuat::IDENTITY, DQuat::from_xyzw(0.0, 0.0, 0.0, 2.0))),
            "frames: each must be a quaternion of length 1",
        ),
        (
            with(&|joint| joint.axes = JointAxes::World(DVec3::NAN)),
            "axis: must be finite and not (0, 0, 0), is [NaN, NaN, NaN]; give a direction",
        ),
        (with(&|joint| joint.limits = Some(limits)), "limits.min: must be in order, the least first, are 0 and NaN"),
        (with(&|joint| joint.motor = Some(position(0.0))), "motor.target.frequency: must be greater than 0, is 0"),
        (
            with(&|joint| joint.motor = Some(speed.with_max_force(f64::NAN))),
            "motor.max_force: must be at least 0, is NaN",
        ),
        (
            with(&|joint| (joint.motor, joint.keys) = (Some(speed), Some(keys(f64::NAN)))),
            "motor.keys.values: must be finite, is NaN",
        ),
        (
            with(&|joint| joint.keys = Some(keys(0.0))),
            "motor.keys: set a speed or a position: the motor's target must be one",
        ),
        (with(&|joint| joint.friction = -1.0), "friction: must be at least 0, is -1"),
        (
            with(&|joint| joint.breakable = Some(Breakable::at_force(0.0))),
            "breakable: force and torque must be greater than 0, window and from finite and at least 0",
        ),
        (with(&|joint| joint.coordinate = f64::NAN), "coordinate: must be finite, is NaN"),
        (
            with(&|joint| (joint.kind, joint.motor) = (JointKindSpec::Fixed, Some(speed))),
            "motor: the joint has no axis of its own: use a Hinge, a Slider, a Distance, or a Generic with an axis",
        ),
    ];
    for (joint, expected) in cases {
        let error = SceneSpec { joints: vec![joint], ..hinge() }.validate().expect_err(expected).to_string();
        assert_eq!(error, format!("made: joints[0].{expected}"));
    }
}
