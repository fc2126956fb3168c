//! The scene file: what it may leave out, what each field becomes, and the scenes that come with
//! Plumb.

use std::path::{Path, PathBuf};

use bevy::math::{DQuat, DVec3};
use plumb::physics::{CollisionLayers, LockedAxes, Position, RigidBody, Softness, headless_app, step};
use plumb::scene::{BodySpec, JointSpec, MaterialSpec, SceneSpec, ShapeSpec, ViewSpec, load};

fn parse(text: &str) -> SceneSpec {
    SceneSpec::from_ron(text, "scene.ron").unwrap_or_else(|error| panic!("{error}"))
}

fn in_repository(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

fn scene_files() -> Vec<PathBuf> {
    let folder = in_repository("assets/scenes");
    std::fs::read_dir(folder).expect("assets/scenes").map(|entry| entry.expect("an entry").path()).collect()
}

#[test]
fn an_empty_file_is_an_empty_scene_under_earths_gravity() {
    let scene = SceneSpec::from_ron("()", "some/where/void.ron").expect("nothing is wrong with it");
    assert_eq!(scene, SceneSpec::new("void", DVec3::new(0.0, -9.81, 0.0)));
}

#[test]
fn a_body_needs_no_more_than_a_name_and_a_shape() {
    let scene = parse(r#"(bodies: [(name: "ball", shape: Sphere(radius: 2)), (name: "ground", shape: HalfSpace)])"#);
    let ball = BodySpec::new("ball", ShapeSpec::Sphere { radius: 2.0 }, DVec3::ZERO);
    assert_eq!(scene.bodies, [ball, BodySpec::ground()], "a half-space is static unless it says otherwise");
}

#[test]
fn every_field_of_a_body_arrives() {
    let scene = parse(
        r#"Scene(
            gravity: (1, 2, 3),
            bodies: [Body(
                name: "all", kind: Kinematic, shape: Cone(radius: 1, height: 2.5), density: 7, mass: 8,
                inertia: (1, 2, 3), position: (4, 5, 6), rotation: (0, 0, 3, 4), velocity: (7, 8, 9),
                angular_velocity: (-1, -2, -3), force: (10, 11, 12), torque: (13, 14, 15), friction: 0, restitution: 1,
                layers: (memberships: 5, filters: 6), sensor: true, locked: (translation: (true, false, true)), gravity_scale: -1,
                linear_damping: 0.5, angular_damping: 0.25, color: (0, 0.5, 1),
            )],
            view: (eye: (1, 1, 1), target: (0, 0, 0)),
        )"#,
    );
    let expected = BodySpec {
        name: "all".to_owned(),
        kind: RigidBody::Kinematic,
        shape: Some(ShapeSpec::Cone { radius: 1.0, height: 2.5 }),
        density: 7.0,
        mass: Some(8.0),
        inertia: Some(DVec3::new(1.0, 2.0, 3.0)),
        position: DVec3::new(4.0, 5.0, 6.0),
        rotation: DQuat::from_xyzw(0.0, 0.0, 0.6, 0.8),
        linear_velocity: DVec3::new(7.0, 8.0, 9.0),
        angular_velocity: DVec3::new(-1.0, -2.0, -3.0),
        force: DVec3::new(10.0, 11.0, 12.0),
        torque: DVec3::new(13.0, 14.0, 15.0),
        material: MaterialSpec { friction: 0.0, restitution: 1.0 },
        layers: CollisionLayers { memberships: 5, filters: 6 },
        locked: LockedAxes { translation: [true, false, true], rotation: [false; 3] },
        sensor: true,
        gravity_scale: -1.0,
        damping: (0.5, 0.25),
        color: Some([0.0, 0.5, 1.0]),
    };
    assert_eq!(scene.gravity, DVec3::new(1.0, 2.0, 3.0));
    assert_eq!(scene.view, Some(ViewSpec { eye: DVec3::ONE, target: DVec3::ZERO }));
    let [body] = &scene.bodies[..] else { panic!("one body") };
    assert!(body.rotation.abs_diff_eq(expected.rotation, 1e-15), "a quaternion is scaled to length 1");
    assert_eq!(BodySpec { rotation: expected.rotation, ..body.clone() }, expected);
}

#[test]
fn degrees_turn_about_the_worlds_x_then_y_then_z() {
    let scene = parse(r#"(bodies: [(name: "a", shape: Sphere(radius: 1), rotation_degrees: (90, 0, 90))])"#);
    // About x: y goes to z; then about z: z stays. x goes to y.
    let rotation = scene.bodies[0].rotation;
    assert!((rotation * DVec3::Y).abs_diff_eq(DVec3::Z, 1e-15), "{}", rotation * DVec3::Y);
    assert!((rotation * DVec3::X).abs_diff_eq(DVec3::Y, 1e-15), "{}", rotation * DVec3::X);
}

/// Two balls, the second turned, and these joints.
fn joined(joints: &str) -> SceneSpec {
    parse(&format!(
        r#"(bodies: [
            (name: "a", shape: Sphere(radius: 1), position: (0, 3, 0)),
            (name: "b", shape: Sphere(radius: 1), position: (4, 3, 0), rotation_degrees: (0, 0, 90)),
        ], joints: [{joints}])"#
    ))
}

