//! The command line, run as a process: what it prints, what it writes, how it refuses.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use plumb::lab::{Plan, Simulation};
use plumb::physics::{SETTINGS, SolverSettings};
use plumb::scene::catalog;
use serde_json::Value;

fn plumb(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_plumb")).args(arguments).output().expect("the binary runs")
}

/// What a command that ends well prints.
fn prints(arguments: &[&str]) -> String {
    let output = plumb(arguments);
    let complaint = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {complaint}");
    assert_eq!(complaint, "", "{arguments:?}");
    String::from_utf8(output.stdout).unwrap()
}

fn json(arguments: &[&str]) -> Value {
    serde_json::from_str(&prints(arguments)).expect("one JSON value")
}

/// Checks that a command ends with exit status 2 and one line that contains all of `says`.
pub(super) fn refuses(arguments: &[&str], says: &[&str]) {
    let output = plumb(arguments);
    let complaint = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {complaint}");
    assert_eq!(complaint.lines().count(), 1, "{arguments:?}: {complaint}");
    assert!(output.stdout.is_empty(), "{arguments:?}");
    for part in says {
        assert!(complaint.contains(part), "{arguments:?} does not say '{part}': {complaint}");
    }
}

/// A folder for one test with one file in it; and the file's path.
pub(super) fn file(name: &str, text: &str) -> (tempfile::TempDir, String) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    fs::write(&path, text).unwrap();
    let path = path.to_str().unwrap().to_owned();
    (folder, path)
}

#[test]
fn scenes_lists_every_scene_and_parameter() {
    let listing = prints(&["scenes"]);
    for scene in catalog() {
        let from = listing.lines().position(|line| line.starts_with(&format!("{} ", scene.name)));
        let mut lines = listing.lines().skip(from.unwrap_or_else(|| panic!("no {}", scene.name)));
        assert!(lines.next().unwrap().ends_with(scene.about));
        assert!(lines.next().unwrap().ends_with(scene.truth));
        for (parameter, line) in scene.parameters.iter().zip(lines) {
            assert!(line.trim().starts_with(parameter.name), "{line}");
            for part in [&format!(" {} (", parameter.default), &parameter.range(), parameter.about] {
                assert!(line.contains(part), "{line} lacks {part}");
            }
        }
    }
}

#[test]
fn help_and_version_are_no_errors() {
    assert!(prints(&["--help"]).contains("plumb [SCENE]"));
    assert!(prints(&["run", "--help"]).contains("--every"));
    assert!(prints(&["--version"]).contains(env!("CARGO_PKG_VERSION")));
}

#[test]
fn bad_usage_names_the_help_that_tells_better() {
    refuses(&["--no-such"], &["'--no-such'", "see 'plumb --help'"]);
    refuses(&["run", "stack", "--no-such"], &["'--no-such'", "see 'plumb run --help'"]);
    refuses(&["export", "stack", "--seed", "1"], &["'--seed'", "see 'plumb export --help'"]);
}

