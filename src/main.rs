//! The command line.

use std::process::ExitCode;

use plumb::lab::command::{Command, Open, complain, size_compute_pool};

fn main() -> ExitCode {
    size_compute_pool();
    match Command::from_arguments(std::env::args_os()) {
        Ok(None) => ExitCode::SUCCESS,
        Ok(Some(Command::Open(open))) => open_sandbox(open),
        Ok(Some(Command::Task(task))) => task.perform().map_or_else(|error| complain(&error), ExitCode::from),
        Err(error) => complain(&error),
    }
}

#[cfg(feature = "sandbox")]
fn open_sandbox(open: Open) -> ExitCode {
    use plumb::sandbox::{Launch, launch};

    let Open { scene, parameters, settings } = open;
    launch(Launch { scene, parameters, settings }).map_or_else(|error| complain(&error), |()| ExitCode::SUCCESS)
}

#[cfg(not(feature = "sandbox"))]
fn open_sandbox(_: Open) -> ExitCode {
    use plumb::lab::command::CommandError;

    let problem = "this build has no window (feature 'sandbox' is off); 'plumb run SCENE' simulates without one";
    complain(&CommandError::Usage(problem.into()))
}
