//! `plumb race`.

use std::fmt::Write;
use std::fs;
use std::path::Path;

use indicatif::{ProgressBar, ProgressStyle};

use super::arguments::RaceArguments;
use super::outcome::{CommandError, Outcome, print};
use crate::lab::race::{Course, Moment, Race, Runner};
use crate::lab::{Plan, StepMilliseconds, read_settings, write_whole};
use crate::physics::SolverSettings;

/// Most runners: more curves nobody tells apart.
const MOST_RUNNERS: usize = 8;

pub(super) fn race(arguments: &RaceArguments) -> Result<Outcome, CommandError> {
    let runners = runners(&arguments.by)?;
    let plan = Plan::new(&arguments.scene, &arguments.parameters.list, runners[0].settings, arguments.seconds)?;
    let seconds = plan.steps as f64 / plan.settings.hz;
    let (scene, built_in) = (plan.scene, plan.built_in);
    let race = Race { scene, built_in, runners, from: arguments.from, seconds, apart: arguments.apart };
    let folder = &arguments.out;
    fs::create_dir_all(folder).map_err(CommandError::unwritable(folder))?;
    let style = ProgressStyle::with_template("{wide_bar} {percent:>3} %, {eta} left").expect("a template of this file");
    let bar = ProgressBar::new(1000).with_style(style);
    let outcome = race.run(|share| bar.set_position((1000.0 * share) as u64));
    bar.finish_and_clear();
    let stem = folder.join(format!("{}-race", race.scene.name));
    let rows = stem.with_extension("csv");
    write_whole(&rows, &outcome.csv()).map_err(CommandError::unwritable(&rows))?;
    outcome.draw(&race, &stem)?;
    let mut said = format!("distances are from {}\n", outcome.base);
    let columns = ["runner", "apart at", "distance", "joint gap", "overlap", "energy", "ms/step", "fails"];
    let line = |said: &mut String, cells: [&str; 8]| {
        let [name, parted, distance, gap, overlap, energy, cost, fails] = cells;
        let row =
            format!("{name:<14} {parted:>9} {distance:>10} {gap:>10} {overlap:>10} {energy:>10} {cost:>9}  {fails}");
        writeln!(said, "{}", row.trim_end()).expect("a string takes all");
    };
    line(&mut said, columns);
    for course in &outcome.courses {
        let cells = cells(course);
        line(&mut said, cells.each_ref().map(String::as_str));
    }
    writeln!(said, "{}.csv, .svg and .png", stem.display()).expect("a string takes all");
    print(&said)?;
    Ok(Outcome::Done)
}

fn cells(course: &Course) -> [String; 8] {
    let most = |of: fn(&Moment) -> f64| course.moments.iter().map(of).fold(0.0, f64::max);
    let last = course.moments.last();
    let costs = course.moments.iter().map(|moment| moment.ms_per_step).filter(|ms| *ms > 0.0);
    let cost = StepMilliseconds::of(costs.map(|ms| 1e-3 * ms).collect()).median;
    [
        course.name.clone(),
        course.parted.map_or_else(|| "never".to_owned(), |time| format!("{time:.2} s")),
        last.map_or_else(String::new, |moment| format!("{:.2e} m", moment.distance)),
        format!("{:.2e} m", most(|moment| moment.joint_gap)),
        format!("{:.2e} m", most(|moment| moment.overlap)),
        last.map_or_else(String::new, |moment| format!("{:.2e} J", moment.energy)),
        format!("{cost:.3}"),
        course.failed.as_ref().map_or_else(|| "no".to_owned(), |(time, reason)| format!("at {time:.2} s: {reason}")),
    ]
}

/// Presets by name and settings by the path of their file.
fn runners(by: &[String]) -> Result<Vec<Runner>, CommandError> {
    if by.is_empty() || by.len() > MOST_RUNNERS {
        return Err(CommandError::Usage(format!("--by takes 1 to {MOST_RUNNERS} presets or settings files")));
    }
    by.iter()
        .map(|name| {
            let preset = SolverSettings::PRESETS.into_iter().find(|(known, _)| known == name);
            let settings = match preset {
                Some((_, preset)) => preset(),
                None if name.ends_with(".ron") => read_settings(Path::new(name))?,
                None => {
                    let known: Vec<&str> = SolverSettings::PRESETS.iter().map(|(name, _)| *name).collect();
                    let known = known.join(", ");
                    return Err(CommandError::Usage(format!(
                        "--by: '{name}' is no preset ({known}) and no settings file (.ron)"
                    )));
                }
            };
            Ok(Runner { name: name.clone(), settings })
        })
        .collect()
}
