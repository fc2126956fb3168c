//! Probes, trails and tapes: asked for by a right click, read in the panel's list.

use bevy::math::DVec3;
use bevy::prelude::*;
use plumb::lab::state_hash;
use plumb::physics::{ContactForces, History, JointLoad, Position, StepStats, Velocity};
use plumb::sandbox::{CurrentScene, Notice, Page, SandboxAction, Selection, Track, Tracks};
use plumb::scene::{Probe, ProbePlot, ProbePoint, ProbeSubject, Probes, SceneSpec};

use crate::eyes::{click, click_on, open_eyes, point_at, reads, seen, texts};
use crate::stage::Stage;

/// A ball that flies.
const THROWN: &str = r#"(
    bodies: [(name: "ball", shape: Sphere(radius: 0.5), position: (0, 20, 0), velocity: (2, 3, 0))],
    view: (eye: (0, 20, 20), target: (0, 20, 0)),
)"#;

/// Two balls that part.
const PARTING: &str = r#"(
    gravity: (0, 0, 0),
    bodies: [
        (name: "left", shape: Sphere(radius: 0.5), position: (-1, 0, 0), velocity: (-1, 0, 0)),
        (name: "right", shape: Sphere(radius: 0.5), position: (1, 1, 0), velocity: (0.5, 0, 0)),
    ],
    view: (eye: (0, 0, 20), target: (0, 0, 0)),
)"#;

/// A box of 98.1 N on the ground, and a ball of as much on a hinge.
const AT_REST: &str = r#"(
    bodies: [
        (name: "ground", shape: HalfSpace),
        (name: "box", shape: Cuboid(size: (1, 1, 1)), mass: 10, position: (-0.7, 0.5, 0)),
        (name: "ball", shape: Sphere(radius: 0.3), mass: 10, position: (1, 2, 0)),
    ],
    joints: [(body_a: "world", body_b: "ball", kind: Hinge, at: (1, 3, 0), axis: (0, 0, 1))],
    view: (eye: (0, 2, 14), target: (0, 2, 0)),
)"#;

/// The sandbox on a scene that stands still, the panel to be read.
fn open(scene: &str) -> Stage {
    let mut stage = Stage::open(scene);
    stage.act(SandboxAction::TogglePause);
    open_eyes(&mut stage, Page::Analyse);
    stage
}

/// A right click on a point of the world; the pointer moves by so much in between.
fn right_click(stage: &mut Stage, point: DVec3, moved: Vec2) {
    let place = stage.seen_at(point);
    point_at(stage, place);
    stage.jump_to(place);
    stage.frames(2);
    stage.press_right();
    stage.jump_to(place + moved);
    stage.frames(1);
    stage.release_right();
    stage.frames(3);
}

/// A right click on a body.
fn ask(stage: &mut Stage, body: &str) {
    let place = stage.position(body);
    right_click(stage, place, Vec2::ZERO);
}

fn leave(stage: &mut Stage) {
    stage.act(SandboxAction::Escape);
    stage.frames(2);
}

fn steps(stage: &mut Stage, count: usize) {
    (0..count).for_each(|_| stage.act(SandboxAction::StepOnce));
    stage.frames(3);
}

/// What the list says of the probe whose name begins so.
#[track_caller]
fn said(stage: &mut Stage, name: &str) -> String {
    let texts = texts(stage);
    let of = texts.iter().find(|(text, place)| text.starts_with(name) && place.x > 900.0);
    let (_, at) = of.unwrap_or_else(|| panic!("no '{name}' in {texts:?}"));
    let beside = texts.iter().filter(|(_, place)| (place.y - at.y).abs() < 7.0 && place.x > at.x);
    beside.map(|(text, _)| text.clone()).find(|text| text != "✖").unwrap_or_default()
}

fn tracks(stage: &mut Stage) -> Tracks {
    stage.world().resource::<Tracks>().clone()
}

fn track(stage: &mut Stage, name: &str) -> Track {
    let tracks = tracks(stage).tracks;
    tracks.into_iter().find(|track| track.name.starts_with(name)).expect("a probe of that name")
}

fn probes(stage: &mut Stage) -> Vec<Probe<Entity, Entity>> {
    stage.world().resource::<Probes>().0.clone()
}

fn steps_made(stage: &mut Stage) -> u64 {
    stage.world().resource::<StepStats>().steps
}

