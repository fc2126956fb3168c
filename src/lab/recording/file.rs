//! The file of a recording.
//!
//! ```text
//! plumb recording 1
//! build 0.1.0 x86_64
//! scene 812 limbs           how many bytes of a scene file follow, and its name
//! settings (hz: 60, …)      as a settings file has them
//! reads forces              or nothing
//! print 7c… 04f1…           fingerprints of the world and its bodies after 0, 1, 2 … steps
//! deeds (written: […], …)   what was done after the step before, before the next
//! end
//! ```

use std::path::{Path, PathBuf};

use super::error::{FIRST_WORDS, RecordingError, VERSION};
use super::print::Print;
use crate::lab::settings_file::settings_to_ron;
use crate::lab::write_whole;
use crate::physics::SolverSettings;
use crate::scene::{SceneError, SceneSpec};

/// What was read while it ran.
const FORCES: &str = "forces";
const NOTHING: &str = "nothing";

/// What happened to a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    /// Version and processor of the build that made it.
    pub build: String,
    /// The scene's name.
    pub name: String,
    /// The scene, as the text of its file.
    pub scene: String,
    /// The settings at its start, on one line.
    pub settings: String,
    /// Whether somebody read the forces of contacts: then what rests is solved in steps in which nothing changes, too, which
    /// its last bits tell.
    pub reads_forces: bool,
    /// After 0, 1, 2 … steps.
    pub prints: Vec<Print>,
    /// What was done after so many steps, as [text](super::deeds).
    pub deeds: Vec<(u64, String)>,
}

/// What the name of its file ends with.
pub const EXTENSION: &str = "plumb";

/// Whether a file of that name is a recording.
pub fn is_recording(name: &str) -> bool {
    Path::new(name).extension().is_some_and(|extension| extension == EXTENSION)
}

/// Version and processor.
fn this_build() -> String {
    format!("{} {}", env!("CARGO_PKG_VERSION"), std::env::consts::ARCH)
}

impl Recording {
    /// Of a scene of which nothing is known yet.
    ///
    /// # Errors
    /// The scene cannot be written.
    pub fn new(scene: &SceneSpec, settings: &SolverSettings) -> Result<Self, SceneError> {
        Ok(Self {
            build: this_build(),
            name: scene.name.clone(),
            scene: scene.to_ron(None)?,
            settings: settings_to_ron(settings),
            reads_forces: false,
            prints: Vec::new(),
            deeds: Vec::new(),
        })
    }

    /// Steps that it tells.
    pub fn steps(&self) -> u64 {
        (self.prints.len() as u64).saturating_sub(1)
    }

    /// Whether this build made it.
    pub fn is_of_this_build(&self) -> bool {
        self.build == this_build()
    }

    /// The text of its file.
    pub fn text(&self) -> String {
        let Self { build, name, scene, settings, reads_forces, prints, deeds } = self;
        let mut text = format!("{FIRST_WORDS}{VERSION}\nbuild {build}\n");
        text += &format!("scene {} {}\n{scene}\n", scene.len(), name.replace('\n', " "));
        let reads = if *reads_forces { FORCES } else { NOTHING };
        text += &format!("settings {settings}\nreads {reads}\n");
        let mut deeds = deeds.iter().peekable();
        for (step, print) in (0..).zip(prints) {
            text += &format!("print {}\n", print.text());
            while let Some((_, deed)) = deeds.next_if(|(after, _)| *after == step) {
                text += &format!("deeds {deed}\n");
            }
        }
        text + "end\n"
    }

    /// Writes its file, whole. How many bytes it takes.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn write(&self, path: &Path) -> std::io::Result<usize> {
        let text = self.text();
        write_whole(path, &text)?;
        Ok(text.len())
    }

    /// Reads a file.
    ///
    /// # Errors
    /// It cannot be read, is no recording or one of another format, was cut short, or has a line that makes no sense.
    pub fn read(path: &Path) -> Result<Self, RecordingError> {
        let text = std::fs::read_to_string(path)
            .map_err(|reason| RecordingError::Unreadable { path: path.to_owned(), reason })?;
        Lines { path: path.to_owned(), rest: &text, line: 0 }.recording()
    }
}

/// A file that is being read.
struct Lines<'a> {
    path: PathBuf,
    rest: &'a str,
    /// The last that was read, from 1.
    line: usize,
}

impl<'a> Lines<'a> {
    fn recording(mut self) -> Result<Recording, RecordingError> {
        let first = self.rest.lines().next().unwrap_or_default();
        let Some(version) = first.strip_prefix(FIRST_WORDS) else {
            return Err(RecordingError::NoRecording { path: self.path });
        };
        if version != VERSION {
            return Err(RecordingError::OtherVersion { path: self.path, version: version.to_owned() });
        }
        self.next(0)?;
        let build = self.after("build ")?.to_owned();
        let head = self.after("scene ")?;
        let (length, name) = head.split_once(' ').unwrap_or((head, ""));
        let scene = self.block(length)?.to_owned();
        let settings = self.after("settings ")?.to_owned();
        let reads_forces = match self.after("reads ")? {
            FORCES => true,
            NOTHING => false,
            _ => return Err(self.malformed("expected 'forces' or 'nothing'")),
        };
        let (mut prints, mut deeds) = (Vec::new(), Vec::new());
        loop {
            let line = self.next(prints.len())?;
            if line == "end" {
                break;
            } else if let Some(print) = line.strip_prefix("print ") {
                prints.push(Print::parse(print).ok_or_else(|| self.malformed("no fingerprints of 16 and 4 digits"))?);
            } else if let (Some(deed), Some(step)) = (line.strip_prefix("deeds "), prints.len().checked_sub(1)) {
                deeds.push((step as u64, deed.to_owned()));
            } else {
                return Err(self.malformed("expected a line of 'print', 'deeds' or 'end'"));
            }
        }
        if prints.is_empty() {
            return Err(self.malformed("it has no step"));
        }
        Ok(Recording { build, name: name.to_owned(), scene, settings, reads_forces, prints, deeds })
    }

    /// The next line, whole, of a file that has had so many fingerprints.
    fn next(&mut self, prints: usize) -> Result<&'a str, RecordingError> {
        let cut = || RecordingError::Cut { path: self.path.clone(), steps: prints.saturating_sub(1) };
        let (line, rest) = self.rest.split_once('\n').ok_or_else(cut)?;
        self.rest = rest;
        self.line += 1;
        Ok(line)
    }

    /// What the next line has after a word.
    fn after(&mut self, word: &str) -> Result<&'a str, RecordingError> {
        let line = self.next(0)?;
        line.strip_prefix(word).ok_or_else(|| self.malformed(&format!("expected a line of '{}'", word.trim())))
    }

    /// So many bytes and the end of a line.
    fn block(&mut self, length: &str) -> Result<&'a str, RecordingError> {
        let length: usize = length.parse().map_err(|_| self.malformed("expected how many bytes follow"))?;
        if self.rest.len() <= length {
            return Err(RecordingError::Cut { path: self.path.clone(), steps: 0 });
        }
        let is_whole = self.rest.is_char_boundary(length) && self.rest[length..].starts_with('\n');
        if !is_whole {
            return Err(self.malformed("what follows is longer or shorter than that"));
        }
        let block = &self.rest[..length];
        self.rest = &self.rest[length + 1..];
        self.line += block.matches('\n').count() + 1;
        Ok(block)
    }

    fn malformed(&self, problem: &str) -> RecordingError {
        RecordingError::Malformed { path: self.path.clone(), line: self.line, problem: problem.to_owned() }
    }
}
