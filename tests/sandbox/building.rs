//! Adding, joining, pinning, cutting, and taking it back.

use bevy::math::DVec3;
use bevy::prelude::*;
use plumb::physics::{BallJoint, Collider, Diagnostics, Mass, Position, Quarantined, RigidBody, Rotation, Velocity};
use plumb::sandbox::{Blueprint, MeshForm, Notice, Picked, SandboxAction, Selection, Weight};
use plumb::scene::ShapeSpec;

use crate::stage::{SIZE, Stage};

/// A table on the ground, seen from above; weightless things beside it.
const ROOM: &str = r#"(
    bodies: [
        (name: "ground", shape: HalfSpace),
        (name: "table", kind: Static, shape: Cuboid(size: (2, 1, 2)), position: (0, 0.5, 0)),
        (name: "left", shape: Cuboid(size: (1, 1, 1)), mass: 10, position: (-3, 3, 0), gravity_scale: 0),
        (name: "right", shape: Sphere(radius: 0.5), mass: 10, position: (3, 3, 0), gravity_scale: 0),
        (name: "post", kind: Static, shape: Sphere(radius: 0.3), position: (3, 6, 0)),
    ],
    view: (eye: (0, 6, 14), target: (0, 2, 0)),
)"#;

fn notice(stage: &mut Stage) -> Notice {
    stage.world().resource::<Notice>().clone()
}

#[track_caller]
fn assert_refused(stage: &mut Stage, action: SandboxAction, words: &str) {
    let before = counts(stage);
    stage.act(action);
    let Notice::Error(reason) = notice(stage) else { panic!("no refusal but {:?}", notice(stage)) };
    assert!(reason.contains(words), "{reason}");
    assert_eq!(reason.lines().count(), 1);
    stage.frames(2);
    assert_eq!(counts(stage), before, "nothing has changed");
}

/// Bodies and joints.
fn counts(stage: &mut Stage) -> (usize, usize) {
    let world = stage.world();
    (world.query::<&RigidBody>().iter(world).count(), world.query::<&BallJoint>().iter(world).count())
}

/// The body of that name that the user has added.
fn named(stage: &mut Stage, name: &str) -> Option<Entity> {
    let world = stage.world();
    let mut bodies = world.query_filtered::<(Entity, &Name), With<RigidBody>>();
    bodies.iter(world).find(|(_, own)| own.as_str() == name).map(|(entity, _)| entity)
}

fn added(stage: &mut Stage, name: &str) -> Entity {
    named(stage, name).unwrap_or_else(|| panic!("no body {name}: {:?}", notice(stage)))
}

fn place(stage: &mut Stage, body: Entity) -> DVec3 {
    stage.world().get::<Position>(body).unwrap().0
}

/// Adds a body where a point of the world is seen, the world standing still.
fn add_at(stage: &mut Stage, shape: ShapeSpec, point: DVec3) {
    stage.world().resource_mut::<Blueprint>().shape = shape;
    let seen = stage.seen_at(point);
    stage.move_to(seen);
    stage.key(KeyCode::KeyA);
}

fn paused(scene: &str) -> Stage {
    let mut stage = Stage::open(scene);
    stage.act(SandboxAction::TogglePause);
    stage.frames(2);
    stage
}

fn pick(stage: &mut Stage, a: Picked, b: Option<Picked>) {
    *stage.world().resource_mut::<Selection>() = Selection { body: Some(a), partner: b, ..default() };
}

fn at(entity: Entity, x: f64, y: f64, z: f64) -> Picked {
    Picked { entity, point: DVec3::new(x, y, z), normal: None }
}

/// The two ends of the only joint, world.
fn joint_ends(stage: &mut Stage) -> [DVec3; 2] {
    let world = stage.world();
    let ball = *world.query::<&BallJoint>().single(world).expect("one joint");
    [(ball.body_a, ball.anchor_a), (ball.body_b, ball.anchor_b)].map(|(body, anchor)| {
        let body = world.entity(body);
        body.get::<Position>().unwrap().0 + body.get::<Rotation>().unwrap().0 * anchor
    })
}

