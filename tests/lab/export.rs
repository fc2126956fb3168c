//! Scenes as text that reads back to the same scene: `to_ron`, `plumb export`, and scenes captured
//! from a running world.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

use bevy::math::{DQuat, DVec3};
use bevy::prelude::*;
use plumb::lab::Simulation;
use plumb::physics::{
    BallJoint, Collider, CollisionLayers, LockedAxes, Mass, Position, RigidBody, Rotation, Softness, SolverSettings,
};
use plumb::scene::{
    BodyColor, BodySpec, JointSpec, MaterialSpec, MeshSpec, SceneEntity, SceneSpec, ShapeSpec, ViewSpec,
    builtin_meshes, catalog, load,
};

fn text_of(scene: &SceneSpec) -> String {
    scene.to_ron(None).unwrap_or_else(|error| panic!("{error}"))
}

fn read(text: &str, name: &str) -> SceneSpec {
    SceneSpec::from_ron(text, name).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

fn bits(simulation: &Simulation) -> Vec<u64> {
    let states = simulation.sample().bodies.iter();
    let numbers = states.flat_map(|body| {
        let vectors = [body.position, body.linear, body.angular].map(|vector| vector.to_array());
        vectors.concat().into_iter().chain(body.rotation.to_array())
    });
    numbers.map(f64::to_bits).collect()
}

/// Asserts that two scenes start in the same state and go on to the same states.
#[track_caller]
fn assert_same_run(one: &SceneSpec, other: &SceneSpec) {
    let [mut one, mut other] = [one, other].map(|scene| Simulation::new(scene.clone(), SolverSettings::default()));
    assert_eq!(bits(&one), bits(&other), "{} starts", one.scene().name);
    (0..20).for_each(|_| one.step());
    (0..20).for_each(|_| other.step());
    assert_eq!(one.state_hash(), other.state_hash(), "{} after 20 steps", one.scene().name);
}

#[test]
fn every_built_in_scene_reads_back_to_the_same_states() {
    for info in catalog() {
        let scene = info.make(&info.defaults()).unwrap();
        let text = text_of(&scene);
        let again = read(&text, info.name);
        assert_eq!(scene, again, "{}", info.name);
        assert_same_run(&scene, &again);
        assert_eq!(text, text_of(&again));
    }
}

#[test]
fn scenes_from_files_read_back_with_their_joints_to_the_world() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/scenes");
    for file in fs::read_dir(folder).unwrap() {
        let file = file.unwrap().path();
        let scene = load(file.to_str().unwrap(), &[]).unwrap();
        let again = read(&text_of(&scene), file.to_str().unwrap());
        assert_eq!(scene, again, "{}", scene.name);
        assert_same_run(&scene, &again);
    }
}

/// A scene in which nothing is at its default.
fn unusual() -> SceneSpec {
    let third = 1.0 / 3.0;
    let body = BodySpec {
        kind: RigidBody::Kinematic,
        density: 0.1 + 0.2,
        inertia: Some(DVec3::new(third, 1e-300, 1e300)),
        force: DVec3::new(1e16, -1e-16, 5.0),
        torque: DVec3::new(-0.0, 0.0, 0.0),
        layers: CollisionLayers { memberships: 5, filters: u32::MAX },
        locked: LockedAxes { translation: [false, true, false], rotation: [true; 3] },
        sensor: true,
        gravity_scale: -0.0,
        damping: (third, 2.5),
        ..BodySpec::new("quo\"te\\ é\n", ShapeSpec::Cone { radius: third, height: 2.0 }, DVec3::new(-0.0, third, 1e7))
            .with_mass(third)
            .with_rotation(DQuat::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), 1.234_567_890_123))
            .with_velocity(DVec3::splat(third), DVec3::new(0.0, -0.0, third))
            .with_material(third, 0.7)
            .with_color([0.1, 1.0 / 3.0, 0.3])
    };
    let mut ball = BodySpec::new("ball", ShapeSpec::Sphere { radius: 0.25 }, DVec3::Y);
    ball.kind = RigidBody::Dynamic;
    let joint = JointSpec {
        collide: true,
        softness: Some(Softness { frequency: third, damping_ratio: 0.5, max_force: 1e9 }),
        ..JointSpec::new(&body, DVec3::new(-0.0, third, 0.0), &ball, DVec3::X)
    };
    let mut scene = SceneSpec::new("unusual", DVec3::new(-0.0, third, -1e-5));
    let capsule = BodySpec::new("capsule", ShapeSpec::Capsule { radius: third, length: 0.1 }, DVec3::Z);
    scene.bodies = vec![body, ball, capsule, BodySpec::ground().with_rotation(DQuat::from_rotation_x(0.1))];
    scene.joints.push(joint);
    scene.view = Some(ViewSpec { eye: DVec3::splat(third), target: DVec3::NEG_X });
    scene
}