#[test]
fn a_height_that_is_asked_for_is_read_and_follows_the_fall() {
    let mut stage = open(THROWN);
    ask(&mut stage, "ball");
    click_on(&mut stage, "y", "ball");
    click_on(&mut stage, "vy", "ball");
    leave(&mut stage);
    assert_eq!(probes(&mut stage).len(), 2);
    steps(&mut stage, 60);

    let tracks = tracks(&mut stage);
    assert_eq!(tracks.rows.len(), 60);
    for row in &tracks.rows {
        let t = row.time;
        let (height, speed) = (20.0 + 3.0 * t - 0.5 * 9.81 * t * t, 3.0 - 9.81 * t);
        // Substeps of 1/240 s fall behind by g t/480 at most.
        assert!((row.values[0] - height).abs() < 0.03, "{} m instead of {height} at {t} s", row.values[0]);
        assert!((row.values[1] - speed).abs() < 1e-9, "{} m/s instead of {speed} at {t} s", row.values[1]);
    }
    let height = stage.position("ball").y;
    assert_eq!(tracks.rows.back().unwrap().values[0], height);
    assert_eq!(said(&mut stage, "ball y"), format!("{height:.1} m"));
    assert!(stage.world().resource::<Selection>().body.is_none(), "a right click picks nothing");

    let row = texts(&mut stage).iter().find(|(text, _)| text.starts_with("ball y")).unwrap().1.y;
    let mut crosses = texts(&mut stage).into_iter().filter(|(text, place)| text == "✖" && (place.y - row).abs() < 7.0);
    let (_, cross) = crosses.next_back().unwrap();
    click(&mut stage, cross);
    stage.frames(2);
    assert!(!reads(&mut stage, "ball y") && reads(&mut stage, "ball vy"));
    assert_eq!(self::tracks(&mut stage).rows.back().unwrap().values.len(), 1);
}

#[test]
fn a_right_drag_asks_for_nothing_and_a_click_beside_the_menu_closes_it() {
    let mut stage = open(THROWN);
    let place = stage.position("ball");
    right_click(&mut stage, place, Vec2::new(40.0, 0.0));
    assert!(!reads(&mut stage, "this point"));
    right_click(&mut stage, place, Vec2::new(1.0, 0.0));
    assert!(reads(&mut stage, "this point"));
    let sky = stage.seen_at(place) + Vec2::new(-200.0, -200.0);
    click(&mut stage, sky);
    stage.frames(2);
    assert!(!reads(&mut stage, "this point"));
}

/// A hundred steps with probes of the ball and the box that read so: the state, and where the box is.
fn run_with(plots: impl Fn([Entity; 2], Entity) -> Vec<Probe<Entity, Entity>>) -> (Stage, u64, DVec3) {
    let mut stage = open(AT_REST);
    let bodies = ["box", "ball"].map(|name| stage.body(name));
    let joint = stage.world().resource::<CurrentScene>().entities.joints[0];
    stage.world().insert_resource(Probes(plots(bodies, joint)));
    steps(&mut stage, 100);
    let (hash, place) = (state_hash(stage.app.world()), stage.position("box"));
    (stage, hash, place)
}

fn loads(stage: &mut Stage) -> usize {
    let world = stage.world();
    world.query::<&JointLoad>().iter(world).count()
}

#[test]
fn nothing_is_sampled_without_a_probe_and_a_probe_changes_no_step() {
    let of = |subject, plot| Probe::Plot(subject, plot);
    let (mut unwatched, hash, _) = run_with(|_, _| Vec::new());
    assert!(tracks(&mut unwatched).rows.is_empty() && loads(&mut unwatched) == 0);
    let (mut watched, same, _) = run_with(|[body, ball], joint| {
        vec![
            Probe::Trail(ProbePoint::center(ball)),
            Probe::Tape([ProbePoint::center(body), ProbePoint::center(ball)]),
            of(ProbeSubject::Point(ProbePoint::center(ball)), ProbePlot::Energy),
            of(ProbeSubject::Joint(joint), ProbePlot::Force),
            of(ProbeSubject::Joint(joint), ProbePlot::Coordinate),
            of(ProbeSubject::Scene, ProbePlot::Energy),
        ]
    });
    assert_eq!(same, hash, "to the last bit");
    assert_eq!((tracks(&mut watched).rows.len(), loads(&mut watched)), (100, 1));
    assert!(!watched.world().contains_resource::<ContactForces>());
}