#[test]
fn a_body_is_added_on_the_surface_that_is_pointed_at() {
    let mut stage = paused(ROOM);
    let shapes = [
        (ShapeSpec::Cuboid { size: DVec3::new(0.4, 0.6, 0.4) }, "box", 0.3),
        (ShapeSpec::Sphere { radius: 0.2 }, "ball", 0.2),
        (ShapeSpec::Cylinder { radius: 0.2, height: 0.4 }, "cylinder", 0.2),
        (ShapeSpec::Cone { radius: 0.2, height: 0.4 }, "cone", 0.1),
    ];
    for (i, (shape, name, height)) in shapes.into_iter().enumerate() {
        for (point, name) in [
            (DVec3::new(-0.7 + 0.45 * i as f64, 1.0, 0.0), name.to_owned()),
            (DVec3::new(-0.8 + 0.6 * i as f64, 0.0, 4.0), format!("{name} 2")),
        ] {
            add_at(&mut stage, shape.clone(), point);
            let body = added(&mut stage, &name);
            let off = place(&mut stage, body) - (point + DVec3::Y * height);
            assert!(off.length() < 0.01, "{name} is off by {off}");
            assert!(off.y > 0.0, "{name} is above the surface, not in it");
        }
    }
    stage.act(SandboxAction::TogglePause);
    stage.frames(60);
    let ball = added(&mut stage, "box");
    assert!((place(&mut stage, ball).y - 1.3).abs() < 0.01, "and stays there");
}

#[test]
fn bodies_added_at_one_place_pile_up_without_overlapping() {
    let mut stage = paused(ROOM);
    stage.world().insert_resource(Diagnostics::default());
    // At the foot of the table's side, where half of the box would be in the ground.
    for _ in 0..6 {
        add_at(&mut stage, ShapeSpec::Cuboid { size: DVec3::splat(0.7) }, DVec3::new(0.0, 0.1, 1.0));
    }
    stage.act(SandboxAction::StepOnce);
    let depth = stage.world().resource::<Diagnostics>().penetration;
    assert!(depth < 1e-3, "the deepest overlap is {depth} m");
    let world = stage.world();
    let fastest = world.query::<&Velocity>().iter(world).map(|v| v.linear.length()).fold(0.0, f64::max);
    assert!(fastest < 1.0, "nothing is thrown off: {fastest} m/s");
    assert!(named(&mut stage, "box 6").is_some());
}

#[test]
fn into_empty_space_a_body_is_added_at_a_fair_distance() {
    let mut stage = paused(
        r#"(gravity: (0, 0, 0), bodies: [(name: "far", kind: Static, shape: Sphere(radius: 300), position: (0, 0, -1000))],
            view: (eye: (0, 0, 10), target: (0, 0, 0)))"#,
    );
    add_at(&mut stage, ShapeSpec::Sphere { radius: 0.3 }, DVec3::ZERO);
    let ball = added(&mut stage, "ball");
    let off = place(&mut stage, ball);
    assert!(off.length() < 0.05, "it is {off} from what the camera orbits, not on the distant ball");
}

#[test]
fn with_the_pointer_on_the_panel_a_body_goes_to_the_middle_of_the_free_picture() {
    let mut stage = paused(ROOM);
    stage.move_to(Vec2::new(SIZE.x - 100.0, 200.0));
    let window = stage.window();
    let position = Vec2::new(SIZE.x - 100.0, 200.0);
    stage.world().write_message(bevy::window::CursorMoved { window, position, delta: None });
    stage.frames(3);
    stage.act(SandboxAction::SpawnBody);
    let body = added(&mut stage, "box");
    // The camera looks at (0, 2, 0) from in front and above: behind it lies the table's top.
    let (x, y) = (place(&mut stage, body).x, place(&mut stage, body).y);
    assert!(x.abs() < 0.01 && y < 2.0, "it is at x = {x}, y = {y}");
}

#[test]
fn weight_is_a_density_or_a_mass() {
    let mut stage = paused(ROOM);
    for (weight, mass) in [(Weight::Density(500.0), 62.5), (Weight::Mass(3.0), 3.0)] {
        stage.world().resource_mut::<Blueprint>().weight = weight;
        assert_eq!(stage.world().resource::<Blueprint>().mass(), mass);
        add_at(&mut stage, ShapeSpec::Cuboid { size: DVec3::splat(0.5) }, DVec3::new(0.0, 1.0, 0.0));
        stage.act(SandboxAction::StepOnce);
        stage.frames(1);
        let body = added(&mut stage, "box");
        assert!((stage.world().get::<Mass>(body).unwrap().0 - mass).abs() < 1e-9);
        stage.act(SandboxAction::Undo);
    }
}

