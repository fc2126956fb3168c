//! Grounds from pictures: how bright each pixel of a PNG is says how high the ground is there.

use std::fs::File;
use std::io::{self, BufReader, ErrorKind, Read};
use std::path::{Path, PathBuf};

use super::mesh::BUILTIN_PREFIX;
use super::surface::{SurfaceForm, SurfaceSpec};
use crate::physics::{MeshError, TriangleMesh};

/// The pictures that come with Plumb, by name.
const BUILTIN: [(&str, &[u8]); 1] = [("hills.png", include_bytes!("../../assets/heights/hills.png"))];

/// Weights of red, green and blue in how bright a color is (ITU-R BT.709), as shares of their sum: whole numbers, so that
/// a grey that is stored as a color is exactly that grey.
const LUMA: [f64; 3] = [2126.0, 7152.0, 722.0];
const LUMA_SUM: f64 = 10_000.0;

/// What a scene's `file` says for each picture of heights that comes with Plumb: `plumb:hills.png` and so on.
pub fn builtin_height_pictures() -> impl Iterator<Item = String> {
    BUILTIN.iter().map(|(name, _)| format!("{BUILTIN_PREFIX}{name}"))
}

/// Why a picture is no ground. Displays as one line.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum HeightPictureError {
    /// None of that name comes with Plumb.
    #[error("no picture '{file}' comes with Plumb; there is {}", builtin_height_pictures().collect::<Vec<_>>().join(", "))]
    UnknownBuiltin {
        /// What was asked for.
        file: String,
    },
    /// The file cannot be read.
    #[error("{} cannot be read: {problem}; a picture's path is relative to its scene's file", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// Why.
        problem: String,
    },
    /// The file is no PNG, or a broken one.
    #[error("{file} is not a whole PNG picture ({problem}); export it as PNG")]
    NotPng {
        /// The file.
        file: String,
        /// What the decoder stumbled over.
        problem: String,
    },
    /// It has a single row or column.
    #[error("{file} has {width} x {height} pixels; give at least 2 x 2")]
    TooFew {
        /// The file.
        file: String,
        /// In pixels.
        width: u32,
        /// In pixels.
        height: u32,
    },
    /// A surface of it would have more than [`TriangleMesh::MOST_TRIANGLES`].
    #[error(
        "{file} has {width} x {height} pixels, which are {count} triangles of at most {}; scale it down, a square to {side} x {side}",
        TriangleMesh::MOST_TRIANGLES,
        side = most_of_a_square()
    )]
    TooMany {
        /// The file.
        file: String,
        /// In pixels.
        width: u32,
        /// In pixels.
        height: u32,
        /// How many there would be.
        count: u64,
    },
    /// With that size and those heights it is no surface.
    #[error("{file}: {error}")]
    Surface {
        /// The file.
        file: String,
        /// What is wrong with it.
        error: MeshError,
    },
}

/// Pixels along each side of the largest square picture.
fn most_of_a_square() -> usize {
    (TriangleMesh::MOST_TRIANGLES / 2).isqrt() + 1
}