#[test]
fn contact_forces_that_are_read_move_no_body_that_one_could_see() {
    let (_, _, place) = run_with(|_, _| Vec::new());
    let (mut stage, _, watched) = run_with(|[body, _], _| {
        vec![Probe::Plot(ProbeSubject::Point(ProbePoint::center(body)), ProbePlot::ContactForce)]
    });
    assert!(watched.distance(place) < 1e-7, "{watched} is not {place}");
    assert!(stage.world().contains_resource::<ContactForces>());
    stage.world().resource_mut::<Probes>().0.clear();
    stage.frames(2);
    assert!(!stage.world().contains_resource::<ContactForces>(), "nobody reads them any more");
}

#[test]
fn contacts_bear_a_weight_and_so_does_a_joint() {
    let mut stage = open(AT_REST);
    ask(&mut stage, "box");
    click_on(&mut stage, "contact force", "box");
    leave(&mut stage);
    right_click(&mut stage, DVec3::new(1.0, 3.0, 0.0), Vec2::ZERO);
    assert!(reads(&mut stage, "hinge of the world and ball"));
    click_on(&mut stage, "force", "hinge of the world and ball");
    click_on(&mut stage, "coordinate", "hinge of the world and ball");
    click_on(&mut stage, "gap", "hinge of the world and ball");
    leave(&mut stage);
    assert_eq!(said(&mut stage, "box contact force"), "–", "no step has told it yet");
    steps(&mut stage, 90);
    for (name, expected) in [("box contact force", 98.1), ("hinge of the world and ball force", 98.1)] {
        let text = said(&mut stage, name);
        let value: f64 = text.strip_suffix(" N").unwrap_or_else(|| panic!("{name}: {text}")).parse().unwrap();
        assert!((value - expected).abs() < 0.5, "{name}: {text}");
    }
    assert!(said(&mut stage, "hinge of the world and ball coordinate").ends_with('°'));
    let gap = tracks(&mut stage).rows.back().unwrap().values[3];
    assert!((0.0..1e-3).contains(&gap), "{gap} m");
}

#[test]
fn a_trail_lies_on_the_parabola_and_is_cut_by_going_back() {
    let mut stage = open(THROWN);
    ask(&mut stage, "ball");
    click_on(&mut stage, "trail", "this point");
    let Some(Probe::Trail(ProbePoint { at, .. })) = probes(&mut stage).first().copied() else { panic!("no trail") };
    assert!((at.length() - 0.5).abs() < 0.01 && at.z > 0.4, "the point that is seen, not {at}");
    leave(&mut stage);
    steps(&mut stage, 60);
    let trail = track(&mut stage, "ball").trail;
    assert!(trail.len() >= 60);
    for (_, t, place) in &trail {
        let on_it = DVec3::new(2.0 * t, 20.0 + 3.0 * t - 0.5 * 9.81 * t * t, 0.0) + at;
        assert!(place.distance(on_it) < 0.03, "{place} instead of {on_it} at {t} s");
    }

    let back = steps_made(&mut stage) - 40;
    stage.act(SandboxAction::GoTo { step: back });
    stage.frames(2);
    let trail = track(&mut stage, "ball").trail;
    assert_eq!(trail.back().unwrap().0, back);
    steps(&mut stage, 3);
    let steps: Vec<u64> = track(&mut stage, "ball").trail.iter().map(|(step, ..)| *step).collect();
    assert!(steps.windows(2).all(|pair| pair[0] + 1 == pair[1]), "no step is left out: {steps:?}");
    assert_eq!(steps.last(), Some(&(back + 3)));
}

#[test]
fn samples_go_with_the_moment_and_begin_anew_with_the_scene() {
    let mut stage = open(THROWN);
    ask(&mut stage, "ball");
    click_on(&mut stage, "y", "ball");
    leave(&mut stage);
    steps(&mut stage, 50);
    let now = steps_made(&mut stage);
    stage.act(SandboxAction::GoTo { step: now - 30 });
    stage.frames(2);
    let last = tracks(&mut stage).rows.back().unwrap().clone();
    let height = stage.position("ball").y;
    assert!((last.time - (now - 30) as f64 / 60.0).abs() < 1e-9, "the last is of {} s", last.time);
    assert_eq!(last.values[0], height);
    let rows = tracks(&mut stage).rows;
    assert!(rows.iter().zip(rows.iter().skip(1)).all(|(one, next)| one.time < next.time), "nothing of later is left");
    assert_eq!(said(&mut stage, "ball y"), format!("{height:.1} m"));
    stage.act(SandboxAction::GoToNow);
    stage.frames(2);
    let rows = tracks(&mut stage).rows;
    // On its ways it reads what was before it was asked for, too, from the keyframe on that it sets out from.
    let (made, known) = (steps_made(&mut stage), rows.len() as u64);
    assert!(made == now && (50..=now).contains(&known), "what was read is known yet: {known} of {made}");
    assert!(rows.iter().skip(1).all(|row| !row.breaks));
    stage.act(SandboxAction::Reset);
    stage.frames(2);
    assert!(tracks(&mut stage).rows.is_empty());
    assert_eq!(said(&mut stage, "ball y"), "20.0 m", "of the ball that is there now");
    steps(&mut stage, 2);
    assert!((tracks(&mut stage).rows[0].time - 1.0 / 60.0).abs() < 1e-9);
}

