//! Drags made of pointer messages.

use bevy::math::DVec3;
use bevy::prelude::*;
use plumb::physics::{BallJoint, Damping, Position, RenderOrigin, RigidBody, Rotation, Velocity};
use plumb::sandbox::{SandboxAction, Selection};

use crate::stage::Stage;

/// A free box in weightlessness, so that only the drag moves it.
const BOX: &str = r#"(
    gravity: (0, 0, 0),
    bodies: [(name: "box", shape: Cuboid(size: (1, 1, 1)), mass: 10)],
    view: (eye: (0, 0, 8), target: (0, 0, 0)),
)"#;

/// Bodies and joints that are there for the drag alone.
fn handles(stage: &mut Stage) -> usize {
    let world = stage.world();
    let bodies = world.query_filtered::<&RigidBody, With<Velocity>>().iter(world).count();
    bodies + world.query::<&BallJoint>().iter(world).count()
}

/// Where a point of a body is now; `anchor` in body axes.
fn point_of(stage: &mut Stage, body: Entity, anchor: DVec3) -> DVec3 {
    let body = stage.world().entity(body);
    body.get::<Position>().unwrap().0 + body.get::<Rotation>().unwrap().0 * anchor
}

/// Picks a point of the world's and holds it.
fn grab(stage: &mut Stage, point: DVec3) -> Vec2 {
    let place = stage.seen_at(point);
    stage.move_to(place);
    stage.press();
    place
}

#[test]
fn a_drag_takes_the_held_point_to_the_pointer() {
    let mut stage = Stage::open(BOX);
    let held = DVec3::new(0.3, 0.2, 0.5);
    let place = grab(&mut stage, held);
    stage.move_to(place + Vec2::new(-150.0, -80.0));
    stage.frames(240);

    let body = stage.body("box");
    let now = point_of(&mut stage, body, held);
    let seen = stage.seen_at(now);
    assert!(seen.distance(place + Vec2::new(-150.0, -80.0)) < 2.0, "the held point is seen at {seen}");
    // The plane it moves in is parallel to the picture: no nearer, no farther.
    let depth = stage.depth(now);
    assert!((depth - 7.5).abs() < 0.02, "it is {depth} m away");
    assert_eq!(stage.world().resource::<Selection>().entity(), Some(body));
}

#[test]
fn a_released_body_flies_on_and_leaves_nothing_behind() {
    let mut stage = Stage::open(BOX);
    let before = handles(&mut stage);
    let place = grab(&mut stage, DVec3::ZERO);
    assert_eq!(handles(&mut stage), before + 2, "a handle and a joint");
    stage.move_to(place + Vec2::new(200.0, 0.0));
    stage.release();
    stage.frames(2);
    assert_eq!(handles(&mut stage), before);
    let body = stage.body("box");
    assert!(stage.world().get::<Damping>(body).is_none(), "the grip's drag is gone");
    let at_release = stage.position("box");
    stage.move_to(place);
    stage.frames(30);
    assert!(stage.position("box").x > at_release.x + 0.2, "it keeps its velocity and the pointer no longer holds it");
}

#[test]
fn a_drag_that_starts_over_the_panel_moves_nothing() {
    // A wall that fills the picture, also behind the panel at the right.
    let wall = r#"(
        gravity: (0, 0, 0),
        bodies: [(name: "wall", shape: Cuboid(size: (40, 20, 1)), mass: 10)],
        view: (eye: (0, 0, 8), target: (0, 0, 0)),
    )"#;
    for (x, moves) in [(1180.0, false), (500.0, true)] {
        let mut stage = Stage::open(wall);
        let body = stage.body("wall");
        stage.move_to(Vec2::new(x, 400.0));
        stage.press();
        stage.move_to(Vec2::new(x - 200.0, 400.0));
        stage.frames(30);
        let moved = stage.position("wall").length();
        assert_eq!(moved > 0.5, moves, "pressed at x = {x}, it moved by {moved} m");
        assert_eq!(stage.world().resource::<Selection>().entity() == Some(body), moves);
    }
}

