//! `plumb replay`.

use super::arguments::ReplayArguments;
use super::outcome::{CommandError, Outcome, print};
use super::progress::Progress;
use crate::lab::recording::{Difference, Recording, Replay};

pub(super) fn replay(arguments: &ReplayArguments) -> Result<Outcome, CommandError> {
    let path = &arguments.file;
    let recording = Recording::read(path)?;
    let (_, settings) = recording.start(path)?;
    let mut progress = Progress::new(recording.steps());
    let Replay { steps, differs } = recording.replay(path, |step| progress.show(step))?;
    drop(progress);
    let mut said = format!("{}, recorded by {}", recording.name, recording.build);
    said += if recording.is_of_this_build() { ", this build\n" } else { ", another build than this\n" };
    said += &format!(
        "{} steps, {:.2} s at {} Hz at first, {} of them with acts from outside before them\n",
        recording.steps(),
        recording.steps() as f64 / settings.hz,
        settings.hz,
        recording.deeds.len(),
    );
    let outcome = match &differs {
        None => {
            said += "all of them come out the same, to the last bit\n";
            Outcome::Done
        }
        Some(Difference { step, body }) => {
            let first = match body {
                Some(body) => format!("the first body that is elsewhere is '{body}'"),
                None if recording.prints[steps as usize].bodies.is_empty() => {
                    "there are too many bodies to say which".into()
                }
                None => "all bodies are where they were, but not what the solver carries on".into(),
            };
            said += &format!("step {step} comes out otherwise: {first}\n");
            Outcome::CheckFailed
        }
    };
    print(&said)?;
    Ok(outcome)
}
