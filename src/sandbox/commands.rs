//! Commands that need what the window is made of: what they say, and how they end.

use super::film::{FilmError, Filmed, shoot};
use super::monkey::{Failure, Played, play};
use crate::lab::command::{CommandError, Filming, MonkeyRun, Outcome, Progress, print};
use crate::lab::recording::Difference;

/// Why such a command was not done, in one line.
#[derive(Debug, thiserror::Error)]
pub enum SandboxCommandError {
    /// There is no film.
    #[error(transparent)]
    Film(#[from] FilmError),
    /// The scene cannot be played with.
    #[error("{0}")]
    Play(String),
    /// What it says cannot be said.
    #[error(transparent)]
    Command(#[from] CommandError),
}

/// `plumb film`.
///
/// # Errors
/// Bad input, no graphics driver, or an output that cannot be written.
pub fn film(filming: &Filming) -> Result<Outcome, SandboxCommandError> {
    let mut progress = None;
    let Filmed { frames, replay } =
        shoot(filming, |frame, of| progress.get_or_insert_with(|| Progress::new(of)).show(frame))?;
    drop(progress);
    let [width, height] = filming.size;
    let pictures = if frames == 1 { "1 picture".to_owned() } else { format!("{frames} pictures") };
    let mut said = format!("{pictures} of {width} x {height} pixels: {}\n", filming.out.display());
    let mut outcome = Outcome::Done;
    if let Some(Difference { step, .. }) = replay.and_then(|replay| replay.differs) {
        said += &format!("step {step} comes out otherwise than recorded: from there on it is another film\n");
        outcome = Outcome::CheckFailed;
    }
    print(&said)?;
    Ok(outcome)
}

/// `plumb monkey`.
///
/// # Errors
/// Bad input, or an output that cannot be written.
pub fn monkey(run: &MonkeyRun) -> Result<Outcome, SandboxCommandError> {
    let mut progress = Progress::new(run.steps);
    let played = play(run, |steps| progress.show(steps)).map_err(SandboxCommandError::Play)?;
    drop(progress);
    let Played { steps, deeds, checks, thrown, most_bodies, failure } = played;
    let count: u64 = deeds.values().sum();
    let kinds: Vec<String> = deeds.iter().map(|(kind, count)| format!("{kind} {count}")).collect();
    let mut said = format!("{steps} steps, {count} deeds, {checks} checks, up to {most_bodies} bodies\n");
    said += &format!("{}\n", kinds.join(", "));
    if thrown > 0 {
        said += &format!("set aside after sweeps by forces had thrown them: {thrown}\n");
    }
    let Some(Failure { place: (bout, step), seed, problem, deeds, recording }) = failure else {
        print(&(said + "nothing broke\n"))?;
        return Ok(Outcome::Done);
    };
    let again = if bout > 1 { format!(" (the first with --seed {seed})") } else { String::new() };
    said += &format!("seed {}, bout {bout}{again}, step {step}: {problem}\nbefore it:\n", run.seed);
    deeds.iter().for_each(|deed| said += &format!("  {deed}\n"));
    let place = run.out.display();
    match recording {
        Ok(recording) => {
            recording.write(&run.out).map_err(CommandError::unwritable(&run.out))?;
            said += &format!("recorded: 'plumb {place}' shows it\n");
        }
        Err(problem) => said += &format!("not recorded: {problem}\n"),
    }
    print(&said)?;
    Ok(Outcome::CheckFailed)
}
