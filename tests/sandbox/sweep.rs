//! The panel's sweep: run by a process of its own, its curve, and what a click takes.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use bevy::prelude::*;
use plumb::lab::{Metrics, Plan, measure};
use plumb::physics::{SolverSettings, StepStats};
use plumb::sandbox::{ChartSource, CurrentScene, Notice, Page, SandboxAction};

use crate::eyes::{click, click_on, discs, open_eyes, point_at, reads, rewrite, seen, text_with};
use crate::stage::Stage;

/// The color of points that hold.
const SKY: [u8; 3] = [86, 180, 233];

/// A built-in scene by the classic method, the panel's sweep open with that name chosen.
fn sweeping(folder: &Path, scene: &str, parameters: &[(&str, f64)], name: &str) -> Stage {
    let mut stage = Stage::open("(bodies: [])");
    let program = PathBuf::from(env!("CARGO_BIN_EXE_plumb"));
    stage.world().insert_resource(ChartSource { program, folder: folder.to_owned() });
    let parameters = parameters.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect();
    stage.act(SandboxAction::LoadScene { scene: scene.to_owned(), parameters });
    *stage.world().resource_mut::<SolverSettings>() = SolverSettings { threads: 2, ..SolverSettings::classic() };
    open_eyes(&mut stage, Page::Solver);
    click_on(&mut stage, "Sweep", "");
    click_on(&mut stage, "…", "Sweep");
    click_on(&mut stage, name, "Sweep");
    stage
}

/// Has another quantity be drawn.
fn choose(stage: &mut Stage, from: &str, to: &str) {
    click_on(stage, from, "Sweep");
    click_on(stage, to, "Sweep");
}

/// Waits until that holds, while the scene goes on.
fn wait(stage: &mut Stage, what: &str, holds: impl Fn(&mut Stage) -> bool) {
    let started = Instant::now();
    while !holds(stage) {
        assert!(started.elapsed() < Duration::from_secs(120), "{what}");
        stage.frames(1);
        std::thread::sleep(Duration::from_millis(10));
    }
}

/// Presses Run, and waits until it has ended.
fn run(stage: &mut Stage) {
    click_on(stage, "Run", "Sweep");
    wait(stage, "the sweep does not end", |stage| !reads(stage, "Stop"));
    // Axes are fitted, and drawn a frame later.
    stage.frames(3);
}

/// What the lab measures of a scene for 2 s.
fn measured(scene: &str, settings: SolverSettings) -> Metrics {
    let plan = Plan::new(scene, &[], SolverSettings { threads: 1, ..settings }, Some(2.0)).unwrap();
    measure(&plan, |_| Ok::<(), ()>(())).unwrap()
}

/// The number that is told of the point under the pointer.
fn told(stage: &mut Stage, at: Vec2, value: &str) -> f64 {
    point_at(stage, at);
    let text = text_with(stage, &format!("{value}\n")).unwrap_or_else(|| panic!("{value} is not told"));
    let number = text.lines().nth(1).and_then(|line| line.rsplit_once(": ")).map(|(_, number)| number.to_owned());
    number.and_then(|number| number.parse().ok()).unwrap_or_else(|| panic!("no number in '{text}'"))
}

