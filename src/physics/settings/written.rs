//! What a user wrote of the settings: `(method: exact, hz: 120)`, the rest as in a preset. What presets and sweeps leave
//! in a setting that the method does not read is nobody's word; what a user wrote is, and is refused.

use std::fmt;

use serde::Deserialize;
use serde::de::{Deserializer, Error, MapAccess, Visitor};

use super::{ExactIntegrator, Integrator, SETTINGS, Setting, SettingsError, SolverSettings};

/// Settings, and which of them a user wrote.
#[derive(Default)]
pub struct WrittenSettings {
    /// What they add up to.
    pub settings: SolverSettings,
    written: Vec<&'static Setting>,
}

impl WrittenSettings {
    /// Those of a preset: nothing is written yet.
    pub fn from_preset(settings: SolverSettings) -> Self {
        Self { settings, written: Vec::new() }
    }

    /// Takes one that was written, if it was: its [`Setting::path`], and where that is.
    pub fn write<T>(&mut self, path: &str, value: Option<T>, place: impl FnOnce(&mut SolverSettings) -> &mut T) {
        if let Some(value) = value {
            *place(&mut self.settings) = value;
            self.written.extend(SETTINGS.iter().find(|setting| setting.path == path));
        }
    }

    /// Checks that all that was written is read, and that all values are in their ranges.
    ///
    /// # Errors
    /// The first that is not.
    pub fn check(&self) -> Result<(), SettingsError> {
        let settings = self.settings;
        if let Some(unread) = self.written.iter().find(|setting| !setting.is_read(&settings)) {
            return Err(SettingsError::Unread { name: unread.name, problem: unread.why_unread(&settings) });
        }
        settings.validate()
    }
}

/// Two engines have integrators of their own, by the same name in files: the value tells whose is meant.
#[derive(Deserialize)]
#[serde(rename_all = "snake_case")]
enum AnyIntegrator {
    Euler,
    VelocityVerlet,
    Gauss,
    Rattle,
}

impl AnyIntegrator {
    fn put(self, settings: &mut SolverSettings) -> &'static str {
        let SolverSettings { sweeps, exact, .. } = settings;
        match self {
            Self::Euler => sweeps.integrator = Integrator::Euler,
            Self::VelocityVerlet => sweeps.integrator = Integrator::VelocityVerlet,
            Self::Gauss => exact.integrator = ExactIntegrator::Gauss,
            Self::Rattle => exact.integrator = ExactIntegrator::Rattle,
        }
        match self {
            Self::Euler | Self::VelocityVerlet => "sweeps.integrator",
            Self::Gauss | Self::Rattle => "exact.integrator",
        }
    }
}

impl<'de> Deserialize<'de> for WrittenSettings {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_struct("SolverSettings", &[], OnDefault)
    }
}

/// Reads what is written on top of the default preset.
struct OnDefault;

impl<'de> Visitor<'de> for OnDefault {
    type Value = WrittenSettings;

    fn expecting(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.write_str("solver settings")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<WrittenSettings, A::Error> {
        let WrittenSettings { mut settings, mut written } = WrittenSettings::default();
        while let Some(name) = map.next_key::<String>()? {
            let Some(setting) = SETTINGS.iter().find(|setting| setting.name == name) else {
                let names: Vec<_> = SETTINGS.iter().map(|setting| setting.name).collect();
                return Err(A::Error::custom(format!("no setting is named {name}; there are {}", names.join(", "))));
            };
            if written.iter().any(|known: &&Setting| known.name == name) {
                return Err(A::Error::duplicate_field(setting.name));
            }
            let path = if name == "integrator" {
                map.next_value::<AnyIntegrator>()?.put(&mut settings)
            } else {
                settings.take(setting.path, &mut map)?;
                setting.path
            };
            written.extend(SETTINGS.iter().find(|setting| setting.path == path));
        }
        Ok(WrittenSettings { settings, written })
    }
}
