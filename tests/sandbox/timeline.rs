//! Back to what happened, on from there, backwards, round and round.

use bevy::math::DVec3;
use bevy::prelude::*;
use plumb::physics::{BallJoint, History, JointCoordinate, Position, RenderOrigin, RigidBody, StepStats};
use plumb::sandbox::{
    GhostChoice, GhostReadings, Ghosts, Notice, Playback, SandboxAction, Selection, ShownStep, Timeline,
};

use crate::stage::{SIZE, Stage};

/// A box that falls beside one that hangs, and a ground far below.
const SCENE: &str = r#"(
    bodies: [
        (name: "ground", kind: Static, shape: HalfSpace, position: (0, -3, 0)),
        (name: "box", shape: Cuboid(size: (1, 1, 1)), mass: 10, position: (-1.5, 1, 0)),
        (name: "bob", shape: Sphere(radius: 0.5), mass: 10, position: (2, 1, 0)),
    ],
    joints: [(body_a: "world", body_b: "bob", at: (0, 2, 0))],
    view: (eye: (0, 0, 10), target: (0, 0, 0)),
)"#;

fn step(stage: &mut Stage) -> u64 {
    stage.world().resource::<StepStats>().steps
}

fn reach(stage: &mut Stage) -> [u64; 2] {
    stage.world().resource::<History>().reach()
}

fn go(stage: &mut Stage, step: u64) {
    stage.act(SandboxAction::GoTo { step });
}

fn named(stage: &mut Stage, name: &str) -> Vec<Entity> {
    let world = stage.world();
    let mut names = world.query::<(Entity, &Name)>();
    names.iter(world).filter(|(_, found)| found.as_str() == name).map(|(entity, _)| entity).collect()
}

/// Runs on until the world has made so many steps, and tells where the body is after each.
fn play_to(stage: &mut Stage, name: &str, last: u64) -> Vec<(u64, DVec3)> {
    let mut seen = Vec::new();
    stage.world().resource_mut::<Playback>().paused = false;
    while step(stage) < last {
        let before = step(stage);
        stage.frames(1);
        if step(stage) > before {
            seen.push((step(stage), stage.position(name)));
        }
    }
    pause(stage);
    seen
}

/// At once.
fn pause(stage: &mut Stage) {
    stage.world().resource_mut::<Playback>().paused = true;
    stage.world().resource_mut::<Time<Virtual>>().pause();
}

#[test]
fn a_step_back_is_a_step_back_and_on_from_there_it_is_as_it_was() {
    let mut stage = Stage::open(SCENE);
    let first = step(&mut stage);
    let seen = play_to(&mut stage, "bob", first + 60);
    stage.tap(KeyCode::Comma);
    assert!(stage.world().resource::<Playback>().paused);
    assert_eq!((step(&mut stage), stage.position("bob")), seen[58]);
    go(&mut stage, first + 20);
    assert_eq!((step(&mut stage), stage.position("bob")), seen[19]);
    assert_eq!(play_to(&mut stage, "bob", first + 60), seen[20..]);
    // As far as there is something, and no farther.
    let [start, end] = reach(&mut stage);
    stage.tap(KeyCode::Home);
    assert_eq!(step(&mut stage), start);
    stage.tap(KeyCode::Comma);
    assert_eq!(step(&mut stage), start);
    go(&mut stage, u64::MAX);
    assert_eq!(step(&mut stage), end);
    assert!(!matches!(stage.world().resource::<Notice>(), Notice::Error(_)));
}

