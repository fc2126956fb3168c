//! The panel's chart: measured by a process of its own.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use bevy::prelude::*;
use plumb::lab::sweep::read_records;
use plumb::physics::SolverSettings;
use plumb::sandbox::{ChartSource, Notice, Page, SandboxAction};

use crate::eyes::{click, click_on, discs, open_eyes, point_at, reads};
use crate::stage::Stage;

#[test]
fn the_scenes_chart_is_measured_while_the_scene_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    let program = PathBuf::from(env!("CARGO_BIN_EXE_plumb"));
    let mut stage = Stage::open("(bodies: [])");
    stage.world().insert_resource(ChartSource { program: program.clone(), folder: folder.path().to_owned() });
    stage.act(SandboxAction::LoadScene { scene: "slide_roll".to_owned(), parameters: Vec::new() });
    stage.act(SandboxAction::MeasureChart);
    let file = folder.path().join("points.csv");
    let started = Instant::now();
    while read_records(&file, &program).len() < 32 {
        assert!(started.elapsed() < Duration::from_secs(120), "{:?}", read_records(&file, &program).len());
        stage.frames(1);
        std::thread::sleep(Duration::from_millis(20));
    }
    assert!(read_records(&file, &program).iter().all(|record| record.scene == "slide_roll"));

    // Once that process has ended, the same action measures every point again.
    let started = Instant::now();
    while read_records(&file, &program).len() < 64 {
        assert!(started.elapsed() < Duration::from_secs(120), "{:?}", read_records(&file, &program).len());
        stage.act(SandboxAction::MeasureChart);
        std::thread::sleep(Duration::from_millis(20));
    }
}

#[test]
fn a_program_that_cannot_be_run_is_named() {
    let mut stage = Stage::open("(bodies: [])");
    let nowhere = ChartSource { program: PathBuf::from("/nowhere/plumb"), folder: PathBuf::from("charts") };
    stage.world().insert_resource(nowhere);
    stage.act(SandboxAction::LoadScene { scene: "slide_roll".to_owned(), parameters: Vec::new() });
    stage.act(SandboxAction::MeasureChart);
    let notice = stage.world().resource::<Notice>().clone();
    assert!(matches!(&notice, Notice::Error(text) if text.contains("cannot be measured")), "{notice:?}");
}

/// The color of the points of the first method, `game`.
const SKY: [u8; 3] = [86, 180, 233];

#[test]
fn a_click_takes_over_the_settings_of_a_point() {
    let folder = tempfile::tempdir().unwrap();
    let program = PathBuf::from(env!("CARGO_BIN_EXE_plumb"));
    let mut stage = Stage::open("(bodies: [])");
    stage.world().insert_resource(ChartSource { program: program.clone(), folder: folder.path().to_owned() });
    stage.act(SandboxAction::LoadScene { scene: "slide_roll".to_owned(), parameters: Vec::new() });
    open_eyes(&mut stage, Page::Solver);
    *stage.world().resource_mut::<SolverSettings>() = SolverSettings { threads: 2, ..SolverSettings::classic() };
    stage.frames(2);
    click_on(&mut stage, "Chart", "");
    click_on(&mut stage, "Measure", "Chart");
    let started = Instant::now();
    while !reads(&mut stage, "Measure again") {
        assert!(started.elapsed() < Duration::from_secs(120), "it is not measured");
        stage.frames(1);
        std::thread::sleep(Duration::from_millis(20));
    }
    assert!(reads(&mut stage, "no point has the present settings"));
    // One of the cheapest: which is the very cheapest, the clock tells.
    let points = discs(&mut stage, SKY);
    let is_told = |place: &Vec2| {
        point_at(&mut stage, *place);
        reads(&mut stage, "game f32\n60 Hz, substeps 1, iterations 1\n")
    };
    let coarse = points.into_iter().find(is_told).expect("the point under the pointer is told");
    click(&mut stage, coarse);
    let own = *stage.world().resource::<SolverSettings>();
    // Threads and sleep stay as they were.
    let mut game = SolverSettings { hz: 60.0, substeps: 1, iterations: 1, threads: 2, ..SolverSettings::game() };
    game.impulse.sleep_speed = SolverSettings::classic().impulse.sleep_speed;
    let differing = own.differences(&game).map(|setting| setting.name);
    assert_eq!(differing.collect::<Vec<_>>(), [""; 0]);
    stage.frames(2);
    assert!(reads(&mut stage, "the ring has the present settings"));
}
