//! Bad scenes: each gets an error of one line that names the place and what is wrong there.

use std::fs;

use bevy::math::{DQuat, DVec3};
use plumb::scene::{BodySpec, JointSpec, MAX_BODIES, MAX_FILE_BYTES, SceneSpec, ShapeSpec, ViewSpec, load};

#[track_caller]
fn one_line<T>(result: Result<T, plumb::scene::SceneError>) -> String {
    let message = result.err().expect("it is an error").to_string();
    assert!(!message.contains(['\n', '\r']), "one line: {message}");
    message
}

#[track_caller]
fn loading(scene: &str, parameters: &[(&str, f64)]) -> String {
    let parameters: Vec<_> = parameters.iter().map(|&(name, value)| (name.to_owned(), value)).collect();
    one_line(load(scene, &parameters))
}

#[track_caller]
fn parsing(text: &str) -> String {
    one_line(SceneSpec::from_ron(text, "scene.ron"))
}

/// The error of a scene with one body, on line 2, that starts `(name: "a", ` (13 characters after
/// two blanks) and goes on as given.
#[track_caller]
fn of_body(fields: &str) -> String {
    parsing(&format!("(bodies: [\n  (name: \"a\", {fields}),\n])"))
}

/// The error of a scene of three balls, two dynamic, and one joint.
#[track_caller]
fn of_joint(fields: &str) -> String {
    parsing(&format!(
        r#"(bodies: [
            (name: "a", shape: Sphere(radius: 1)), (name: "b", shape: Sphere(radius: 1)),
            (name: "rock", kind: Static, shape: Sphere(radius: 1)), (name: "wall", kind: Static),
        ], joints: [({fields})])"#
    ))
}

#[test]
fn an_unknown_scene_gets_the_nearest_name() {
    let cure = "'plumb scenes' lists the built-in ones, a scene of your own is a path that ends in .ron";
    assert_eq!(loading("pyramd", &[]), format!("no scene 'pyramd', did you mean 'pyramid'?; {cure}"));
    assert_eq!(loading("Limbs", &[]), format!("no scene 'Limbs', did you mean 'limbs'?; {cure}"));
    assert_eq!(loading("teapot", &[]), format!("no scene 'teapot'; {cure}"));
    assert_eq!(loading("", &[]), format!("no scene ''; {cure}"));
}

#[test]
fn an_unknown_or_repeated_parameter_is_named() {
    assert_eq!(loading("stack", &[("m", 3.0)]), "stack: no parameter 'm'; it has n, jitter");
    assert_eq!(loading("pendulum", &[("n", 3.0)]), "pendulum: no parameter 'n'; it has none");
    assert_eq!(
        loading("assets/scenes/example.ron", &[("n", 3.0)]),
        "assets/scenes/example.ron: no parameter 'n'; it has none"
    );
    assert_eq!(loading("stack", &[("n", 3.0), ("n", 4.0)]), "stack: parameter 'n' is given twice; give it once");
}

#[test]
fn a_parameter_out_of_range_is_told_its_range() {
    assert_eq!(loading("stack", &[("n", 2.5)]), "stack: parameter n must be a whole number from 1 to 1000, is 2.5");
    assert_eq!(loading("stack", &[("n", 0.0)]), "stack: parameter n must be a whole number from 1 to 1000, is 0");
    assert_eq!(loading("bounce", &[("e", 1.5)]), "bounce: parameter e must be from 0 to 1, is 1.5");
    assert_eq!(loading("bounce", &[("e", f64::NAN)]), "bounce: parameter e must be from 0 to 1, is NaN");
    assert_eq!(
        loading("stack", &[("n", f64::INFINITY)]),
        "stack: parameter n must be a whole number from 1 to 1000, is inf"
    );
}

#[test]
fn too_many_bodies_are_refused_before_any_is_made() {
    let expected = "pyramid: 500501 bodies are more than the limit of 100000; make the scene smaller";
    assert_eq!(loading("pyramid", &[("n", 1000.0)]), expected);
    let expected = "joint_grid: 1000000 bodies are more than the limit of 100000; make the scene smaller";
    assert_eq!(loading("joint_grid", &[("n", 1000.0)]), expected);
}

#[test]
fn a_file_with_too_many_bodies_is_refused() {
    let bodies: String = (0..=MAX_BODIES).map(|i| format!("(name:\"{i}\",shape:Sphere(radius:1)),")).collect();
    let expected = "scene.ron: 100001 bodies are more than the limit of 100000; make the scene smaller";
    assert_eq!(parsing(&format!("(bodies:[{bodies}])")), expected);
}