#[test]
fn every_bit_of_every_field_survives() {
    let scene = unusual();
    let again = read(&text_of(&scene), "unusual.ron");
    assert_eq!(scene, again);
    // Equality does not tell −0 from 0: the text does.
    assert_eq!(format!("{scene:?}"), format!("{again:?}"));
}

#[test]
fn defaults_are_left_out_and_each_body_has_its_line() {
    let mut scene = SceneSpec::new("plain", DVec3::new(0.0, -9.81, 0.0));
    assert_eq!(text_of(&scene), "()\n");
    let mut ball = BodySpec::new("ball", ShapeSpec::Sphere { radius: 0.5 }, DVec3::new(0.0, 2.0, 0.1));
    scene.bodies = vec![BodySpec::ground(), ball.clone(), BodySpec::pin("world:0", DVec3::new(0.0, 3.0, 0.0))];
    scene.joints = vec![JointSpec::at(&scene.bodies[2], &ball, DVec3::new(0.0, 3.0, 0.0))];
    let expected = r#"(
    bodies: [
        (name: "ground", shape: HalfSpace),
        (name: "ball", shape: Sphere(radius: 0.5), position: (0.0, 2.0, 0.1)),
    ],
    joints: [
        (body_a: "world", body_b: "ball", anchor_a: (0.0, 3.0, 0.0), anchor_b: (0.0, 1.0, -0.1)),
    ],
)
"#;
    assert_eq!(text_of(&scene), expected);
    ball.name = "world".into();
    scene.bodies.push(ball);
    let refusal = scene.to_ron(None).unwrap_err().to_string();
    assert!(refusal.contains("bodies[3].name") && refusal.contains("'world'"), "{refusal}");
}

#[test]
fn what_makes_no_sense_is_not_written() {
    let mut scene = unusual();
    scene.bodies[0].linear_velocity.y = f64::NAN;
    let refusal = scene.to_ron(None).unwrap_err().to_string();
    assert!(refusal.contains("bodies[0].velocity"), "{refusal}");
}

