//! The panel's chart: measured by a process of its own.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use bevy::prelude::*;
use plumb::lab::sweep::read_records;
use plumb::physics::{SolverSettings, StepStats};
use plumb::sandbox::{ChartOf, ChartSource, Notice, SandboxAction};

use crate::eyes::{click, click_on, discs, open_eyes, point_at, reads, rewrite, seen};
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

/// The colour of the points of a varied chart: of its only curve.
const SKY: [u8; 3] = [86, 180, 233];

/// `slide_roll` by the classic method with a slop of its own on two threads, the panel's chart open at *vary*.
fn varying(folder: &std::path::Path) -> Stage {
    let mut stage = Stage::open("(bodies: [])");
    let program = PathBuf::from(env!("CARGO_BIN_EXE_plumb"));
    stage.world().insert_resource(ChartSource { program, folder: folder.to_owned() });
    stage.act(SandboxAction::LoadScene { scene: "slide_roll".to_owned(), parameters: Vec::new() });
    *stage.world().resource_mut::<SolverSettings>() =
        SolverSettings { slop: 0.02, threads: 2, ..SolverSettings::classic() };
    open_eyes(&mut stage);
    click_on(&mut stage, "Chart", "");
    click_on(&mut stage, "vary", "Chart");
    click_on(&mut stage, "…", "Chart");
    click_on(&mut stage, "iterations", "Chart");
    stage
}

/// Settings that a step reads and that differ.
fn differing(one: &SolverSettings, other: &SolverSettings) -> Vec<&'static str> {
    one.differences(other).map(|setting| setting.name).collect()
}

fn measure(stage: &mut Stage) {
    click_on(stage, "Measure", "Chart");
    let started = Instant::now();
    while !reads(stage, "Measure again") {
        assert!(started.elapsed() < Duration::from_secs(120), "it is not measured");
        stage.frames(1);
        std::thread::sleep(Duration::from_millis(20));
    }
}

#[test]
fn the_panel_varies_one_setting_of_the_present_ones_and_a_click_takes_a_point_over() {
    let folder = tempfile::tempdir().unwrap();
    let mut stage = varying(folder.path());
    let varied = ChartOf::Varied("iterations=1:16:log:5".to_owned());
    assert_eq!(*stage.world().resource::<ChartOf>(), varied, "values about the present four are suggested");
    measure(&mut stage);

    let records = read_records(&folder.path().join("points.csv"), env!("CARGO_BIN_EXE_plumb").as_ref());
    assert_eq!(records.len(), 5);
    for (record, iterations) in records.iter().zip([1, 2, 4, 8, 16]) {
        assert_eq!(record.scene, "slide_roll");
        let expected = SolverSettings { iterations, slop: 0.02, threads: 1, ..SolverSettings::classic() };
        assert_eq!(differing(&record.solver_settings().unwrap(), &expected), [""; 0]);
    }

    assert!(reads(&mut stage, "the ring has the present settings"), "four sweeps are among the values");
    let dots = discs(&mut stage, SKY);
    assert_eq!(dots.len(), 5);
    point_at(&mut stage, dots[1]);
    assert!(reads(&mut stage, "iterations 2\n"), "the point under the pointer is told");
    // The point has what the settings were when the chart was asked for, but the machine's threads.
    stage.world().resource_mut::<SolverSettings>().slop = 0.03;
    stage.frames(2);
    assert!(reads(&mut stage, "no point has the present settings"));
    click(&mut stage, dots[1]);
    let taken = SolverSettings { iterations: 2, slop: 0.02, threads: 2, ..SolverSettings::classic() };
    assert_eq!(differing(stage.world().resource::<SolverSettings>(), &taken), [""; 0]);
    stage.frames(2);
    assert!(reads(&mut stage, "the ring has the present settings"));

    click_on(&mut stage, "methods", "Chart");
    assert_eq!(*stage.world().resource::<ChartOf>(), ChartOf::Methods);
    assert!(reads(&mut stage, "not measured yet"), "the methods are another chart");
}

#[test]
fn values_that_cannot_be_had_are_told_below_the_line_and_vary_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let mut stage = varying(folder.path());
    for (before, typed, says) in [
        ("1:16:log:5", "0,4", "iterations: 0 is out of range, must be at least 1"),
        ("0,4", "4:1:lin:3", "does not go up"),
        ("4:1:lin:3", "1.5", "'1.5' is not a whole number"),
    ] {
        rewrite(&mut stage, before, "Chart", typed);
        assert!(reads(&mut stage, says), "{typed}");
        let chart = stage.world().resource::<ChartOf>();
        assert_eq!(*chart, ChartOf::Varied("iterations=1:16:log:5".to_owned()), "{typed}");
    }
    rewrite(&mut stage, "1.5", "Chart", "3,5");
    assert_eq!(*stage.world().resource::<ChartOf>(), ChartOf::Varied("iterations=3,5".to_owned()));
    assert!(!reads(&mut stage, "whole number"), "what is mended is no longer told");
    seen(&mut stage, "3,5", "Chart");
}

/// Of what is asked for elsewhere than in the line, the notice tells.
#[test]
fn a_chart_of_what_nobody_reads_is_refused_with_a_notice() {
    let folder = tempfile::tempdir().unwrap();
    let mut stage = varying(folder.path());
    for (text, says) in [("bumgarte=1", "nothing is named 'bumgarte'"), ("sleep_speed=0.1", "pgs does not read it")] {
        *stage.world().resource_mut::<ChartOf>() = ChartOf::Varied(text.to_owned());
        stage.frames(2);
        let notice = stage.world().resource::<Notice>().clone();
        assert!(matches!(&notice, Notice::Error(told) if told.contains(says)), "{text}: {notice:?}");
        assert_eq!(*stage.world().resource::<ChartOf>(), ChartOf::Methods, "{text}");
    }
    let steps = stage.world().resource::<StepStats>().steps;
    stage.frames(10);
    assert!(stage.world().resource::<StepStats>().steps > steps, "the scene goes on");
}