#[test]
fn syntax_errors_name_line_and_column() {
    assert_eq!(parsing("(\n  bodies: [\n    (name: \"a\" shape: HalfSpace),\n])"), "scene.ron:3:16: Expected comma");
    assert_eq!(parsing("(\n  bodies: ["), "scene.ron:2:11: Expected opening `(` for struct `Body`");
    assert_eq!(parsing(""), "scene.ron:1:1: Expected opening `(` for struct `Scene`");
    assert_eq!(parsing("(gravity: (0, -9.81, 0))\n)"), "scene.ron:1:25: Non-whitespace trailing characters");
}

#[test]
fn wrong_types_and_unknown_fields_name_line_and_column() {
    assert_eq!(of_body("mass: \"heavy\""), "scene.ron:2:20: Expected float");
    let unknown = of_body("colour: (1, 0, 0)");
    assert!(unknown.starts_with("scene.ron:2:15: Unexpected field named `colour` in `Body`"), "{unknown}");
    assert!(unknown.contains("`color`"), "{unknown}");
    assert_eq!(
        of_body("shape: Ball(radius: 1)"),
        "scene.ron:2:22: Unexpected variant named `Ball` in enum `Shape`, expected one of `HalfSpace`, `Sphere`, `Cuboid`, `Capsule`, `Cylinder`, `Cone`, `Hull`, `Mesh`, `Compound`, `Heights`, or `Surface` instead"
    );
    assert_eq!(
        of_body("shape: Sphere(radius: 1, height: 2)"),
        "scene.ron:2:40: Unexpected field named `height` in `Sphere`, expected `radius` instead"
    );
    assert_eq!(of_body("shape: Sphere()"), "scene.ron:2:29: Unexpected missing field named `radius` in `Sphere`");
    assert_eq!(
        of_body("kind: Fluid"),
        "scene.ron:2:21: Unexpected variant named `Fluid` in enum `RigidBody`, expected one of `Dynamic`, `Kinematic`, or `Static` instead"
    );
    assert_eq!(
        of_body("position: (1, 2)"),
        "scene.ron:2:30: Expected tuple struct Vector with 3 elements but found 2 elements instead"
    );
    assert_eq!(
        of_body("layers: (members: 1)"),
        "scene.ron:2:24: Unexpected field named `members` in `CollisionLayers`, expected either `memberships` or `filters` instead"
    );
    assert_eq!(
        parsing("(bodies: [(shape: HalfSpace)])"),
        "scene.ron:1:28: Unexpected missing field named `name` in `Body`"
    );
}

