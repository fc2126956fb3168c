//! The command line.

use std::process::ExitCode;

use plumb::lab::command::{Command, OfSandbox, complain, size_compute_pool};

fn main() -> ExitCode {
    size_compute_pool();
    match Command::from_arguments(std::env::args_os()) {
        Ok(None) => ExitCode::SUCCESS,
        Ok(Some(Command::Task(task))) => task.perform().map_or_else(|error| complain(&error), ExitCode::from),
        Ok(Some(Command::OfSandbox(command))) => with_sandbox(*command),
        Err(error) => complain(&error),
    }
}

#[cfg(feature = "sandbox")]
fn with_sandbox(command: OfSandbox) -> ExitCode {
    use plumb::lab::command::Open;
    use plumb::sandbox::{Launch, film, launch, monkey};

    match command {
        OfSandbox::Open(Open { scene, parameters, settings }) => {
            launch(Launch { scene, parameters, settings }).map_or_else(|error| complain(&error), |()| ExitCode::SUCCESS)
        }
        OfSandbox::Monkey(run) => monkey(&run).map_or_else(|error| complain(&error), ExitCode::from),
        OfSandbox::Film(filming) => film(&filming).map_or_else(|error| complain(&error), ExitCode::from),
    }
}

#[cfg(not(feature = "sandbox"))]
fn with_sandbox(_: OfSandbox) -> ExitCode {
    use plumb::lab::command::CommandError;

    let problem = "this build draws nothing (feature 'sandbox' is off); 'plumb run SCENE' simulates without a window";
    complain(&CommandError::Usage(problem.into()))
}
