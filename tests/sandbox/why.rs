//! Colors by a quantity with their legend, and what the solves and phases of a step were, as plots.

use std::hash::{DefaultHasher, Hasher};

use bevy::prelude::*;
use plumb::physics::{Diagnostics, PhaseTimes, SolveTrace, SolverSettings, StepStats, hash_state};
use plumb::sandbox::{ColorBy, CurrentScene, Page, Playback, SandboxAction, Selection};

use crate::eyes::{click_on, open_eyes, reads};
use crate::stage::Stage;

/// The least and the greatest of a scale.
const COLD: [u8; 3] = [68, 1, 84];
const HOT: [u8; 3] = [253, 231, 37];
/// Of what a quantity says nothing of.
const GRAY: [u8; 3] = [120, 123, 128];
const RED: [u8; 3] = [255, 0, 0];

/// A red box 30 cm deep in a floor, and one that touches nothing.
const OVERLAPPING: &str = r#"(gravity: (0, 0, 0), bodies: [
    (name: "floor", kind: Static, shape: Cuboid(size: (4, 1, 4)), color: (0, 0, 1)),
    (name: "deep", shape: Cuboid(size: (1, 1, 1)), position: (0, 0.7, 0), color: (1, 0, 0)),
    (name: "apart", shape: Cuboid(size: (1, 1, 1)), position: (0, 5, 0), color: (0, 1, 0)),
])"#;

/// One that stands still.
fn paused(scene: &str) -> Stage {
    let mut stage = Stage::open("(bodies: [])");
    stage.world().resource_mut::<Playback>().paused = true;
    match scene.starts_with('(') {
        true => stage.load(scene),
        false => stage.act(SandboxAction::LoadScene { scene: scene.to_owned(), parameters: Vec::new() }),
    }
    stage.world().resource_mut::<Playback>().paused = true;
    stage.frames(3);
    stage
}

fn steps(stage: &mut Stage, count: usize) {
    (0..count).for_each(|_| stage.act(SandboxAction::StepOnce));
}

/// Opens the section and chooses that.
fn choose(stage: &mut Stage, name: &str) {
    open_eyes(stage, Page::Analyse);
    if !reads(stage, "color by") {
        click_on(stage, "Why", "");
    }
    click_on(stage, name, "Why");
}

/// The color that a body is drawn in.
fn color(stage: &mut Stage, name: &str) -> [u8; 3] {
    let body = stage.body(name);
    color_of(stage, body)
}

fn color_of(stage: &mut Stage, body: Entity) -> [u8; 3] {
    let world = stage.world();
    let material = world.get::<MeshMaterial3d<StandardMaterial>>(body).expect("a picture").0.clone();
    let material = world.resource::<Assets<StandardMaterial>>().get(&material).expect("its material");
    let [r, g, b, _] = material.base_color.to_srgba().to_u8_array();
    [r, g, b]
}

#[test]
fn a_body_has_the_color_of_its_overlap_and_then_its_own_again() {
    let mut stage = paused(OVERLAPPING);
    steps(&mut stage, 1);
    assert_eq!(color(&mut stage, "deep"), RED);
    choose(&mut stage, "overlap");
    let [deep, apart, floor] = ["deep", "apart", "floor"].map(|name| color(&mut stage, name));
    assert_eq!([deep, apart, floor], [HOT, COLD, GRAY], "10 cm and more, nothing, and what does not move");
    for word in ["overlap", "1 µm", "10 mm", "deepest 2", "gray: does not move"] {
        assert!(reads(&mut stage, word), "no '{word}' in the legend");
    }
    choose(&mut stage, "–");
    let [deep, apart, floor] = ["deep", "apart", "floor"].map(|name| color(&mut stage, name));
    assert_eq!([deep, apart, floor], [RED, [0, 255, 0], [0, 0, 255]]);
    assert!(!reads(&mut stage, "10 mm"), "the legend is gone with the colors");
}

/// Two boxes at rest beside each other, and two that come along.
const TRAINS: &str = r#"(gravity: (0, 0, 0), bodies: [
    (name: "a", shape: Cuboid(size: (1, 1, 1)), position: (0, 0, 0)),
    (name: "b", shape: Cuboid(size: (1, 1, 1)), position: (1, 0, 0)),
    (name: "c", shape: Cuboid(size: (1, 1, 1)), position: (10, 0, 0), velocity: (-3, 0, 0)),
    (name: "d", shape: Cuboid(size: (1, 1, 1)), position: (11, 0, 0), velocity: (-3, 0, 0)),
])"#;

