//! Error against cost as the step gets smaller.

use crate::accuracy;
use crate::engine::{EngineKind, Settings};
use crate::plan::{Plan, Report};
use crate::record::Row;
use crate::scene::Scene;
use crate::statistics::{median, range};
use crate::table::{short, table};

/// Measured where none is asked for.
pub const SCENES: &str = "rods 5";

/// Steps a second.
const RATES: [f64; 7] = [60.0, 120.0, 240.0, 480.0, 1000.0, 2000.0, 5000.0];

/// Measures every scene of a plan at every rate.
pub fn measure(plan: &Plan) -> Report {
    let mut report = Report::default();
    for scene in &plan.scenes {
        plan.progress(scene);
        let rows = measure_scene(scene, plan);
        report.text += &text(scene, plan, &rows);
        report.note_refusals(scene, &rows);
        report.rows.extend(rows);
    }
    report
}

/// Rounds outermost, so that the engines alternate; errors are the same in each, times are not.
fn measure_scene(scene: &Scene, plan: &Plan) -> Vec<Row> {
    let seconds = plan.seconds.unwrap_or_else(|| scene.seconds());
    let round = || -> Vec<Row> {
        let runs = RATES.iter().flat_map(|&hz| plan.engines.iter().map(move |&kind| (hz, kind)));
        let run = |(hz, kind)| accuracy::run(scene, kind, &Settings { hz, ..plan.settings }, seconds, "precision");
        runs.map(run).collect()
    };
    let rounds: Vec<Vec<Row>> = (0..plan.rounds).map(|_| round()).collect();
    let Some((first, _)) = rounds.split_first() else { return Vec::new() };
    let sum_up = |(index, row): (usize, &Row)| {
        let times: Vec<f64> = rounds.iter().filter_map(|rows| rows[index].ms_per_step).collect();
        let (low, high) = range(&times).unzip();
        Row { ms_per_step: median(&times), ms_low: low, ms_high: high, ..row.clone() }
    };
    first.iter().enumerate().map(sum_up).collect()
}

/// A line a rate: the error, and what a simulated second costs.
fn text(scene: &Scene, plan: &Plan, rows: &[Row]) -> String {
    let at_1_s = rows.iter().any(|row| row.error_at_1_s.is_some());
    let error = |row: &Row| if at_1_s { row.error_at_1_s } else { row.error };
    let what = if at_1_s { "error at 1 s" } else { rows.first().map_or("", |row| row.answer) };
    let mut heading = vec![format!("{scene}, {what}; ms per second")];
    heading.extend(plan.engines.iter().map(EngineKind::to_string));
    let mut cells = vec![heading];
    for (hz, rows) in RATES.iter().zip(rows.chunks(plan.engines.len())) {
        let cell = |row: &Row| match (error(row), row.ms_per_step) {
            (Some(error), Some(milliseconds)) => format!("{}; {}", short(error), short(milliseconds * hz)),
            _ => "-".to_owned(),
        };
        cells.push([format!("1/{hz}")].into_iter().chain(rows.iter().map(cell)).collect());
    }
    table(&cells) + "\n"
}
