//! `--vary` of `plumb chart` and `plumb map`, and `--set` of `plumb run`, run as processes.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use plumb::lab::read_settings;
use plumb::physics::{ContactModel, SolverSettings};

use crate::command_line::refuses;
use crate::sweeps::{keys, rows, succeeds};

/// How often each value of a column of the settings was run.
fn values(folder: &Path, setting: &str) -> Vec<String> {
    let of = |settings: String| {
        let (_, after) = settings.split_once(&format!("{setting}:")).expect(setting);
        after.split([',', ')']).next().unwrap_or_default().to_owned()
    };
    rows(folder).into_iter().map(|record| of(record.settings)).collect()
}

#[test]
fn a_chart_varies_one_thing_and_draws_a_curve_for_each_candidate() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let arguments = [
        "chart",
        "slide_roll",
        "--vary",
        "iterations=1:100:log:3",
        "--preset",
        "classic",
        "--compare",
        "warm_starting=true,contacts=clipping",
        "--seconds",
        "0.2",
        "--measure",
        "error,cost,drift",
    ];
    let said = succeeds(&arguments, folder);
    let path = folder.join("slide_roll-by-iterations-and-warm_starting-and-contacts.svg");
    assert_eq!(said.trim(), path.display().to_string());
    let records = rows(folder);
    assert_eq!(values(folder, "iterations"), ["1", "10", "100", "1", "10", "100"]);
    assert_eq!(values(folder, "contacts"), [["extreme_vertices"; 3], ["clipping"; 3]].concat());
    assert!(records.iter().all(|record| record.seconds == 0.2 && record.error.is_some()));
    assert_eq!(records[0].series, "classic");
    assert_eq!(records[3].series, "warm_starting=true, contacts=clipping");
    // Nothing else is varied: the first is the preset but for its sweeps.
    let first = SolverSettings { iterations: 1, ..SolverSettings::classic() };
    assert_eq!(records[0].solver_settings().unwrap().differences(&first).count(), 0);
    let svg = fs::read_to_string(&path).unwrap();
    // A disc for each run of the first curve in three panels, one in the legend and the faint one.
    assert_eq!(svg.matches("<circle").count(), 3 * 3 + 2, "{svg}");
    for text in ["classic", "warm_starting=true, contacts=clipping", "iterations", "bodies move by, m"] {
        assert!(svg.contains(text), "no {text}");
    }
    assert!(fs::read(path.with_extension("png")).unwrap().starts_with(b"\x89PNG"));

    succeeds(&arguments, folder);
    assert_eq!(rows(folder), records, "a second chart measured anew");
}

#[test]
fn a_map_of_two_by_two_has_a_panel_for_each_choice() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let arguments = [
        "map",
        "incline",
        "--vary",
        "theta=5,45",
        "--vary",
        "mu=0.1,0.4",
        "--vary",
        "contacts=single_point,extreme_vertices,clipping",
        "--preset",
        "classic",
        "--seconds",
        "0.2",
    ];
    let said = succeeds(&arguments, folder);
    let path = folder.join("map-incline-by-theta-mu-and-contacts.svg");
    assert_eq!(said.trim(), path.display().to_string());
    let records = rows(folder);
    assert_eq!(records.len(), 12);
    assert_eq!(keys(folder).len(), 12, "a key leaves out what varies");
    let contacts = records.iter().map(|record| record.solver_settings().unwrap().sweeps.contacts);
    let [one, two, three] = [ContactModel::SinglePoint, ContactModel::ExtremeVertices, ContactModel::Clipping];
    assert_eq!(contacts.collect::<Vec<_>>(), [[one; 4], [two; 4], [three; 4]].concat());
    let parameters: BTreeSet<&str> = records.iter().map(|record| record.parameters.as_str()).collect();
    let expected = ["theta=45 mu=0.1", "theta=45 mu=0.4", "theta=5 mu=0.1", "theta=5 mu=0.4"];
    assert_eq!(parameters.into_iter().collect::<Vec<_>>(), expected);

    // With numbers in its cells it is of the same runs.
    succeeds(&[&arguments[..], &["--measure", "drift"]].concat(), folder);
    assert_eq!(rows(folder), records);
    let svg = fs::read_to_string(&path).unwrap();
    assert!(svg.contains("bodies move by, m") && svg.contains("contacts=single_point"), "{svg}");
    // Cells and the four of the legend, on a white ground.
    assert_eq!(svg.matches("<rect").count(), 12 + 4 + 1, "{svg}");
}