#[test]
fn the_curve_is_what_the_lab_measures_and_a_click_takes_a_value() {
    let folder = tempfile::tempdir().unwrap();
    let mut stage = sweeping(folder.path(), "slide_roll", &[], "hz");
    seen(&mut stage, "15:240:log:5", "Sweep"); // what is suggested
    rewrite(&mut stage, "15:240:log:5", "Sweep", "30:240:log:4");
    run(&mut stage);
    let dots = discs(&mut stage, SKY);
    assert_eq!(dots.len(), 4);
    let rates = [30.0, 60.0, 120.0, 240.0];
    let errors = rates.map(|hz| {
        let truth = measured("slide_roll", SolverSettings { hz, ..SolverSettings::classic() }).truth;
        truth.expect("a known answer").error
    });
    assert!(reads(&mut stage, "error, m/s"));
    for ((dot, hz), error) in dots.iter().zip(rates).zip(errors) {
        let told = told(&mut stage, *dot, &format!("hz={hz}"));
        // Of three digits.
        assert!((told - error).abs() < 5.1e-3 * error, "{hz} Hz: {told}, not {error}");
    }
    // By the values' logarithms along, by the errors, which are within a decade, up.
    let [left, up] = [dots[1].x - dots[0].x, dots[0].y - dots[3].y];
    for (index, dot) in dots.iter().enumerate() {
        assert!((dot.x - dots[0].x - index as f32 * left).abs() < 1.0, "{dots:?}");
        let share = (errors[index] - errors[0]) / (errors[3] - errors[0]);
        assert!((dots[0].y - dot.y - up * share as f32).abs() < 1.0, "{dots:?} of {errors:?}");
    }
    click_on(&mut stage, "log", "Sweep");
    let logarithmic = discs(&mut stage, SKY);
    let share = ((errors[1] / errors[0]).ln() / (errors[3] / errors[0]).ln()) as f32;
    let up = (logarithmic[0].y - logarithmic[1].y) / (logarithmic[0].y - logarithmic[3].y);
    assert!((up - share).abs() < 0.02, "{up}, not {share}");

    // Of the same runs, something else.
    choose(&mut stage, "error", "bodies move by, m");
    let move_by = told(&mut stage, dots[3], "hz=240");
    let expected = measured("slide_roll", SolverSettings { hz: 240.0, ..SolverSettings::classic() }).drift_max_m;
    assert!((move_by - expected).abs() < 6e-3, "{move_by}, not {expected}");
    choose(&mut stage, "bodies move by, m", "bodies tremble at, m/s");
    assert!(reads(&mut stage, "not known of these runs"), "of what does not stay no trembling is measured");

    assert!(reads(&mut stage, "now 60"));
    // Anywhere above or below a point means it.
    click(&mut stage, dots[2] + Vec2::new(3.0, 25.0));
    let own = *stage.world().resource::<SolverSettings>();
    let expected = SolverSettings { hz: 120.0, threads: 2, ..SolverSettings::classic() };
    assert_eq!(own.differences(&expected).map(|setting| setting.name).collect::<Vec<_>>(), [""; 0]);
    stage.frames(2);
    assert!(reads(&mut stage, "now 120") && !reads(&mut stage, "from before"), "what varies makes nothing old");

    stage.world().resource_mut::<SolverSettings>().iterations = 7;
    stage.frames(2);
    assert!(reads(&mut stage, "from before: settings are others now: iterations"));
    assert_eq!(discs(&mut stage, SKY).len(), 4, "what was measured is kept");
}

#[test]
fn a_click_on_a_scenes_parameter_loads_the_scene_with_it() {
    let folder = tempfile::tempdir().unwrap();
    let mut stage = sweeping(folder.path(), "incline", &[("mu", 0.3), ("theta", 40.0)], "theta");
    *stage.world().resource_mut::<SolverSettings>() = SolverSettings::accurate();
    stage.frames(2);
    let suggested = text_with(&mut stage, ":lin:5").expect("values");
    rewrite(&mut stage, &suggested, "Sweep", "5,20,60");
    run(&mut stage);
    choose(&mut stage, "error", "bodies move by, m");
    let dots = discs(&mut stage, SKY);
    assert_eq!(dots.len(), 3, "a parameter that is set can vary, too");
    assert!(reads(&mut stage, "now 40"));
    let [least, most] = [0, 2].map(|index| told(&mut stage, dots[index], ["theta=5", "", "theta=60"][index]));
    assert!(least < 0.01 && most > 5.0, "{least} m, {most} m: it sticks below atan 0.3, 17°");
    click(&mut stage, dots[1]);
    let scene = stage.world().resource::<CurrentScene>();
    assert_eq!((scene.scene.as_str(), scene.parameters.len()), ("incline", 2));
    for (name, value) in [("mu", 0.3), ("theta", 20.0)] {
        assert!(scene.parameters.contains(&(name.to_owned(), value)), "{:?}", scene.parameters);
    }
    stage.frames(3);
    assert!(reads(&mut stage, "now 20") && !reads(&mut stage, "from before"));
    stage.act(SandboxAction::LoadScene { scene: "incline".into(), parameters: vec![("mu".into(), 0.1)] });
    stage.frames(3);
    assert!(reads(&mut stage, "from before: the scene has other parameters now"));
    assert_eq!(discs(&mut stage, SKY).len(), 3);
}

#[test]
fn a_point_that_fails_is_no_disc_and_tells_why() {
    let folder = tempfile::tempdir().unwrap();
    let mut stage = sweeping(folder.path(), "stack", &[("n", 5.0)], "iterations");
    rewrite(&mut stage, "1:16:log:5", "Sweep", "1,100");
    run(&mut stage);
    let dots = discs(&mut stage, SKY);
    assert_eq!(dots.len(), 1, "a hundred sweeps hold the stack, one does not");
    point_at(&mut stage, dots[0] - Vec2::X * 150.0);
    assert!(reads(&mut stage, "iterations=1\n"));
    assert!(reads(&mut stage, "fails: a body that should stay moves by"));
    point_at(&mut stage, dots[0]);
    assert!(reads(&mut stage, "iterations=100\n") && !reads(&mut stage, "fails: "));
}