#[test]
fn a_drag_happens_again_until_something_else_is_done() {
    let mut stage = Stage::open(SCENE);
    let first = step(&mut stage);
    let bob = stage.position("bob");
    let place = stage.seen_at(bob);
    stage.move_to(place);
    stage.press();
    stage.move_to(place + Vec2::new(-60.0, -150.0));
    stage.frames(20);
    assert_eq!(named(&mut stage, "drag joint").len(), 1);
    let middle = step(&mut stage);
    stage.move_to(place + Vec2::new(100.0, -100.0));
    stage.release();
    let seen_in_the_end = {
        stage.frames(20);
        (step(&mut stage), stage.position("bob"))
    };
    assert!(named(&mut stage, "drag joint").is_empty());
    go(&mut stage, first);
    let again = play_to(&mut stage, "bob", seen_in_the_end.0);
    assert_eq!(*again.last().unwrap(), seen_in_the_end);
    // In the middle of it the hand is there; with another deed it lets go.
    go(&mut stage, middle);
    assert_eq!(named(&mut stage, "drag handle").len(), 1);
    stage.world().resource_mut::<Playback>().paused = false;
    stage.act(SandboxAction::ThrowBall);
    stage.frames(5);
    assert!(named(&mut stage, "drag handle").is_empty() && named(&mut stage, "drag joint").is_empty());
    assert_eq!(reach(&mut stage)[1], step(&mut stage), "what was to come will not");
}

#[test]
fn whoever_goes_back_lets_go() {
    let mut stage = Stage::open(SCENE);
    stage.frames(20);
    let place = stage.position("bob");
    let place = stage.seen_at(place);
    stage.move_to(place);
    stage.press();
    stage.frames(10);
    let head = step(&mut stage);
    stage.tap(KeyCode::Comma);
    stage.frames(5);
    assert_eq!(step(&mut stage), head, "the frame of the key has made one");
    // It is held there, as it was; on at the end it is not.
    stage.tap(KeyCode::End);
    stage.frames(2);
    assert!(named(&mut stage, "drag handle").is_empty());
}

#[test]
fn what_is_built_goes_and_comes_with_the_head() {
    let mut stage = Stage::open(SCENE);
    stage.frames(10);
    pause(&mut stage);
    stage.move_to(Vec2::new(500.0, 500.0));
    stage.key(KeyCode::KeyA);
    let added = named(&mut stage, "box 2");
    assert_eq!(added.len(), 1, "{:?}", stage.world().resource::<Notice>());
    let built = step(&mut stage);
    play_to(&mut stage, "bob", built + 30);
    let bob = stage.body("bob");
    *stage.world().resource_mut::<Selection>() = Selection::of(bob);
    stage.tap(KeyCode::Delete);
    assert!(named(&mut stage, "bob").is_empty());
    assert_eq!(stage.world().query::<&BallJoint>().iter(stage.app.world()).count(), 0);
    let cut = step(&mut stage);
    play_to(&mut stage, "box", cut + 10);

    go(&mut stage, built - 1);
    assert!(named(&mut stage, "box 2").is_empty());
    assert_eq!(named(&mut stage, "bob").len(), 1);
    go(&mut stage, built + 1);
    assert_eq!(named(&mut stage, "box 2"), added, "the same entity");
    assert!(stage.world().get::<Mesh3d>(added[0]).is_some(), "it is drawn");
    // The deletion has not been done here: what undo takes back is the box.
    stage.tap(KeyCode::End);
    assert!(named(&mut stage, "bob").is_empty());
    stage.key_with_control(KeyCode::KeyZ);
    assert_eq!(named(&mut stage, "bob"), [bob], "the same entity comes back");
    go(&mut stage, built + 1);
    stage.key_with_control(KeyCode::KeyZ);
    assert!(named(&mut stage, "box 2").is_empty());
    play_to(&mut stage, "bob", built + 40);
    assert_eq!(reach(&mut stage)[1], built + 40, "the deletion will not be done");
    assert_eq!(named(&mut stage, "bob").len(), 1);
    stage.key_with_control(KeyCode::KeyZ);
    assert_eq!(*stage.world().resource::<Notice>(), Notice::Error("nothing to undo".into()));
}