#[test]
fn json_has_every_key_and_no_other() {
    let metrics = json(&["run", "rods", "-p", "n=2", "--seconds", "0.5", "--hz", "240", "--json"]);
    let keys = |value: &Value| value.as_object().unwrap().keys().cloned().collect::<Vec<_>>().join(" ");
    let sorted = |text: &str| {
        let mut words: Vec<_> = text.split_whitespace().collect();
        words.sort_unstable();
        words.join(" ")
    };
    assert_eq!(
        sorted(&keys(&metrics)),
        sorted(
            "scene parameters settings bodies joints contacts steps seconds ms_per_step counts exact energy momentum \
             joint_error_max_m joint_gaps limit_overshoot_max joint_load_max broken_joints \
             penetration_max_m sink_max_m drift_max_m jitter_m_per_s force_error contact_residual \
             truth truth_unknown further_truths shares quarantined simd state_hash"
        )
    );
    assert_eq!(sorted(&keys(&metrics["ms_per_step"])), "median p95 total");
    assert_eq!(sorted(&keys(&metrics["energy"])), "end max_relative_drift start");
    assert_eq!(sorted(&keys(&metrics["truth"])), "error fails_above name uncertainty unit");
    assert_eq!(sorted(&keys(&metrics["counts"])), "axes_tested pairs row_updates");
    assert_eq!(sorted(&keys(&metrics["momentum"])), "angular_max_relative_drift linear_max_relative_drift");
    assert_eq!(keys(&metrics["joint_gaps"]), "ball");
    assert_eq!(sorted(&keys(&metrics["joint_gaps"]["ball"])), "gap_m tilt_rad");
    assert_eq!(sorted(&keys(&metrics["joint_load_max"])), "force_n torque_n_m");
    assert_eq!(metrics["limit_overshoot_max"], Value::Null);
    assert_eq!(sorted(&keys(&metrics["shares"])), "energy_rise joint_of_limb moved_of_size sunk_of_size");

    assert_eq!(metrics["scene"], "rods");
    assert_eq!(metrics["parameters"]["n"], 2.0);
    assert_eq!(metrics["bodies"], 3);
    assert_eq!(metrics["joints"], 2);
    assert_eq!(metrics["steps"], 120);
    assert_eq!(metrics["seconds"], 0.5);
    assert_eq!(metrics["quarantined"], Value::Array(Vec::new()));
    let hash = metrics["state_hash"].as_str().unwrap();
    assert!(hash.len() == 16 && hash.chars().all(|digit| digit.is_ascii_hexdigit()), "{hash}");
    let cost = |key: &str| metrics["ms_per_step"][key].as_f64().unwrap();
    assert!(0.0 < cost("median") && cost("median") <= cost("p95") && cost("p95") < cost("total"));
}

#[test]
fn json_of_a_scene_without_an_answer_says_so() {
    let metrics = json(&["run", "limbs", "--seconds", "0.04", "--json"]);
    assert_eq!(metrics["truth"], Value::Null);
    assert_eq!(metrics["truth_unknown"], "a converged answer begins at 0.05 s");
}

#[test]
fn settings_add_up_from_preset_file_and_flags() {
    let settings = |arguments: &[&str]| {
        let all = [&["run", "pendulum", "--seconds", "0.02", "--json"], arguments].concat();
        json(&all)["settings"].clone()
    };
    let as_json = |settings| serde_json::to_value(settings).unwrap();
    assert_eq!(settings(&[]), as_json(SolverSettings::default()));
    assert_eq!(settings(&["--preset", "classic"]), as_json(SolverSettings::classic()));
    let flags = "--preset classic --method pgs --hz 120 --substeps 3 --iterations 7 --precision f64 --threads 2";
    let expected = SolverSettings {
        hz: 120.0,
        substeps: 3,
        iterations: 7,
        precision: plumb::physics::Precision::F64,
        threads: 2,
        ..SolverSettings::classic()
    };
    assert_eq!(settings(&flags.split_whitespace().collect::<Vec<_>>()), as_json(expected));

    let text = "// mine\n(hz: 100, slop: 0.004, correction_speed: None, restitution_speed: Some(1), friction: off)";
    let (_folder, path) = file("mine.ron", text);
    let expected = SolverSettings {
        hz: 50.0,
        slop: 0.004,
        correction_speed: None,
        restitution_speed: Some(1.0),
        friction: plumb::physics::FrictionModel::Off,
        ..SolverSettings::default()
    };
    assert_eq!(settings(&["--settings", &path, "--hz", "50"]), as_json(expected));
}

#[test]
fn settings_that_json_prints_can_be_read_back_from_ron() {
    let text = ron::to_string(&SolverSettings::classic()).unwrap();
    let (_folder, path) = file("classic.ron", &text);
    let read = plumb::lab::read_settings(Path::new(&path)).unwrap();
    assert_eq!(ron::to_string(&read).unwrap(), text);
}

#[test]
fn summary_names_the_truth_and_the_state() {
    let arguments = ["run", "pendulum", "--seconds", "0.1"];
    let summary = prints(&arguments);
    let hash = json(&[&arguments[..], &["--json"]].concat())["state_hash"].as_str().unwrap().to_owned();
    assert!(summary.contains("angle of the rod") && summary.contains(&hash), "{summary}");
}

