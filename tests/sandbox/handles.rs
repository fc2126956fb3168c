//! Moving, turning and scaling what is picked by its handles.

use std::f64::consts::FRAC_PI_2;

use bevy::math::{DQuat, DVec3};
use bevy::prelude::*;
use plumb::lab::state_hash;
use plumb::physics::{Collider, History, Mass, Position, RenderOrigin, Rotation, StepStats, Velocity};
use plumb::sandbox::{Placement, Playback, SandboxAction, Selection, Snap, Tool};
use plumb::scene::{BodySpec, ShapeSpec};

use crate::stage::Stage;

/// Two boxes in the air, a ball that rests, and a bob that hangs.
const SCENE: &str = r#"(
    bodies: [
        (name: "ground", kind: Static, shape: HalfSpace),
        (name: "a", shape: Cuboid(size: (0.6, 0.6, 0.6)), position: (-1.03, 2, 0)),
        (name: "b", shape: Cuboid(size: (0.6, 0.6, 0.6)), position: (0.97, 2, 0)),
        (name: "ball", shape: Sphere(radius: 0.4), position: (-3, 0.4, 0)),
        (name: "bob", shape: Sphere(radius: 0.3), position: (4, 1, 0)),
    ],
    joints: [(body_a: "world", body_b: "bob", at: (4, 3, 0))],
    view: (eye: (1, 3, 12), target: (0, 1.5, 0)),
)"#;

/// How long an arrow is, of the distance from the eye.
const ARROW: f64 = 0.14;

fn pause(stage: &mut Stage, paused: bool) {
    stage.world().resource_mut::<Playback>().paused = paused;
    let mut time = stage.world().resource_mut::<Time<Virtual>>();
    if paused { time.pause() } else { time.unpause() }
}

fn open() -> Stage {
    let mut stage = Stage::open(SCENE);
    // At its very start.
    stage.act(SandboxAction::Reset);
    pause(&mut stage, true);
    stage.frames(1);
    stage.act(SandboxAction::GoToStart);
    stage
}

fn hold(stage: &mut Stage, names: &[&str], tool: Tool) {
    let bodies: Vec<Entity> = names.iter().map(|name| stage.body(name)).collect();
    stage.act(SandboxAction::ChooseTool(tool));
    // As by a click: the inspector opens on the other side.
    let place = stage.position(names[0]);
    let place = stage.seen_at(place);
    stage.jump_to(place);
    stage.world().insert_resource(Selection::of_bodies(bodies));
    stage.frames(2);
}

/// How long arrows are there, m.
fn arrow(stage: &mut Stage, centre: DVec3) -> f64 {
    let eye = stage.camera().translation.as_dvec3() + stage.world().resource::<RenderOrigin>().0;
    ARROW * eye.distance(centre)
}

fn grab(stage: &mut Stage, from: DVec3) {
    let place = stage.seen_at(from);
    stage.jump_to(place);
    stage.frames(2);
    stage.press();
    stage.frames(1);
}

fn drag_to(stage: &mut Stage, to: DVec3) {
    let place = stage.seen_at(to);
    stage.jump_to(place);
    stage.frames(2);
}

fn let_go(stage: &mut Stage) {
    stage.release();
    stage.frames(1);
}

fn rotation(stage: &mut Stage, name: &str) -> DQuat {
    let body = stage.body(name);
    stage.world().get::<Rotation>(body).expect("a pose").0
}

fn near(one: DVec3, other: DVec3, far: f64) -> bool {
    one.distance(other) < far
}

