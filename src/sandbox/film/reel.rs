//! Where the frames of a film go: a GIF, one picture, or a folder of numbered pictures.

use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use bevy::image::Image;
use gif::{Encoder, EncodingError, Frame, Repeat};

use crate::lab::Draft;
use crate::lab::command::CommandError;
use crate::sandbox::screenshot::save_picture;

/// How much time the choice of a frame's 256 colors may take, 1 (the best colors) to 30.
const HASTE: i32 = 10;

/// Of films and pictures that a name may end with as if such were written: it is no name of a folder.
const OTHER_KINDS: [&str; 11] = ["mp4", "webm", "mkv", "mov", "avi", "apng", "webp", "jpg", "jpeg", "bmp", "svg"];

/// What frames are written to. Files are there whole or not at all: what is begun has another name until it is done.
pub(super) enum Reel {
    /// That plays for ever.
    Gif { file: Draft, encoder: Box<Encoder<BufWriter<File>>>, fps: f64, frames: u32 },
    /// One frame.
    Picture(Draft),
    /// `frame-00001.png` and so on, in a folder.
    Folder { path: PathBuf, frames: u32 },
}

impl Reel {
    /// By what the name ends with. Frames are of that size, pixels, so many a second.
    pub fn begin(path: &Path, [width, height]: [u16; 2], fps: f64) -> Result<Self, CommandError> {
        let ends_with = |wanted: &str| path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case(wanted));
        if ends_with("gif") {
            let (draft, file) = Draft::begin(path).map_err(CommandError::unwritable(path))?;
            let begin = || {
                let mut encoder = Encoder::new(BufWriter::new(file), width, height, &[])?;
                encoder.set_repeat(Repeat::Infinite)?;
                Ok(Box::new(encoder))
            };
            let encoder = begin().map_err(to_io).map_err(CommandError::unwritable(path))?;
            Ok(Self::Gif { file: draft, encoder, fps, frames: 0 })
        } else if ends_with("png") {
            Ok(Self::Picture(Draft::begin(path).map_err(CommandError::unwritable(path))?.0))
        } else if let Some(kind) = OTHER_KINDS.iter().find(|kind| ends_with(kind)) {
            let place = path.display();
            Err(CommandError::Usage(format!("{place}: no .{kind} is written: name a .gif, a .png or a folder")))
        } else {
            fs::create_dir_all(path).map_err(CommandError::unwritable(path))?;
            Ok(Self::Folder { path: path.to_owned(), frames: 0 })
        }
    }

    /// Whether it takes the last frame alone.
    pub fn is_one_picture(&self) -> bool {
        matches!(self, Self::Picture(_))
    }

    /// One frame more.
    pub fn add(&mut self, image: Image) -> Result<(), CommandError> {
        match self {
            Self::Gif { file, encoder, fps, frames } => {
                let (width, height) = (image.width() as u16, image.height() as u16);
                let unwritable = || CommandError::unwritable(file.place());
                let pixels = image.try_into_dynamic().map_err(io::Error::other).map_err(unwritable())?;
                let mut frame = Frame::from_rgb_speed(width, height, &pixels.to_rgb8(), HASTE);
                frame.delay = delay(*frames, *fps);
                *frames += 1;
                encoder.write_frame(&frame).map_err(to_io).map_err(unwritable())
            }
            Self::Picture(file) => save_picture(image, file.path()).map_err(CommandError::unwritable(file.place())),
            Self::Folder { path, frames } => {
                *frames += 1;
                let place = path.join(format!("frame-{frames:05}.png"));
                let saved = Draft::begin(&place)
                    .and_then(|(file, _)| save_picture(image, file.path()).and_then(|()| file.finish()));
                saved.map_err(CommandError::unwritable(&place))
            }
        }
    }

    /// The last frame has been added.
    pub fn end(self) -> Result<(), CommandError> {
        match self {
            Self::Gif { file, encoder, .. } => {
                let flushed = encoder.into_inner().map_err(to_io).and_then(|mut output| output.flush());
                flushed.and_then(|()| file.finish()).map_err(CommandError::unwritable(file.place()))
            }
            Self::Picture(file) => file.finish().map_err(CommandError::unwritable(file.place())),
            Self::Folder { .. } => Ok(()),
        }
    }
}

/// How long a frame is shown after so many others, hundredths of a second: what is rounded off does not add up.
fn delay(frames: u32, fps: f64) -> u16 {
    let shown = |frames: f64| (100.0 * frames / fps).round();
    (shown(f64::from(frames) + 1.0) - shown(f64::from(frames))) as u16
}

fn to_io(error: EncodingError) -> io::Error {
    match error {
        EncodingError::Io(error) => error,
        other => io::Error::other(other),
    }
}

#[cfg(test)]
mod tests {
    use super::delay;

    #[test]
    fn frames_last_as_long_after_a_quarter_of_an_hour_as_at_first() {
        for frames in [0, 100, 25_000] {
            assert_eq!(delay(frames, 25.0), 4);
            assert_eq!((0..30).map(|frame| delay(frames + frame, 30.0)).sum::<u16>(), 100);
        }
    }
}
