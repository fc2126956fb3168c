//! Every action through its message.

use bevy::math::DVec3;
use bevy::prelude::*;
use bevy::render::view::screenshot::Screenshot;
use plumb::physics::{BallJoint, Collider, ContactForces, Mass, RigidBody, Shape, StepStats, Velocity};
use plumb::sandbox::{CurrentScene, Notice, Playback, SandboxAction, Selection, ShownGizmos};

use crate::stage::Stage;

const FALLING: &str = r#"(
    bodies: [
        (name: "hook", kind: Static, position: (0, 3, 0)),
        (name: "bob", shape: Sphere(radius: 0.3), position: (1, 3, 0)),
        (name: "ball", shape: Sphere(radius: 0.3), position: (-1, 3, 0)),
    ],
    joints: [(body_a: "hook", body_b: "bob", at: (0, 3, 0))],
    view: (eye: (0, 2, 8), target: (0, 2, 0)),
)"#;

fn steps(stage: &mut Stage) -> u64 {
    stage.world().resource::<StepStats>().steps
}

fn count<C: Component>(stage: &mut Stage) -> usize {
    let world = stage.world();
    world.query::<&C>().iter(world).count()
}

#[test]
fn pause_stops_time_and_play_goes_on() {
    let mut stage = Stage::open(FALLING);
    stage.act(SandboxAction::TogglePause);
    stage.frames(2);
    let before = stage.position("ball");
    stage.frames(30);
    assert_eq!(stage.position("ball"), before);
    stage.act(SandboxAction::TogglePause);
    stage.frames(30);
    assert!(stage.position("ball").y < before.y - 0.5);
}

#[test]
fn one_step_is_one_step_and_pauses() {
    let mut stage = Stage::open(FALLING);
    stage.act(SandboxAction::StepOnce);
    stage.frames(2);
    assert!(stage.world().resource::<Playback>().paused);
    let before = steps(&mut stage);
    stage.act(SandboxAction::StepOnce);
    stage.act(SandboxAction::StepOnce);
    stage.frames(10);
    assert_eq!(steps(&mut stage), before + 2);
}

#[test]
fn slow_motion_is_a_fifth_of_the_speed() {
    let mut stage = Stage::open(FALLING);
    let mut steps_in = |frames| {
        let before = steps(&mut stage);
        stage.frames(frames);
        let made = steps(&mut stage) - before;
        stage.act(SandboxAction::ToggleSlowMotion);
        made
    };
    let (usual, slow, usual_again) = (steps_in(100), steps_in(100), steps_in(100));
    assert!(usual.abs_diff(100) <= 1, "{usual} steps");
    assert!(slow.abs_diff(20) <= 1, "{slow} steps in slow motion");
    assert!(usual_again.abs_diff(100) <= 1, "{usual_again} steps");
}

#[test]
fn reset_puts_back_what_moved_and_removes_what_was_thrown() {
    let mut stage = Stage::open(FALLING);
    stage.act(SandboxAction::TogglePause);
    stage.act(SandboxAction::Reset);
    let start = [stage.position("ball"), stage.position("bob")];
    let bodies = count::<RigidBody>(&mut stage);
    stage.act(SandboxAction::TogglePause);
    stage.act(SandboxAction::ThrowBall);
    stage.frames(40);
    assert_ne!([stage.position("ball"), stage.position("bob")], start);
    assert_eq!(count::<RigidBody>(&mut stage), bodies + 1);

    stage.act(SandboxAction::TogglePause);
    stage.act(SandboxAction::Reset);
    assert_eq!([stage.position("ball"), stage.position("bob")], start);
    assert_eq!((count::<RigidBody>(&mut stage), count::<BallJoint>(&mut stage)), (bodies, 1));
    assert_eq!(stage.world().resource::<Selection>().entity(), None);
}

#[test]
fn a_thrown_ball_flies_from_the_camera_along_its_view() {
    let mut stage = Stage::open(FALLING);
    stage.act(SandboxAction::TogglePause);
    let before = count::<Velocity>(&mut stage);
    stage.act(SandboxAction::ThrowBall);
    assert_eq!(count::<Velocity>(&mut stage), before + 1);
    let forward = stage.camera().forward().as_dvec3();
    let world = stage.world();
    let fastest = world
        .query::<&Velocity>()
        .iter(world)
        .map(|v| v.linear)
        .fold(DVec3::ZERO, |a, b| if b.length() > a.length() { b } else { a });
    assert!(fastest.length() > 4.0 && fastest.normalize().dot(forward) > 0.9, "its velocity is {fastest}");
}

#[test]
fn a_thrown_ball_is_the_same_from_near_and_far() {
    let mut energies = Vec::new();
    for distance in [5.0, 500.0] {
        let view = format!("view: (eye: (0, 1, {distance}), target: (0, 1, 0))");
        let mut stage = Stage::open(&format!("(bodies: [(name: \"box\", shape: Cuboid(size: (1, 1, 1)))], {view})"));
        stage.act(SandboxAction::TogglePause);
        stage.act(SandboxAction::ThrowBall);
        stage.act(SandboxAction::StepOnce);
        let world = stage.world();
        let mut bodies = world.query::<(&Name, &Mass, &Velocity)>();
        let (_, mass, velocity) = bodies.iter(world).find(|(name, ..)| name.starts_with("thrown")).expect("a ball");
        energies.push(0.5 * mass.0 * velocity.linear.length_squared());
    }
    assert!(energies[1] < 5.0 * energies[0] && energies[1] < 2e5, "{energies:?} J");
}

