//! `plumb chart`, `map` and `fit`, run as processes: what they keep, draw, resume and share out.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use plumb::lab::chart::{Extent, Subject};
use plumb::lab::map::ATLAS;
use plumb::lab::read_settings;
use plumb::lab::sweep::{Record, Store};
use plumb::lab::verdict::Verdict;
use plumb::scene;

/// The quickest scene there is.
const SCENE: &str = "slide_roll";

fn plumb(arguments: &[&str], folder: &Path) -> Output {
    let command = Command::new(env!("CARGO_BIN_EXE_plumb")).args(arguments).arg("--out").arg(folder).output();
    command.expect("the binary runs")
}

pub(super) fn succeeds(arguments: &[&str], folder: &Path) -> String {
    let output = plumb(arguments, folder);
    let complaint = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {complaint}");
    String::from_utf8(output.stdout).unwrap()
}

/// The rows of a folder's file, as they are written.
pub(super) fn rows(folder: &Path) -> Vec<Record> {
    let mut reader = csv::ReaderBuilder::new().flexible(true).from_path(folder.join("points.csv")).unwrap();
    reader.deserialize().filter_map(Result::ok).collect()
}

pub(super) fn keys(folder: &Path) -> BTreeSet<String> {
    rows(folder).into_iter().map(|record| record.key).collect()
}

fn planned() -> usize {
    let subject = Subject { scene: SCENE.to_owned(), parameters: Vec::new() };
    subject.points(Extent::Quick).unwrap().len()
}

#[test]
fn chart_draws_every_point_and_measures_none_twice() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    succeeds(&["chart", SCENE, "--quick"], folder);
    let first = rows(folder);
    assert_eq!(first.len(), planned());
    assert!(first.iter().all(|record| record.error.is_some_and(f64::is_finite) && record.cost().unwrap() > 0.0));
    // A mark and a legend entry a method, the front's rings: as many shapes as points at least.
    let svg = fs::read_to_string(folder.join("slide_roll.svg")).unwrap();
    let shapes = svg.matches("<circle").count() + svg.matches("<polygon").count() + svg.matches("<polyline").count();
    assert!(shapes > first.len(), "{shapes} shapes for {} points", first.len());
    assert!(fs::read(folder.join("slide_roll.png")).unwrap().starts_with(b"\x89PNG"));
    let page = fs::read_to_string(folder.join("index.html")).unwrap();
    assert!(page.contains("slide_roll.svg") && page.contains("The front runs") || page.contains("One point beats"));

    succeeds(&["chart", SCENE, "--quick"], folder);
    assert_eq!(rows(folder), first, "a second chart measured anew");

    succeeds(&["chart", SCENE, "--quick", "--again"], folder);
    let both = rows(folder);
    assert_eq!(both.len(), 2 * planned());
    assert_eq!(both[..planned()], first);
    assert_eq!(keys(folder).len(), planned());
    succeeds(&["chart", SCENE, "--quick"], folder);
    assert_eq!(rows(folder), both, "a chart measured twice was measured a third time");
}

#[test]
fn an_interrupted_sweep_goes_on_where_it_was() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    succeeds(&["chart", SCENE, "--quick"], folder);
    let first = rows(folder);
    let path = folder.join("points.csv");
    let text = fs::read(&path).unwrap();
    fs::write(&path, &text[..text.len() - 40]).unwrap();
    succeeds(&["chart", SCENE, "--quick"], folder);
    let resumed = rows(folder);
    assert_eq!(keys(folder).len(), planned());
    // All but the row cut short are the ones that were there.
    let kept = first.len() - 1;
    assert_eq!(resumed.iter().filter(|record| first[..kept].contains(record)).count(), kept);
}

