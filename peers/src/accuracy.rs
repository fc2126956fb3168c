//! How far off the engines are at their recommended settings.

use crate::engine::{EngineKind, Settings, Unable};
use crate::metrics::{Meter, Metrics};
use crate::overlap;
use crate::plan::{Plan, Report};
use crate::record::Row;
use crate::scene::Scene;
use crate::statistics::median;
use crate::table::{short, table};

/// Measured where none are asked for.
pub const SCENES: &str = "chain 1, chain 100, chain 1000, stack 10, stack 30, pyramid 40, pyramids 8, sandwich 1000, \
                          top, joint_grid 100, rods 5, bridge 30, bridge 100, ragdolls 1, ragdolls 10, \
                          hinge_chain 100 1, hinge_chain 100 1000, hinge_chain 100 1 45, arm, car 0 100 10, \
                          four_bar 1, four_bar 40";

/// Measures every scene of a plan.
pub fn measure(plan: &Plan) -> Report {
    let mut report = Report::default();
    let mut heading = vec!["error".to_owned(), String::new()];
    heading.extend(plan.engines.iter().map(EngineKind::to_string));
    let mut cells = vec![heading];
    for scene in &plan.scenes {
        plan.progress(scene);
        let seconds = plan.seconds.unwrap_or_else(|| seconds(scene));
        let rows: Vec<Row> =
            plan.engines.iter().map(|&kind| run(scene, kind, &plan.settings, seconds, "accuracy")).collect();
        for (what, error) in headline(scene) {
            let mut line = vec![format!("{scene}, {} s", short(seconds)), what.to_owned()];
            line.extend(rows.iter().map(|row| error(row).map_or_else(|| "-".to_owned(), short)));
            cells.push(line);
        }
        report.note_refusals(scene, &rows);
        report.rows.extend(rows);
    }
    report.text = table(&cells) + &report.text;
    report
}

/// Runs a scene in an engine and says how far off it was, or why there is nothing to say.
pub fn run(scene: &Scene, kind: EngineKind, settings: &Settings, seconds: f64, name: &'static str) -> Row {
    let row = Row { seconds, ..Row::new(name, scene, kind, settings) };
    match watch(scene, kind, settings, seconds) {
        Err(unable) => row.with_note(unable),
        Ok(Watched { metrics: None, .. }) => row.with_note("a state is not finite"),
        Ok(Watched { metrics: Some(metrics), milliseconds, overlaps }) => Row {
            ms_per_step: median(&milliseconds),
            overlap: overlaps.iter().copied().reduce(f64::max),
            overlap_end: overlaps.last().copied(),
            ..row.with_metrics(&metrics)
        },
    }
}

/// What a run was like.
struct Watched {
    /// If it stayed finite.
    metrics: Option<Metrics>,
    /// What each step took, ms.
    milliseconds: Vec<f64>,
    /// The deepest overlap of two bodies after each step of a scene that moves, m.
    overlaps: Vec<f64>,
}

fn watch(scene: &Scene, kind: EngineKind, settings: &Settings, seconds: f64) -> Result<Watched, Unable> {
    let mut run = kind.start(scene, settings)?;
    let mut meter = Meter::new(scene, run.read()?);
    let (mut milliseconds, mut overlaps) = (Vec::new(), Vec::new());
    for _ in 0..(seconds * settings.hz).round() as u64 {
        milliseconds.push(1e3 * run.step()?.as_secs_f64());
        let (step, time) = (run.steps(), run.time());
        let states = run.read()?;
        meter.observe(step, time, states);
        if scene.is_moving {
            overlaps.push(overlap::deepest(scene, states));
        }
    }
    Ok(Watched { metrics: meter.metrics(), milliseconds, overlaps })
}

/// 100 steps for the large scenes, 10 s for those at rest or swinging.
fn seconds(scene: &Scene) -> f64 {
    match scene.name() {
        "pyramid" | "pyramids" | "joint_grid" => 100.0 / 60.0,
        "chain" | "stack" | "sandwich" | "top" => 10.0,
        _ => scene.seconds(),
    }
}

/// A column of a row, with what it is.
type Headline = (&'static str, fn(&Row) -> Option<f64>);

/// What is shown of a scene; all is in the rows.
fn headline(scene: &Scene) -> Vec<Headline> {
    let worst_joint: Headline = ("worst joint separation, m", |row| row.joint_separation);
    let last_joint: Headline = ("joint separation at the end, m", |row| row.joint_separation_end);
    let tilt: Headline = ("worst tilt of a hinge, rad", |row| row.hinge_tilt);
    let overshoot: Headline = ("worst overshoot of a limit, rad", |row| row.limit_overshoot);
    match scene.name() {
        "chain" | "joint_grid" => vec![worst_joint, last_joint],
        "rods" => vec![("error at 1 s, m", |row| row.error_at_1_s), worst_joint],
        "top" => vec![("energy change, relative", |row| row.energy_change)],
        "bridge" => vec![worst_joint, last_joint, tilt, ("worst sink, m", |row| row.sink)],
        "ragdolls" => vec![worst_joint, tilt, overshoot],
        "hinge_chain" => vec![worst_joint, tilt, overshoot, ("energy change, relative", |row| row.energy_change)],
        "arm" => vec![
            ("tip of the forearm, m", |row| row.error),
            worst_joint,
            tilt,
            ("torques of the motors, N·m", |row| row.torque_error),
        ],
        "car" => vec![("speed of the chassis, m/s", |row| row.error), worst_joint, tilt],
        "four_bar" => vec![("angles of the rods, rad", |row| row.error), worst_joint, tilt],
        "stack" | "pyramid" | "pyramids" | "sandwich" => vec![
            ("worst sink, m", |row| row.sink),
            ("sink at the end, m", |row| row.sink_end),
            ("worst drift, m", |row| row.drift),
        ],
        _ if scene.is_moving => vec![
            ("deepest overlap, m", |row| row.overlap),
            ("overlap at the end, m", |row| row.overlap_end),
            worst_joint,
            tilt,
            overshoot,
        ],
        _ => vec![("error", |row| row.error)],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_is_as_long_as_asked_and_near_the_reference() {
        let scene = Scene::parse("rods 1").unwrap();
        let settings = Settings { hz: 120.0, substeps: None, threads: 1, sleep: false };
        for kind in EngineKind::standard() {
            let row = run(&scene, kind, &settings, 1.0, "precision");
            // Half a swing of a metre: an engine that ran at another rate would be off by far more.
            let error = row.error_at_1_s.unwrap();
            assert!(error < 0.1, "{kind}: {error}");
            assert!(row.error.unwrap() >= error && row.ms_per_step.is_some(), "{kind}");
            assert_eq!((row.seconds, row.hz, row.answer), (1.0, 120.0, "tip of the last rod"));
        }
    }
}