#[test]
fn numbers_out_of_range_name_line_and_column() {
    assert_eq!(of_body("mass: 0"), "scene.ron:2:21: must be greater than 0, is 0");
    assert_eq!(of_body("mass: -1.5"), "scene.ron:2:21: must be greater than 0, is -1.5");
    assert_eq!(of_body("density: 0"), "scene.ron:2:24: must be greater than 0, is 0");
    assert_eq!(of_body("inertia: (1, 0, 1)"), "scene.ron:2:28: must be greater than 0, is 0");
    assert_eq!(of_body("shape: Sphere(radius: 0)"), "scene.ron:2:37: must be greater than 0, is 0");
    assert_eq!(of_body("shape: Cuboid(size: (1, -1, 1))"), "scene.ron:2:39: must be greater than 0, is -1");
    assert_eq!(of_body("shape: Cone(radius: 1, height: -2)"), "scene.ron:2:46: must be greater than 0, is -2");
    assert_eq!(of_body("friction: -0.1"), "scene.ron:2:25: must be at least 0, is -0.1");
    assert_eq!(of_body("restitution: 1.1"), "scene.ron:2:28: must be 0 to 1, is 1.1");
    assert_eq!(of_body("position: (0, NaN, 0)"), "scene.ron:2:29: must be finite, is NaN");
    assert_eq!(of_body("velocity: (0, 0, inf)"), "scene.ron:2:32: must be finite, is inf");
    assert_eq!(of_body("force: (0, 0, -inf)"), "scene.ron:2:29: must be finite, is -inf");
    assert_eq!(of_body("angular_damping: -1"), "scene.ron:2:32: must be at least 0, is -1");
    assert_eq!(of_body("position: (1e999, 0, 0)"), "scene.ron:2:26: must be finite, is inf");
    assert_eq!(of_body("color: (255, 0, 0)"), "scene.ron:2:23: must be 0 to 1, is 255");
    assert_eq!(
        of_body("rotation: (0, 0, 0, 0)"),
        "scene.ron:2:36: a rotation must not be (0, 0, 0, 0); no rotation is (0, 0, 0, 1)"
    );
    assert_eq!(parsing("(gravity: (0, NaN, 0))"), "scene.ron:1:15: must be finite, is NaN");
    assert_eq!(of_joint(r#"body_a: "a", body_b: "b", at: (0, inf, 0)"#), "scene.ron:4:56: must be finite, is inf");
}

#[test]
fn bodies_that_make_no_sense_are_named() {
    let ball = "shape: Sphere(radius: 1)";
    assert_eq!(
        parsing(&format!("(bodies: [(name: \"a\", {ball}), (name: \"b\", {ball}), (name: \"a\", {ball})])")),
        "scene.ron: bodies[2].name: 'a' is already the name of bodies[0]"
    );
    assert_eq!(parsing(&format!("(bodies: [(name: \"\", {ball})])")), "scene.ron: bodies[0].name: must not be empty");
    for name in ["world", "world:0"] {
        let expected = format!("scene.ron: bodies[0].name: '{name}' is kept for what does not move; choose another");
        assert_eq!(parsing(&format!("(bodies: [(name: \"{name}\", {ball})])")), expected);
    }
    assert_eq!(
        of_body("kind: Dynamic, shape: HalfSpace"),
        "scene.ron: bodies[0].shape: a half-space has no mass and does not move: say kind: Static"
    );
    let massless =
        "scene.ron: bodies[0].shape: a dynamic body needs a shape, or both a mass and an inertia; or say kind: Static";
    assert_eq!(of_body("mass: 1"), massless);
    assert_eq!(of_body("inertia: (1, 1, 1)"), massless);
    assert_eq!(
        of_body("rotation: (0, 0, 0, 1), rotation_degrees: (0, 0, 0)"),
        "scene.ron: bodies[0].rotation: give either 'rotation' or 'rotation_degrees', not both"
    );
    assert_eq!(
        of_body("shape: Sphere(radius: 1e150)"),
        "scene.ron: bodies[0].shape: its size and density give a mass of inf kg; use less extreme ones"
    );
    assert_eq!(
        of_body("shape: Sphere(radius: 1e-150)"),
        "scene.ron: bodies[0].shape: its size and density give a mass of 0e0 kg; use less extreme ones"
    );
}

#[test]
fn joints_that_join_nothing_are_named() {
    assert_eq!(
        of_joint(r#"body_a: "a", body_b: "arm", at: (0, 0, 0)"#),
        "scene.ron: joints[0].body_b: no body 'arm'; name one of the scene's bodies, or 'world'"
    );
    assert_eq!(
        of_joint(r#"body_a: "a", body_b: "a", at: (0, 0, 0)"#),
        "scene.ron: joints[0].body_b: joins 'a' to itself; a joint needs two bodies"
    );
    assert_eq!(
        of_joint(r#"body_a: "rock", body_b: "wall", at: (0, 0, 0)"#),
        "scene.ron: joints[0].body_b: neither 'rock' nor 'wall' is dynamic; one of them must be"
    );
    assert_eq!(
        of_joint(r#"body_a: "world", body_b: "world", at: (0, 0, 0)"#),
        "scene.ron: joints[0].body_b: joins the world to itself; one of the two must be a dynamic body"
    );
    assert_eq!(
        of_joint(r#"body_a: "wall", body_b: "world", at: (0, 0, 0)"#),
        "scene.ron: joints[0].body_b: neither 'wall' nor the world is dynamic; one of them must be"
    );
    let ways = "scene.ron: joints[0]: give either 'at' or both 'anchor_a' and 'anchor_b'";
    assert_eq!(of_joint(r#"body_a: "a", body_b: "b""#), ways);
    assert_eq!(of_joint(r#"body_a: "a", body_b: "b", anchor_a: (0, 0, 0)"#), ways);
    assert_eq!(of_joint(r#"body_a: "a", body_b: "b", at: (0, 0, 0), anchor_a: (0, 0, 0)"#), ways);
    assert_eq!(
        parsing("(view: (eye: (1, 2, 3), target: (1, 2, 3)))"),
        "scene.ron: view.target: must not be where the eye is"
    );
}

#[test]
fn files_that_cannot_be_read_are_named() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = |name: &str| folder.path().join(name).to_str().expect("UTF-8").to_owned();
    let missing = path("missing.ron");
    assert_eq!(loading(&missing, &[]), format!("{missing}: cannot be read: No such file or directory (os error 2)"));
    let directory = path("folder.ron");
    fs::create_dir(&directory).expect("a folder");
    assert_eq!(loading(&directory, &[]), format!("{directory}: is a folder, not a scene file"));
    let binary = path("binary.ron");
    fs::write(&binary, b"(\n\xff\xfe)").expect("a file");
    let expected = format!("{binary}: is not UTF-8 text (line 2); a scene is a RON text file");
    assert_eq!(loading(&binary, &[]), expected);
    let large = path("large.ron");
    fs::File::create(&large).and_then(|file| file.set_len(MAX_FILE_BYTES + 1)).expect("a sparse file");
    assert_eq!(loading(&large, &[]), format!("{large}: is larger than 64 MiB, the limit for a scene"));
    let flawed = path("flawed.ron"); // what the parser sees carries the whole path
    fs::write(&flawed, "(gravity: 9.81)").expect("a file");
    let expected = format!("{flawed}:1:10: Expected opening `(` for struct `Vector`");
    assert_eq!(loading(&flawed, &[]), expected);
}

/// A valid scene of two balls and a joint, to spoil.
fn sound() -> SceneSpec {
    let mut scene = SceneSpec::new("made", DVec3::ZERO);
    let ball = |name| BodySpec::new(name, ShapeSpec::Sphere { radius: 1.0 }, DVec3::ZERO);
    scene.bodies = vec![ball("a"), ball("b")];
    scene.joints = vec![JointSpec::at(&scene.bodies[0], &scene.bodies[1], DVec3::X)];
    scene.view = Some(ViewSpec { eye: DVec3::ONE, target: DVec3::ZERO });
    scene
}

#[test]
fn scenes_made_in_code_are_held_to_the_same_rules() {
    assert_eq!(sound().validate(), Ok(()));
    let spoiled = |spoil: fn(&mut SceneSpec)| {
        let mut scene = sound();
        spoil(&mut scene);
        one_line(scene.validate())
    };
    let cases: [(fn(&mut SceneSpec), &str); 19] = [
        (|s| s.gravity.y = f64::NAN, "made: gravity: must be finite, is NaN"),
        (|s| s.bodies[1].position.x = f64::INFINITY, "made: bodies[1].position: must be finite, is inf"),
        (|s| s.bodies[1].linear_velocity.z = f64::NAN, "made: bodies[1].velocity: must be finite, is NaN"),
        (|s| s.bodies[1].angular_velocity.z = f64::NAN, "made: bodies[1].angular_velocity: must be finite, is NaN"),
        (|s| s.bodies[1].force.x = f64::NAN, "made: bodies[1].force: must be finite, is NaN"),
        (|s| s.bodies[1].torque.x = f64::NAN, "made: bodies[1].torque: must be finite, is NaN"),
        (|s| s.bodies[1].gravity_scale = f64::NAN, "made: bodies[1].gravity_scale: must be finite, is NaN"),
        (|s| s.bodies[1].mass = Some(0.0), "made: bodies[1].mass: must be greater than 0, is 0"),
        (|s| s.bodies[1].density = -1.0, "made: bodies[1].density: must be greater than 0, is -1"),
        (|s| s.bodies[1].inertia = Some(DVec3::ZERO), "made: bodies[1].inertia: must be greater than 0, is 0"),
        (|s| s.bodies[1].damping.1 = -1.0, "made: bodies[1].angular_damping: must be at least 0, is -1"),
        (|s| s.bodies[1].material.friction = -1.0, "made: bodies[1].friction: must be at least 0, is -1"),
        (|s| s.bodies[1].material.restitution = 2.0, "made: bodies[1].restitution: must be 0 to 1, is 2"),
        (
            |s| s.bodies[1].shape = Some(ShapeSpec::Cuboid { size: DVec3::new(1.0, 0.0, 1.0) }),
            "made: bodies[1].shape.size: must be greater than 0, is 0",
        ),
        (
            |s| s.bodies[1].rotation = DQuat::from_xyzw(0.0, 0.0, 0.0, 0.0),
            "made: bodies[1].rotation: a rotation must be a quaternion of length 1, is of length 0",
        ),
        (|s| s.bodies[1].color = Some([0.0, 2.0, 0.0]), "made: bodies[1].color: must be 0 to 1, is 2"),
        (|s| s.joints[0].anchor_b.y = f64::NAN, "made: joints[0].anchor_b: must be finite, is NaN"),
        (
            |s| {
                s.joints[0].softness =
                    Some(plumb::physics::Softness { frequency: 0.0, damping_ratio: 1.0, max_force: 1.0 });
            },
            "made: joints[0].softness.frequency: must be greater than 0, is 0",
        ),
        (
            |s| s.view = Some(ViewSpec { eye: DVec3::NAN, target: DVec3::ZERO }),
            "made: view.eye: must be finite, is NaN",
        ),
    ];
    for (spoil, expected) in cases {
        assert_eq!(spoiled(spoil), expected);
    }
}