#[test]
fn time_runs_backwards_to_its_beginning() {
    let mut stage = Stage::open(SCENE);
    let first = step(&mut stage);
    play_to(&mut stage, "bob", first + 50);
    stage.tap(KeyCode::KeyU);
    let start = step(&mut stage);
    stage.frames(10);
    let now = step(&mut stage);
    assert!((8..=12).contains(&(start - now)), "{start} {now}");
    stage.frames(80);
    assert_eq!(step(&mut stage), reach(&mut stage)[0]);
    assert!(!stage.world().resource::<Timeline>().backwards);
    // Play stops it.
    stage.tap(KeyCode::End);
    stage.tap(KeyCode::KeyU);
    stage.frames(5);
    stage.tap(KeyCode::Space);
    let now = step(&mut stage);
    stage.frames(5);
    assert!(step(&mut stage) > now);
}

#[test]
fn marks_make_a_loop() {
    let mut stage = Stage::open(SCENE);
    let first = step(&mut stage);
    for mark in [20, 35] {
        play_to(&mut stage, "bob", first + mark);
        stage.tap(KeyCode::KeyK);
    }
    play_to(&mut stage, "bob", first + 60);
    go(&mut stage, first + 25);
    stage.tap(KeyCode::KeyL);
    assert_eq!(stage.world().resource::<Timeline>().looped, Some([first + 20, first + 35]));
    let mut steps = Vec::new();
    for _ in 0..40 {
        stage.frames(1);
        steps.push(step(&mut stage));
    }
    assert!(steps.iter().all(|step| (first + 20..=first + 35).contains(step)), "{steps:?}");
    assert!(steps.windows(2).filter(|steps| steps[1] < steps[0]).count() >= 2, "{steps:?}");
    assert_eq!(reach(&mut stage)[1], first + 60, "nothing is lost");
    stage.tap(KeyCode::KeyL);
    stage.frames(60);
    assert!(step(&mut stage) > first + 60);
    // A mark goes where it stands.
    go(&mut stage, first + 20);
    stage.tap(KeyCode::KeyK);
    assert_eq!(stage.world().resource::<Timeline>().marks, [first + 35]);
}

#[test]
fn the_head_is_dragged_along_the_strip() {
    let mut stage = Stage::open(SCENE);
    let first = step(&mut stage);
    play_to(&mut stage, "bob", first + 100);
    crate::eyes::click(&mut stage, Vec2::new(500.0, SIZE.y - 31.0));
    stage.frames(2);
    let ([start, end], now) = (reach(&mut stage), step(&mut stage));
    assert!(start < now && now < end, "{start} {now} {end}");
    assert!(stage.world().resource::<Playback>().paused);
    assert_eq!(stage.world().resource::<Selection>().entity(), None);
}

#[test]
fn a_ghost_goes_back_too() {
    let mut stage = Stage::open("(bodies: [])");
    stage.act(SandboxAction::LoadScene { scene: "chain".into(), parameters: Vec::new() });
    stage.world().insert_resource(Ghosts(vec![GhostChoice::Method(0)]));
    stage.act(SandboxAction::Reset);
    stage.frames(60);
    let head = step(&mut stage);
    for to in [head - 30, head - 5, head - 40] {
        go(&mut stage, to);
        stage.world().resource_mut::<Playback>().paused = false;
        stage.frames(4);
        assert_eq!(
            stage.world().resource::<GhostReadings>().ghosts.first().map(|ghost| ghost.apart.distance),
            Some(0.0),
            "back to {to}"
        );
    }
}

#[test]
fn another_scene_has_a_past_of_its_own() {
    let mut stage = Stage::open(SCENE);
    stage.frames(30);
    let bodies = |stage: &mut Stage| stage.world().query::<&RigidBody>().iter(stage.app.world()).count();
    let before = bodies(&mut stage);
    stage.act(SandboxAction::Reset);
    let head = step(&mut stage);
    assert!(reach(&mut stage)[0] + 2 >= head, "{head} {:?}", reach(&mut stage));
    go(&mut stage, 0);
    assert_eq!(bodies(&mut stage), before);
    assert!(stage.position("box").y > 0.9, "it has hardly fallen");
}

