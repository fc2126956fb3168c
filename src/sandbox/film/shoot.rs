//! A film from its first frame to its last.

use std::path::Path;

use super::error::FilmError;
use super::reel::Reel;
use super::studio::Studio;
use crate::lab::Plan;
use crate::lab::command::{CommandError, Filming};
use crate::lab::recording::{Recording, RecordingError, Replay, is_recording};
use crate::physics::{History, go_to};
use crate::sandbox::timeline;
use crate::sandbox::window::catch_failed_start;

/// What came of it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Filmed {
    /// Frames that were written.
    pub frames: u64,
    /// Of a recording: how it went when it was run again.
    pub replay: Option<Replay>,
}

/// Draws it. `watch` is told how many frames there are, of how many.
///
/// # Errors
/// Bad input, no graphics driver, or an output that cannot be written.
pub fn shoot(film: &Filming, mut watch: impl FnMut(u64, u64)) -> Result<Filmed, FilmError> {
    let path = Path::new(&film.scene);
    let recording = is_recording(&film.scene).then(|| Recording::read(path)).transpose().map_err(CommandError::from)?;
    let (scene, settings, whole) = match &recording {
        Some(recording) => {
            let (scene, settings) = recording.start(path).map_err(CommandError::from)?;
            (scene, settings, (recording.steps() as f64 * settings.step() - film.from).max(0.0))
        }
        None => {
            let plan = Plan::new(&film.scene, &film.parameters, film.settings, film.seconds);
            let plan = plan.map_err(CommandError::from)?;
            (plan.scene, plan.settings, plan.steps as f64 * plan.settings.step())
        }
    };
    let seconds = film.seconds.unwrap_or(whole);
    let mut reel = Reel::begin(&film.out, film.size, film.fps)?;
    let mut studio = catch_failed_start(|| Studio::open(&scene, settings, film.size))?;
    let replay = recording.map(|recording| run_again(&mut studio, &recording, path)).transpose();
    let replay = replay.map_err(CommandError::from)?;
    let (first, frames) = match reel.is_one_picture() {
        true => (film.from + seconds, 1),
        false => (film.from, ((seconds * film.fps).round() as u64).max(1)),
    };
    for frame in 0..frames {
        watch(frame, frames);
        let [width, height] = film.size.map(u32::from);
        let picture = studio.picture(first + frame as f64 / film.fps);
        reel.add(picture.ok_or(FilmError::NoPicture(width, height))?)?;
    }
    reel.end()?;
    Ok(Filmed { frames, replay })
}

/// Has all of a recording happen, and goes back to its start: it happens once more while it is filmed.
fn run_again(studio: &mut Studio, recording: &Recording, path: &Path) -> Result<Replay, RecordingError> {
    let entities = studio.entities.clone();
    let world = studio.world();
    timeline::begin(world);
    let replay = recording.replay_in(world, &entities, path, |_| ())?;
    let begun = world.resource::<History>().begun();
    go_to(world, begun)?;
    Ok(replay)
}
