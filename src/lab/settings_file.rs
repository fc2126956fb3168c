//! Settings from a RON file: `(hz: 120, substeps: 8)`, all other fields at the default preset's.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

use ron::error::SpannedError;
use ron::extensions::Extensions;
use serde::de::{Deserializer, Error as _, IgnoredAny, MapAccess, Visitor};

use crate::physics::{SettingsError, SolverSettings};

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
    #[error("{}:{}: {}", path.display(), .reason.span.start, .reason.code)]
    Malformed {
        /// The file.
        path: PathBuf,
        /// What the parser said, and where.
        reason: SpannedError,
    },
    /// A value out of its range.
    #[error("{}:{place}: {reason}", path.display())]
    OutOfRange {
        /// The file.
        path: PathBuf,
        /// Line and column.
        place: ron::error::Position,
        /// Which field.
        reason: SettingsError,
    },
}

/// Reads and checks settings.
///
/// # Errors
/// The file cannot be read or understood, or a value is out of its range.
pub fn read_settings(path: &Path) -> Result<SolverSettings, SettingsFileError> {
    let path = || path.to_owned();
    let text =
        std::fs::read_to_string(path()).map_err(|reason| SettingsFileError::Unreadable { path: path(), reason })?;
    let settings: SolverSettings =
        options().from_str(&text).map_err(|reason| SettingsFileError::Malformed { path: path(), reason })?;
    settings.validate().map_err(|reason| SettingsFileError::OutOfRange {
        path: path(),
        place: place_of(reason.field, &text),
        reason,
    })?;
    Ok(settings)
}

/// `correction_speed: 3.0` beside `Some(3.0)`.
fn options() -> ron::Options {
    ron::Options::default().with_default_extension(Extensions::IMPLICIT_SOME)
}

/// Where the value of a field of well-formed settings ends.
fn place_of(field: &'static str, text: &str) -> ron::error::Position {
    let stopped = ron::Deserializer::from_str_with_options(text, &options()).and_then(|mut ron| {
        ron.deserialize_struct("SolverSettings", &[], StopAt(field)).map_err(|error| ron.span_error(error))
    });
    stopped.map_or_else(|error| error.span.end, |()| ron::error::Position { line: 1, col: 1 })
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
            fields.next_value::<IgnoredAny>()?;
            if name == self.0 {
                return Err(A::Error::custom("here"));
            }
        }
        Ok(())
    }
}