#[test]
fn who_only_looks_at_the_past_ends_nothing() {
    let mut stage = Stage::open("(bodies: [])");
    stage.act(SandboxAction::LoadScene { scene: "car".into(), parameters: Vec::new() });
    stage.frames(5);
    let first = step(&mut stage);
    stage.hold(KeyCode::ArrowUp);
    stage.frames(30);
    stage.let_go(KeyCode::ArrowUp);
    stage.frames(30);
    go(&mut stage, first + 15);
    let [_, last] = reach(&mut stage);
    // A press while time stands still picks, and does nothing else.
    let chassis = stage.position("chassis");
    let place = stage.seen_at(chassis);
    stage.move_to(place);
    stage.press();
    stage.frames(2);
    stage.release();
    assert!(stage.world().resource::<Selection>().entity().is_some());
    stage.world().resource_mut::<Playback>().paused = false;
    stage.frames(10);
    assert_eq!(reach(&mut stage)[1], last, "the motors do what they did");
    stage.tap(KeyCode::End);
    assert_eq!(step(&mut stage), last);
}

#[test]
fn undo_keeps_to_what_has_been_done_at_the_moment_on_view() {
    let mut stage = Stage::open(SCENE);
    pause(&mut stage);
    let add = |stage: &mut Stage, x: f32| {
        pause(stage);
        stage.move_to(Vec2::new(x, 500.0));
        stage.key(KeyCode::KeyA);
        step(stage)
    };
    let one = add(&mut stage, 300.0);
    play_to(&mut stage, "bob", one + 20);
    let two = add(&mut stage, 700.0);
    play_to(&mut stage, "bob", two + 20);
    assert_eq!((named(&mut stage, "box 2").len(), named(&mut stage, "box 3").len()), (1, 1));
    // Played on to both, not sent there.
    go(&mut stage, one + 5);
    play_to(&mut stage, "bob", two + 10);
    stage.key_with_control(KeyCode::KeyZ);
    assert_eq!((named(&mut stage, "box 2").len(), named(&mut stage, "box 3").len()), (1, 0));
    // What was deleted in a future that will not be is not deleted, and does not come back.
    let bob = stage.body("bob");
    play_to(&mut stage, "box", two + 30);
    let before = step(&mut stage);
    play_to(&mut stage, "box", before + 10);
    *stage.world().resource_mut::<Selection>() = Selection::of(bob);
    stage.tap(KeyCode::Delete);
    play_to(&mut stage, "box", before + 20);
    go(&mut stage, before);
    stage.act(SandboxAction::ThrowBall);
    play_to(&mut stage, "bob", before + 30);
    go(&mut stage, before + 25);
    // First undo takes back the ball, then that there was another future: what was to come is there again, the deletion too.
    stage.key_with_control(KeyCode::KeyZ);
    assert!(named(&mut stage, "thrown ball").is_empty());
    stage.key_with_control(KeyCode::KeyZ);
    assert_eq!(
        (step(&mut stage), reach(&mut stage)[1]),
        (before, before + 20),
        "{:?}",
        stage.world().resource::<Notice>()
    );
    assert!(named(&mut stage, "thrown ball").is_empty());
    assert_eq!(named(&mut stage, "bob"), [bob]);
    stage.tap(KeyCode::End);
    assert!(named(&mut stage, "bob").is_empty());
    stage.key_with_control(KeyCode::KeyZ);
    assert_eq!(named(&mut stage, "bob"), [bob]);
}

