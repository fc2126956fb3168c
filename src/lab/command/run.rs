//! `plumb run`.

use std::io::IsTerminal;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use crate::lab::{Metrics, Plan, Sample, TrajectoryWriter, measure};

use super::arguments::RunArguments;
use super::outcome::{CommandError, Outcome, print};
use super::summary;

pub(super) fn run(arguments: &RunArguments) -> Result<Outcome, CommandError> {
    let settings = arguments.settings.resolve()?;
    let plan = Plan::new(&arguments.scene, &arguments.parameters.list, settings, arguments.seconds)?;
    let metrics = measure_and_write(&plan, arguments)?;
    if arguments.json {
        let json = serde_json::to_string_pretty(&metrics)
            .map_err(|error| CommandError::Output { place: "standard output".into(), reason: error.into() })?;
        print(&format!("{json}\n"))?;
    } else {
        print(&summary::of(&metrics))?;
    }
    Ok(if metrics.quarantined.is_empty() { Outcome::Done } else { Outcome::CheckFailed })
}

/// The file is created before the run: nobody waits for a run whose result cannot be kept.
fn measure_and_write(plan: &Plan, arguments: &RunArguments) -> Result<Metrics, CommandError> {
    let mut progress = Progress::new(plan.steps);
    let Some(path) = &arguments.out else {
        return measure(plan, |sample| {
            progress.show(sample);
            Ok(())
        });
    };
    let unwritable = |reason| CommandError::Output { place: path.display().to_string(), reason };
    let names = plan.scene.bodies.iter().map(|body| body.name.clone()).collect();
    let mut trajectory = TrajectoryWriter::create(path, names, arguments.every).map_err(unwritable)?;
    let metrics = measure(plan, |sample| {
        progress.show(sample);
        trajectory.write(sample).map_err(unwritable)
    })?;
    trajectory.finish().map_err(unwritable)?;
    Ok(metrics)
}

/// A bar on standard error for runs that a person waits for.
struct Progress {
    started: Instant,
    steps: u64,
    bar: Option<ProgressBar>,
}

impl Progress {
    /// Runs shorter than this are over before a bar is read.
    const PATIENCE: Duration = Duration::from_secs(1);

    fn new(steps: u64) -> Self {
        Self { started: Instant::now(), steps, bar: None }
    }

    fn show(&mut self, sample: &Sample) {
        if self.bar.is_none() && self.started.elapsed() > Self::PATIENCE && std::io::stderr().is_terminal() {
            let style = ProgressStyle::with_template("{wide_bar} {percent:>3} %, {eta} left");
            let bar = ProgressBar::new(self.steps).with_elapsed(self.started.elapsed());
            self.bar = Some(bar.with_style(style.expect("a template of this file")));
        }
        if let Some(bar) = &self.bar {
            bar.set_position(sample.step);
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}