#[test]
fn a_tape_is_as_long_as_its_ends_are_apart() {
    let mut stage = open(PARTING);
    ask(&mut stage, "left");
    click_on(&mut stage, "tape from here", "this point");
    assert!(!reads(&mut stage, "this point"), "the menu is gone");
    let right = stage.position("right");
    let other = stage.seen_at(right);
    point_at(&mut stage, other);
    stage.jump_to(other);
    stage.frames(2);
    stage.press();
    stage.release();
    stage.frames(3);
    assert!(stage.world().resource::<Selection>().body.is_none(), "that click only measures");
    let Some(Probe::Tape([from, to])) = probes(&mut stage).first().copied() else { panic!("no tape") };
    let length = |t: f64| {
        let start = DVec3::new(2.0, 1.0, 0.0) + to.at - from.at;
        (start + DVec3::X * (1.5 * t)).length()
    };
    steps(&mut stage, 120);
    let row = tracks(&mut stage).rows.back().unwrap().clone();
    assert!((row.values[0] - length(row.time)).abs() < 1e-9, "{} m at {} s", row.values[0], row.time);
    let text = format!("{:.2} m", row.values[0]);
    assert_eq!(said(&mut stage, "left"), text);
    let labels = texts(&mut stage).into_iter().filter(|(shown, place)| *shown == text && place.x < 900.0).count();
    assert_eq!(labels, 1, "beside its middle in the picture");
}

#[test]
fn escape_draws_no_tape_and_the_next_click_picks() {
    let mut stage = open(PARTING);
    ask(&mut stage, "left");
    click_on(&mut stage, "tape from here", "this point");
    leave(&mut stage);
    let right = stage.position("right");
    let other = stage.seen_at(right);
    point_at(&mut stage, other);
    stage.jump_to(other);
    stage.frames(2);
    stage.press();
    stage.release();
    stage.frames(2);
    assert!(probes(&mut stage).is_empty());
    let body = stage.body("right");
    assert_eq!(stage.world().resource::<Selection>().entity(), Some(body));
}

#[test]
fn a_probe_of_what_is_deleted_is_gone_and_goes_on_after_undo() {
    let mut stage = open(AT_REST);
    ask(&mut stage, "ball");
    click_on(&mut stage, "x", "ball");
    click_on(&mut stage, "trail", "this point");
    leave(&mut stage);
    right_click(&mut stage, DVec3::new(1.0, 3.0, 0.0), Vec2::ZERO);
    click_on(&mut stage, "force", "hinge of the world and ball");
    leave(&mut stage);
    steps(&mut stage, 5);
    let ball = stage.body("ball");
    *stage.world().resource_mut::<Selection>() = Selection::of(ball);
    stage.act(SandboxAction::DeletePicked);
    steps(&mut stage, 5);
    assert_eq!(said(&mut stage, "ball x"), "gone");
    assert_eq!(said(&mut stage, "hinge of the world and ball force"), "gone");
    assert!(tracks(&mut stage).rows.back().unwrap().values.iter().all(|value| value.is_nan()));
    stage.act(SandboxAction::Undo);
    steps(&mut stage, 5);
    assert_eq!(said(&mut stage, "ball x"), "1.00 m");
    assert!(said(&mut stage, "hinge of the world and ball force").ends_with(" N"));
    let trail = track(&mut stage, "ball (").trail;
    assert_eq!(trail.len(), 5, "only what came after, without a line across");
}