#[test]
fn shards_merge_by_concatenation() {
    let folders: [_; 3] = std::array::from_fn(|_| tempfile::tempdir().unwrap());
    let [one, other, both] = folders.each_ref().map(|folder| folder.path());
    succeeds(&["chart", SCENE, "--quick", "--shard", "1/2"], one);
    succeeds(&["chart", SCENE, "--quick", "--shard", "2/2"], other);
    assert!(keys(one).is_disjoint(&keys(other)));
    assert!(!keys(one).is_empty() && !keys(other).is_empty());
    let text = [one, other].map(|folder| fs::read(folder.join("points.csv")).unwrap()).concat();
    fs::write(both.join("points.csv"), &text).unwrap();
    succeeds(&["chart", SCENE, "--quick"], both);
    assert_eq!(fs::read(both.join("points.csv")).unwrap(), text, "the merged file lacked a point");
    assert_eq!(keys(both).len(), planned());
}

#[test]
fn points_of_another_build_are_left_aside() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("points.csv");
    succeeds(&["chart", SCENE, "--quick"], folder.path());
    // This test's program is not the one that measured.
    let store = Store::open(&path).unwrap();
    assert_eq!(store.records().len(), 0);
    assert_eq!(store.ignored(), planned());
}

#[test]
fn chart_refuses_what_makes_no_sense() {
    let folder = tempfile::tempdir().unwrap();
    for (arguments, says) in [
        (&["chart", "stak"][..], "stack"),
        (&["chart", "rods", "chain", "-p", "n=2"], "exactly one scene"),
        (&["chart", "rods", "--shard", "3/2"], "I/N"),
        (&["chart", "rods", "--peers", "nowhere"], "nowhere"),
        (&["map", "limbs"], "no map of 'limbs'"),
        (&["fit", "pendulum", "--error", "0"], "greater than 0"),
        (&["fit", "pendulum"], "--error"),
    ] {
        let output = plumb(arguments, folder.path());
        let complaint = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {complaint}");
        assert!(complaint.contains(says) && complaint.lines().count() == 1, "{arguments:?}: {complaint}");
    }
}

#[test]
fn maps_name_scenes_and_parameters_that_exist() {
    for map in &ATLAS {
        let map = map.plan();
        for point in map.points() {
            assert!(point.settings.validate().is_ok());
        }
        let (x, y) = (map.x.values(), map.y.values());
        let corners = [0, x.len() - 1].map(|column| [0, y.len() - 1].map(|row| (x[column], y[row])));
        for (x, y) in corners.into_iter().flatten() {
            let point = map.point(&map.study.candidates[0], x, y);
            let loaded = scene::load(&point.scene, &point.parameters);
            assert!(loaded.is_ok(), "{}: {}", map.name, loaded.unwrap_err());
        }
        assert_eq!(map.study.check(&[&map.x, &map.y]), Ok(()), "{}", map.name);
    }
}

/// The map of made-up records, so that the picture's cells are known.
#[test]
fn maps_put_each_verdict_in_its_cell() {
    // Over substeps: sweeps are all the same to a method that has none.
    let map = ATLAS.iter().find(|map| map.name == "stack").unwrap().plan();
    let points = map.points();
    let folder = tempfile::tempdir().unwrap();
    succeeds(&["chart", SCENE, "--quick"], folder.path());
    let sample = rows(folder.path()).remove(0);
    // Fails to the left of column 3, from row 2 up; the last point of all was not measured.
    let verdict = |column: usize, row: usize| if column < 3 && row >= 2 { Verdict::Fails } else { Verdict::Holds };
    let (columns, rows) = (map.x.values().len(), map.y.values().len());
    let records: Vec<Record> = points[..points.len() - 1]
        .iter()
        .enumerate()
        .map(|(index, point)| {
            let verdict = verdict(index % columns, index / columns % rows);
            Record { key: point.key(), verdict, ..sample.clone() }
        })
        .collect();
    let maps = map.maps(&records);
    for (index, drawn) in maps.iter().enumerate() {
        for (row, cells) in drawn.cells.iter().enumerate() {
            for (column, cell) in cells.iter().enumerate() {
                let last = (index, row, column) == (maps.len() - 1, rows - 1, columns - 1);
                let expected = (!last).then(|| verdict(column, row));
                assert_eq!(
                    cell.as_ref().map(|record| record.verdict),
                    expected,
                    "map {index}, row {row}, column {column}"
                );
            }
        }
    }
    map.draw(&maps, folder.path()).unwrap();
    let svg = fs::read_to_string(folder.path().join("map-stack.svg")).unwrap();
    assert_eq!(svg.matches("×</text>").count() + svg.matches("×\n</text>").count(), {
        records.iter().filter(|record| record.verdict == Verdict::Fails).count()
    });
}

