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
use clap::Parser;

pub use arguments::Open;
pub use outcome::{CommandError, Outcome};

use arguments::{Arguments, Subcommand};
use outcome::print;

/// What the command line asks for.
pub enum Command {
    /// Open the sandbox.
    Open(Open),
    /// Anything else: done with [`Task::perform`].
    Task(Task),
}

/// A command that needs no window.
pub struct Task(Subcommand);

impl Command {
    /// Reads the command line of this process. None: help or version was asked for and printed.
    ///
    /// # Errors
    /// Bad usage, or a scene or settings that make no sense.
    pub fn from_arguments(arguments: impl IntoIterator<Item = OsString>) -> Result<Option<Self>, CommandError> {
        let arguments = match Arguments::try_parse_from(arguments) {
            Ok(arguments) => arguments,
            Err(error) if !error.use_stderr() => {
                print(&error.render().to_string())?;
                return Ok(None);
            }
            Err(error) => return Err(CommandError::Usage(first_paragraph(&error.render().to_string()))),
        };
        Ok(Some(match arguments.subcommand {
            Some(subcommand) => Self::Task(Task(subcommand)),
            None => Self::Open(arguments.open.resolve()?),
        }))
    }
}

impl Task {
    /// Does it.
    ///
    /// # Errors
    /// Bad input, or an output that cannot be written.
    pub fn perform(self) -> Result<Outcome, CommandError> {
        match self.0 {
            Subcommand::Scenes => scenes::list(),
            Subcommand::Run(arguments) => run::run(&arguments),
            Subcommand::Export(arguments) => export::export(&arguments),
            Subcommand::Chart(arguments) => chart::chart(&arguments),
            Subcommand::Map(arguments) => map::map(&arguments),
            Subcommand::Race(arguments) => race::race(&arguments),
            Subcommand::Replay(arguments) => replay::replay(&arguments),
            Subcommand::Fit(arguments) => fit::fit(&arguments),
        }
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

/// Clap explains itself in paragraphs; the first says what is wrong.
fn first_paragraph(message: &str) -> String {
    let lines = message.lines().take_while(|line| !line.trim().is_empty()).map(str::trim);
    let line = lines.collect::<Vec<_>>().join(" ");
    format!("{}; see 'plumb --help'", line.strip_prefix("error: ").unwrap_or(&line))
}