#[test]
fn the_wheel_moves_the_held_body_and_not_the_camera() {
    let mut stage = Stage::open(BOX);
    let camera = stage.camera();
    grab(&mut stage, DVec3::ZERO);
    stage.wheel(3.0);
    stage.frames(90);
    let farther = -stage.position("box").z;
    assert!(farther > 1.0, "three notches up take it away from the camera: {farther} m");
    stage.wheel(-6.0);
    stage.frames(90);
    let nearer = stage.position("box").z;
    assert!(nearer > 1.0, "six down bring it nearer than it was: {nearer} m");
    assert_eq!(stage.camera(), camera, "the camera rests");

    stage.release();
    stage.frames(2);
    stage.wheel(3.0);
    stage.frames(60);
    assert_ne!(stage.camera(), camera, "without a drag the wheel zooms");
}

#[test]
fn a_body_deleted_or_reset_while_it_is_dragged_ends_the_drag() {
    for action in [SandboxAction::DeletePicked, SandboxAction::Reset] {
        let mut stage = Stage::open(BOX);
        let before = handles(&mut stage);
        let bodies_after = if action == SandboxAction::Reset { before } else { before - 1 };
        let place = grab(&mut stage, DVec3::ZERO);
        stage.move_to(place + Vec2::new(100.0, 0.0));
        stage.act(action.clone());
        stage.move_to(place - Vec2::new(100.0, 0.0));
        stage.frames(10);
        assert_eq!(handles(&mut stage), bodies_after, "after {action:?}");
        if action == SandboxAction::Reset {
            assert_eq!(stage.position("box"), DVec3::ZERO, "the new box is not held");
        }
    }
}

#[test]
fn a_pointer_that_jumps_does_not_fling_the_body() {
    let mut stage = Stage::open(BOX);
    let place = grab(&mut stage, DVec3::ZERO);
    let body = stage.body("box");
    let mut fastest = 0.0_f64;
    for i in 0..60 {
        let side = if i % 2 == 0 { 1.0 } else { -1.0 };
        stage.jump_to(place + Vec2::new(side * 450.0, 300.0 * side));
        stage.frames(3);
        let velocity = stage.world().get::<Velocity>(body).unwrap().linear;
        fastest = fastest.max(velocity.length());
        assert!(velocity.is_finite());
    }
    assert!(fastest > 2.0, "it follows ({fastest} m/s)");
    assert!(fastest < 40.0, "but not at any speed ({fastest} m/s)");
    assert!(stage.position("box").length() < 8.0, "it stays in the picture");
}

#[test]
fn a_body_dragged_into_the_ground_stays_on_it() {
    let mut stage = Stage::open(
        r#"(
            bodies: [
                (name: "ground", shape: HalfSpace),
                (name: "box", shape: Cuboid(size: (1, 1, 1)), mass: 10, position: (0, 0.5, 0)),
            ],
            view: (eye: (0, 3, 8), target: (0, 0.5, 0)),
        )"#,
    );
    let place = grab(&mut stage, DVec3::new(0.0, 0.5, 0.5));
    stage.move_to(place + Vec2::new(0.0, 300.0));
    for _ in 0..120 {
        stage.frames(1);
        let height = stage.position("box").y;
        assert!(height > 0.4, "it has sunk to {height}");
    }
}

#[test]
fn a_static_body_is_picked_but_not_dragged() {
    let mut stage = Stage::open(
        r#"(
            gravity: (0, 0, 0),
            bodies: [(name: "post", kind: Static, shape: Sphere(radius: 1))],
            view: (eye: (0, 0, 8), target: (0, 0, 0)),
        )"#,
    );
    let before = handles(&mut stage);
    let place = grab(&mut stage, DVec3::ZERO);
    stage.move_to(place + Vec2::new(100.0, 0.0));
    stage.frames(10);
    let post = stage.body("post");
    assert_eq!(stage.world().resource::<Selection>().entity(), Some(post));
    assert_eq!(handles(&mut stage), before);
    assert_eq!(stage.position("post"), DVec3::ZERO);
}