#[test]
fn probes_stay_with_the_scene_file_whatever_bodies_are_called() {
    let mut stage = open(AT_REST);
    let [body, ball] = ["box", "ball"].map(|name| stage.body(name));
    // Two bodies of one name.
    *stage.world().get_mut::<Name>(ball).unwrap() = Name::new("box");
    let joint = stage.world().resource::<CurrentScene>().entities.joints[0];
    let at = DVec3::new(0.1, 0.2, 0.25);
    let all = vec![
        Probe::Plot(ProbeSubject::Point(ProbePoint { body: Some(ball), at }), ProbePlot::Speed),
        Probe::Plot(ProbeSubject::Joint(joint), ProbePlot::Torque),
        Probe::Plot(ProbeSubject::Scene, ProbePlot::StepTime),
        Probe::Trail(ProbePoint { body: Some(body), at }),
        Probe::Tape([ProbePoint::center(ball), ProbePoint { body: None, at: DVec3::Y }]),
        // Not there: not in the file.
        Probe::Trail(ProbePoint::center(Entity::PLACEHOLDER)),
    ];
    stage.world().insert_resource(Probes(all.clone()));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("saved.ron");
    stage.act(SandboxAction::SaveScene { path: path.clone(), overwrite: false });
    let place = stage.world().get::<Position>(ball).unwrap().0;

    let scene = path.to_str().unwrap().to_owned();
    stage.act(SandboxAction::LoadScene { scene, parameters: Vec::new() });
    let notice = stage.world().resource::<Notice>().clone();
    assert!(!matches!(notice, Notice::Error(_)), "{notice:?}");
    let loaded = probes(&mut stage);
    assert_eq!(loaded.len(), all.len() - 1);
    let Probe::Plot(ProbeSubject::Point(point), ProbePlot::Speed) = loaded[0] else { panic!("{loaded:?}") };
    assert_eq!(point.at, at);
    assert_eq!(stage.world().get::<Position>(point.body.unwrap()).unwrap().0, place, "the same body");
    let joint = stage.world().resource::<CurrentScene>().entities.joints[0];
    assert_eq!(loaded[1], Probe::Plot(ProbeSubject::Joint(joint), ProbePlot::Torque));
    assert_eq!(loaded[2], all[2]);
    assert!(matches!(loaded[3], Probe::Trail(ProbePoint { body: Some(_), at: there }) if there == at));
    assert!(matches!(loaded[4], Probe::Tape([_, ProbePoint { body: None, at: DVec3::Y }])));

    // One that is taken away stays away over a reset; another scene has its own.
    stage.world().resource_mut::<Probes>().0.remove(0);
    stage.act(SandboxAction::Reset);
    assert_eq!(probes(&mut stage).len(), 4);
    stage.load(PARTING);
    stage.frames(2);
    assert!(probes(&mut stage).is_empty() && tracks(&mut stage).tracks.is_empty());
}

#[test]
fn a_scene_that_was_built_in_comes_back_with_its_probes() {
    let mut stage = open(THROWN);
    ask(&mut stage, "ball");
    click_on(&mut stage, "vx", "ball");
    leave(&mut stage);
    let ball = stage.body("ball");
    *stage.world().resource_mut::<Selection>() = Selection::of(ball);
    stage.act(SandboxAction::PinPicked);
    stage.load(PARTING);
    stage.frames(2);
    assert!(probes(&mut stage).is_empty());
    stage.act(SandboxAction::Undo);
    stage.frames(2);
    assert!(reads(&mut stage, "ball vx") && said(&mut stage, "ball vx") != "gone");
}

#[test]
fn a_file_of_all_that_was_read_has_a_column_a_probe() {
    let mut stage = open(PARTING);
    ask(&mut stage, "left");
    click_on(&mut stage, "x", "left");
    click_on(&mut stage, "trail", "this point");
    click_on(&mut stage, "speed", "left");
    leave(&mut stage);
    steps(&mut stage, 30);
    click_on(&mut stage, "Save CSV", "Probes");
    let Notice::Info(said) = stage.world().resource::<Notice>().clone() else { panic!("not saved") };
    let path = said.strip_prefix("saved ").unwrap().to_owned();
    let text = std::fs::read_to_string(&path).unwrap();
    std::fs::remove_file(&path).unwrap();
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some("t,left x [m],left speed [m/s]"));
    let rows: Vec<Vec<f64>> =
        lines.map(|line| line.split(',').map(|cell| cell.parse().expect("a number")).collect()).collect();
    assert_eq!(rows.len(), 30);
    for row in &rows {
        assert!((row[1] - (-1.0 - row[0])).abs() < 1e-9 && row[2] == 1.0, "{row:?}");
    }
}