#[test]
fn islands_have_a_color_each_and_one_when_they_have_met() {
    let mut stage = Stage::open(TRAINS);
    choose(&mut stage, "island");
    let colors = |stage: &mut Stage| ["a", "b", "c", "d"].map(|name| color(stage, name));
    let before = colors(&mut stage);
    assert!(before[0] == before[1] && before[2] == before[3] && before[1] != before[2], "{before:?}");
    assert!(reads(&mut stage, "2 islands") && reads(&mut stage, "a and 1 more"));
    for _ in 0..40 {
        stage.frames(1);
        assert_eq!(colors(&mut stage), before, "an island keeps its color");
    }
    let met = (0..300).any(|_| {
        stage.frames(1);
        colors(&mut stage)[2] == before[0]
    });
    assert!(met, "they meet 2.7 s after the start");
    assert_eq!(colors(&mut stage), [before[0]; 4], "the oldest body of both lends its color");
    stage.frames(2);
    assert!(reads(&mut stage, "1 island") && reads(&mut stage, "a and 3 more"));
}

const BOX_ON_GROUND: &str = r#"(bodies: [
    (name: "ground", kind: Static, shape: HalfSpace),
    (name: "box", shape: Cuboid(size: (1, 1, 1)), position: (0, 0.5, 0), color: (1, 0, 0)),
    (name: "ball", shape: Sphere(radius: 0.5), position: (5, 40, 0)),
])"#;

#[test]
fn who_sleeps_is_blue_gray_and_who_wakes_is_warm_again() {
    let mut stage = Stage::open(BOX_ON_GROUND);
    choose(&mut stage, "asleep");
    stage.frames(60);
    assert_eq!(color(&mut stage, "box"), [92, 112, 150]);
    let falling = color(&mut stage, "ball");
    assert!(falling[0] > 200 && falling[2] < 80, "{falling:?}: awake");
    assert!(reads(&mut stage, "asleep: 1") && reads(&mut stage, "awake: 1"));
    let body = stage.body("box");
    stage.world().get_mut::<plumb::physics::Velocity>(body).unwrap().linear.y = 3.0;
    stage.frames(3);
    let woken = color(&mut stage, "box");
    assert!(woken[0] > 200 && woken[2] < 80, "{woken:?}");
}

#[test]
fn who_is_about_to_sleep_is_between() {
    let mut stage = paused(BOX_ON_GROUND);
    stage.world().insert_resource(ColorBy::Asleep);
    let mut reds: Vec<u8> = Vec::new();
    for _ in 0..60 {
        steps(&mut stage, 1);
        reds.push(color(&mut stage, "box")[0]);
    }
    let first = reds.iter().position(|red| *red == 92).expect("asleep after half a second");
    assert!((20..45).contains(&first), "{first} steps");
    assert!(reds[2..first].is_sorted_by(|one, next| one >= next), "{reds:?}");
    let distinct: std::collections::HashSet<_> = reds[..first].iter().collect();
    assert!(distinct.len() > 10, "by steps: {reds:?}");
}

#[test]
fn joints_and_their_bodies_have_the_color_of_gaps_and_loads() {
    let mut stage = paused("chain");
    stage.world().insert_resource(SolverSettings::classic());
    steps(&mut stage, 30);
    choose(&mut stage, "joint gap");
    let (hot, cold) = (color(&mut stage, "rod 0"), color(&mut stage, "ball"));
    assert!(reads(&mut stage, "joint gap") && reads(&mut stage, "largest "));
    assert!(![hot, cold].contains(&GRAY), "{hot:?} {cold:?}: all hang on joints");
    choose(&mut stage, "load");
    steps(&mut stage, 2);
    assert!(reads(&mut stage, "joint load") && reads(&mut stage, "100 %"));
    assert!(reads(&mut stage, "of joints that cannot break"));
    choose(&mut stage, "graph color");
    assert!(reads(&mut stage, "its graph has no colors"));
    choose(&mut stage, "effort");
    assert!(reads(&mut stage, "solves of each row") && reads(&mut stage, "most 4"), "sweeps of classic");
}

