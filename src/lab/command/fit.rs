//! `plumb fit`.

use std::fmt::Write as _;
use std::path::PathBuf;
use std::time::Duration;

use crate::lab::chart::{ChartError, POINTS, Subject};
use crate::lab::fit::{Fit, MARGIN, fit as search, switch};
use crate::lab::sweep::{Budget, Record, Shard, Store, run};
use crate::lab::verdict::Verdict;
use crate::lab::{Plan, write_settings};
use crate::physics::SolverSettings;

use super::arguments::FitArguments;
use super::chart::{SweepBar, make_folder, tell_ignored};
use super::outcome::{CommandError, Outcome, print};

const BUDGET: Budget = Budget { most: Duration::from_secs(10), least: Duration::from_millis(100) };

pub(super) fn fit(arguments: &FitArguments) -> Result<Outcome, CommandError> {
    let subject = Subject { scene: arguments.scene.clone(), parameters: arguments.parameters.list.clone() };
    let plan = Plan::new(&subject.scene, &subject.parameters, SolverSettings::default(), arguments.seconds)?;
    let seconds = plan.steps as f64 / plan.settings.hz;
    make_folder(&arguments.out)?;
    let mut store = Store::open(&arguments.out.join(POINTS)).map_err(ChartError::from)?;
    tell_ignored(&store);
    let bar = SweepBar::new();
    let found = search::<ChartError>(&subject.scene, &subject.parameters, seconds, arguments.error, |points| {
        run(points, Shard::ALL, BUDGET, &mut store, |progress, point| bar.show(&progress, point))
    })?;
    bar.finish();
    if found.tried.iter().all(|record| record.error.is_none()) {
        let problem = format!("{}: nothing is known of its answer, so no error can be held", subject.title());
        return Err(CommandError::Usage(problem));
    }
    print(&table(&found))?;
    match switch(&found.tried) {
        Some(error) if error.is_finite() => {
            print(&format!(
                "\nBelow an error of {error:.1e}, accurate is the cheapest; above it, a faster method is.\n"
            ))?;
        }
        Some(_) => print("\naccurate is the cheapest for any error.\n")?,
        None => print("\naccurate is for no error the cheapest of these.\n")?,
    }
    conclude(&subject, &found, arguments)
}

/// Says what was found and writes it down. Status 1 where nothing holds the error.
fn conclude(subject: &Subject, found: &Fit, arguments: &FitArguments) -> Result<Outcome, CommandError> {
    let error = arguments.error;
    let Some(best) = &found.best else {
        let nearest = found.nearest.as_ref().map(describe).unwrap_or_else(|| "every run failed".into());
        print(&format!("\nNothing holds {error} for {}. The best there is: {nearest}\n", subject.title()))?;
        return Ok(Outcome::CheckFailed);
    };
    let path: PathBuf = arguments.out.join(format!("fit-{}.ron", subject.stem()));
    let settings = best.solver_settings().unwrap_or_default();
    write_settings(&path, &settings).map_err(CommandError::unwritable(&path))?;
    let percent = 100.0 * MARGIN;
    let parameters =
        subject.parameters.iter().fold(String::new(), |text, (name, value)| format!("{text} -p {name}={value}"));
    print(&format!(
        "\nCheapest that holds {percent} % of {error} for {}: {}\nwritten to {}: plumb run {}{parameters} --settings {}\n",
        subject.title(),
        describe(best),
        path.display(),
        subject.scene,
        path.display(),
    ))?;
    Ok(Outcome::Done)
}

fn describe(record: &Record) -> String {
    let Record { series, hz, substeps, iterations, unit, .. } = record;
    format!(
        "{series}, {hz} Hz, substeps {substeps}, iterations {iterations}: error {:.2e} {unit}, {:.3} ms a simulated second",
        record.error.unwrap_or(f64::NAN),
        record.cost().unwrap_or(f64::NAN),
    )
}

/// Everything tried, cheapest first.
fn table(found: &Fit) -> String {
    let mut table = format!(
        "{:23} {:>7} {:>9} {:>11} {:>12} {:>12}  {}\n",
        "method", "hz", "substeps", "iterations", "ms per s", "error", "verdict"
    );
    for record in &found.tried {
        let number = |value: Option<f64>| value.map_or("-".to_owned(), |value| format!("{value:.3e}"));
        let verdict = match record.verdict {
            Verdict::Holds => "holds".to_owned(),
            other => format!("{other}: {}", record.reason),
        };
        // Writing to a string does not fail.
        let _ = writeln!(
            table,
            "{:23} {:>7} {:>9} {:>11} {:>12} {:>12}  {verdict}",
            record.series,
            record.hz,
            record.substeps,
            record.iterations,
            number(record.cost()),
            number(record.error),
        );
    }
    table
}