/// So that the map of friction over contact points shows how much there is, where every other says whether it holds.
#[test]
fn a_map_that_writes_a_measure_has_it_in_its_cells() {
    let map = ATLAS.iter().find(|map| map.name == "incline").unwrap().plan();
    let folder = tempfile::tempdir().unwrap();
    succeeds(&["chart", SCENE, "--quick"], folder.path());
    let sample = rows(folder.path()).remove(0);
    let points = map.points();
    let records = points.iter().map(|point| Record { key: point.key(), drift: Some(3.125), ..sample.clone() });
    map.draw(&map.maps(&records.collect::<Vec<_>>()), folder.path()).unwrap();
    let svg = fs::read_to_string(folder.path().join("map-incline.svg")).unwrap();
    assert_eq!(svg.matches("3.12").count(), points.len(), "{svg}");
    for text in ["incline mu=0.1: bodies move by, m", "friction=one_tangent", "friction=two_tangents", "accurate"] {
        assert!(svg.contains(text), "no {text}");
    }
}

#[test]
fn fit_writes_the_cheapest_settings_that_hold() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let text = succeeds(&["fit", "rods", "-p", "n=1", "--error", "5e-3", "--seconds", "1"], folder);
    // A step of the true method costs about as much as one of the others here, and has no error to speak of.
    assert!(text.contains("Cheapest that holds") && text.contains("accurate is the cheapest"), "{text}");
    let (_, command) = text.split_once(": plumb ").expect("a command to go on with");
    let command: Vec<&str> = command.split_whitespace().collect();
    let settings = read_settings(Path::new(command.last().unwrap())).unwrap();
    let records = rows(folder);
    let found = records.iter().find(|record| record.solver_settings() == Some(settings)).unwrap();
    assert!(found.error.unwrap() <= 0.8 * 5e-3 && found.verdict <= Verdict::Degrades);
    let cheaper = records.iter().filter(|record| record.cost() < found.cost());
    for record in cheaper {
        let holds = record.error.unwrap() <= 0.8 * 5e-3 && record.verdict <= Verdict::Degrades;
        assert!(!holds, "{record:?} is cheaper and holds too");
    }
    // What is written runs, and the run is the one that was measured.
    let run =
        Command::new(env!("CARGO_BIN_EXE_plumb")).args(command).args(["--seconds", "1", "--json"]).output().unwrap();
    let run: serde_json::Value = serde_json::from_slice(&run.stdout).unwrap();
    // Numbers are read from JSON to a unit in the last place.
    let (again, first) = (run["truth"]["error"].as_f64().unwrap(), found.error.unwrap());
    assert!((again - first).abs() <= 2.0 * f64::EPSILON * first, "{again:e} for {first:e}");
}

#[test]
fn fit_says_so_where_nothing_holds() {
    let folder = tempfile::tempdir().unwrap();
    let output = plumb(&["fit", "top", "--error", "1e-17", "--seconds", "0.2"], folder.path());
    assert_eq!(output.status.code(), Some(1));
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.contains("Nothing holds") && text.contains("The best there is"), "{text}");
    assert!(!folder.path().join("fit-top.ron").exists());
}
