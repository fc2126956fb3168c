//! Settings from a RON file: `(hz: 120, substeps: 8)`, all others at the default preset's.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

use ron::error::Position;
use ron::extensions::Extensions;
use ron::ser::PrettyConfig;
use serde::de::{Deserializer, Error as _, IgnoredAny, MapAccess, Visitor};

use super::whole_file::write_whole;
use crate::physics::{Method, SettingsError, SolverSettings, WrittenSettings};

/// Why there are no settings, in one line that names the place.
#[derive(Debug, thiserror::Error)]
pub enum SettingsFileError {
    /// No such file, or no right to read it.
    #[error("{}: cannot be read: {reason}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the system said.
        reason: io::Error,
    },
    /// Not RON, a wrong type, an unknown field.
    #[error("{}:{place}: {problem}", path.display())]
    Malformed {
        /// The file.
        path: PathBuf,
        /// Line and column.
        place: Position,
        /// What the parser said.
        problem: String,
    },
    /// A value out of its range, or of a setting that the method does not read.
    #[error("{}:{place}: {reason}", path.display())]
    Refused {
        /// The file.
        path: PathBuf,
        /// Line and column.
        place: Position,
        /// Which setting.
        reason: SettingsError,
    },
}

/// Reads and checks settings.
///
/// # Errors
/// The file cannot be read or understood, has a setting that its method does not read, or a value out of its range.
pub fn read_settings(path: &Path) -> Result<SolverSettings, SettingsFileError> {
    Ok(read_written(path, None)?.settings)
}

/// The same, with another method if one is given, and with what the user wrote.
pub(super) fn read_written(path: &Path, method: Option<Method>) -> Result<WrittenSettings, SettingsFileError> {
    let text = std::fs::read_to_string(path)
        .map_err(|reason| SettingsFileError::Unreadable { path: path.to_owned(), reason })?;
    let mut written: WrittenSettings = options().from_str(&text).map_err(|error| SettingsFileError::Malformed {
        path: path.to_owned(),
        place: error.span.start,
        problem: error.code.to_string(),
    })?;
    written.settings.method = method.unwrap_or(written.settings.method);
    written.check().map_err(|reason| SettingsFileError::Refused {
        path: path.to_owned(),
        place: place_of(reason.name(), &text),
        reason,
    })?;
    Ok(written)
}
/// Writes those settings that the method reads to a file that [`read_settings`] reads, one a line.
///
/// # Errors
/// The file cannot be written.
pub fn write_settings(path: &Path, settings: &SolverSettings) -> io::Result<()> {
    write_whole(path, &settings_text(settings))
}

/// What [`write_settings`] writes.
pub fn settings_text(settings: &SolverSettings) -> String {
    let text = options().to_string_pretty(settings, PrettyConfig::new()).expect("numbers and names always have a text");
    text + "\n"
}

/// All settings that the method reads on one line, as a settings file may have them.
pub(super) fn settings_to_ron(settings: &SolverSettings) -> String {
    options().to_string(settings).expect("numbers and names always have a text")
}

/// Settings from such a line.
pub(super) fn settings_from_ron(text: &str) -> Result<SolverSettings, ron::error::SpannedError> {
    options().from_str::<WrittenSettings>(text).map(|written| written.settings)
}

/// `correction_speed: 3.0` beside `Some(3.0)`.
fn options() -> ron::Options {
    ron::Options::default().with_default_extension(Extensions::IMPLICIT_SOME)
}

/// Where a field of well-formed settings stands.
fn place_of(field: &'static str, text: &str) -> Position {
    let stopped = ron::Deserializer::from_str_with_options(text, &options()).and_then(|mut ron| {
        ron.deserialize_struct("SolverSettings", &[], StopAt(field)).map_err(|error| ron.span_error(error))
    });
    stopped.map_or_else(|error| error.span.start, |()| Position { line: 1, col: 1 })
}

/// Reads a struct up to a field and fails there: only an error carries the parser's position.
struct StopAt(&'static str);

impl<'de> Visitor<'de> for StopAt {
    type Value = ();

    fn expecting(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.write_str("solver settings")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut fields: A) -> Result<(), A::Error> {
        while let Some(name) = fields.next_key::<String>()? {
            if name == self.0 {
                return Err(A::Error::custom("here"));
            }
            fields.next_value::<IgnoredAny>()?;
        }
        Ok(())
    }
}
