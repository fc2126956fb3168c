//! Solvers of contact problems on saved problems, one island's solve each: how soon, and of how many, each finds impulses that
//! obey the laws.
//!
//! `cargo bench --profile measure --no-default-features --features lab --bench contacts -- [DIR] [--limit SECONDS] [--chart FILE]
//! [--csv FILE]`
//!
//! DIR is a folder of problems (`.txt`); without it, those beside this file. `plumb run SCENE --preset accurate --problems DIR`
//! writes the hardest of a run, `fclib.py` beside this file those of FCLIB. The format is told in
//! `src/lab/contact_problem.rs`; the name of a file up to its first `-` is the group that it is told with. A solver has
//! `--limit` (10) seconds for each problem. `--chart` draws the performance profile, `.svg` and `.png`; `--csv`
//! writes all times, and the least residual of each.
//!
//! Each solver runs on one thread, everything that it needs included: its own form of the problem, its structure, its
//! factorisations. Times are those at which the impulses that it has came to a residual of 1e-4, 1e-8 and 1e-10 m/s, which is
//! measured outside of it and while the clock stands ([`natural_map`]).

mod admm;
mod gauss_seidel;
mod natural_map;
// The solver has more than is asked for here.
#[allow(dead_code, unused_imports)]
mod physics;
#[allow(dead_code, unused_imports)]
#[path = "../../src/lab/picture/mod.rs"]
mod picture;
mod plumb_solver;
mod points;
mod profile;
mod table;
mod watch;

use std::io::{self, IsTerminal, Write};
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

use natural_map::Impulses;
use plumb::lab::{contact_problem_files, read_contact_problem};
use plumb::physics::ContactProblem;
use plumb_solver::Given;
use watch::{Seen, WANTED, Watch};

/// What is compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Solver {
    /// Plumb's, from the impulses of the step before.
    Guessed,
    /// Plumb's, from none.
    Unguessed,
    /// Block Gauss–Seidel, from the impulses of the step before.
    GaussSeidel,
    /// The alternating direction method of multipliers, from the impulses of the step before.
    Admm,
}

impl Solver {
    const ALL: [Self; 4] = [Self::Guessed, Self::Unguessed, Self::GaussSeidel, Self::Admm];

    fn name(self) -> &'static str {
        match self {
            Self::Guessed => "Plumb",
            Self::Unguessed => "Plumb, from zero",
            Self::GaussSeidel => "Gauss–Seidel",
            Self::Admm => "ADMM",
        }
    }

    fn run(self, problem: &ContactProblem, limit: Duration) -> Seen {
        let (guess, zero) = (Impulses::guess(problem), Impulses::zero(problem));
        match self {
            Self::Guessed => of_plumb(problem, &guess, limit),
            Self::Unguessed => of_plumb(problem, &zero, limit),
            Self::GaussSeidel => {
                let mut watch = Watch::start(problem, limit);
                gauss_seidel::solve(problem, &guess, &mut watch);
                watch.seen()
            }
            Self::Admm => {
                let mut watch = Watch::start(problem, limit);
                admm::solve(problem, &guess, &mut watch);
                watch.seen()
            }
        }
    }
}

/// Plumb's goes for one residual, so that it is asked for each in turn.
fn of_plumb(problem: &ContactProblem, start: &Impulses, limit: Duration) -> Seen {
    let mut all = Seen { times: [None; WANTED.len()], least: f64::INFINITY };
    for (index, tolerance) in WANTED.into_iter().enumerate() {
        let mut watch = Watch::start(problem, limit);
        Given::new(problem).solve(start, tolerance, &mut watch);
        let seen = watch.seen();
        all.times[index] = seen.times[index];
        all.least = all.least.min(seen.least);
    }
    all
}

/// What was seen of all solvers on one problem, in the order of [`Solver::ALL`].
struct Timed {
    file: PathBuf,
    seen: [Seen; Solver::ALL.len()],
}

impl Timed {
    /// The name of its file up to the first `-`.
    fn group(&self) -> String {
        let name = self.file.file_stem().unwrap_or_default().to_string_lossy();
        name.split('-').next().unwrap_or_default().to_owned()
    }
}

/// What is asked for.
struct Arguments {
    folder: PathBuf,
    limit: Duration,
    chart: Option<PathBuf>,
    csv: Option<PathBuf>,
}

impl Arguments {
    fn read(words: impl IntoIterator<Item = String>) -> Result<Self, String> {
        let beside = concat!(env!("CARGO_MANIFEST_DIR"), "/benches/contacts/problems");
        let mut arguments = Self { folder: beside.into(), limit: Duration::from_secs(10), chart: None, csv: None };
        let mut words = words.into_iter();
        while let Some(word) = words.next() {
            match &*word {
                // Cargo's own.
                "--bench" => {}
                "--limit" => {
                    let limit = words.next().and_then(|limit| limit.parse().ok());
                    let limit = limit.and_then(|limit| Duration::try_from_secs_f64(limit).ok());
                    arguments.limit = limit.ok_or("--limit is to be followed by seconds, as '--limit 10'")?;
                }
                "--chart" => {
                    arguments.chart = Some(words.next().ok_or("--chart is to be followed by a file")?.into());
                }
                "--csv" => {
                    arguments.csv = Some(words.next().ok_or("--csv is to be followed by a file")?.into());
                }
                option if option.starts_with('-') => {
                    let known = "--limit SECONDS, --chart FILE and --csv FILE";
                    return Err(format!("there is no option '{option}'; there are {known}"));
                }
                folder => arguments.folder = folder.into(),
            }
        }
        Ok(arguments)
    }
}

fn main() -> ExitCode {
    match Arguments::read(std::env::args().skip(1)).and_then(|arguments| run(&arguments)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("contacts: {error}");
            ExitCode::from(2)
        }
    }
}

fn run(arguments: &Arguments) -> Result<(), String> {
    let files = contact_problem_files(&arguments.folder).map_err(|error| error.to_string())?;
    // All before the first is timed: what is malformed is told at once.
    let problems: Result<Vec<_>, _> = files.iter().map(|file| read_contact_problem(file)).collect();
    let problems = problems.map_err(|error| error.to_string())?;
    let shows = io::stderr().is_terminal();
    let mut timed = Vec::new();
    for (file, problem) in files.iter().zip(&problems) {
        if shows {
            eprint!("\r\x1b[2K{} of {}", timed.len() + 1, files.len());
        }
        let seen = Solver::ALL.map(|solver| solver.run(problem, arguments.limit));
        timed.push(Timed { file: file.clone(), seen });
    }
    if shows {
        eprint!("\r\x1b[2K");
    }
    let text = table::text(&timed, arguments.limit);
    io::stdout().write_all(text.as_bytes()).map_err(|error| format!("standard output: cannot be written: {error}"))?;
    if let Some(csv) = &arguments.csv {
        std::fs::write(csv, table::csv(&timed))
            .map_err(|error| format!("{}: cannot be written: {error}", csv.display()))?;
    }
    match &arguments.chart {
        Some(chart) => profile::draw(&timed, chart).map_err(|error| error.to_string()),
        None => Ok(()),
    }
}
