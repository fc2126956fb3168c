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
mod run;
mod scenes;
mod summary;

use std::ffi::OsString;
use std::io::{self, Write};
use std::process::ExitCode;

use bevy::tasks::{ComputeTaskPool, TaskPoolBuilder};
use clap::Parser;

use crate::lab::chart::{ChartError, PeersError};
use crate::lab::{PlanError, SettingsFileError};
use crate::physics::{SettingsError, SolverSettings};
use crate::scene::SceneError;

use arguments::{Arguments, Subcommand};

/// What the command line asks for.
pub enum Command {
    /// Open the sandbox.
    Open(Open),
    /// Anything else: done with [`Task::perform`].
    Task(Task),
}

/// What the sandbox opens with; the scene exists and its parameters are in range.
pub struct Open {
    /// A built-in scene or the path of a RON file.
    pub scene: String,
    /// Its parameters.
    pub parameters: Vec<(String, f64)>,
    /// The solver's settings.
    pub settings: SolverSettings,
}

/// A command that needs no window.
pub struct Task(Subcommand);

/// Bad usage or input, in one line.
#[derive(Debug, thiserror::Error)]
pub enum CommandError {
    /// A command line that makes no sense.
    #[error("{0}")]
    Usage(String),
    /// A scene that cannot be had.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// Settings that cannot be had.
    #[error(transparent)]
    SettingsFile(#[from] SettingsFileError),
    /// Settings that are out of range.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// A run that makes no sense.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// Charts that cannot be made.
    #[error(transparent)]
    Chart(#[from] ChartError),
    /// Rows of other engines that cannot be had.
    #[error(transparent)]
    Peers(#[from] PeersError),
    /// An output that cannot be written.
    #[error("{place}: cannot be written: {reason}")]
    Output {
        /// The file.
        place: String,
        /// What the system said.
        reason: io::Error,
    },
}

/// How a task ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Exit status 0.
    Done,
    /// Exit status 1: a body was quarantined, or no settings hold the error asked for.
    CheckFailed,
}

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

impl From<Outcome> for ExitCode {
    fn from(outcome: Outcome) -> Self {
        match outcome {
            Outcome::Done => Self::SUCCESS,
            Outcome::CheckFailed => Self::FAILURE,
        }
    }
}

/// Clap explains itself in paragraphs; the first says what is wrong.
fn first_paragraph(message: &str) -> String {
    let lines = message.lines().take_while(|line| !line.trim().is_empty()).map(str::trim);
    let line = lines.collect::<Vec<_>>().join(" ");
    format!("{}; see 'plumb --help'", line.strip_prefix("error: ").unwrap_or(&line))
}

/// Prints to standard output. A reader that has seen enough (`plumb scenes | head`) is no error.
fn print(text: &str) -> Result<(), CommandError> {
    let mut output = io::stdout().lock();
    match output.write_all(text.as_bytes()).and_then(|()| output.flush()) {
        Err(reason) if reason.kind() != io::ErrorKind::BrokenPipe => {
            Err(CommandError::Output { place: "standard output".into(), reason })
        }
        _ => Ok(()),
    }
}