#[test]
fn trajectory_reads_back_to_the_very_states() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.csv");
    let out = path.to_str().unwrap();
    prints(&["run", "rods", "-p", "n=2", "--hz", "240", "--seconds", "0.1", "--out", out]);

    let text = fs::read_to_string(&path).unwrap();
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some("t,body,x,y,z,qx,qy,qz,qw,vx,vy,vz,wx,wy,wz"));
    let rows: Vec<Vec<&str>> = lines.map(|line| line.split(',').collect()).collect();
    assert_eq!(rows.len(), 25 * 3);

    let settings = SolverSettings { hz: 240.0, ..SolverSettings::default() };
    let plan = Plan::new("rods", &[("n".into(), 2.0)], settings, Some(0.1)).unwrap();
    let names: Vec<_> = plan.scene.bodies.iter().map(|body| body.name.clone()).collect();
    let mut simulation = Simulation::new(plan.scene, settings);
    for (row, fields) in rows.iter().enumerate() {
        let body = row % 3;
        if row > 0 && body == 0 {
            simulation.step();
        }
        let sample = simulation.sample();
        let state = sample.bodies[body];
        let numbers = [state.position.to_array().as_slice(), &state.rotation.to_array()].concat();
        let speeds = [state.linear.to_array(), state.angular.to_array()].concat();
        assert_eq!(fields[1], names[body]);
        let read = |field: &str| field.parse::<f64>().unwrap().to_bits();
        assert_eq!(read(fields[0]), sample.time.to_bits());
        for (field, number) in fields[2..].iter().zip(numbers.iter().chain(&speeds)) {
            assert_eq!(read(field), number.to_bits(), "{fields:?}");
        }
    }
}

#[test]
fn trajectory_has_a_row_at_each_interval() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.csv");
    let times = |hz: &str, every: &str| {
        let out = path.to_str().unwrap();
        prints(&["run", "pendulum", "--hz", hz, "--seconds", "1", "--every", every, "--out", out]);
        let text = fs::read_to_string(&path).unwrap();
        let rows = text.lines().skip(1).filter(|line| line.contains(",rod"));
        rows.map(|line| line.split(',').next().unwrap().parse().unwrap()).collect::<Vec<f64>>()
    };
    let tenths: Vec<f64> = (0..=10).map(|n| f64::from(6 * n) / 60.0).collect();
    assert_eq!(times("60", "0.1"), tenths);
    // Steps that miss the multiples: the first step after each.
    assert_eq!(times("8", "0.3"), [0.0, 0.375, 0.625, 1.0]);
    // Finer than the steps: every step.
    assert_eq!(times("4", "0.01"), [0.0, 0.25, 0.5, 0.75, 1.0]);
}

#[test]
fn a_scene_of_ones_own_runs_and_has_no_borrowed_answer() {
    let text = r#"(bodies: [(name: "a, b", shape: Sphere(radius: 0.5), position: (0, 3, 0))])"#;
    let (folder, path) = file("pendulum.ron", text);
    let out = folder.path().join("out.csv");
    let metrics = json(&["run", &path, "--seconds", "0.1", "--json", "--out", out.to_str().unwrap()]);
    assert_eq!(metrics["scene"], "pendulum");
    assert_eq!(metrics["bodies"], 1);
    assert_eq!(metrics["truth"], Value::Null);
    let last = fs::read_to_string(out).unwrap().lines().last().unwrap().to_owned();
    assert!(last.starts_with("0.1,\"a, b\",0.0,2."), "{last}");
}

#[test]
fn a_body_that_leaves_the_finite_is_reported_and_fails_the_run() {
    let text = r#"(bodies: [(name: "comet", shape: Sphere(radius: 0.5), velocity: (1.7e308, 0, 0))])"#;
    let (_folder, path) = file("comet.ron", text);
    let output = plumb(&["run", &path, "--seconds", "2", "--json"]);
    assert_eq!(output.status.code(), Some(1));
    let metrics: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(metrics["quarantined"][0]["body"], "comet");
    assert_eq!(metrics["quarantined"][0]["reason"], "its state is not finite");
    let summary = plumb(&["run", &path, "--seconds", "2"]);
    assert_eq!(summary.status.code(), Some(1));
    assert!(String::from_utf8(summary.stdout).unwrap().contains("comet: its state is not finite"));
}