#[test]
fn an_arrow_moves_along_its_axis_and_undo_takes_the_whole_drag_back() {
    let mut stage = open();
    hold(&mut stage, &["a"], Tool::Move);
    let start = stage.position("a");
    let tip = start + DVec3::X * (0.8 * arrow(&mut stage, start));
    grab(&mut stage, tip);
    for part in 1..=5 {
        // The hand wavers.
        let way = DVec3::new(0.2 * f64::from(part), 0.05 * f64::from(part % 2), 0.0);
        drag_to(&mut stage, tip + way);
    }
    drag_to(&mut stage, tip + DVec3::X);
    let_go(&mut stage);
    let end = stage.position("a");
    assert!(near(end, start + DVec3::X, 0.02) && end.y == start.y && end.z == start.z, "{start} to {end}");
    let body = stage.body("a");
    let drawn = stage.world().get::<Transform>(body).expect("a picture").translation;
    assert!(near(drawn.as_dvec3(), end, 1e-5), "it is drawn where it is: {drawn}");
    stage.act(SandboxAction::Undo);
    assert_eq!(stage.position("a"), start);
    stage.act(SandboxAction::Redo);
    assert_eq!(stage.position("a"), end);
    // A click on a body with the tool in hand picks that, and drags nothing.
    let ball = stage.position("ball");
    grab(&mut stage, ball);
    let_go(&mut stage);
    assert_eq!(stage.world().resource::<Selection>().entity(), Some(stage.body("ball")));
}

#[test]
fn all_that_is_picked_moves_as_one_and_to_the_grid_while_ctrl_is_held() {
    let mut stage = open();
    hold(&mut stage, &["a", "b"], Tool::Move);
    let starts = ["a", "b"].map(|name| stage.position(name));
    let centre = starts[0].midpoint(starts[1]);
    let tip = centre + DVec3::Y * (0.8 * arrow(&mut stage, centre));
    grab(&mut stage, tip);
    stage.hold(KeyCode::ControlLeft);
    drag_to(&mut stage, tip + DVec3::Y * 0.53);
    let ends = ["a", "b"].map(|name| stage.position(name));
    assert!(near(ends[0] - starts[0], DVec3::Y * 0.5, 1e-9), "{} to {}", starts[0], ends[0]);
    assert!(near(ends[1] - starts[1], DVec3::Y * 0.5, 1e-9));
    stage.let_go(KeyCode::ControlLeft);
    stage.frames(1);
    let free = stage.position("a").y - starts[0].y;
    assert!((free - 0.53).abs() < 0.02 && (free - 0.5).abs() > 0.005, "without Ctrl it is where the hand is: {free}");
    let_go(&mut stage);
    // The other way round where the grid is switched on.
    stage.world().insert_resource(Snap { is_on: true, grid: 0.25, ..default() });
    let centre = centre + DVec3::Y * free;
    let tip = centre + DVec3::X * (0.8 * arrow(&mut stage, centre));
    grab(&mut stage, tip);
    drag_to(&mut stage, tip + DVec3::X * 0.3);
    let_go(&mut stage);
    let middle = stage.position("a").midpoint(stage.position("b"));
    assert!((middle.x - 0.25).abs() < 1e-9, "the middle of both is on the grid: {middle}");
}

#[test]
fn a_ring_turns_about_the_common_centre() {
    let mut stage = open();
    hold(&mut stage, &["a", "b"], Tool::Turn);
    let centre = stage.position("a").midpoint(stage.position("b"));
    let radius = arrow(&mut stage, centre);
    let on_ring = |angle: f64| centre + DQuat::from_rotation_z(angle) * DVec3::new(radius, 0.0, 0.0);
    grab(&mut stage, on_ring(0.9));
    stage.hold(KeyCode::ControlLeft);
    for part in 1..=6 {
        drag_to(&mut stage, on_ring(0.9 + FRAC_PI_2 * f64::from(part) / 6.0 + 0.02));
    }
    let_go(&mut stage);
    stage.let_go(KeyCode::ControlLeft);
    let end = stage.position("a");
    assert!(near(end, centre + DVec3::NEG_Y, 1e-6), "a quarter turn to the last bit: {end}");
    assert!(rotation(&mut stage, "b").angle_between(DQuat::from_rotation_z(FRAC_PI_2)) < 1e-6);
    stage.act(SandboxAction::Undo);
    assert!(near(stage.position("a"), DVec3::new(-1.03, 2.0, 0.0), 1e-12));
}