#[test]
fn what_happened_is_recorded_and_on_view_again() {
    let mut stage = Stage::open(SCENE);
    play_to(&mut stage, "box", 20);
    assert_eq!(stage.world().resource::<History>().begun(), 0);
    stage.act(SandboxAction::ThrowBall);
    play_to(&mut stage, "box", 50);
    let at = |stage: &mut Stage| {
        let balls = named(stage, "thrown ball");
        balls.into_iter().map(|ball| stage.world().get::<Position>(ball).unwrap().0).collect::<Vec<_>>()
    };
    let ball = at(&mut stage);
    assert_eq!(ball.len(), 1);
    stage.key_with_control(KeyCode::KeyR);
    stage.frames(1);
    let Notice::Info(said) = stage.world().resource::<Notice>().clone() else {
        panic!("{:?}", stage.world().resource::<Notice>())
    };
    let path = said.split(" steps to ").nth(1).and_then(|rest| rest.rsplit_once(", ")).expect("a path").0.to_owned();
    assert_eq!(step(&mut stage), 50);
    stage.load("(bodies: [])");
    stage.act(SandboxAction::LoadScene { scene: path.clone(), parameters: Vec::new() });
    std::fs::remove_file(&path).unwrap();
    assert!(matches!(stage.world().resource::<Notice>(), Notice::Info(_)), "{:?}", stage.world().resource::<Notice>());
    let [first, last] = reach(&mut stage);
    assert_eq!((step(&mut stage), last - first), (first, 50));
    assert!(named(&mut stage, "thrown ball").is_empty());
    go(&mut stage, last);
    assert_eq!(at(&mut stage), ball);
    let bodies = stage.world().query_filtered::<Entity, (With<RigidBody>, With<Mesh3d>)>().iter(stage.world()).count();
    assert_eq!(bodies, 3, "the ball is drawn, too");
}

#[test]
fn the_turns_of_a_hinge_that_came_back_are_recorded() {
    let mut stage = Stage::open(
        r#"(
            gravity: (0, 0, 0),
            bodies: [(name: "wheel", shape: Cuboid(size: (1, 1, 0.2)), mass: 1, position: (0, 0, 0), angular_velocity: (0, 0, 20))],
            joints: [(body_a: "world", body_b: "wheel", kind: Hinge, at: (0, 0, 0), axis: (0, 0, 1))],
        )"#,
    );
    play_to(&mut stage, "wheel", 60);
    stage.world().resource_mut::<Playback>().paused = false;
    let wheel = stage.body("wheel");
    stage.world().insert_resource(Selection::of(wheel));
    stage.act(SandboxAction::DeletePicked);
    stage.frames(5);
    stage.act(SandboxAction::Undo);
    stage.frames(5);
    let world = stage.world();
    let turns = world.query::<&JointCoordinate>().single(world).unwrap().value;
    assert!(turns > 6.0 * std::f64::consts::PI, "{turns}");
    let recording = stage.record();
    assert!(recording.steps() > 65, "steps are made without it and after it came back: {}", recording.steps());
    stage.replays();
}

#[test]
fn a_scene_that_came_back_is_recorded_as_it_came_back() {
    let mut stage = Stage::open(SCENE);
    play_to(&mut stage, "box", 20);
    let bob = stage.body("bob");
    stage.world().insert_resource(Selection::of(bob));
    stage.act(SandboxAction::PinPicked);
    stage.act(SandboxAction::ThrowBall);
    stage.world().resource_mut::<Playback>().paused = false;
    stage.frames(10);
    stage.load("(bodies: [])");
    stage.frames(3);
    stage.act(SandboxAction::Undo);
    stage.frames(20);
    assert_eq!(named(&mut stage, "thrown ball").len(), 1);
    let recording = stage.record();
    assert!(recording.steps() > 10, "{}", recording.steps());
    stage.replays();
}

/// So many bodies that the way to a moment takes long, all in free flight.
fn swarm() -> String {
    let body = |index: u32| {
        let [x, y] = [index % 50, index / 50].map(|place| 2 * place);
        format!(
            "(name: \"{index}\", shape: Sphere(radius: 0.5), position: ({x}, {y}, 0), angular_velocity: (0, 1, 0)),"
        )
    };
    let bodies: String = (0..2500).map(body).collect();
    format!("(bodies: [{bodies}], view: (eye: (50, 60, 200), target: (50, 60, 0)))")
}

fn drawn(stage: &mut Stage, name: &str) -> Vec3 {
    let body = stage.body(name);
    let world = stage.world();
    world.get::<GlobalTransform>(body).unwrap().translation() + world.resource::<RenderOrigin>().0.as_vec3()
}

