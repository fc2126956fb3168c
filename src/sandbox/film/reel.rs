//! Where the frames of a film go: a GIF, one picture, or a folder of numbered pictures.

use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use bevy::image::Image;
use gif::{Encoder, EncodingError, Frame, Repeat};

use super::error::FilmError;

/// How much time the choice of a frame's 256 colors may take, 1 (the best colors) to 30.
const HASTE: i32 = 10;

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
    pub fn begin(path: &Path, [width, height]: [u16; 2], fps: f64) -> Result<Self, FilmError> {
        let ends_with = |wanted: &str| path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case(wanted));
        if ends_with("gif") {
            let (draft, file) = Draft::of(path)?;
            let begin = || {
                let mut encoder = Encoder::new(BufWriter::new(file), width, height, &[])?;
                encoder.set_repeat(Repeat::Infinite)?;
                Ok(Box::new(encoder))
            };
            let encoder = begin().map_err(to_io).map_err(FilmError::unwritable(path))?;
            Ok(Self::Gif { file: draft, encoder, fps, frames: 0 })
        } else if ends_with("png") {
            Ok(Self::Picture(Draft::of(path)?.0))
        } else {
            fs::create_dir_all(path).map_err(FilmError::unwritable(path))?;
            Ok(Self::Folder { path: path.to_owned(), frames: 0 })
        }
    }

    /// Whether it takes the last frame alone.
    pub fn is_one_picture(&self) -> bool {
        matches!(self, Self::Picture(_))
    }

    /// One frame more.
    pub fn add(&mut self, image: Image) -> Result<(), FilmError> {
        match self {
            Self::Gif { file, encoder, fps, frames } => {
                let (width, height) = (image.width() as u16, image.height() as u16);
                let unwritable = || FilmError::unwritable(&file.path);
                let pixels = image.try_into_dynamic().map_err(io::Error::other).map_err(unwritable())?;
                let mut frame = Frame::from_rgb_speed(width, height, &pixels.to_rgb8(), HASTE);
                // Hundredths of a second, such that what is rounded off does not add up.
                let shown = |frames: u32| (100.0 * f64::from(frames) / *fps).round() as u16;
                frame.delay = shown(*frames + 1) - shown(*frames);
                *frames += 1;
                encoder.write_frame(&frame).map_err(to_io).map_err(unwritable())
            }
            Self::Picture(file) => file.save(image),
            Self::Folder { path, frames } => {
                *frames += 1;
                let file = Draft::of(&path.join(format!("frame-{frames:05}.png")))?.0;
                file.save(image)?;
                file.finish()
            }
        }
    }

    /// The last frame has been added.
    pub fn end(self) -> Result<(), FilmError> {
        match self {
            Self::Gif { file, encoder, .. } => {
                let flushed = encoder.into_inner().map_err(to_io).and_then(|mut output| output.flush());
                flushed.map_err(FilmError::unwritable(&file.path))?;
                file.finish()
            }
            Self::Picture(file) => file.finish(),
            Self::Folder { .. } => Ok(()),
        }
    }
}

/// A file under another name beside its place, which is removed again where it is not finished.
pub(super) struct Draft {
    path: PathBuf,
    draft: PathBuf,
}

impl Draft {
    /// Begins the file that is to be at that path.
    fn of(path: &Path) -> Result<(Self, File), FilmError> {
        let no_file = || FilmError::unwritable(path)(io::Error::new(io::ErrorKind::InvalidInput, "names no file"));
        let name = path.file_name().ok_or_else(no_file)?;
        // Of the same kind, by the end of its name.
        let draft = path.with_file_name(format!(".{}.{}", std::process::id(), name.to_string_lossy()));
        let file = File::create(&draft).map_err(FilmError::unwritable(path))?;
        Ok((Self { path: path.to_owned(), draft }, file))
    }

    /// Writes a picture into it.
    fn save(&self, image: Image) -> Result<(), FilmError> {
        let pixels = image.try_into_dynamic().map_err(io::Error::other);
        let saved = pixels.and_then(|pixels| pixels.to_rgb8().save(&self.draft).map_err(io::Error::other));
        saved.map_err(FilmError::unwritable(&self.path))
    }

    /// Puts it in its place.
    fn finish(&self) -> Result<(), FilmError> {
        fs::rename(&self.draft, &self.path).map_err(FilmError::unwritable(&self.path))
    }
}

impl Drop for Draft {
    fn drop(&mut self) {
        let _ = fs::remove_file(&self.draft); // it has its place, or none
    }
}

fn to_io(error: EncodingError) -> io::Error {
    match error {
        EncodingError::Io(error) => error,
        other => io::Error::other(other),
    }
}