#[test]
fn a_box_stretches_and_its_mass_follows() {
    let mut stage = open();
    hold(&mut stage, &["a"], Tool::Scale);
    let body = stage.body("a");
    let before = 216.0; // 1000 kg/m³: no step has seen it yet
    let centre = stage.position("a");
    let arrow = arrow(&mut stage, centre);
    grab(&mut stage, centre + DVec3::X * arrow);
    drag_to(&mut stage, centre + DVec3::X * (2.0 * arrow));
    let_go(&mut stage);
    let spec = BodySpec::of_entity(stage.world(), body).expect("a body");
    let Some(ShapeSpec::Cuboid { size }) = spec.shape else { panic!("a box") };
    assert!(near(size, DVec3::new(1.2, 0.6, 0.6), 0.01), "{size}");
    stage.act(SandboxAction::StepOnce);
    let after = stage.world().get::<Mass>(body).expect("a mass").0;
    assert!((after / before - size.x / 0.6).abs() < 1e-9, "{before} kg to {after} kg");
    stage.act(SandboxAction::Undo);
    stage.act(SandboxAction::StepOnce);
    assert!((stage.world().get::<Mass>(body).expect("a mass").0 - before).abs() < 1e-9);
    // The middle scales all of it, and several bodies about their centre.
    hold(&mut stage, &["ball", "b"], Tool::Scale);
    let centres = ["ball", "b"].map(|name| stage.position(name));
    let centre = centres[0].midpoint(centres[1]);
    grab(&mut stage, centre);
    let place = stage.seen_at(centre) + Vec2::new(30.0, -30.0);
    stage.jump_to(place);
    stage.frames(2);
    let_go(&mut stage);
    let ball = stage.body("ball");
    let radius = stage.world().get::<Collider>(ball).expect("a shape").bounding_radius();
    let factor = radius / 0.4;
    assert!(factor > 1.2, "larger: {factor}");
    let apart = stage.position("ball").distance(stage.position("b"));
    assert!((apart / centres[0].distance(centres[1]) - factor).abs() < 1e-6, "and as much farther apart");
    stage.replays();
}

#[test]
fn while_time_runs_a_hand_holds_what_it_moves_until_it_lets_go() {
    let mut stage = open();
    hold(&mut stage, &["a"], Tool::Move);
    let start = stage.position("a");
    let tip = start + DVec3::Y * (0.8 * arrow(&mut stage, start));
    grab(&mut stage, tip);
    pause(&mut stage, false);
    drag_to(&mut stage, tip + DVec3::Y);
    stage.frames(30);
    let body = stage.body("a");
    let held = stage.position("a");
    assert!(near(held, start + DVec3::Y, 0.03), "{held}");
    assert_eq!(*stage.world().get::<Velocity>(body).expect("a velocity"), Velocity::default());
    stage.release();
    stage.frames(20);
    assert!(stage.position("a").y < held.y - 0.2, "it falls: {}", stage.position("a"));
    stage.replays();
    pause(&mut stage, true);
    stage.act(SandboxAction::Undo);
    assert!(near(stage.position("a"), start, 1e-9), "all of the drag is one deed: {}", stage.position("a"));
}

#[test]
fn escape_takes_a_drag_back() {
    let mut stage = open();
    hold(&mut stage, &["a"], Tool::Move);
    let start = stage.position("a");
    grab(&mut stage, start);
    drag_to(&mut stage, start + DVec3::new(0.5, 0.5, 0.0));
    assert!(!near(stage.position("a"), start, 0.3));
    stage.act(SandboxAction::Escape);
    stage.frames(2);
    assert_eq!(stage.position("a"), start);
    let_go(&mut stage);
    assert_eq!(stage.position("a"), start);
}

