//! `plumb run`.

use std::fs::{self, File};
use std::path::Path;

use bevy::prelude::World;

use crate::lab::recording::Recording;
use crate::lab::run::measure_world;
use crate::lab::{Metrics, Plan, Simulation, TrajectoryWriter, write_contact_problem};
use crate::physics::{HardProblem, HardProblems, Method};

use super::arguments::RunArguments;
use super::outcome::{CommandError, Outcome, print};
use super::progress::Progress;
use super::summary;

/// Contact problems that a run writes at most.
const PROBLEMS: usize = 10;

pub(super) fn run(arguments: &RunArguments) -> Result<Outcome, CommandError> {
    let settings = arguments.settings.resolve()?;
    if arguments.problems.is_some() && settings.method != Method::Exact {
        return Err(CommandError::Usage(
            "--problems: only 'accurate' solves contact problems; add '--preset accurate'".into(),
        ));
    }
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
    let parameters = arguments.parameters.list.iter().map(|(name, value)| format!(" {name}={value}"));
    let name: String = std::iter::once(plan.scene.name.clone()).chain(parameters).collect();
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
    let problems = arguments.problems.as_deref();
    problems.map(|folder| fs::create_dir_all(folder).map_err(unwritable(folder))).transpose()?;
    let mut progress = Progress::new(plan.steps);
    let begin = |world: &mut World| {
        if problems.is_some() {
            world.insert_resource(HardProblems::new(PROBLEMS));
        }
    };
    let metrics = measure_world(plan, begin, |simulation: &Simulation| {
        let sample = simulation.sample();
        progress.show(sample.step);
        if let Some(recording) = &mut recording {
            recording.note(simulation);
        }
        if let Some(folder) = problems.filter(|_| sample.step == plan.steps) {
            write_problems(folder, &name, simulation.world().resource::<HardProblems>().list())?;
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

/// Named by the scene with the parameters given, the step, and the iterations that it took there.
fn write_problems(folder: &Path, name: &str, problems: &[HardProblem]) -> Result<(), CommandError> {
    if problems.is_empty() {
        eprintln!("plumb: no contact problem took an iteration; nothing is written to {}", folder.display());
    }
    for HardProblem { step, iterations, tolerance, residual, problem } in problems {
        let path = folder.join(format!("{}-{step:05}-{iterations}.txt", name.replace([' ', '/'], "_")));
        let comment = format!(
            "{name}, step {step}: {iterations} iterations to {residual:.1e} m/s, where {tolerance:.1e} were wanted"
        );
        write_contact_problem(&path, problem, &comment).map_err(CommandError::unwritable(&path))?;
    }
    Ok(())
}