#[test]
fn hulls_are_written_as_points_and_meshes_as_files() {
    let folder = tempfile::tempdir().unwrap();
    let (scenes, meshes) = (folder.path().join("scenes"), folder.path().join("meshes"));
    fs::create_dir(&scenes).unwrap();
    fs::create_dir(&meshes).unwrap();
    let tetrahedron = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    fs::write(meshes.join("four.obj"), tetrahedron).unwrap();
    let corners = [DVec3::ZERO, DVec3::X, DVec3::new(0.1, 1.0 / 3.0, 0.0), DVec3::Z];
    let mut scene = SceneSpec::new("shapes", DVec3::ZERO);
    let own = MeshSpec::load("four.obj", &meshes, 0.5).unwrap();
    let embedded = builtin_meshes().next().unwrap();
    let shapes = [
        ShapeSpec::hull(corners),
        ShapeSpec::Mesh(own),
        ShapeSpec::Mesh(MeshSpec::load(&embedded, Path::new(""), 1.0).unwrap()),
    ];
    scene.bodies = shapes
        .into_iter()
        .enumerate()
        .map(|(i, shape)| BodySpec::new(format!("body {i}"), shape, DVec3::X * 5.0 * i as f64))
        .collect();

    let text = scene.to_ron(Some(&scenes)).unwrap();
    assert!(text.contains(r#"Mesh(file: "../meshes/four.obj", scale: 0.5)"#), "{text}");
    assert!(text.contains(&format!(r#"Mesh(file: "{embedded}")"#)), "{text}");
    let written = scenes.join("shapes.ron");
    assert_same_run(&scene, &read(&text, written.to_str().unwrap()));
    let again = read(&text, written.to_str().unwrap());
    assert_eq!(again.bodies[0], scene.bodies[0]);
    assert_eq!(again.to_ron(Some(&scenes)).unwrap(), text);

    let anywhere = text_of(&scene);
    assert!(anywhere.contains(meshes.join("four.obj").to_str().unwrap()), "{anywhere}");
    assert_same_run(&scene, &read(&anywhere, "/somewhere/else.ron"));
}

#[test]
fn export_writes_what_runs_alike() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("chain.ron");
    let plumb = |arguments: &[&str]| {
        let output = Command::new(env!("CARGO_BIN_EXE_plumb")).args(arguments).output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    };
    let printed = plumb(&["export", "chain", "-p", "r=1000"]);
    assert_eq!(plumb(&["export", "chain", "-p", "r=1000", "--out", path.to_str().unwrap()]), "");
    assert_eq!(fs::read_to_string(&path).unwrap(), printed);
    assert!(printed.starts_with("// plumb export chain -p r=1000\n("), "{printed}");
    let scene = load("chain", &[("r".into(), 1000.0)]).unwrap();
    assert_eq!(load(path.to_str().unwrap(), &[]).unwrap(), scene);
    // And once more, from the file.
    let again = plumb(&["export", path.to_str().unwrap()]);
    assert_eq!(printed.split_once('\n').unwrap().1, again.split_once('\n').unwrap().1);
}

#[test]
fn export_to_a_closed_pipe_or_a_bad_place_is_no_panic() {
    let mut child = Command::new(env!("CARGO_BIN_EXE_plumb"))
        .args(["export", "pyramids"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!((output.status.code(), output.stderr.len()), (Some(0), 0));
    let refused = Command::new(env!("CARGO_BIN_EXE_plumb"))
        .args(["export", "top", "--out", "/nowhere/top.ron"])
        .output()
        .unwrap();
    assert_eq!(refused.status.code(), Some(2));
    let complaint = String::from_utf8(refused.stderr).unwrap();
    assert!(complaint.contains("/nowhere/top.ron: cannot be written") && complaint.lines().count() == 1);
}

/// A scene after some steps, and as it is captured.
fn captured(scene: &SceneSpec, steps: u32) -> (Simulation, SceneSpec) {
    let mut simulation = Simulation::new(scene.clone(), SolverSettings::default());
    (0..steps).for_each(|_| simulation.step());
    let captured = SceneSpec::of_world(simulation.world_mut(), "captured");
    (simulation, captured)
}

/// Asserts that bodies are in the same states to the last bit, but for the turn of hulls that lie
/// askew in their own axes: to the principal ones and back costs rounding.
#[track_caller]
fn assert_same_states(one: &Simulation, other: &Simulation) {
    assert_eq!(one.scene().bodies.len(), other.scene().bodies.len());
    let bits = |vector: DVec3| vector.to_array().map(f64::to_bits);
    let states = one.sample().bodies.iter().zip(other.sample().bodies);
    for ((one, other), spec) in states.zip(&one.scene().bodies) {
        for (one, other) in [(one.position, other.position), (one.linear, other.linear), (one.angular, other.angular)] {
            assert_eq!(bits(one), bits(other), "{}", spec.name);
        }
        let is_askew = spec.shape.as_ref().is_some_and(|shape| shape.axes() != DQuat::IDENTITY);
        let same_bits = one.rotation.to_array().map(f64::to_bits) == other.rotation.to_array().map(f64::to_bits);
        let near = is_askew && one.rotation.abs_diff_eq(other.rotation, 1e-15);
        assert!(same_bits || near, "{}: {} {}", spec.name, one.rotation, other.rotation);
    }
}

#[test]
fn a_scene_is_captured_as_it_stands_to_the_last_bit() {
    for name in ["limbs", "chain", "card_house", "painleve", "top"] {
        let (simulation, scene) = captured(&load(name, &[]).unwrap(), 100);
        let again = read(&text_of(&scene), "captured.ron");
        assert_eq!(scene, again, "{name}");
        let respawned = Simulation::new(again, SolverSettings::default());
        assert_same_states(&simulation, &respawned);
        for (one, other) in simulation.scene().joints.iter().zip(&scene.joints) {
            assert!(one.anchor_a.abs_diff_eq(other.anchor_a, 1e-15) && one.anchor_b.abs_diff_eq(other.anchor_b, 1e-15));
            let anchors = (one.anchor_a, one.anchor_b);
            let found = JointSpec { anchor_a: anchors.0, anchor_b: anchors.1, ..other.clone() };
            assert_same_joint(&found, one, simulation.scene());
        }
    }
}

/// Axes of the world are frames of the bodies once a joint is seen, and its coordinate is then known.
#[track_caller]
fn assert_same_joint(found: &JointSpec, given: &JointSpec, scene: &SceneSpec) {
    let rotation = |name: &String| scene.bodies.iter().find(|body| body.name == *name).expect("a body").rotation;
    let rotations = [&given.body_a, &given.body_b].map(rotation);
    let [found_frames, frames] = [found, given].map(|joint| joint.axes.frames(rotations));
    for (found, given) in found_frames.into_iter().zip(frames) {
        assert!(
            found.abs_diff_eq(given, 1e-14) || found.abs_diff_eq(-given, 1e-14),
            "{}: {found}, {given}",
            scene.name
        );
    }
    assert_eq!(JointSpec { axes: given.axes, coordinate: given.coordinate, ..found.clone() }, *given, "{}", scene.name);
}

#[test]
fn a_scene_captured_at_its_start_is_the_scene() {
    let files = ["mobile", "wrecking_ball", "example"]
        .map(|name| format!("{}/assets/scenes/{name}.ron", env!("CARGO_MANIFEST_DIR")));
    let scenes = catalog().iter().map(|info| info.make(&info.defaults()).unwrap());
    for scene in scenes.chain(files.map(|file| load(&file, &[]).unwrap())).chain([unusual()]) {
        for steps in [0, 1] {
            let (_, found) = captured(&scene, steps);
            assert_eq!(found.gravity, scene.gravity);
            assert_eq!(found.joints.len(), scene.joints.len());
            for (found, given) in found.joints.iter().zip(&scene.joints) {
                assert_same_joint(found, given, &scene);
            }
            for (found, given) in found.bodies.iter().zip(&scene.bodies) {
                // A hull askew in its own axes turns to its principal ones and back.
                let turned_back = given.shape.as_ref().is_some_and(|shape| shape.axes() != DQuat::IDENTITY);
                let tolerance = if turned_back { 1e-15 } else { 0.0 };
                let same_turn = found.rotation.abs_diff_eq(given.rotation, tolerance);
                assert!(same_turn || steps > 0, "{}: {}", scene.name, given.name);
                // A step moves what moves; all else about each body stays.
                let mut expected = BodySpec { rotation: found.rotation, ..given.clone() };
                if given.mass.is_some() {
                    expected.density = 1000.0; // the mass wins: nothing is left of it
                }
                if steps > 0 {
                    expected.position = found.position;
                    expected.linear_velocity = found.linear_velocity;
                    expected.angular_velocity = found.angular_velocity;
                }
                assert_eq!(*found, expected, "{} after {steps} steps", scene.name);
            }
            assert_eq!(found.bodies.len(), scene.bodies.len());
        }
    }
}

#[test]
fn what_users_add_is_captured_under_names_of_its_own() {
    let mut simulation = Simulation::new(load("stack", &[("n".into(), 2.0)]).unwrap(), SolverSettings::default());
    let world = simulation.world_mut();
    let ball = |world: &mut World, name: &str, height: f64| {
        let body = (Name::new(name.to_owned()), SceneEntity, RigidBody::Dynamic, Collider::sphere(0.1));
        world.spawn((body, Position(DVec3::new(5.0, height, 0.0)), BodyColor([0.5, 0.25, 1.0]))).id()
    };
    let names = ["ball", "ball 2", "ball", "world", "cube 0", "ball"];
    let balls: Vec<Entity> = names.iter().zip(1..).map(|(name, height)| ball(world, name, f64::from(height))).collect();
    world.spawn((SceneEntity, BallJoint::new(balls[0], balls[2])));
    // A hand's joint and its handle are not of the scene.
    let handle = world.spawn((RigidBody::Kinematic, Position(DVec3::ZERO))).id();
    world.spawn(BallJoint::new(handle, balls[1]));
    simulation.step();
    let scene = SceneSpec::of_world(simulation.world_mut(), "mine");
    assert_eq!(scene.name, "mine");
    let found: Vec<_> = scene.bodies.iter().map(|body| &*body.name).collect();
    assert_eq!(found, ["ground", "cube 0", "cube 1", "ball", "ball 2", "ball 3", "body", "cube 0 2", "ball 4"]);
    assert_eq!(scene.bodies[3].color, Some([0.5, 0.25, 1.0]));
    assert_eq!((scene.bodies[3].mass, scene.bodies[3].inertia), (None, None), "they follow from the shape");
    let joints: Vec<_> = scene.joints.iter().map(|joint| (&*joint.body_a, &*joint.body_b)).collect();
    assert_eq!(joints, [("ball", "ball 3")]);
    text_of(&scene);
}

#[test]
fn a_mass_that_was_given_is_kept_and_the_inertia_follows() {
    let mut scene = SceneSpec::new("masses", DVec3::ZERO);
    let cube = ShapeSpec::Cuboid { size: DVec3::new(1.0, 2.0, 3.0) };
    scene.bodies = vec![
        BodySpec::new("by density", cube.clone(), DVec3::ZERO),
        BodySpec::new("by mass", cube.clone(), DVec3::X * 9.0).with_mass(7.0),
        BodySpec { inertia: Some(DVec3::ONE), ..BodySpec::new("by hand", cube, DVec3::X * 18.0) },
    ];
    let (mut simulation, found) = captured(&scene, 3);
    assert_eq!(found.bodies, scene.bodies);
    let first = simulation.entities().bodies[0];
    simulation.world_mut().entity_mut(first).insert(Mass(42.0));
    simulation.step();
    let changed = SceneSpec::of_world(simulation.world_mut(), "changed");
    assert_eq!((changed.bodies[0].mass, changed.bodies[0].inertia), (Some(42.0), None));
}

#[test]
fn a_hull_is_captured_in_the_axes_it_was_given_in() {
    // Askew in its own axes, and hung by a corner.
    let corners = [DVec3::ZERO, DVec3::new(2.0, 0.3, 0.1), DVec3::new(0.2, 1.0, 0.0), DVec3::new(0.4, 0.1, 0.7)];
    let turn = DQuat::from_axis_angle(DVec3::new(0.0, 0.6, 0.8), 0.7);
    let hull = BodySpec::new("hull", ShapeSpec::hull(corners), DVec3::new(0.0, 3.0, 0.0))
        .with_rotation(turn)
        .with_velocity(DVec3::ZERO, DVec3::new(1.0, 2.0, 3.0));
    let pin = BodySpec::pin("world:0", hull.point(DVec3::new(0.5, 0.0, 0.0)));
    let mut scene = SceneSpec::new("hung", DVec3::new(0.0, -9.81, 0.0));
    scene.joints.push(JointSpec::new(&pin, DVec3::ZERO, &hull, DVec3::new(0.5, 0.0, 0.0)));
    scene.bodies = vec![hull, pin];
    let (simulation, found) = captured(&scene, 100);
    assert_eq!(found.bodies[0].shape, scene.bodies[0].shape);
    assert!(found.joints[0].anchor_b.abs_diff_eq(DVec3::new(0.5, 0.0, 0.0), 1e-14));
    let again = read(&text_of(&found), "hung.ron");
    let respawned = Simulation::new(again, SolverSettings::default());
    assert_same_states(&simulation, &respawned);
    let world = simulation.world();
    let body = simulation.entities().bodies[0];
    let point =
        |anchor: DVec3| world.get::<Position>(body).unwrap().0 + world.get::<Rotation>(body).unwrap().0 * anchor;
    let axes = scene.bodies[0].shape.as_ref().unwrap().axes();
    let corner = DVec3::new(0.3, -0.2, 0.1);
    assert!(point(axes.inverse() * corner).abs_diff_eq(found.bodies[0].point(corner), 1e-14));
}

#[test]
fn a_material_of_a_shapeless_body_is_none() {
    let (_, found) = captured(&load("chain", &[]).unwrap(), 1);
    let pin = found.bodies.iter().find(|body| body.shape.is_none()).expect("a pivot");
    assert_eq!(pin.material, MaterialSpec { friction: 0.6, restitution: 0.0 });
}