#[test]
fn contacts_that_are_swept_have_colors_of_the_graph() {
    let mut stage = paused("stack");
    let mut settings = SolverSettings::game();
    settings.impulse.fitted_effort = false;
    stage.world().insert_resource(settings);
    steps(&mut stage, 5);
    choose(&mut stage, "graph color");
    assert!(reads(&mut stage, "colors, one after the other") && reads(&mut stage, "1: "));
    choose(&mut stage, "effort");
    // Sweeps with springs and without.
    let solves = settings.substeps * 2 * settings.iterations;
    assert!(reads(&mut stage, &format!("most {solves}")), "{solves}");
    settings.impulse.fitted_effort = true;
    stage.world().insert_resource(settings);
    steps(&mut stage, 40);
    stage.frames(2);
    assert!(reads(&mut stage, "dark gray: left alone (10)"), "nothing changes any more");
}

/// Of all that the next step depends on, after so many steps.
fn hash(scene: &str, settings: SolverSettings, looks: bool) -> u64 {
    let mut stage = paused(scene);
    stage.world().insert_resource(settings);
    if looks {
        open_eyes(&mut stage, Page::Analyse);
        click_on(&mut stage, "Why", "");
    }
    for by in ColorBy::EVERY {
        if looks {
            stage.world().insert_resource(by);
        }
        steps(&mut stage, 15);
        assert_eq!(stage.world().contains_resource::<SolveTrace>(), looks);
    }
    assert_eq!(stage.world().resource::<StepStats>().steps, 120);
    let mut hasher = DefaultHasher::new();
    hash_state(stage.world(), &mut hasher);
    hasher.finish()
}

#[test]
fn to_look_changes_no_bit() {
    let mut swept = SolverSettings::game();
    swept.impulse.fitted_effort = false;
    for (scene, settings) in [
        ("stack", SolverSettings::game()),
        ("stack", swept),
        ("stack", SolverSettings::xpbd()),
        ("stack", SolverSettings::classic()),
        ("stack", SolverSettings::accurate()),
        ("limbs", SolverSettings::game()),
    ] {
        let method = settings.method;
        assert_eq!(hash(scene, settings, true), hash(scene, settings, false), "{scene} by {method:?}");
    }
}

/// The longest solve of the last step.
fn longest_solve(stage: &mut Stage) -> Vec<f64> {
    let (trace, stats) = (stage.world().resource::<SolveTrace>().clone(), *stage.world().resource::<StepStats>());
    assert_eq!(trace.step, stats.steps);
    trace.residuals.solves.into_iter().max_by_key(Vec::len).unwrap_or_default()
}

#[test]
fn residuals_fall_from_sweep_to_sweep() {
    let mut stage = paused("stack");
    open_eyes(&mut stage, Page::Analyse);
    click_on(&mut stage, "Why", "");
    assert!(reads(&mut stage, "not measured in this step"));
    let many = SolverSettings { iterations: 40, ..SolverSettings::classic() };
    // Contacts of classic begin with some overlap; the longest solve of `accurate` is of a first forecast, of which 1e-3 m/s
    // are asked.
    for (settings, least, first) in
        [(SolverSettings::classic(), 0.9, 5), (many, 0.1, 5), (SolverSettings::accurate(), 1e-3, 1)]
    {
        stage.act(SandboxAction::Reset);
        stage.world().insert_resource(settings);
        steps(&mut stage, first);
        let solve = longest_solve(&mut stage);
        assert!(solve.len() > 1 && solve.iter().all(|residual| residual.is_finite()), "{solve:?}");
        assert!(solve[solve.len() - 1] < least * solve[0], "{:?}: {solve:?}", settings.method);
        stage.frames(2);
        assert!(reads(&mut stage, "residual, m/s") && reads(&mut stage, "at the end "));
    }
    // Each sweep of each substep, with springs and without.
    let mut settings = SolverSettings::game();
    settings.impulse.fitted_effort = false;
    stage.world().insert_resource(settings);
    steps(&mut stage, 3);
    let solves = stage.world().resource::<SolveTrace>().residuals.solves.clone();
    assert_eq!(solves.len(), 2 * settings.substeps as usize);
    assert!(solves.iter().all(|solve| solve.len() == settings.iterations as usize && solve[0] > 0.0), "{solves:?}");
    // Solved directly.
    stage.world().insert_resource(SolverSettings::game());
    steps(&mut stage, 60);
    stage.frames(2);
    assert!(reads(&mut stage, "nothing was swept in this step"));
}