#[test]
fn refuses_an_unknown_scene() {
    refuses(&["run", "penduum"], &["penduum", "plumb scenes"]);
    refuses(&["penduum"], &["penduum", "plumb scenes"]);
}

#[test]
fn refusals_stay_on_one_line_whatever_they_quote() {
    refuses(&["run", "pen\ndulum\n\n"], &["pen dulum"]);
    refuses(&["run", "/nowhere/a\nb.ron"], &["a b.ron"]);
    refuses(&["run", "rods", "--hz", "6\n0"], &["--hz"]);
}

#[cfg(not(feature = "sandbox"))]
#[test]
fn refuses_a_window_in_a_build_without_one() {
    refuses(&[], &["draws nothing", "plumb run"]);
    refuses(&["pendulum"], &["draws nothing", "plumb run"]);
}

#[test]
fn refuses_no_scene() {
    refuses(&["run"], &["SCENE"]);
}

#[test]
fn refuses_a_missing_scene_file() {
    refuses(&["run", "/nowhere/mine.ron"], &["/nowhere/mine.ron"]);
    refuses(&["/nowhere/mine.ron"], &["/nowhere/mine.ron"]);
}

#[test]
fn refuses_a_broken_scene_file() {
    let (_folder, path) = file("mine.ron", "(\n  bodies: [(name: 7)],\n)");
    refuses(&["run", &path], &[&path, ":2:18:"]);
}

#[test]
fn refuses_an_unknown_parameter() {
    refuses(&["run", "rods", "-p", "m=3"], &["rods", "'m'"]);
    refuses(&["rods", "-p", "m=3"], &["rods", "'m'"]);
}

#[test]
fn refuses_a_malformed_parameter() {
    refuses(&["run", "rods", "-p", "n"], &["'n'", "NAME=VALUE"]);
    refuses(&["run", "rods", "-p", "=3"], &["'=3'", "name is missing"]);
    refuses(&["run", "rods", "-p", "n=two"], &["n=two", "'two' is not a number"]);
    refuses(&["run", "rods", "-p", "n=NaN"], &["n=NaN", "n must be finite"]);
}

#[test]
fn refuses_a_parameter_out_of_range() {
    refuses(&["run", "rods", "-p", "n=0"], &["rods", " n ", "0"]);
    refuses(&["run", "rods", "-p", "n=2.5"], &["rods", " n ", "whole", "2.5"]);
}

#[test]
fn refuses_an_unknown_preset() {
    refuses(&["run", "rods", "--preset", "best"], &["--preset", "'best'", "steady, classic"]);
    refuses(&["run", "rods", "--preset", "classic", "--settings", "x.ron"], &["--preset", "--settings"]);
}

#[test]
fn refuses_an_unknown_flag() {
    refuses(&["run", "rods", "--speed", "3"], &["--speed"]);
    refuses(&["--speed"], &["--speed"]);
}

#[test]
fn refuses_an_unknown_method_or_precision() {
    refuses(&["run", "rods", "--method", "magic"], &["--method", "magic", "pgs"]);
    refuses(&["run", "rods", "--precision", "f16"], &["--precision", "f16", "f64"]);
}

#[test]
fn refuses_a_step_rate_that_is_not_positive() {
    for hz in ["0", "-60", "NaN", "inf", "1e10"] {
        refuses(&["run", "rods", "--hz", hz], &["hz", "greater than 0"]);
    }
    refuses(&["run", "rods", "--hz", "fast"], &["--hz", "fast"]);
    refuses(&["rods", "--hz", "0"], &["hz", "greater than 0"]);
}

#[test]
fn refuses_counts_below_one() {
    for flag in ["substeps", "iterations", "threads"] {
        let option = format!("--{flag}");
        refuses(&["run", "rods", &option, "0"], &[flag, "at least 1"]);
        refuses(&["run", "rods", &option, "-1"], &[flag, "-1"]);
        refuses(&["run", "rods", &option, "1.5"], &[flag, "1.5"]);
    }
}

