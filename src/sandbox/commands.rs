//! Commands that need what the window is made of: what they say, and how they end.

use super::film::{FilmError, Filmed, shoot};
use crate::lab::command::{CommandError, Filming, Outcome, Progress, print};
use crate::lab::recording::Difference;

/// Why such a command was not done, in one line.
#[derive(Debug, thiserror::Error)]
pub enum SandboxCommandError {
    /// There is no film.
    #[error(transparent)]
    Film(#[from] FilmError),
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