#[test]
fn a_shape_that_makes_no_sense_is_refused() {
    let mut stage = paused(ROOM);
    stage.world().resource_mut::<Blueprint>().shape = ShapeSpec::Sphere { radius: -1.0 };
    assert_refused(&mut stage, SandboxAction::SpawnBody, "must be greater than 0");
}

#[test]
fn two_picked_bodies_are_joined_where_the_second_was_clicked() {
    let mut stage = Stage::open(ROOM);
    let (left, right) = (stage.body("left"), stage.body("right"));
    let front = DVec3::new(-3.0, 3.0, 0.5);
    let spot = stage.seen_at(front);
    stage.move_to(spot);
    stage.press();
    stage.release();
    let spot = stage.seen_at(DVec3::new(3.0, 3.0, 0.5));
    stage.move_to(spot);
    stage.hold(KeyCode::ShiftLeft);
    stage.press();
    stage.release();
    stage.let_go(KeyCode::ShiftLeft);
    let selection = stage.world().resource::<Selection>().clone();
    assert_eq!(selection.picks().map(|picked| picked.entity).collect::<Vec<_>>(), [left, right]);
    assert_eq!(counts(&mut stage).1, 0, "nothing is dragged");

    stage.key(KeyCode::KeyJ);
    let ends = joint_ends(&mut stage);
    assert!(ends[1].distance(DVec3::new(3.0, 3.0, 0.5)) < 0.1, "it is at {}", ends[1]);
    stage.world().insert_resource(Diagnostics::default());
    stage.world().get_mut::<Velocity>(left).unwrap().linear = DVec3::new(0.0, 4.0, 0.0);
    stage.frames(90);
    let error = stage.world().resource::<Diagnostics>().joint_error;
    assert!(error < 0.01, "the joint holds: {error} m apart");
    assert!(stage.position("right").distance(DVec3::new(3.0, 3.0, 0.0)) > 0.3, "the one takes the other along");
    assert!(matches!(notice(&mut stage), Notice::Info(text) if text == "joined left to right by a ball joint"));
}

#[test]
fn joins_that_make_no_sense_are_refused() {
    let mut stage = paused(ROOM);
    let [left, right, post, table] = ["left", "right", "post", "table"].map(|name| stage.body(name));
    assert_refused(&mut stage, SandboxAction::JoinPicked, "pick two bodies");
    pick(&mut stage, at(left, 0.0, 0.0, 0.0), None);
    assert_refused(&mut stage, SandboxAction::JoinPicked, "pick two bodies");
    pick(&mut stage, at(left, 0.0, 0.0, 0.0), Some(at(left, 0.5, 0.0, 0.0)));
    assert_refused(&mut stage, SandboxAction::JoinPicked, "itself");
    pick(&mut stage, at(post, 0.0, 0.0, 0.0), Some(at(table, 0.0, 0.5, 0.0)));
    assert_refused(&mut stage, SandboxAction::JoinPicked, "can move");

    pick(&mut stage, at(left, 0.0, 0.0, 0.0), Some(at(right, 0.0, 0.5, 0.0)));
    stage.act(SandboxAction::JoinPicked);
    assert_eq!(counts(&mut stage).1, 1);
    assert_refused(&mut stage, SandboxAction::JoinPicked, "already");
    // At another place it makes an axis of the two.
    pick(&mut stage, at(left, 0.0, 0.0, 0.0), Some(at(right, 0.0, -0.5, 0.0)));
    stage.act(SandboxAction::JoinPicked);
    assert_eq!(counts(&mut stage).1, 2);
    let world = stage.world();
    assert_eq!(world.query::<&Quarantined>().iter(world).count(), 0);
}

#[test]
fn a_pinned_body_hangs_where_it_was_clicked() {
    let mut stage = Stage::open(
        r#"(bodies: [(name: "rod", shape: Cuboid(size: (2, 0.1, 0.1)), position: (0, 3, 0))],
            view: (eye: (0, 3, 8), target: (0, 3, 0)))"#,
    );
    stage.act(SandboxAction::TogglePause);
    stage.act(SandboxAction::Reset);
    let rod = stage.body("rod");
    pick(&mut stage, at(rod, -1.0, 0.0, 0.0), None);
    stage.key(KeyCode::KeyW);
    assert_eq!(counts(&mut stage), (2, 1));
    stage.act(SandboxAction::TogglePause);
    stage.frames(120);
    let [pin, held] = joint_ends(&mut stage);
    assert_eq!(pin, DVec3::new(-1.0, 3.0, 0.0));
    assert!(held.distance(pin) < 0.01, "it slipped by {}", held.distance(pin));
    assert!((stage.position("rod").distance(pin) - 1.0).abs() < 0.01);

    stage.act(SandboxAction::Undo);
    assert_eq!(counts(&mut stage), (1, 0), "the pin goes with its joint");
    let before = stage.position("rod").y;
    stage.frames(30);
    assert!(stage.position("rod").y < before - 0.5, "and the rod falls");
}

