//! What is measured as rows: for `plumb chart` (CSV), for programs (JSON).

use std::fs::File;
use std::io::{self, Write};
use std::path::Path;

use serde::Serialize;

use crate::engine::{EngineKind, Method, Settings};
use crate::metrics::Metrics;
use crate::scene::Scene;

/// One run. The README says what each column holds.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    pub run: &'static str,
    pub scene: String,
    pub parameters: String,
    pub engine: String,
    pub version: String,
    pub precision: &'static str,
    pub hz: f64,
    pub substeps: u32,
    pub iterations: u32,
    pub threads: u32,
    /// Simulated.
    pub seconds: f64,
    /// What `error` is the distance from.
    pub answer: &'static str,
    pub error: Option<f64>,
    pub unit: &'static str,
    pub error_at_1_s: Option<f64>,
    pub joint_separation: Option<f64>,
    pub joint_separation_end: Option<f64>,
    pub hinge_tilt: Option<f64>,
    pub limit_overshoot: Option<f64>,
    pub torque_error: Option<f64>,
    pub sink: Option<f64>,
    pub sink_end: Option<f64>,
    pub drift: Option<f64>,
    /// Deepest overlap of two bodies, m, whenever it was looked for; and after the last step.
    pub overlap: Option<f64>,
    pub overlap_end: Option<f64>,
    pub energy_change: Option<f64>,
    pub energy_drift: Option<f64>,
    /// Median.
    pub ms_per_step: Option<f64>,
    pub ms_low: Option<f64>,
    pub ms_high: Option<f64>,
    pub times_plumb: Option<f64>,
    pub times_fastest_peer: Option<f64>,
    /// Why there is no number.
    pub note: String,
}

impl Row {
    /// A row without a number yet.
    pub fn new(run: &'static str, scene: &Scene, kind: EngineKind, settings: &Settings) -> Self {
        let Method { version, precision, substeps, iterations } = kind.method(settings);
        Self {
            run,
            scene: scene.name().to_owned(),
            parameters: scene.parameters(),
            engine: kind.to_string(),
            version,
            precision,
            hz: settings.hz,
            substeps,
            iterations,
            threads: settings.threads,
            seconds: 0.0,
            answer: "",
            error: None,
            unit: "",
            error_at_1_s: None,
            joint_separation: None,
            joint_separation_end: None,
            hinge_tilt: None,
            limit_overshoot: None,
            torque_error: None,
            sink: None,
            sink_end: None,
            drift: None,
            overlap: None,
            overlap_end: None,
            energy_change: None,
            energy_drift: None,
            ms_per_step: None,
            ms_low: None,
            ms_high: None,
            times_plumb: None,
            times_fastest_peer: None,
            note: String::new(),
        }
    }

    /// The same run with how far off it was.
    pub fn with_metrics(self, metrics: &Metrics) -> Self {
        let answer = metrics.answer.as_ref();
        Self {
            answer: answer.map_or("", |answer| answer.name),
            error: answer.map(|answer| answer.error),
            unit: answer.map_or("", |answer| answer.unit),
            error_at_1_s: metrics.error_at_1_s,
            joint_separation: metrics.joint_separation,
            joint_separation_end: metrics.joint_separation_end,
            hinge_tilt: metrics.hinge_tilt,
            limit_overshoot: metrics.limit_overshoot,
            torque_error: metrics.torque_error,
            sink: Some(metrics.sink),
            sink_end: Some(metrics.sink_end),
            drift: Some(metrics.drift),
            energy_change: metrics.energy_change,
            energy_drift: metrics.energy_drift,
            ..self
        }
    }

    /// The same run with the reason why there is nothing to measure.
    pub fn with_note(self, note: impl ToString) -> Self {
        Self { note: note.to_string(), ..self }
    }
}

/// Writes rows to `DIR/FILE.csv`, making the folder if need be.
pub fn write_csv(rows: &[Row], directory: &Path, file: &str) -> io::Result<()> {
    std::fs::create_dir_all(directory)?;
    let sink = File::create(directory.join(file).with_extension("csv"))?;
    write_rows(rows, sink)
}

fn write_rows(rows: &[Row], sink: impl Write) -> io::Result<()> {
    let mut csv = csv::Writer::from_writer(sink);
    for row in rows {
        csv.serialize(row)?;
    }
    csv.flush()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metrics::Answer;

    /// The Python script writes the same columns: `plumb chart` reads both.
    #[test]
    fn columns_are_those_of_the_readme_and_of_the_mujoco_script() {
        let scene = Scene::parse("rods 1").unwrap();
        let settings = Settings { hz: 120.0, substeps: None, threads: 1, sleep: false };
        let row = Row { seconds: 1.0, ..Row::new("precision", &scene, EngineKind::Rapier, &settings) };
        let metrics = Metrics {
            answer: Some(Answer { name: "tip", error: 0.5, unit: "m" }),
            error_at_1_s: Some(0.25),
            joint_separation: None,
            joint_separation_end: None,
            hinge_tilt: Some(0.125),
            limit_overshoot: None,
            torque_error: None,
            sink: 2.0,
            sink_end: 1.5,
            drift: 3.0,
            energy_change: Some(-0.125),
            energy_drift: Some(0.125),
        };
        let mut bytes = Vec::new();
        write_rows(&[row.clone().with_metrics(&metrics), row.with_note("panicked: a, \"b\"")], &mut bytes).unwrap();
        let text = String::from_utf8(bytes).unwrap();
        let [header, measured, refused] = text.lines().collect::<Vec<_>>()[..] else { panic!("{text}") };
        assert!(include_str!("../mujoco_rods.py").contains(header), "{header}");
        for column in header.split(',') {
            assert!(include_str!("../README.md").contains(&format!("| `{column}` |")), "{column}");
        }
        assert_eq!(
            measured,
            "precision,rods,n=1,rapier,0.36.1,f32,120.0,4,1,1,1.0,tip,0.5,m,0.25,,,0.125,,,2.0,1.5,3.0,,,-0.125,0.125,,,,,,"
        );
        assert!(refused.ends_with(",1.0,,,,,,,,,,,,,,,,,,,,,,\"panicked: a, \"\"b\"\"\""), "{refused}");
    }
}