/// What was put elsewhere is on the strip of time and in a recording like all that is done from outside.
#[test]
fn what_is_put_elsewhere_is_recorded_and_gone_back_to() {
    let mut stage = open();
    stage.act(SandboxAction::GoToStart);
    let mut hashes = Vec::new();
    let step = |stage: &mut Stage, hashes: &mut Vec<u64>| {
        stage.act(SandboxAction::StepOnce);
        hashes.push(state_hash(stage.world()));
    };
    for _ in 0..20 {
        step(&mut stage, &mut hashes);
    }
    // One in the air, one at rest, and one on a joint.
    let turned = DQuat::from_rotation_y(0.4);
    let [a, ball, bob] = ["a", "ball", "bob"].map(|name| stage.body(name));
    let ways = [(a, DVec3::Y), (ball, DVec3::new(1.0, 0.5, 0.3)), (bob, DVec3::new(0.4, 0.0, 0.2))];
    let world = stage.world();
    let placements = ways.map(|(body, way)| Placement {
        body,
        position: world.get::<Position>(body).expect("a pose").0 + way,
        rotation: (turned * world.get::<Rotation>(body).expect("a pose").0).normalize(),
        shape: (body == ball).then_some(ShapeSpec::Sphere { radius: 0.5 }),
    });
    let (to, before) = (placements[0].position, world.get::<Velocity>(a).copied());
    stage.act(SandboxAction::PlaceBodies { placements: placements.into(), continues: false });
    // It is a part of that moment.
    hashes[19] = state_hash(stage.world());
    assert_eq!(stage.position("a"), to);
    assert_eq!(stage.world().get::<Velocity>(a).copied(), before, "what flies flies on, where time stood still");
    for _ in 0..40 {
        step(&mut stage, &mut hashes);
    }
    let last = stage.world().resource::<StepStats>().steps;
    let first = last - 60;
    for back in [5, 20, 35] {
        stage.act(SandboxAction::GoTo { step: first + back });
        let mut again = Vec::new();
        while stage.world().resource::<StepStats>().steps < last {
            step(&mut stage, &mut again);
        }
        assert_eq!(again, hashes[back as usize..], "on from step {back}");
    }
    stage.replays();
    let history = stage.world().resource::<History>();
    assert!(history.acts().any(|step| step == first + 20), "it is one of the acts");
}

#[test]
fn what_cannot_be_put_there_stays() {
    let mut stage = open();
    let body = stage.body("a");
    let place = stage.position("a");
    for (position, rotation, shape) in [
        (DVec3::NAN, DQuat::IDENTITY, None),
        (DVec3::ZERO, DQuat::from_xyzw(0.0, 0.0, 0.0, 0.5), None),
        (DVec3::ZERO, DQuat::IDENTITY, Some(ShapeSpec::Sphere { radius: -1.0 })),
    ] {
        let placements = vec![Placement { body, position, rotation, shape }];
        stage.act(SandboxAction::PlaceBodies { placements, continues: false });
        assert_eq!(stage.position("a"), place);
        assert!(matches!(stage.world().resource::<plumb::sandbox::Notice>(), plumb::sandbox::Notice::Error(_)));
    }
}

#[test]
fn with_shift_held_a_click_picks_what_is_behind_a_handle() {
    let mut stage = open();
    let (a, b) = (stage.body("a"), stage.body("b"));
    let near = Placement { body: b, position: DVec3::new(0.2, 2.0, 0.0), rotation: DQuat::IDENTITY, shape: None };
    stage.act(SandboxAction::PlaceBodies { placements: vec![near], continues: false });
    hold(&mut stage, &["a"], Tool::Move);
    let (before, behind) = (stage.position("a"), DVec3::new(0.25, 2.0, 0.0));
    stage.hold(KeyCode::ShiftLeft);
    grab(&mut stage, behind);
    let_go(&mut stage);
    stage.let_go(KeyCode::ShiftLeft);
    let picked: Vec<Entity> = stage.world().resource::<Selection>().bodies().collect();
    assert_eq!(picked, [a, b]);
    assert_eq!(stage.position("a"), before);
    // Without it the handle is on top.
    hold(&mut stage, &["a"], Tool::Move);
    grab(&mut stage, behind);
    drag_to(&mut stage, behind + DVec3::X);
    let_go(&mut stage);
    assert!((stage.position("a").x - before.x - 1.0).abs() < 0.02, "{}", stage.position("a"));
}
