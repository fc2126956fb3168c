//! The camera goes along with a body.

use bevy::math::DVec3;
use bevy::prelude::*;
use plumb::physics::{Position, RenderOrigin, Velocity};
use plumb::sandbox::{Notice, SandboxAction, Selection};

use crate::stage::Stage;

/// A ball that is fast enough to be out of the picture in a second.
const LAUNCHED: &str = r#"(
    gravity: (0, 0, 0),
    bodies: [(name: "ball", shape: Sphere(radius: 0.3), velocity: (30, 0, 0))],
    view: (eye: (0, 1, 6), target: (0, 0, 0)),
)"#;

/// From the camera to the ball as it is drawn.
fn offset(stage: &mut Stage) -> Vec3 {
    let ball = stage.body("ball");
    let drawn = *stage.world().get::<Transform>(ball).unwrap();
    drawn.translation - stage.camera().translation
}

fn follow(stage: &mut Stage) {
    let ball = stage.body("ball");
    *stage.world().resource_mut::<Selection>() = Selection::of(ball);
    stage.key(KeyCode::KeyV);
    stage.frames(120); // the view swings to the ball
}

#[test]
fn a_followed_body_stays_where_it_is_in_the_picture() {
    let mut stage = Stage::open(LAUNCHED);
    follow(&mut stage);
    let before = offset(&mut stage);
    stage.frames(120);
    assert!(stage.position("ball").x > 100.0);
    assert!(offset(&mut stage).distance(before) < 0.05, "{before} became {}", offset(&mut stage));

    // As far off as where the origin of the picture goes along.
    let ball = stage.body("ball");
    stage.world().get_mut::<Position>(ball).unwrap().0 = DVec3::new(5000.0, 0.0, 0.0);
    stage.frames(10);
    assert!(stage.world().resource::<RenderOrigin>().0.x > 4000.0);
    assert!(offset(&mut stage).distance(before) < 0.05, "{before} became {}", offset(&mut stage));

    stage.key(KeyCode::KeyV);
    let rested = stage.camera();
    stage.frames(30);
    assert_eq!(stage.camera(), rested, "asked again, it stays");
}

#[test]
fn the_camera_goes_back_with_the_body_at_a_reset_and_to_the_scene_when_that_is_framed() {
    let mut stage = Stage::open(LAUNCHED);
    let start = stage.camera();
    follow(&mut stage);
    let before = offset(&mut stage);
    stage.act(SandboxAction::Reset);
    stage.frames(30);
    assert!(stage.position("ball").x < 30.0);
    assert!(offset(&mut stage).distance(before) < 0.05, "{before} became {}", offset(&mut stage));

    stage.act(SandboxAction::FrameScene);
    stage.frames(30);
    assert!(stage.camera().translation.distance(start.translation) < 1e-3, "it follows no more");
}

#[test]
fn without_a_picked_body_it_says_what_to_do_and_a_body_that_goes_is_let_go() {
    let mut stage = Stage::open(LAUNCHED);
    stage.key(KeyCode::KeyV);
    let notice = stage.world().resource::<Notice>().clone();
    assert!(matches!(&notice, Notice::Error(text) if text.contains("click")), "{notice:?}");

    follow(&mut stage);
    let ball = stage.body("ball");
    *stage.world().resource_mut::<Selection>() = Selection::of(ball);
    stage.act(SandboxAction::DeletePicked);
    let rested = stage.camera();
    stage.frames(30);
    assert_eq!(stage.camera(), rested);
}

#[test]
fn a_followed_body_that_stands_still_leaves_the_camera_to_the_user() {
    let mut stage = Stage::open(LAUNCHED);
    let ball = stage.body("ball");
    stage.world().get_mut::<Velocity>(ball).unwrap().linear = DVec3::ZERO;
    follow(&mut stage);
    let before = stage.camera();
    stage.move_to(Vec2::new(300.0, 300.0));
    stage.wheel(-1.0);
    stage.wheel(-5.0);
    stage.frames(60);
    assert!(stage.camera().translation.distance(before.translation) > 1.0);
}
