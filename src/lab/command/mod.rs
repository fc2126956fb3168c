//! The command line: what it may say (`arguments`), and what it then does, but for the window,
//! which the binary opens.
//!
//! Results go to standard output or files, progress and complaints to standard error. Exit
//! status: 0 done, 1 a check failed, 2 bad usage or input, with one line that says what and
//! where.

mod arguments;
mod chart;
mod export;
mod fit;
mod map;
mod outcome;
mod progress;
mod race;
mod replay;
mod run;
mod scenes;
mod settings;
mod summary;
mod vary;

use std::ffi::OsString;
use std::io::{self, Write};
use std::process::ExitCode;

use bevy::tasks::{ComputeTaskPool, TaskPoolBuilder};
use clap::{CommandFactory, Parser};

pub use arguments::{Filming, MonkeyRun, Open};
pub use outcome::{CommandError, Outcome, print};
pub use progress::Progress;

use arguments::{Arguments, Subcommand};

/// What the command line asks for.
pub enum Command {
    /// Something that needs what the window is made of.
    OfSandbox(Box<OfSandbox>),
    /// Anything else: done with [`Task::perform`].
    Task(Task),
}

/// What needs what the window is made of.
pub enum OfSandbox {
    /// Open the sandbox.
    Open(Open),
    /// Draw off screen.
    Film(Filming),
    /// Let a monkey play.
    Monkey(MonkeyRun),
}

/// A command that needs no window.
pub struct Task(Box<dyn FnOnce() -> Result<Outcome, CommandError>>);

impl Command {
    /// Reads the command line of this process. None: help or version was asked for and printed.
    ///
    /// # Errors
    /// Bad usage, or a scene or settings that make no sense.
    pub fn from_arguments(arguments: impl IntoIterator<Item = OsString>) -> Result<Option<Self>, CommandError> {
        let given: Vec<OsString> = arguments.into_iter().collect();
        let arguments = match Arguments::try_parse_from(&given) {
            Ok(arguments) => arguments,
            Err(error) if !error.use_stderr() => {
                print(&error.render().to_string())?;
                return Ok(None);
            }
            Err(error) => return Err(CommandError::Usage(complaint(&error.render().to_string(), &given))),
        };
        let Some(subcommand) = arguments.subcommand else {
            return Ok(Some(Self::OfSandbox(Box::new(OfSandbox::Open(arguments.open.resolve()?)))));
        };
        Ok(Some(match subcommand {
            Subcommand::Film(arguments) => Self::OfSandbox(Box::new(OfSandbox::Film(arguments.resolve()?))),
            Subcommand::Monkey(arguments) => Self::OfSandbox(Box::new(OfSandbox::Monkey(arguments.resolve()?))),
            Subcommand::Scenes => Self::task(scenes::list),
            Subcommand::Run(arguments) => Self::task(move || run::run(&arguments)),
            Subcommand::Export(arguments) => Self::task(move || export::export(&arguments)),
            Subcommand::Chart(arguments) => Self::task(move || chart::chart(&arguments)),
            Subcommand::Map(arguments) => Self::task(move || map::map(&arguments)),
            Subcommand::Race(arguments) => Self::task(move || race::race(&arguments)),
            Subcommand::Replay(arguments) => Self::task(move || replay::replay(&arguments)),
            Subcommand::Fit(arguments) => Self::task(move || fit::fit(&arguments)),
        }))
    }

    fn task(perform: impl FnOnce() -> Result<Outcome, CommandError> + 'static) -> Self {
        Self::Task(Task(Box::new(perform)))
    }
}

impl Task {
    /// Does it.
    ///
    /// # Errors
    /// Bad input, or an output that cannot be written.
    pub fn perform(self) -> Result<Outcome, CommandError> {
        (self.0)()
    }
}

/// Prints what went wrong in one line and gives the exit status for it.
pub fn complain(error: &dyn std::error::Error) -> ExitCode {
    let message = error.to_string();
    let line: Vec<&str> = message.split_whitespace().collect();
    // Nothing is left to tell if even this fails.
    let _ = writeln!(io::stderr(), "plumb: {}", line.join(" "));
    ExitCode::from(2)
}

/// Sizes the pool that physics steps run on, once, before any app is made: all cores but one,
/// since the thread that calls a step works too.
pub fn size_compute_pool() {
    ComputeTaskPool::get_or_init(|| {
        let cores = bevy::tasks::available_parallelism();
        let threads = cores.saturating_sub(1).max(1);
        TaskPoolBuilder::new().num_threads(threads).thread_name("Compute Task Pool".into()).build()
    });
}

/// Clap explains itself in paragraphs; the first says what is wrong. The help is that of the subcommand that was `given`.
fn complaint(message: &str, given: &[OsString]) -> String {
    let lines = message.lines().take_while(|line| !line.trim().is_empty()).map(str::trim);
    let line = lines.collect::<Vec<_>>().join(" ");
    let subcommand = given.get(1).and_then(|name| name.to_str());
    let subcommand = subcommand.filter(|name| Arguments::command().find_subcommand(name).is_some());
    let helped = subcommand.map_or_else(|| "plumb".to_owned(), |name| format!("plumb {name}"));
    format!("{}; see '{helped} --help'", line.strip_prefix("error: ").unwrap_or(&line))
}