impl SurfaceSpec {
    /// A ground over a rectangle of that `size` along x and z, m, about the body's position, from a PNG of 8 or 16 bits a
    /// channel: `height` is where black and white are, m, and greys are between them in proportion to their value as it is
    /// stored, without gamma. Colors count by their luma, opacity not at all; of an animation, its still picture does.
    ///
    /// The outermost pixels are on the rim. Rows of pixels go along x; the topmost is at −z, the leftmost pixel of each at
    /// −x: seen from above with x to the right and z down, the ground is as the picture shows it.
    ///
    /// `file` is relative to `folder`, or the name of one that comes with Plumb ([`builtin_height_pictures`]).
    ///
    /// # Errors
    /// The file is missing or no PNG, has fewer than 2 x 2 pixels or too many for a surface, or a number is not finite.
    pub fn height_picture(
        file: &str,
        folder: &Path,
        size: [f64; 2],
        height: [f64; 2],
    ) -> Result<Self, HeightPictureError> {
        let path = (!file.starts_with(BUILTIN_PREFIX)).then(|| folder.join(file));
        let shown = path.as_ref().map_or(file.to_owned(), |path| path.display().to_string());
        let unreadable = |path: &Path, error: &io::Error| HeightPictureError::Unreadable {
            path: path.to_owned(),
            problem: error.to_string(),
        };
        let picture = match &path {
            None => Picture::decode(builtin(file)?, &shown),
            Some(path) => {
                let opened = File::open(path).map_err(|error| unreadable(path, &error))?;
                Picture::decode(BufReader::new(opened), &shown)
            }
        };
        let picture = picture.map_err(|failure| match (failure, &path) {
            (Failure::Decoding(png::DecodingError::IoError(error)), Some(path))
                if error.kind() != ErrorKind::UnexpectedEof =>
            {
                unreadable(path, &error)
            }
            (Failure::Decoding(error), _) => {
                let problem = error.to_string().trim_end_matches('.').to_owned();
                HeightPictureError::NotPng { file: shown.clone(), problem }
            }
            (Failure::Size(error), _) => error,
        })?;
        let [low, high] = height;
        let [nx, nz] = [picture.width - 1, picture.height - 1];
        let mesh = TriangleMesh::grid(size, [nx, nz], |pixel, _| low + (high - low) * picture.brightness(pixel));
        let form = SurfaceForm::Picture { file: file.into(), path: path.map(Into::into), size, height };
        let made = mesh.and_then(|mesh| Self::of(form, mesh, false));
        made.map_err(|error| HeightPictureError::Surface { file: shown, error })
    }
}

fn builtin(file: &str) -> Result<&'static [u8], HeightPictureError> {
    let known = BUILTIN.iter().find(|(name, _)| file.strip_prefix(BUILTIN_PREFIX) == Some(name));
    known.map(|&(_, bytes)| bytes).ok_or_else(|| HeightPictureError::UnknownBuiltin { file: file.to_owned() })
}

/// A picture as it is stored, row by row from the top.
struct Picture {
    width: u32,
    height: u32,
    channels: usize,
    /// Bytes of each value, the most significant first.
    depth: usize,
    bytes: Vec<u8>,
}

/// Why there is no picture.
enum Failure {
    Decoding(png::DecodingError),
    Size(HeightPictureError),
}

impl Picture {
    /// Looks at the size before there is memory for the pixels.
    fn decode(source: impl Read, shown: &str) -> Result<Self, Failure> {
        let mut decoder = png::Decoder::new(source);
        // Palettes become colors and what has fewer than 8 bits has 8.
        decoder.set_transformations(png::Transformations::EXPAND);
        let mut reader = decoder.read_info().map_err(Failure::Decoding)?;
        let (width, height) = reader.info().size();
        check_size(width, height, shown).map_err(Failure::Size)?;
        let mut bytes = vec![0; reader.output_buffer_size()];
        reader.next_frame(&mut bytes).map_err(Failure::Decoding)?;
        let (color, bits) = reader.output_color_type();
        let depth = if bits == png::BitDepth::Sixteen { 2 } else { 1 };
        Ok(Self { width, height, channels: color.samples(), depth, bytes })
    }

    /// Of a pixel by its place from the left and from the top: from 0, black, to 1, white.
    fn brightness(&self, [column, row]: [u32; 2]) -> f64 {
        let pixel = row as usize * self.width as usize + column as usize;
        let value = |channel: usize| {
            let first = (pixel * self.channels + channel) * self.depth;
            self.bytes[first..first + self.depth].iter().fold(0.0, |value, &byte| 256.0 * value + f64::from(byte))
        };
        // The last of 2 and of 4 is opacity.
        let luma = if self.channels < 3 {
            value(0)
        } else {
            LUMA.iter().enumerate().map(|(channel, weight)| weight * value(channel)).sum::<f64>() / LUMA_SUM
        };
        luma / if self.depth == 2 { f64::from(u16::MAX) } else { f64::from(u8::MAX) }
    }
}

fn check_size(width: u32, height: u32, shown: &str) -> Result<(), HeightPictureError> {
    let file = shown.to_owned();
    if width < 2 || height < 2 {
        return Err(HeightPictureError::TooFew { file, width, height });
    }
    let count = 2 * u64::from(width - 1) * u64::from(height - 1);
    if count > TriangleMesh::MOST_TRIANGLES as u64 {
        return Err(HeightPictureError::TooMany { file, width, height, count });
    }
    Ok(())
}