#[test]
fn delete_removes_the_picked_body_and_its_joints() {
    let mut stage = Stage::open(FALLING);
    let (bob, hook) = (stage.body("bob"), stage.body("hook"));
    stage.act(SandboxAction::DeletePicked);
    assert!(stage.world().get::<RigidBody>(bob).is_some(), "nothing is picked, nothing goes");
    *stage.world().resource_mut::<Selection>() = Selection::of(bob);
    stage.act(SandboxAction::DeletePicked);
    stage.frames(2);
    assert!(stage.world().get::<RigidBody>(bob).is_none());
    assert!(stage.world().get::<RigidBody>(hook).is_some());
    assert_eq!(count::<BallJoint>(&mut stage), 0);
    assert_eq!(stage.world().resource::<Selection>().entity(), None);
}

#[test]
fn escape_unpicks() {
    let mut stage = Stage::open(FALLING);
    let bob = stage.body("bob");
    *stage.world().resource_mut::<Selection>() = Selection::of(bob);
    stage.act(SandboxAction::Escape);
    assert_eq!(stage.world().resource::<Selection>().entity(), None);
}

#[test]
fn frame_scene_brings_the_camera_back() {
    let mut stage = Stage::open(FALLING);
    let start = stage.camera();
    stage.move_to(Vec2::new(300.0, 300.0));
    stage.wheel(-1.0); // the orbit camera may miss the first event of all: it wakes by it
    stage.wheel(-5.0);
    stage.frames(60);
    assert!(stage.camera().translation.distance(start.translation) > 1.0);
    stage.act(SandboxAction::FrameScene);
    stage.frames(2);
    assert!(stage.camera().translation.distance(start.translation) < 1e-3);
}

#[test]
fn a_scene_without_a_view_is_framed_whole() {
    let mut stage = Stage::open(
        r#"(bodies: [
            (name: "ground", shape: HalfSpace),
            (name: "left", shape: Sphere(radius: 1), position: (-20, 1, 0)),
            (name: "right", shape: Sphere(radius: 1), position: (20, 1, 0)),
        ])"#,
    );
    for name in ["left", "right"] {
        let position = stage.position(name);
        let seen = stage.seen_at(position);
        assert!((0.0..crate::stage::SIZE.x).contains(&seen.x), "{name} is at {seen}");
    }
}

#[test]
fn a_bad_scene_is_named_and_the_old_one_stays() {
    let mut stage = Stage::open(FALLING);
    let bodies = count::<RigidBody>(&mut stage);
    stage.act(SandboxAction::LoadScene { scene: "no-such-scene".into(), parameters: Vec::new() });
    let Notice::Error(error) = stage.world().resource::<Notice>().clone() else { panic!("no error") };
    assert!(error.contains("no-such-scene"), "{error}");
    assert_eq!(count::<RigidBody>(&mut stage), bodies);
}

#[test]
fn a_built_in_scene_loads_with_its_parameters() {
    let mut stage = Stage::open(FALLING);
    stage.act(SandboxAction::LoadScene { scene: "stack".into(), parameters: vec![("n".into(), 3.0)] });
    let current = stage.world().resource::<CurrentScene>();
    assert_eq!((current.scene.as_str(), current.parameters.len()), ("stack", 1));
    let world = stage.world();
    let cubes = world.query::<&Collider>().iter(world).filter(|c| matches!(c.shape(), Shape::Cuboid { .. })).count();
    assert_eq!(cubes, 3);
}

#[test]
fn a_screenshot_is_asked_for() {
    let mut stage = Stage::open(FALLING);
    assert_eq!(count::<Screenshot>(&mut stage), 0);
    stage.act(SandboxAction::Screenshot);
    assert_eq!(count::<Screenshot>(&mut stage), 1);
}

#[test]
fn every_body_has_a_mesh_about_its_centre_of_mass() {
    let mut stage =
        Stage::open(r#"(bodies: [(name: "cone", shape: Cone(radius: 0.5, height: 2), position: (0, 1, 0))])"#);
    let cone = stage.body("cone");
    let world = stage.world();
    let mesh = world.get::<Mesh3d>(cone).expect("a mesh on the body itself").0.clone();
    let mesh = world.resource::<Assets<Mesh>>().get(&mesh).unwrap();
    let positions = mesh.attribute(Mesh::ATTRIBUTE_POSITION).unwrap().as_float3().unwrap();
    let scale = world.get::<Transform>(cone).unwrap().scale;
    let heights = positions.iter().map(|p| scale.y * p[1]);
    assert_eq!(heights.clone().fold(f32::MAX, f32::min), -0.5, "the base is a quarter of the height below");
    assert_eq!(heights.fold(f32::MIN, f32::max), 1.5);
}

#[test]
fn contacts_of_the_last_scene_are_not_drawn_over_the_next() {
    let mut stage = Stage::open(FALLING);
    stage.world().resource_mut::<ShownGizmos>().contacts = true;
    stage.act(SandboxAction::LoadScene { scene: "stack".into(), parameters: Vec::new() });
    stage.frames(10);
    assert!(!stage.world().resource::<ContactForces>().0.is_empty());
    stage.act(SandboxAction::TogglePause);
    stage.act(SandboxAction::LoadScene { scene: "pendulum".into(), parameters: Vec::new() });
    assert!(stage.world().resource::<ContactForces>().0.is_empty());
}