#[test]
fn phases_take_no_longer_than_the_step_and_are_timed_only_on_view() {
    let mut stage = paused("limbs");
    steps(&mut stage, 2);
    assert!(!stage.world().contains_resource::<PhaseTimes>() && !stage.world().contains_resource::<SolveTrace>());
    open_eyes(&mut stage, Page::Analyse);
    stage.act(SandboxAction::TogglePlots);
    click_on(&mut stage, "Why", "");
    for _ in 0..30 {
        steps(&mut stage, 1);
        let times = stage.world().resource::<PhaseTimes>().seconds;
        let took = stage.world().resource::<StepStats>().step_seconds;
        assert!(times.iter().all(|seconds| seconds.is_finite() && *seconds > 0.0), "{times:?}");
        assert!(times.iter().sum::<f64>() <= took, "{times:?} in a step of {took} s");
    }
    for name in PhaseTimes::NAMES {
        assert!(reads(&mut stage, name), "{name}");
    }
    click_on(&mut stage, "Why", "");
    stage.frames(3);
    assert!(!stage.world().contains_resource::<PhaseTimes>() && !stage.world().contains_resource::<SolveTrace>());
    assert!(stage.world().contains_resource::<Diagnostics>(), "the plots are still open");
}

#[test]
fn colors_stay_through_other_scenes_undo_deletion_and_the_past() {
    let mut stage = Stage::open(BOX_ON_GROUND);
    choose(&mut stage, "overlap");
    stage.frames(10);
    let body = stage.body("box");
    // Deleted, and back.
    stage.world().insert_resource(Selection::of(body));
    stage.act(SandboxAction::DeletePicked);
    stage.frames(5);
    stage.act(SandboxAction::Undo);
    stage.frames(5);
    let is_of_scale = |color: [u8; 3]| color != RED && color != GRAY;
    assert!(is_of_scale(color(&mut stage, "box")), "it came back, and has its overlap's color");
    // Another scene, and the old one back as it was built by then.
    let body = stage.body("box");
    stage.world().insert_resource(Selection::of(body));
    stage.act(SandboxAction::PinPicked);
    stage.frames(5);
    stage.load(OVERLAPPING);
    stage.frames(5);
    assert!(is_of_scale(color(&mut stage, "deep")) && reads(&mut stage, "deepest"));
    stage.act(SandboxAction::Undo);
    stage.frames(5);
    assert!(is_of_scale(color(&mut stage, "box")));
    for by in ColorBy::EVERY {
        stage.world().insert_resource(by);
        let step = stage.world().resource::<StepStats>().steps;
        stage.act(SandboxAction::GoTo { step: step.saturating_sub(3) });
        stage.act(SandboxAction::GoToStart);
        stage.frames(2);
        stage.act(SandboxAction::TogglePause);
        stage.frames(5);
        stage.act(SandboxAction::Reset);
        stage.act(SandboxAction::ThrowBall);
        stage.frames(3);
    }
    // A number that is none.
    let ball = stage.world().resource::<CurrentScene>().entities.bodies[2];
    stage.world().get_mut::<plumb::physics::Velocity>(ball).unwrap().linear.x = f64::NAN;
    for by in ColorBy::EVERY {
        stage.world().insert_resource(by);
        stage.frames(2);
    }
    stage.world().insert_resource(ColorBy::Nothing);
    stage.frames(2);
    let body = stage.world().resource::<CurrentScene>().entities.bodies[1];
    assert_eq!(color_of(&mut stage, body), RED);
}

/// Recolored while colors are shown, it has its new color afterwards.
#[test]
fn a_body_that_is_recolored_meanwhile_has_that_color_afterwards() {
    let mut stage = paused(BOX_ON_GROUND);
    steps(&mut stage, 2);
    stage.world().insert_resource(ColorBy::Effort);
    stage.frames(2);
    let body = stage.body("box");
    stage.world().entity_mut(body).insert(plumb::scene::BodyColor([0.0, 1.0, 0.0]));
    stage.frames(2);
    assert_ne!(color(&mut stage, "box"), [0, 255, 0]);
    stage.world().insert_resource(ColorBy::Nothing);
    stage.frames(2);
    assert_eq!(color(&mut stage, "box"), [0, 255, 0]);
}