#[test]
fn far_from_the_origin_a_drag_is_as_exact_as_at_it() {
    let mut stage = Stage::open(
        r#"(
            gravity: (0, 0, 0),
            bodies: [(name: "box", shape: Cuboid(size: (1, 1, 1)), mass: 10, position: (1e7, 0, 0))],
            view: (eye: (1e7, 0, 8), target: (1e7, 0, 0)),
        )"#,
    );
    assert_eq!(stage.world().resource::<RenderOrigin>().0, DVec3::new(1e7, 0.0, 0.0));
    let start = DVec3::new(1e7, 0.0, 0.5);
    let place = grab(&mut stage, start);
    stage.move_to(place + Vec2::new(0.0, -87.0));
    stage.frames(300);
    // 87 px at 7.5 m in a picture of 720 px that is 45° high.
    let expected = 7.5 * (std::f64::consts::PI / 8.0).tan() * 87.0 / 360.0;
    let body = stage.body("box");
    let moved = point_of(&mut stage, body, DVec3::new(0.0, 0.0, 0.5)) - start;
    assert!((moved - DVec3::Y * expected).length() < 5e-3, "it moved by {moved}, expected {expected} up");
}

#[test]
fn the_picture_follows_a_camera_that_goes_far() {
    let mut stage = Stage::open(BOX);
    let world = stage.world();
    let mut cameras = world.query::<&mut bevy_panorbit_camera::PanOrbitCamera>();
    let mut camera = cameras.single_mut(world).unwrap();
    camera.target_focus = Vec3::new(5000.0, 0.0, 0.0);
    stage.frames(120);
    let origin = stage.world().resource::<RenderOrigin>().0;
    assert!((origin - DVec3::new(5000.0, 0.0, 0.0)).length() < 1000.0, "the origin is at {origin}");
    let body = stage.body("box");
    let drawn = stage.world().get::<Transform>(body).unwrap().translation.as_dvec3();
    assert!((drawn + origin).length() < 1e-3, "the box stays where it is in the world");
    assert_eq!(stage.position("box"), DVec3::ZERO, "and is not teleported");
}

/// Two cubes that are one body, with nothing between, before a wall of two triangles.
const DUMB_BELL: &str = r#"(
    gravity: (0, 0, 0),
    bodies: [
        (name: "dumb-bell", mass: 10, shape: Compound(children: [
            (shape: Cuboid(size: (1, 1, 1)), position: (-1, 0, 0)),
            (shape: Cuboid(size: (1, 1, 1)), position: (1, 0, 0)),
        ])),
        (name: "wall", position: (0, 0, -2), shape: Surface(
            vertices: [(-4, -4, 0), (4, -4, 0), (4, 4, 0), (-4, 4, 0)],
            triangles: [(0, 1, 2), (0, 2, 3)],
        )),
    ],
    view: (eye: (0, 0, 8), target: (0, 0, 0)),
)"#;

#[test]
fn a_compound_is_held_by_its_children_and_not_where_it_has_none() {
    let mut stage = Stage::open(DUMB_BELL);
    let (held, body) = (DVec3::new(1.1, 0.2, 0.5), stage.body("dumb-bell"));
    let place = grab(&mut stage, held);
    stage.move_to(place + Vec2::new(40.0, -60.0));
    stage.frames(240);
    let now = point_of(&mut stage, body, held);
    let seen = stage.seen_at(now);
    assert!(seen.distance(place + Vec2::new(40.0, -60.0)) < 2.0, "the held point is seen at {seen}");
    assert_eq!(stage.world().resource::<Selection>().entity(), Some(body));

    let mut stage = Stage::open(DUMB_BELL);
    let (wall, before) = (stage.body("wall"), handles(&mut stage));
    grab(&mut stage, DVec3::ZERO);
    stage.frames(3);
    // What is seen through the gap does not move.
    assert_eq!(stage.world().resource::<Selection>().entity(), Some(wall));
    assert_eq!(handles(&mut stage), before);
}
