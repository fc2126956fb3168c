//! The panel's chart: measured by a process of its own.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use bevy::prelude::*;
use plumb::lab::sweep::read_records;
use plumb::sandbox::{ChartSource, Notice, SandboxAction};

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
