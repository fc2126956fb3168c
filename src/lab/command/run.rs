//! `plumb run`.

use std::fs::File;
use std::path::Path;

use crate::lab::recording::Recording;
use crate::lab::run::measure_world;
use crate::lab::{Metrics, Plan, Simulation, TrajectoryWriter};

use super::arguments::RunArguments;
use super::outcome::{CommandError, Outcome, print};
use super::progress::Progress;
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

/// Files are created before the run: nobody waits for a run whose result cannot be kept.
fn measure_and_write(plan: &Plan, arguments: &RunArguments) -> Result<Metrics, CommandError> {
    let unwritable = CommandError::unwritable;
    let names = plan.scene.bodies.iter().map(|body| body.name.clone()).collect();
    let out = arguments.out.as_deref();
    let writer = |path: &Path| TrajectoryWriter::create(path, names, arguments.every).map_err(unwritable(path));
    let mut trajectory = out.map(writer).transpose()?;
    let record = arguments.record.as_deref();
    let begin = |path: &Path| {
        File::create(path).map_err(unwritable(path))?;
        Recording::of_plan(plan).map_err(CommandError::from)
    };
    let mut recording = record.map(begin).transpose()?;
    let mut progress = Progress::new(plan.steps);
    let metrics = measure_world(plan, |simulation: &Simulation| {
        let sample = simulation.sample();
        progress.show(sample.step);
        if let Some(recording) = &mut recording {
            recording.note(simulation);
        }
        trajectory.as_mut().zip(out).map_or(Ok(()), |(file, path)| file.write(&sample).map_err(unwritable(path)))
    })?;
    if let (Some(trajectory), Some(path)) = (trajectory, out) {
        trajectory.finish().map_err(unwritable(path))?;
    }
    if let (Some(recording), Some(path)) = (recording, record) {
        recording.write(path).map_err(unwritable(path))?;
    }
    Ok(metrics)
}