#[test]
fn a_joint_at_a_point_of_the_world_is_the_same_as_one_by_its_anchors() {
    let at = joined(r#"(body_a: "a", body_b: "b", at: (1, 3, 0), collide: true)"#);
    let anchors = joined(r#"(body_a: "a", body_b: "b", anchor_a: (1, 0, 0), anchor_b: (0, 3, 0), collide: true)"#);
    let [at, anchors] = [&at, &anchors].map(|scene| scene.joints[0].clone());
    assert!(at.anchor_b.abs_diff_eq(anchors.anchor_b, 1e-15), "{}", at.anchor_b);
    assert_eq!(JointSpec { anchor_b: anchors.anchor_b, ..at }, anchors);
    assert_eq!(anchors.softness, None);
}

#[test]
fn a_joint_to_the_world_is_one_to_a_static_point_there() {
    for side in [r#"(body_a: "world", body_b: "a", at: (1, 3, 0))"#, r#"(body_a: "a", body_b: "world", at: (1, 3, 0))"#]
    {
        let scene = joined(side);
        let [.., pin] = &scene.bodies[..] else { panic!("bodies") };
        assert_eq!((scene.bodies.len(), pin), (3, &BodySpec::pin("world:0", DVec3::new(1.0, 3.0, 0.0))));
        let joint = &scene.joints[0];
        let mut sides = [(&*joint.body_a, joint.anchor_a), (&*joint.body_b, joint.anchor_b)];
        sides.sort_by_key(|&(name, _)| name.to_owned());
        assert_eq!(sides, [("a", DVec3::X), ("world:0", DVec3::ZERO)]);
    }
    let by_anchors = joined(r#"(body_a: "world", body_b: "a", anchor_a: (1, 3, 0), anchor_b: (0, 0, 0))"#);
    assert_eq!(by_anchors.bodies[2].position, DVec3::new(1.0, 3.0, 0.0));
}

#[test]
fn a_soft_joint_is_critically_damped_unless_it_says_otherwise() {
    let scene = joined(r#"(body_a: "a", body_b: "b", at: (2, 3, 0), softness: (frequency: 2, max_force: 10))"#);
    assert_eq!(scene.joints[0].softness, Some(Softness { frequency: 2.0, damping_ratio: 1.0, max_force: 10.0 }));
}

#[test]
fn scenes_that_come_with_plumb_load_and_run() {
    let files = scene_files();
    assert!(files.len() >= 3);
    for file in files {
        let scene = load(file.to_str().expect("UTF-8"), &[]).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(file.file_stem().and_then(|stem| stem.to_str()), Some(&*scene.name));
        assert!(scene.view.is_some(), "{}", scene.name);
        let mut app = headless_app();
        let world = app.world_mut();
        let spawned = scene.spawn(world);
        for _ in 0..60 {
            step(world);
        }
        let at = |body: usize| world.get::<Position>(spawned.bodies[body]).expect("a body keeps its position").0;
        let moved = (0..scene.bodies.len()).filter(|&i| at(i) != scene.bodies[i].position).count();
        assert!(moved > scene.joints.len() / 2, "{}: only {moved} bodies moved", scene.name);
        assert!((0..scene.bodies.len()).all(|i| at(i).is_finite()), "{}", scene.name);
    }
}

#[test]
fn the_readme_shows_the_example_scene_as_it_is() {
    let read = |path| std::fs::read_to_string(in_repository(path)).unwrap_or_else(|error| panic!("{path}: {error}"));
    let (readme, example) = (read("README.md"), read("assets/scenes/example.ron"));
    assert!(readme.contains(example.trim_end()), "README.md does not quote assets/scenes/example.ron verbatim");
}
