//! Races: several methods from one moment, and how they part.

use plumb::lab::race::{Outcome, Race, Runner};
use plumb::physics::SolverSettings;
use plumb::scene::load;

fn race(scene: &str, parameters: &[(&str, f64)], by: &[&str], from: f64, seconds: f64) -> Outcome {
    let parameters: Vec<_> = parameters.iter().map(|&(name, value)| (name.to_owned(), value)).collect();
    let preset = |name: &&str| SolverSettings::PRESETS.into_iter().find(|(known, _)| known == name).unwrap();
    let runners = by.iter().map(|name| Runner { name: (*name).to_owned(), settings: preset(name).1() }).collect();
    let scene = load(scene, &parameters).unwrap();
    Race { scene, built_in: true, runners, from, seconds, apart: 0.01 }.run(|_| {})
}

#[test]
fn who_runs_alike_stays_together() {
    for from in [0.0, 0.5] {
        let outcome = race("chain", &[], &["game", "game"], from, 1.0);
        assert_eq!(outcome.base, "game");
        for course in &outcome.courses {
            assert_eq!(course.moments.len(), 61);
            assert!(course.moments.iter().all(|moment| moment.distance == 0.0 && moment.angle == 0.0), "from {from}");
            assert_eq!(course.parted, None);
        }
    }
}

#[test]
fn who_runs_otherwise_parts_and_it_is_told_when() {
    let outcome = race("chain", &[], &["accurate", "classic"], 0.2, 1.5);
    let classic = &outcome.courses[1];
    let parted = classic.parted.expect("they part");
    assert!(parted > 0.0 && parted < 1.5, "{parted} s");
    for moment in &classic.moments {
        assert_eq!(moment.distance > 0.01, moment.time >= parted || moment.distance > 0.01);
        assert!(moment.time >= parted || moment.distance <= 0.01, "{moment:?}, parted at {parted} s");
    }
    assert_eq!(outcome.courses[0].parted, None);
}

#[test]
fn a_stack_stands_by_game_and_falls_by_classic() {
    let outcome = race("stack", &[("n", 5.0)], &["classic", "game", "accurate"], 0.0, 10.0);
    assert_eq!(outcome.base, "the answer");
    let failed: Vec<_> = outcome.courses.iter().map(|course| course.failed.clone()).collect();
    assert!(failed[0].is_some(), "{failed:?}");
    assert_eq!(failed[1..], [None, None]);
    assert!(outcome.courses[1].moments.iter().all(|moment| moment.distance < 1e-3));
}

#[test]
fn rows_and_pictures_have_every_moment() {
    let outcome = race("limbs", &[], &["game", "steady"], 0.3, 0.5);
    let csv = outcome.csv();
    let mut lines = csv.lines();
    assert_eq!(lines.next(), Some("t,runner,distance_m,angle_rad,energy_J,joint_gap_m,overlap_m,ms_per_step"));
    let rows: Vec<Vec<&str>> = lines.map(|line| line.split(',').collect()).collect();
    assert_eq!(rows.len(), 2 * 31);
    for row in rows {
        assert_eq!(row.len(), 8);
        assert!(row.iter().enumerate().all(|(column, cell)| column == 1 || cell.parse::<f64>().unwrap().is_finite()));
    }
}