#[test]
fn a_varied_sweep_that_was_cut_goes_on_and_is_shared_out() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = ["chart", "slide_roll", "--vary", "slop=0:0.02:lin:6", "--preset", "steady", "--seconds", "0.1"];
    succeeds(&arguments, folder.path());
    let first = rows(folder.path());
    let path = folder.path().join("points.csv");
    let text = fs::read(&path).unwrap();
    fs::write(&path, &text[..text.len() - 40]).unwrap();
    succeeds(&arguments, folder.path());
    let resumed = rows(folder.path());
    assert_eq!(keys(folder.path()).len(), 6);
    assert!(first[..5].iter().all(|record| resumed.contains(record)), "points were measured again");

    let shares = ["1/2", "2/2"].map(|share| {
        let folder = tempfile::tempdir().unwrap();
        succeeds(&[&arguments[..], &["--shard", share]].concat(), folder.path());
        keys(folder.path())
    });
    assert!(shares[0].is_disjoint(&shares[1]));
    assert_eq!(&shares[0] | &shares[1], keys(folder.path()));
}

/// Where nobody says which settings, the charts' methods are compared, but for those that read nothing of it.
#[test]
fn methods_that_do_not_read_what_varies_are_left_out() {
    let folder = tempfile::tempdir().unwrap();
    succeeds(&["chart", "slide_roll", "--vary", "axis_epsilon=0,0.1", "--seconds", "0.1"], folder.path());
    let series: Vec<String> = rows(folder.path()).into_iter().map(|record| record.series).collect();
    assert_eq!(series, ["classic f32", "classic f32"]);
    let folder = tempfile::tempdir().unwrap();
    succeeds(&["chart", "slide_roll", "--vary", "baumgarte=0.1,0.2", "--seconds", "0.1"], folder.path());
    assert_eq!(rows(folder.path()).len(), 2 * 6, "six of the methods are of force-level sweeps");
}

#[test]
fn scenes_from_files_are_varied_too() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("ball.ron");
    fs::write(&scene, "(bodies: [(name: \"ball\", shape: Sphere(radius: 0.5), position: (0, 3, 0))])").unwrap();
    let scene = scene.to_str().unwrap();
    succeeds(&["chart", scene, "--vary", "drag=0,1", "--preset", "classic", "--seconds", "0.1"], folder.path());
    assert_eq!(values(folder.path(), "drag"), ["0.0", "1.0"]);
    let sinks: Vec<f64> = rows(folder.path()).iter().map(|record| record.sink.unwrap()).collect();
    assert!(sinks[1] < sinks[0], "{sinks:?}");
    assert!(folder.path().join("ball-by-drag.svg").exists());
    refuses(&["chart", scene, "--vary", "n=1,2"], &["nothing is named 'n'", "there are hz, method"]);
}