#[test]
fn refuses_a_run_without_length() {
    for seconds in ["0", "-1", "NaN", "inf"] {
        refuses(&["run", "rods", "--seconds", seconds], &["seconds", "greater than 0"]);
    }
    refuses(&["run", "rods", "--seconds", "1e12"], &["seconds", "more than", "steps"]);
}

#[test]
fn refuses_a_settings_file_that_is_missing() {
    refuses(&["run", "rods", "--settings", "/nowhere/s.ron"], &["/nowhere/s.ron", "cannot be read"]);
}

#[test]
fn refuses_a_settings_file_that_is_broken() {
    let (_folder, path) = file("s.ron", "(\n  hz: 60\n  substeps: 2,\n)");
    refuses(&["run", "rods", "--settings", &path], &[&path, ":3:3:", "comma"]);
    let (_folder, path) = file("s.ron", "(\n  hz: true,\n)");
    refuses(&["run", "rods", "--settings", &path], &[&path, ":2:6:", "float"]);
}

#[test]
fn refuses_a_settings_file_with_an_unknown_field() {
    let (_folder, path) = file("s.ron", "(\n  hertz: 60,\n)");
    refuses(&["run", "rods", "--settings", &path], &[&path, ":2:3:", "hertz"]);
}

#[test]
fn refuses_what_a_user_wrote_and_the_method_does_not_read() {
    let only_sweeps = "does not read it, only pgs, cg_pgs, nncg, joint_space do: leave it out or choose one of these";
    for (text, place, says) in [
        ("(\n  hz: 60,\n  baumgarte: 0.3,\n)", ":3:3:", ["baumgarte: soft_step", only_sweeps]),
        ("(method: exact,\n iterations: 20)", ":2:2:", ["iterations: exact does not read it", "leave it out"]),
        (
            "(integrator: rattle)",
            ":1:2:",
            ["integrator: soft_step", "only exact does: leave it out or choose that method"],
        ),
        ("(integrator: euler, method: exact)", ":1:2:", ["integrator: exact", only_sweeps]),
        ("(method: xpbd, fitted_effort: false)", ":1:16:", ["fitted_effort: xpbd", "only soft_step does"]),
        ("(method: pgs, sleep_speed: 0.1)", ":1:15:", ["sleep_speed: pgs", "soft_step, sequential_impulses, xpbd do"]),
        (
            "(method: pgs, axis_epsilon: 0.1)",
            ":1:15:",
            [
                "axis_epsilon: pgs reads it only with contacts: extreme_vertices or single_point",
                "leave it out or set that too",
            ],
        ),
        (
            "(method: pgs, contacts: single_point, contacts_ahead: true)",
            ":1:39:",
            ["contacts_ahead: pgs reads it only with contacts: clipping", "leave it out or set that too"],
        ),
        (
            "(method: soft_step, nonlinear_projection: true)",
            ":1:21:",
            ["nonlinear_projection: soft_step", "only pgs, cg_pgs, nncg, joint_space do"],
        ),
    ] {
        let (_folder, path) = file("s.ron", text);
        refuses(&["run", "rods", "--settings", &path], &[&path, place, says[0], says[1]]);
    }
    refuses(&["run", "rods", "--method", "exact", "--iterations", "3"], &["iterations: exact does not read it, only"]);
    refuses(&["rods", "--preset", "accurate", "--precision", "f32"], &["precision: exact does not read it, only"]);
    // What the file says is also held to a method that comes from the command line.
    let (_folder, path) = file("s.ron", "(\n  method: pgs,\n  baumgarte: 0.3,\n)");
    prints(&["run", "rods", "--seconds", "0.02", "--settings", &path]);
    refuses(&["run", "rods", "--settings", &path, "--method", "exact"], &[&path, ":3:3:", "baumgarte: exact"]);
    let (_folder, path) = file("s.ron", "(slop: 0.1, slop: 0.2)");
    refuses(&["run", "rods", "--settings", &path], &[&path, "slop"]);
}

#[test]
fn what_presets_leave_unread_is_no_users_word() {
    for preset in ["game", "steady", "classic", "accurate"] {
        for method in ["pgs", "cg_pgs", "nncg", "joint_space", "soft_step", "sequential_impulses", "xpbd", "exact"] {
            prints(&["run", "pendulum", "--seconds", "0.02", "--preset", preset, "--method", method]);
        }
    }
}