#[test]
fn a_log_axis_and_a_number_of_the_read_outs_are_a_click_away() {
    let mut stage = open(AT_REST);
    let place = seen(&mut stage, "contacts", "Read-outs");
    point_at(&mut stage, place);
    for state in [bevy::input::ButtonState::Pressed, bevy::input::ButtonState::Released] {
        let (button, window) = (MouseButton::Right, stage.window());
        stage.world().write_message(bevy::input::mouse::MouseButtonInput { button, state, window });
        stage.frames(2);
    }
    click_on(&mut stage, "plot contacts", "Read-outs");
    assert_eq!(probes(&mut stage), [Probe::Plot(ProbeSubject::Scene, ProbePlot::Contacts)]);
    steps(&mut stage, 20);
    assert_eq!(said(&mut stage, "scene contacts"), "4");
    // An axis of logarithms has the values themselves on it.
    stage.load(THROWN);
    stage.frames(2);
    let all = vec![Probe::Plot(ProbeSubject::Scene, ProbePlot::KineticEnergy)];
    stage.world().insert_resource(Probes(all));
    steps(&mut stage, 120);
    click_on(&mut stage, "log axis", "Probes");
    stage.frames(3);
    let is_log = |stage: &mut Stage| ["1 kJ", "2 kJ", "5 kJ", "10 kJ", "20 kJ"].iter().any(|mark| reads(stage, mark));
    assert!(is_log(&mut stage), "{:?}", texts(&mut stage));
    // Nothing has no logarithm.
    let ball = stage.body("ball");
    *stage.world().get_mut::<Velocity>(ball).unwrap() = Velocity::default();
    steps(&mut stage, 5);
}

#[test]
fn what_is_wrong_with_a_probe_of_a_file_is_said_in_a_line() {
    for (probe, expected) in [
        (r#"(body: "bal", show: Trail)"#, "probes[0].body: no body 'bal'; name one of the scene's bodies, or 'world'"),
        (
            r#"(body: "world", show: Trail)"#,
            "probes[0].body: the world leaves no trail; name one of the scene's bodies",
        ),
        (r#"(joint: 3, show: Plot(Force))"#, "probes[0].joint: no joint 3; the scene has 0, counted from 0"),
        (r#"(show: Plot(Speed))"#, "probes[0].show: there is no Speed of a scene; name a body or a joint"),
        (r#"(body: "ball", show: Plot(Gap))"#, "probes[0].show: there is no Gap of a body"),
        (r#"(body: "ball", joint: 0, show: Trail)"#, "probes[0].joint: give either 'joint' or 'body', not both"),
        (r#"(at: (0, 0, 0), show: Trail)"#, "probes[0].at: is a point of a body: name the 'body', or 'world'"),
        (
            r#"(body: "ball", show: Tape(body: "nobody"))"#,
            "probes[0].show.body: no body 'nobody'; name one of the scene's bodies, or 'world'",
        ),
        (r#"(body: "ball", show: Plot(Sped))"#, "Sped"),
        (r#"(body: "ball", at: (0, inf, 0), show: Trail)"#, "must be finite"),
    ] {
        let text = format!(r#"(bodies: [(name: "ball", shape: Sphere(radius: 1))], probes: [{probe}])"#);
        let error = SceneSpec::from_ron(&text, "a.ron").expect_err(probe).to_string();
        assert!(error.contains(expected) && error.lines().count() == 1, "{probe}: {error}");
    }
    let many = r#"(show: Plot(Energy)), "#.repeat(101);
    let error = SceneSpec::from_ron(&format!("(probes: [{many}])"), "a.ron").expect_err("too many").to_string();
    assert!(error.contains("probes: 101 are more than the limit of 100"), "{error}");
}

#[test]
fn asking_in_the_past_ends_nothing_that_was_to_come() {
    let mut stage = open(AT_REST);
    steps(&mut stage, 40);
    let last = steps_made(&mut stage);
    stage.act(SandboxAction::GoTo { step: last - 20 });
    ask(&mut stage, "box");
    click_on(&mut stage, "contact force", "box");
    leave(&mut stage);
    right_click(&mut stage, DVec3::new(1.0, 3.0, 0.0), Vec2::ZERO);
    click_on(&mut stage, "force", "hinge of the world and ball");
    leave(&mut stage);
    assert_eq!(stage.world().resource::<History>().reach()[1], last, "it is there yet");
    // Step by step: how much is played again on a way at once goes by where keyframes are, and that by the clock.
    steps(&mut stage, 20);
    assert_eq!(steps_made(&mut stage), last);
    assert_eq!(stage.world().resource::<History>().reach()[1], last, "no step was a new one");
    assert_eq!(tracks(&mut stage).rows.len(), 20, "what is played again is read");
}
