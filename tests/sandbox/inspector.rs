//! The inspector: when it is there, and what it changes of a body.

use bevy::math::DVec3;
use bevy::prelude::*;
use plumb::physics::{Mass, RigidBody, Sensor, SurfaceMaterial, Velocity};
use plumb::sandbox::{Notice, Page, SandboxAction, Selection};
use plumb::scene::{BodySpec, ShapeSpec};

use crate::eyes::{open_eyes, reads, rewrite};
use crate::stage::Stage;

/// A box in the air beside a ball.
const SCENE: &str = r#"(
    bodies: [
        (name: "ground", kind: Static, shape: HalfSpace),
        (name: "box", shape: Cuboid(size: (1, 1, 1)), density: 100, position: (-2, 3, 0)),
        (name: "ball", shape: Sphere(radius: 0.5), mass: 10, position: (2, 0.5, 0)),
    ],
    view: (eye: (0, 2, 12), target: (0, 1.5, 0)),
)"#;

fn change(stage: &mut Stage, name: &str, continues: bool, change: impl FnOnce(&mut BodySpec)) {
    let body = stage.body(name);
    let mut asked = BodySpec::of_entity(stage.world(), body).expect("a body");
    change(&mut asked);
    stage.act(SandboxAction::ChangeBody { body, asked: Box::new(asked), continues });
}

fn mass(stage: &mut Stage, name: &str) -> f64 {
    let body = stage.body(name);
    stage.world().get::<Mass>(body).expect("a mass").0
}

#[test]
fn a_body_that_is_changed_goes_on_as_what_it_is_now_and_undo_takes_it_back() {
    let mut stage = Stage::open(SCENE);
    stage.frames(5);
    assert!((mass(&mut stage, "box") - 100.0).abs() < 1e-9);
    change(&mut stage, "box", false, |body| body.shape = Some(ShapeSpec::Cuboid { size: DVec3::splat(2.0) }));
    stage.frames(5);
    assert!((mass(&mut stage, "box") - 800.0).abs() < 1e-9, "as dense as before: {}", mass(&mut stage, "box"));
    stage.frames(120);
    assert!((stage.position("box").y - 1.0).abs() < 0.01, "it rests on its new faces: {}", stage.position("box"));
    stage.act(SandboxAction::Undo);
    stage.frames(120);
    assert!((mass(&mut stage, "box") - 100.0).abs() < 1e-9);
    assert!((stage.position("box").y - 0.5).abs() < 0.01, "and on its old ones: {}", stage.position("box"));
    stage.act(SandboxAction::Redo);
    stage.frames(10);
    assert!((mass(&mut stage, "box") - 800.0).abs() < 1e-9);
    stage.replays();
}

#[test]
fn mass_surface_kind_and_velocity_are_what_was_asked_for() {
    let mut stage = Stage::open(SCENE);
    let body = stage.body("ball");
    change(&mut stage, "ball", false, |body| {
        body.mass = Some(25.0);
        body.material.friction = 0.1;
        body.linear_velocity = DVec3::X;
        body.name = "marble".into();
    });
    stage.frames(2);
    let world = stage.world();
    assert_eq!(world.get::<Mass>(body).unwrap().0, 25.0);
    assert!((world.get::<SurfaceMaterial>(body).unwrap().friction - 0.1).abs() < 1e-12);
    assert!(world.get::<Velocity>(body).unwrap().linear.x > 0.5);
    assert_eq!(world.get::<Name>(body).unwrap().as_str(), "marble");
    change(&mut stage, "box", false, |body| body.kind = RigidBody::Static);
    let at = stage.position("box");
    stage.frames(60);
    assert_eq!(stage.position("box"), at, "what is static hangs in the air");
    change(&mut stage, "box", false, |body| body.kind = RigidBody::Dynamic);
    stage.frames(60);
    assert!(stage.position("box").y < at.y - 1.0, "and falls again");
    stage.replays();
}

#[test]
fn what_becomes_a_sensor_is_passed_through() {
    let mut stage = Stage::open(SCENE);
    stage.frames(5);
    change(&mut stage, "box", false, |body| body.sensor = true);
    stage.frames(120);
    assert!(stage.position("box").y < -1.0, "the ground holds it: {}", stage.position("box"));
    stage.act(SandboxAction::Undo);
    stage.frames(2);
    let body = stage.body("box");
    assert!(!stage.world().entity(body).contains::<Sensor>(), "that can be taken back");
    stage.replays();
}