#[test]
fn the_exact_method_alone_picks_its_integrator() {
    for (text, integrator) in [("(method: exact)", "gauss"), ("(integrator: rattle, method: exact)", "rattle")] {
        let (_folder, path) = file("s.ron", text);
        let settings = &json(&["run", "pendulum", "--seconds", "0.02", "--settings", &path, "--json"])["settings"];
        assert_eq!((&settings["method"], &settings["integrator"]), (&"exact".into(), &integrator.into()), "{text}");
    }
}

#[test]
fn help_says_what_the_doc_comments_say() {
    let words = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
    let help = words(&prints(&["run", "--help"]));
    for name in ["method", "hz", "substeps", "iterations", "precision", "threads"] {
        let setting = SETTINGS.iter().find(|setting| setting.name == name).unwrap();
        let (_, after) = help.split_once(&format!(" --{name} <")).unwrap_or_else(|| panic!("--{name}: {help}"));
        let (_, after) = after.split_once("> ").unwrap();
        assert!(after.starts_with(&setting.help()), "--{name}: {after}");
        for choice in setting.choices {
            assert!(after.contains(&format!("- {}: {}", choice.name, choice.help())), "--{name}: {after}");
        }
    }
}

#[test]
fn refuses_a_settings_file_with_a_value_out_of_range() {
    let (_folder, path) = file("s.ron", "(\n  hz: 60, // not slop: 1\n  slop: -0.1,\n  drag: 0,\n)");
    refuses(&["run", "rods", "--settings", &path], &[&path, ":3:3:", "slop: -0.1", "at least 0"]);
}

#[test]
fn refuses_an_output_that_cannot_be_written() {
    refuses(&["run", "rods", "--out", "/nowhere/out.csv"], &["/nowhere/out.csv", "cannot be written"]);
    // Before the run: this one would take hours.
    refuses(&["run", "pyramids", "-p", "n=5", "--seconds", "1000", "--out", "/nowhere/out.csv"], &["/nowhere/out.csv"]);
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path().to_str().unwrap();
    refuses(&["run", "rods", "--out", folder], &[folder, "cannot be written"]);
}

#[cfg(target_os = "linux")]
#[test]
fn refuses_to_lose_rows_on_a_full_disk() {
    refuses(&["run", "rods", "--seconds", "0.5", "--out", "/dev/full"], &["/dev/full", "cannot be written"]);
}

#[test]
fn refuses_an_interval_that_is_not_positive_or_has_no_file() {
    for every in ["0", "-0.1", "NaN", "often"] {
        refuses(&["run", "rods", "--out", "/tmp/unused.csv", "--every", every], &["--every", every]);
    }
    refuses(&["run", "rods", "--every", "0.1"], &["--out"]);
    assert!(!Path::new("/tmp/unused.csv").exists());
}

#[test]
fn a_run_is_recorded_and_runs_again() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("stack.plumb");
    let path = path.to_str().unwrap();
    prints(&["run", "stack", "--seconds", "0.5", "--record", path]);
    let said = prints(&["replay", path]);
    for part in ["stack, recorded by", "30 steps", "all of them come out the same"] {
        assert!(said.contains(part), "{said}");
    }
    let text = fs::read_to_string(path).unwrap();
    fs::write(path, text.replacen("friction: 0.5", "friction: 0.4", 1).replacen("substeps:4", "substeps:5", 1))
        .unwrap();
    let output = plumb(&["replay", path]);
    let said = String::from_utf8(output.stdout).unwrap();
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("step 1 comes out otherwise: "), "{said}");
    fs::write(path, &text[..text.len() / 2]).unwrap();
    refuses(&["replay", path], &["stack.plumb", "ends in the middle"]);
    refuses(&[path], &["stack.plumb", "ends in the middle"]);
    refuses(&["replay", "nowhere.plumb"], &["nowhere.plumb: cannot be read"]);
    refuses(&["run", "stack", "--record", "/no/such/folder/a.plumb"], &["/no/such/folder/a.plumb: cannot be written"]);
}