#[test]
fn what_does_not_move_is_not_pinned() {
    let mut stage = paused(ROOM);
    assert_refused(&mut stage, SandboxAction::PinPicked, "pick a body");
    let post = stage.body("post");
    pick(&mut stage, at(post, 0.0, 0.0, 0.0), None);
    assert_refused(&mut stage, SandboxAction::PinPicked, "cannot move");
}

/// Three beads in a row, each joined to the next.
const BEADS: &str = r#"(
    gravity: (0, 0, 0),
    bodies: [
        (name: "a", shape: Sphere(radius: 0.4), position: (-1, 0, 0)),
        (name: "b", shape: Sphere(radius: 0.4), color: (1, 0, 0), restitution: 0.7, mass: 5, velocity: (0, 0, 0.5)),
        (name: "c", shape: Sphere(radius: 0.4), position: (1, 0, 0)),
    ],
    joints: [
        (body_a: "a", body_b: "b", at: (-0.5, 0, 0)),
        (body_a: "b", body_b: "c", at: (0.5, 0, 0)),
    ],
    view: (eye: (0, 0, 8), target: (0, 0, 0)),
)"#;

/// The names of all joints, sorted.
fn joint_names(stage: &mut Stage) -> Vec<String> {
    let world = stage.world();
    let mut names: Vec<_> = world.query::<(&Name, &BallJoint)>().iter(world).map(|(n, _)| n.to_string()).collect();
    names.sort();
    names
}

#[test]
fn the_joint_nearest_the_pointer_is_cut() {
    let (first, second) = (DVec3::new(-0.5, 0.0, 0.0), DVec3::new(0.5, 0.0, 0.0));
    for (picked, pointer, left) in [
        (None, first, vec!["b to c"]),
        (None, second, vec!["a to b"]),
        (Some("b"), second, vec!["a to b"]),
        (Some("a"), second, vec!["b to c"]),
        (Some("b"), first, vec!["b to c"]),
    ] {
        let mut stage = paused(BEADS);
        if let Some(name) = picked {
            let body = stage.body(name);
            pick(&mut stage, at(body, 0.0, 0.0, 0.0), None);
        }
        let seen = stage.seen_at(pointer);
        stage.move_to(seen);
        stage.key(KeyCode::KeyC);
        assert_eq!(joint_names(&mut stage), left, "{picked:?} picked, pointer at {pointer}");
    }
}

#[test]
fn a_joint_is_cut_between_two_picked_bodies_or_by_its_own_button() {
    let mut stage = paused(BEADS);
    let [a, b, c] = ["a", "b", "c"].map(|name| stage.body(name));
    pick(&mut stage, at(a, 0.0, 0.0, 0.0), Some(at(c, 0.0, 0.0, 0.0)));
    assert_refused(&mut stage, SandboxAction::CutPicked, "between");
    pick(&mut stage, at(c, 0.0, 0.0, 0.0), Some(at(b, 0.0, 0.0, 0.0)));
    stage.act(SandboxAction::CutPicked);
    assert_eq!(joint_names(&mut stage), ["a to b"]);
    pick(&mut stage, at(c, 0.0, 0.0, 0.0), None);
    assert_refused(&mut stage, SandboxAction::CutPicked, "c has no joint");

    let world = stage.world();
    let joint = world.query_filtered::<Entity, With<BallJoint>>().single(world).unwrap();
    stage.act(SandboxAction::Cut(joint));
    assert_eq!(joint_names(&mut stage), Vec::<String>::new());
    assert_refused(&mut stage, SandboxAction::Cut(joint), "gone");
    *stage.world().resource_mut::<Selection>() = Selection::default();
    stage.move_to(Vec2::new(30.0, 30.0));
    assert_refused(&mut stage, SandboxAction::CutPicked, "no joint there");
}