#[test]
fn what_cannot_be_swept_is_told_in_a_line_below_the_values() {
    let folder = tempfile::tempdir().unwrap();
    let mut stage = sweeping(folder.path(), "slide_roll", &[], "iterations");
    for (before, typed, says) in [
        ("1:16:log:5", "0,4", "iterations: 0 is out of range, must be at least 1"),
        ("0,4", "4:1:lin:3", "does not go up"),
        ("4:1:lin:3", "1.5", "'1.5' is not a whole number"),
    ] {
        rewrite(&mut stage, before, "Sweep", typed);
        assert!(reads(&mut stage, says), "{typed}");
        click_on(&mut stage, "Run", "Sweep");
        assert!(reads(&mut stage, says) && !reads(&mut stage, "Stop"), "{typed} is not run");
    }
    rewrite(&mut stage, "1.5", "Sweep", "3,5");
    assert!(!reads(&mut stage, "whole number"), "what is mended is no longer told");
    *stage.world().resource_mut::<SolverSettings>() = SolverSettings::accurate();
    stage.frames(2);
    click_on(&mut stage, "Run", "Sweep");
    assert!(reads(&mut stage, "iterations: exact does not read it"), "nor is what the method does not read");
    *stage.world().resource_mut::<SolverSettings>() = SolverSettings::classic();
    stage.world().resource_mut::<ChartSource>().program = PathBuf::from("/nowhere/plumb");
    click_on(&mut stage, "Run", "Sweep");
    assert!(reads(&mut stage, "No such file"), "nor does a program run that is not there");
    stage.world().resource_mut::<ChartSource>().program = PathBuf::from("/bin/false");
    click_on(&mut stage, "Run", "Sweep");
    wait(&mut stage, "it does not end", |stage| !reads(stage, "Stop"));
    let notice = stage.world().resource::<Notice>().clone();
    assert!(matches!(&notice, Notice::Error(text) if text.contains("the sweep ended too early")), "{notice:?}");
}

#[test]
fn another_scene_leaves_the_sweep_at_work_and_stop_keeps_what_is_there() {
    let folder = tempfile::tempdir().unwrap();
    // The last points of it take seconds.
    const VALUES: [u32; 8] = [1, 2, 4, 8, 16, 32, 64, 100];
    let is_on_its_way = |stage: &mut Stage| (1..8).any(|points| reads(stage, &format!("{points} of 8")));
    let mut stage = sweeping(folder.path(), "limbs", &[], "iterations");
    rewrite(&mut stage, "1:16:log:5", "Sweep", "1,2,4,8,16,32,64,100");
    click_on(&mut stage, "Run", "Sweep");
    wait(&mut stage, "no point comes", is_on_its_way);
    let steps = stage.world().resource::<StepStats>().steps;
    stage.frames(5);
    assert!(stage.world().resource::<StepStats>().steps > steps, "the scene goes on");
    stage.act(SandboxAction::LoadScene { scene: "pendulum".into(), parameters: Vec::new() });
    stage.frames(2);
    assert!(reads(&mut stage, "Stop") && reads(&mut stage, "from before: another scene is on view now"));
    stage.act(SandboxAction::Reset);
    wait(&mut stage, "it does not end", |stage| !reads(stage, "Stop"));
    choose(&mut stage, "error", "joints part by, m");
    assert!(!reads(&mut stage, " of 8") && reads(&mut stage, "limbs as it is loaded"));
    // Over another scene, too, a setting is a setting.
    let label = seen(&mut stage, "joints part by, m", "log");
    click(&mut stage, label + Vec2::new(0.0, 100.0));
    let iterations = stage.world().resource::<SolverSettings>().iterations;
    assert!(VALUES.contains(&iterations), "{iterations}");
    assert_eq!(stage.world().resource::<CurrentScene>().scene, "pendulum");

    stage.act(SandboxAction::LoadScene { scene: "limbs".into(), parameters: Vec::new() });
    rewrite(&mut stage, "1,2,4,8,16,32,64,100", "Sweep", "1,2,3,8,16,32,64,100");
    click_on(&mut stage, "Run", "Sweep");
    wait(&mut stage, "no point comes", is_on_its_way);
    click_on(&mut stage, "Stop", "Sweep");
    stage.frames(30);
    assert!(reads(&mut stage, " of 8") && reads(&mut stage, "Run"), "those that are there stay");
}