#[test]
fn what_cannot_be_varied_is_refused_in_one_line() {
    for (arguments, says) in [
        (&["chart", "stack", "--vary", "bumgarte=0.1,0.2"][..], &["nothing is named 'bumgarte'", "n, jitter, hz"][..]),
        (&["chart", "stack", "--vary", "baumgarte=0.1:2:log:9"], &["--vary", "out of range, must be 0 to 1"]),
        (&["chart", "stack", "--vary", "baumgarte=NaN"], &["'NaN' is not a number"]),
        (&["chart", "stack", "--vary", "baumgarte=0:1:log:3"], &["must begin above 0"]),
        (&["chart", "stack", "--vary", "baumgarte=0:1:lin:0"], &["count from 2 to 100"]),
        (&["chart", "stack", "--vary", "n=1:30:lin:1000000000"], &["count from 2 to 100"]),
        (&["chart", "stack", "--vary", "contacts=round"], &["extreme_vertices, single_point, clipping"]),
        (&["chart", "stack", "--vary", "baumgarte=0.1,0.2", "--preset", "game"], &["soft_step does not read it"]),
        (&["chart", "stack", "--vary", "n=1,2", "-p", "n=3"], &["n is varied and given a value besides"]),
        (&["chart", "stack", "--vary", "hz=60,120", "--vary", "hz=30"], &["hz is varied twice"]),
        (&["map", "stack", "--vary", "hz=60,120", "--vary", "hz=30"], &["hz is varied twice"]),
        (&["chart", "stack", "--vary", "hz=60,120", "--compare", "hz=30"], &["hz is varied and given a value besides"]),
        (&["chart", "stack", "--vary", "hz=60,120", "--compare", "n=1,n=2"], &["n is changed to two values at once"]),
        (&["map", "incline", "-p", "mu=0.2"], &["-p goes with --vary"]),
        (&["map", "--vary", "theta=5,10", "--vary", "points=1,2"], &["name exactly one"]),
        (&["chart", "stack", "--vary", "theta=5,10"], &["nothing is named 'theta'; there are n, jitter"]),
        (&["chart", "stack", "--vary", "n=3:1:lin:2"], &["does not go up"]),
        (&["chart", "stack", "--vary", "n=1:3:lin:1"], &["count from 2 to 100"]),
        (&["chart", "stack", "-p", "m=3", "--vary", "hz=60,120"], &["no parameter 'm'"]),
        (&["chart", "stack", "--vary", "drag=0,1", "--set", "drag=2"], &["drag is varied and given"]),
        (&["chart", "stack", "limbs", "--vary", "drag=0,1"], &["name exactly one"]),
        (&["chart", "--vary", "drag=0,1"], &["name exactly one"]),
        (&["chart", "stack", "--vary", "n=1,2", "--vary", "hz=60,120", "--vary", "drag=0,1"], &["two are the most"]),
        (&["chart", "stack", "--preset", "classic"], &["--vary"]),
        (&["chart", "stack", "--measure", "drift"], &["--measure goes with --vary"]),
        (&["chart", "stack", "--vary", "n=1,2", "--measure", "erro"], &["the measures are error, cost"]),
        (&["chart", "stack", "--vary", "n=1,2", "--compare", "slop"], &["--compare slop", "NAME=VALUE"]),
        (&["chart", "stack", "--vary", "n=1,2", "--compare", "baumgarte=0.1"], &["soft_step does not read it"]),
        (&["chart", "stack", "--vary", "n=1,2", "--seconds", "-1"], &["seconds: -1 is out of range"]),
        (&["map", "stack", "--vary", "n=1,2"], &["two --vary make the axes"]),
        (&["map", "stack", "-p", "n=2"], &["-p goes with --vary"]),
        (&["map", "stack", "--measure", "drift,sink"], &["one --measure"]),
        (&["run", "stack", "--set", "baumgarte=2"], &["--set", "must be 0 to 1"]),
        (&["run", "stack", "--set", "baumgarte=0.2"], &["soft_step does not read it"]),
        (&["run", "stack", "--set", "n=2"], &["nothing is named 'n'"]),
    ] {
        refuses(arguments, says);
    }
}

#[test]
fn run_sets_any_setting_on_top_of_a_preset_or_a_file() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("classic.ron");
    plumb::lab::write_settings(&file, &SolverSettings::classic()).unwrap();
    let changed = folder.path().join("changed.ron");
    let mut settings = SolverSettings { correction_speed: Some(2.0), ..SolverSettings::classic() };
    settings.sweeps.warm_starting = true;
    plumb::lab::write_settings(&changed, &settings).unwrap();
    assert_eq!(read_settings(&changed).unwrap().differences(&settings).count(), 0);
    let [file, changed] = [&file, &changed].map(|path| path.to_str().unwrap());
    let set = ["--set", "warm_starting=true", "--set", "correction_speed=2"];
    let run = ["run", "stack", "-p", "n=3", "--seconds", "0.5", "--json"];
    let state = |settings: &[&str]| {
        let output = std::process::Command::new(env!("CARGO_BIN_EXE_plumb")).args(run).args(settings).output().unwrap();
        let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        json["state_hash"].as_str().unwrap().to_owned()
    };
    let expected = state(&["--settings", changed]);
    assert_ne!(expected, state(&["--settings", file]));
    assert_eq!(state(&[&["--settings", file], &set[..]].concat()), expected);
    assert_eq!(state(&[&["--preset", "classic"], &set[..]].concat()), expected);
}