#[test]
fn the_joint_that_the_pointer_is_on_is_cut_though_two_bodies_are_picked() {
    let mut stage = paused(BEADS);
    let [a, b] = ["a", "b"].map(|name| stage.body(name));
    pick(&mut stage, at(a, 0.0, 0.0, 0.0), Some(at(b, 0.0, 0.0, 0.0)));
    let second = stage.seen_at(DVec3::new(0.5, 0.0, 0.0));
    stage.move_to(second);
    stage.key(KeyCode::KeyC);
    assert_eq!(joint_names(&mut stage), ["a to b"]);
    // On none, it is the one between the two.
    stage.jump_to(Vec2::new(100.0, 100.0));
    stage.key(KeyCode::KeyC);
    assert_eq!(joint_names(&mut stage), Vec::<String>::new());
}

#[test]
fn the_joint_that_drags_is_never_cut_or_listed() {
    let mut stage = Stage::open(BEADS);
    let spot = stage.seen_at(DVec3::new(0.0, 0.0, 0.4));
    stage.move_to(spot);
    stage.press();
    assert_eq!(counts(&mut stage), (4, 3));
    for _ in 0..2 {
        stage.key(KeyCode::KeyC);
    }
    assert_refused(&mut stage, SandboxAction::CutPicked, "b has no joint");
}

#[test]
fn undo_takes_back_one_deed_after_the_other() {
    let mut stage = paused(BEADS);
    let [a, b, c] = ["a", "b", "c"].map(|name| stage.body(name));
    let start = (counts(&mut stage), joint_names(&mut stage));
    pick(&mut stage, at(a, 0.0, 0.4, 0.0), Some(at(c, 0.0, 0.4, 0.0)));
    stage.act(SandboxAction::JoinPicked);
    pick(&mut stage, at(b, 0.0, 0.4, 0.0), None);
    stage.act(SandboxAction::PinPicked);
    add_at(&mut stage, ShapeSpec::Sphere { radius: 0.2 }, DVec3::new(0.0, 2.0, 0.0));
    assert_eq!(counts(&mut stage), (5, 4));
    let full = joint_names(&mut stage);

    // The pin goes with its only joint, and comes back with it.
    stage.act(SandboxAction::CutPicked);
    pick(&mut stage, at(b, 0.0, 0.0, 0.0), None);
    while joint_names(&mut stage).iter().any(|name| name.contains("the world")) {
        stage.act(SandboxAction::CutPicked);
    }
    assert_eq!(counts(&mut stage).0, 4);
    while counts(&mut stage).1 < 4 {
        stage.key_with_control(KeyCode::KeyZ);
    }
    assert_eq!((counts(&mut stage), joint_names(&mut stage)), ((5, 4), full));

    let said: Vec<String> = (0..3)
        .map(|_| {
            stage.key_with_control(KeyCode::KeyZ);
            match notice(&mut stage) {
                Notice::Info(text) => text,
                other => panic!("{other:?}"),
            }
        })
        .collect();
    assert_eq!(said, ["undid adding ball", "undid pinning b", "undid joining a to c"]);
    assert_eq!((counts(&mut stage), joint_names(&mut stage)), start);
    assert_refused(&mut stage, SandboxAction::Undo, "nothing to undo");
}

#[test]
fn a_deleted_body_comes_back_as_it_was_with_its_joints() {
    let mut stage = Stage::open(BEADS);
    let b = stage.body("b");
    stage.frames(10);
    stage.act(SandboxAction::TogglePause);
    stage.frames(2);
    // Deleted while a hand holds it: the hand's drag must not come back with it.
    let position = place(&mut stage, b);
    let velocity = *stage.world().get::<Velocity>(b).unwrap();
    let spot = stage.seen_at(position);
    stage.move_to(spot);
    stage.press();
    stage.act(SandboxAction::DeletePicked);
    stage.release();
    stage.frames(2);
    stage.act(SandboxAction::StepOnce);
    assert_eq!(counts(&mut stage), (2, 0));
    assert!(named(&mut stage, "b").is_none());

    stage.act(SandboxAction::Undo);
    let again = added(&mut stage, "b");
    assert_eq!((counts(&mut stage), joint_names(&mut stage)), ((3, 2), vec!["a to b".into(), "b to c".into()]));
    assert_eq!(place(&mut stage, again), position);
    let body = stage.world().entity(again);
    assert_eq!(body.get::<Velocity>(), Some(&velocity));
    assert_eq!(body.get::<Mass>(), Some(&Mass(5.0)));
    assert_eq!(body.get::<plumb::physics::SurfaceMaterial>().unwrap().restitution, 0.7);
    assert_eq!(body.get::<plumb::physics::Damping>(), None);
    assert!(matches!(body.get::<Collider>().unwrap().shape(), plumb::physics::Shape::Sphere { radius: 0.4 }));
    stage.frames(2);
    stage.act(SandboxAction::TogglePause);
    stage.world().insert_resource(Diagnostics::default());
    stage.frames(60);
    assert!(stage.world().resource::<Diagnostics>().joint_error < 0.01, "its joints hold");
}