/// Makes so many steps one by one, however slow the machine is, and tells where the body is after each.
fn step_by_step(stage: &mut Stage, name: &str, count: u64) -> Vec<(u64, DVec3)> {
    let mut make = || {
        stage.act(SandboxAction::StepOnce);
        (step(stage), stage.position(name))
    };
    (0..count).map(|_| make()).collect()
}

fn place_at(seen: &[(u64, DVec3)], step: u64) -> DVec3 {
    seen.iter().find(|(then, _)| *then == step).unwrap().1
}

#[test]
fn a_moment_far_away_is_drawn_before_the_world_is_there() {
    let mut stage = Stage::open(&swarm());
    pause(&mut stage);
    let first = step(&mut stage);
    let seen = step_by_step(&mut stage, "77", 50);
    // As far as can be from a keyframe.
    let farthest = |stage: &mut Stage| {
        let history = stage.world().resource::<History>();
        let far = (first + 2..first + 49).max_by_key(|step| history.way_to(*step)).unwrap();
        assert!(history.way_to(far) >= 10, "the way is {} steps", history.way_to(far));
        far
    };
    let far = farthest(&mut stage);
    // The moment at which the scene begins is always kept whole.
    let near = first + 1;
    let there = place_at(&seen, far).as_vec3();
    let now = seen.last().unwrap().1.as_vec3();
    assert!(there.distance(now) > 0.1);
    for _ in 0..3 {
        stage.world().write_message(SandboxAction::LookAt { step: far });
        stage.frames(1);
        assert_eq!(stage.world().resource::<ShownStep>().step, Some(far));
        assert_eq!(step(&mut stage), first + 50, "the world stays where it is");
        assert!(drawn(&mut stage, "77").distance(there) < 1e-4, "{} instead of {there}", drawn(&mut stage, "77"));
    }
    // Nobody holds the head any more.
    stage.frames(2);
    assert_eq!((step(&mut stage), stage.position("77").as_vec3()), (far, there));
    assert_eq!(stage.world().resource::<ShownStep>().step, None);
    assert!(drawn(&mut stage, "77").distance(there) < 1e-4);
    // A short way is gone at once.
    stage.world().write_message(SandboxAction::LookAt { step: near });
    stage.frames(1);
    assert_eq!(step(&mut stage), near);
    let place = place_at(&seen, near).as_vec3();
    assert!(drawn(&mut stage, "77").distance(place) < 1e-4, "the picture shows it in the same frame");
    // What else is done is done there. On the way there keyframes were made.
    let far = farthest(&mut stage);
    stage.world().write_message(SandboxAction::LookAt { step: far });
    stage.frames(1);
    assert_eq!(step(&mut stage), near);
    stage.act(SandboxAction::StepBack);
    assert_eq!(step(&mut stage), far - 1);
}

#[test]
fn many_bodies_run_backwards_by_their_poses() {
    let mut stage = Stage::open(&swarm());
    pause(&mut stage);
    let seen = step_by_step(&mut stage, "77", 50);
    stage.tap(KeyCode::KeyU);
    // By how far keyframes are away, and that by the clock, the world goes along or is looked at.
    let (mut moments, mut looked) = (Vec::new(), 0);
    for _ in 0..20 {
        stage.frames(1);
        let shown = stage.world().resource::<ShownStep>().step;
        if let Some(at) = shown {
            let there = place_at(&seen, at).as_vec3();
            assert!(drawn(&mut stage, "77").distance(there) < 1e-4, "step {at}");
            looked += 1;
        }
        moments.push(shown.unwrap_or_else(|| step(&mut stage)));
    }
    assert!(looked >= 5 && moments.is_sorted_by(|before, after| after <= before), "{looked} of {moments:?}");
    let last = *moments.last().unwrap();
    stage.tap(KeyCode::KeyU);
    stage.frames(2);
    assert!(!stage.world().resource::<Timeline>().backwards);
    let now = step(&mut stage);
    assert!(now <= last && now + 4 > last, "{now} after {last}");
    assert_eq!(stage.position("77"), place_at(&seen, now));
}