#[test]
fn what_makes_no_sense_is_refused() {
    let mut stage = Stage::open(SCENE);
    for (says, make) in [
        ("called box already", (|body: &mut BodySpec| body.name = "box".into()) as fn(&mut BodySpec)),
        ("has a name", |body| body.name = " ".into()),
        ("radius", |body| body.shape = Some(ShapeSpec::Sphere { radius: -1.0 })),
        ("mass", |body| body.mass = Some(0.0)),
    ] {
        let body = stage.body("ball");
        let before = BodySpec::of_entity(stage.world(), body);
        change(&mut stage, "ball", false, make);
        let Notice::Error(said) = stage.world().resource::<Notice>().clone() else {
            panic!("{says}: nothing was said")
        };
        assert!(said.contains(says), "{said}");
        assert_eq!(BodySpec::of_entity(stage.world(), body).map(|body| body.name), before.map(|body| body.name));
    }
}

#[test]
fn one_drag_of_a_value_is_one_deed() {
    let mut stage = Stage::open(SCENE);
    stage.act(SandboxAction::TogglePause);
    for (mass, continues) in [(20.0, false), (30.0, true), (40.0, true)] {
        change(&mut stage, "ball", continues, |body| body.mass = Some(mass));
    }
    stage.act(SandboxAction::Undo);
    stage.act(SandboxAction::StepOnce);
    assert_eq!(mass(&mut stage, "ball"), 10.0);
}

#[test]
fn it_opens_at_a_click_and_not_at_a_drag() {
    // In the middle of a window that is much higher than wide.
    let mut stage = Stage::open(&SCENE.replace("(2, 0.5, 0)", "(0, 0.5, 0)"));
    open_eyes(&mut stage, Page::Play);
    let is_open = |stage: &mut Stage| reads(stage, "Inspector");
    let press_and_move = |stage: &mut Stage, by: Vec2| {
        let ball = stage.position("ball");
        let place = stage.seen_at(ball);
        stage.jump_to(place);
        stage.frames(2);
        stage.press();
        stage.frames(3);
        stage.jump_to(place + by);
        stage.frames(3);
        stage.release();
        stage.frames(5);
    };
    press_and_move(&mut stage, Vec2::new(0.0, -60.0));
    assert!(stage.world().resource::<Selection>().entity().is_some(), "a drag picks");
    assert!(!is_open(&mut stage), "and plays");
    stage.frames(60);
    press_and_move(&mut stage, Vec2::ZERO);
    assert!(is_open(&mut stage), "a click inspects");
    assert!(reads(&mut stage, "radius"), "what it is");
    stage.act(SandboxAction::Escape);
    stage.frames(2);
    assert!(!is_open(&mut stage));
}

#[test]
fn where_a_body_is_can_be_typed() {
    let mut stage = Stage::open_paused(SCENE);
    open_eyes(&mut stage, Page::Build);
    let (before, ball) = (stage.position("ball"), stage.body("ball"));
    stage.world().insert_resource(Selection::of_bodies([ball]));
    stage.frames(3);
    rewrite(&mut stage, "0.500", "at", "4.25");
    assert_eq!(stage.position("ball"), DVec3 { y: 4.25, ..before });
    stage.act(SandboxAction::Undo);
    assert_eq!(stage.position("ball"), before);
}

#[test]
fn to_look_at_what_is_fast_does_not_slow_it_down() {
    let mut stage = Stage::open_paused(SCENE);
    let ball = stage.body("ball");
    let fast = Velocity { linear: DVec3::Y * 2000.0, angular: DVec3::Z * -3000.0 };
    stage.world().entity_mut(ball).insert(fast);
    stage.world().insert_resource(Selection::of_bodies([ball]));
    open_eyes(&mut stage, Page::Build);
    stage.frames(5);
    assert!(reads(&mut stage, "2000.00"), "it is shown");
    assert_eq!(stage.world().get::<Velocity>(ball), Some(&fast));
}