#[test]
fn deeds_older_than_a_deletion_mean_the_body_that_came_back() {
    let mut stage = paused(BEADS);
    let [a, c] = ["a", "c"].map(|name| stage.body(name));
    pick(&mut stage, at(a, 0.0, 0.4, 0.0), Some(at(c, 0.0, 0.4, 0.0)));
    stage.act(SandboxAction::JoinPicked);
    pick(&mut stage, at(a, 0.0, 0.0, 0.0), None);
    stage.act(SandboxAction::DeletePicked);
    stage.act(SandboxAction::StepOnce);
    assert_eq!(joint_names(&mut stage), ["b to c"]);
    stage.act(SandboxAction::Undo);
    assert_eq!(joint_names(&mut stage), ["a to b", "a to c", "b to c"]);
    stage.act(SandboxAction::Undo);
    assert_eq!(joint_names(&mut stage), ["a to b", "b to c"]);
}

#[test]
fn what_is_gone_is_not_undone_and_the_next_undo_goes_on() {
    let mut stage = paused(BEADS);
    let [a, b, c] = ["a", "b", "c"].map(|name| stage.body(name));
    pick(&mut stage, at(b, 0.0, 0.4, 0.0), None);
    stage.act(SandboxAction::PinPicked);
    pick(&mut stage, at(a, 0.0, 0.4, 0.0), Some(at(c, 0.0, 0.4, 0.0)));
    stage.act(SandboxAction::JoinPicked);
    stage.world().despawn(a); // by somebody else
    stage.act(SandboxAction::StepOnce);
    let left = counts(&mut stage);
    stage.act(SandboxAction::Undo);
    assert!(matches!(notice(&mut stage), Notice::Error(text) if text.contains("gone")));
    assert_eq!(counts(&mut stage), left);
    stage.act(SandboxAction::Undo);
    assert_eq!(counts(&mut stage), (left.0 - 1, left.1 - 1), "the pin");
}

#[test]
fn what_was_built_comes_back_after_a_new_start_or_another_scene() {
    for action in [SandboxAction::Reset, SandboxAction::LoadScene { scene: "stack".into(), parameters: Vec::new() }] {
        let mut stage = paused(BEADS);
        let [a, b] = ["a", "b"].map(|name| stage.body(name));
        pick(&mut stage, at(b, 0.0, 0.4, 0.0), None);
        stage.act(SandboxAction::PinPicked);
        add_at(&mut stage, ShapeSpec::Sphere { radius: 0.2 }, DVec3::new(0.0, 2.0, 0.0));
        stage.world().get_mut::<Position>(a).unwrap().0.z = -0.25;
        let (built, camera) = (counts(&mut stage), stage.camera());
        stage.act(action.clone());
        assert_ne!(counts(&mut stage), built);
        let Notice::Info(said) = notice(&mut stage) else { panic!("{:?}", notice(&mut stage)) };
        assert!(said.contains("Ctrl+Z"), "{said}");

        stage.act(SandboxAction::Undo);
        stage.frames(2);
        assert_eq!(counts(&mut stage), built, "{action:?}");
        assert_eq!(stage.position("a").z, -0.25);
        assert!(named(&mut stage, "ball").is_some());
        assert!(stage.camera().translation.distance(camera.translation) < 1e-4);
        // It goes on as that scene: the pin goes with its joint, and a reset puts it back to its own start.
        let b = stage.body("b");
        pick(&mut stage, at(b, 0.0, 0.4, 0.0), None);
        let pinned = stage.seen_at(DVec3::new(0.0, 0.4, 0.0));
        stage.move_to(pinned);
        stage.act(SandboxAction::CutPicked);
        assert_eq!(counts(&mut stage), (built.0 - 1, built.1 - 1), "the pin is gone too");
        stage.act(SandboxAction::Reset);
        assert_eq!((stage.position("a").z, named(&mut stage, "ball")), (0.0, None));
    }
}

#[test]
fn where_nothing_was_built_nothing_is_kept() {
    let mut stage = paused(BEADS);
    for action in [SandboxAction::Reset, SandboxAction::LoadScene { scene: "stack".into(), parameters: Vec::new() }] {
        stage.act(action);
        assert_refused(&mut stage, SandboxAction::Undo, "nothing to undo");
    }
}

#[test]
fn names_stay_unique() {
    let mut stage = paused(BEADS);
    for _ in 0..3 {
        stage.act(SandboxAction::ThrowBall);
        stage.act(SandboxAction::SpawnBody);
    }
    let world = stage.world();
    let mut names: Vec<String> =
        world.query_filtered::<&Name, With<RigidBody>>().iter(world).map(ToString::to_string).collect();
    let all = names.len();
    names.sort();
    names.dedup();
    assert_eq!(names.len(), all, "{names:?}");
}

/// A slab that lies askew in its own coordinates, far from their origin.
const SLAB: &str = "v 10 0 0\nv 12 1 0\nv 11.8 1.4 0\nv 9.8 0.4 0\nv 10 0 1\nv 12 1 1\nv 11.8 1.4 1\nv 9.8 0.4 1\n\
                    f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

#[test]
fn a_mesh_is_added_as_it_stands_in_its_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("slab.obj");
    std::fs::write(&path, SLAB).unwrap();
    let mut stage = paused(ROOM);
    let file = path.to_str().unwrap().to_owned();
    stage.act(SandboxAction::ChooseMesh { file, scale: 0.5, form: MeshForm::Hull });
    let point = DVec3::new(0.0, 1.0, 0.0);
    let seen = stage.seen_at(point);
    stage.move_to(seen);
    stage.key(KeyCode::KeyA);
    let slab = added(&mut stage, "slab");
    // Its lowest corner is 0.7 below the middle of the file's heights 0 to 1.4, at half the size.
    let off = place(&mut stage, slab) - (point + DVec3::Y * 0.35);
    assert!(off.length() < 0.01 && off.y > 0.0, "off by {off}");
    stage.act(SandboxAction::StepOnce);
    let mass = stage.world().get::<Mass>(slab).unwrap().0;
    assert!((mass - 125.0).abs() < 1.0, "0.125 m³ of it weigh {mass} kg");

    // It comes back in the same pose, as the same mesh.
    *stage.world().resource_mut::<Selection>() = Selection::of(slab);
    let pose = (place(&mut stage, slab), stage.world().get::<Rotation>(slab).unwrap().0);
    stage.act(SandboxAction::DeletePicked);
    stage.act(SandboxAction::Undo);
    let slab = added(&mut stage, "slab");
    assert!(stage.world().get::<plumb::scene::PictureMesh>(slab).is_some());
    assert_eq!(place(&mut stage, slab), pose.0);
    assert!(stage.world().get::<Rotation>(slab).unwrap().0.angle_between(pose.1) < 1e-6);
}

#[test]
fn every_mesh_that_comes_with_plumb_can_be_added() {
    let mut stage = paused(ROOM);
    for file in plumb::scene::builtin_meshes() {
        let before = counts(&mut stage).0;
        stage.act(SandboxAction::ChooseMesh { file: file.clone(), scale: 1.0, form: MeshForm::Hull });
        stage.act(SandboxAction::SpawnBody);
        assert_eq!(counts(&mut stage).0, before + 1, "{file}: {:?}", notice(&mut stage));
    }
}

#[test]
fn a_mesh_that_cannot_be_had_is_named_and_the_last_shape_stays() {
    let mut stage = paused(ROOM);
    let shape = stage.world().resource::<Blueprint>().shape.clone();
    for (file, scale, words) in
        [("no/such.obj", 1.0, "such.obj"), ("plumb:no.obj", 1.0, "plumb:"), ("plumb:gem.obj", -1.0, "greater than 0")]
    {
        assert_refused(&mut stage, SandboxAction::ChooseMesh { file: file.into(), scale, form: MeshForm::Hull }, words);
        assert_eq!(stage.world().resource::<Blueprint>().shape, shape);
    }
}
