//! Settings on the command line.

use std::path::{Path, PathBuf};

use clap::Args;
use serde::Deserialize;
use serde::de::IntoDeserializer;
use serde::de::value::StrDeserializer;

use crate::lab::settings_file::read_written;
use crate::lab::vary::{Assignment, write};
use crate::physics::{Method, Precision, SETTINGS, SolverSettings, WrittenSettings};

use super::outcome::CommandError;

/// A preset or a file, and single settings on top of it.
#[derive(Args)]
pub(super) struct SettingsArguments {
    /// Start from these settings: game (the default), steady (force-level sweeps), classic (the 2009 engine) or
    /// accurate (converges with the step)
    #[arg(long, value_name = "NAME", value_parser = preset, conflicts_with = "settings")]
    preset: Option<Preset>,
    /// Start from the settings in this RON file
    #[arg(long, value_name = "FILE")]
    settings: Option<PathBuf>,
    #[arg(long, value_name = "METHOD", value_parser = named::<Method>, help = help("method"))]
    method: Option<Method>,
    #[arg(long, allow_negative_numbers = true, help = help("hz"))]
    hz: Option<f64>,
    #[arg(long, value_name = "N", allow_negative_numbers = true, help = help("substeps"))]
    substeps: Option<u32>,
    #[arg(long, value_name = "N", allow_negative_numbers = true, help = help("iterations"))]
    iterations: Option<u32>,
    #[arg(long, value_name = "SCALAR", value_parser = named::<Precision>, help = help("precision"))]
    precision: Option<Precision>,
    #[arg(long, value_name = "N", allow_negative_numbers = true, help = help("threads"))]
    threads: Option<u32>,
    /// Change any setting of docs/settings.md; may be repeated, and comes last
    #[arg(long, value_name = "NAME=VALUE", value_parser = setting)]
    pub set: Vec<Assignment>,
}

/// A preset by its name.
type Preset = (&'static str, fn() -> SolverSettings);

/// What a setting is, in the words of its doc comment; of a choice, also what there is to choose from.
fn help(path: &str) -> String {
    let setting = SETTINGS.iter().find(|setting| setting.path == path).expect("a setting of the table");
    let choices = setting.choices.iter().map(|choice| format!("\n- {}: {}", choice.name, choice.help()));
    setting.help() + &choices.collect::<String>()
}

impl SettingsArguments {
    /// The settings they add up to, all read and in range.
    pub fn resolve(&self) -> Result<SolverSettings, CommandError> {
        let mut written = match &self.settings {
            Some(path) => read_written(path, self.chosen_method())?,
            None => WrittenSettings::from_preset(self.preset.map(|(_, preset)| preset()).unwrap_or_default()),
        };
        written.write("method", self.method, |settings| &mut settings.method);
        written.write("hz", self.hz, |settings| &mut settings.hz);
        written.write("substeps", self.substeps, |settings| &mut settings.substeps);
        written.write("iterations", self.iterations, |settings| &mut settings.iterations);
        written.write("precision", self.precision, |settings| &mut settings.precision);
        written.write("threads", self.threads, |settings| &mut settings.threads);
        self.set.iter().for_each(|assignment| write(assignment, &mut written));
        written.check()?;
        Ok(written.settings)
    }

    /// The method that takes the place of a file's.
    fn chosen_method(&self) -> Option<Method> {
        let mut settings = SolverSettings::default();
        let mut set = self.set.iter().filter(|assignment| assignment.name() == "method");
        let last = set.next_back().map(|assignment| {
            assignment.put_in(&mut settings);
            settings.method
        });
        last.or(self.method)
    }

    /// Whether any is given.
    pub fn is_given(&self) -> bool {
        self.preset.is_some() || self.settings.is_some() || !self.changes().is_empty()
    }

    /// What they are called in a legend: where they come from, and what is changed.
    pub fn name(&self) -> String {
        let file = self.settings.as_deref().and_then(Path::file_stem).map(|stem| stem.to_string_lossy().into_owned());
        let preset = self.preset.map_or(SolverSettings::PRESETS[0].0, |(name, _)| name);
        let start = file.unwrap_or_else(|| preset.to_owned());
        std::iter::once(start).chain(self.changes()).collect::<Vec<_>>().join(", ")
    }

    /// What is changed, as `--set` has it.
    fn changes(&self) -> Vec<String> {
        let method = self.method.map(|method| format!("method={}", method.name()));
        let hz = self.hz.map(|hz| format!("hz={hz}"));
        let precision = self.precision.map(|precision| format!("precision={}", precision.name()));
        let counts = [("substeps", self.substeps), ("iterations", self.iterations), ("threads", self.threads)];
        let counts = counts.into_iter().filter_map(|(name, count)| Some(format!("{name}={}", count?)));
        let own = method.into_iter().chain(hz).chain(precision).chain(counts);
        own.chain(self.set.iter().map(Assignment::to_string)).collect()
    }
}

fn preset(name: &str) -> Result<Preset, String> {
    SolverSettings::PRESETS.into_iter().find(|(known, _)| *known == name).ok_or_else(|| {
        let names: Vec<&str> = SolverSettings::PRESETS.iter().map(|(name, _)| *name).collect();
        format!("the presets are {}", names.join(", "))
    })
}

/// `baumgarte=0.2`.
fn setting(text: &str) -> Result<Assignment, String> {
    Assignment::parse(text, None).map_err(|error| error.to_string())
}

/// A choice by the name it has in settings files.
fn named<T: for<'a> Deserialize<'a>>(name: &str) -> Result<T, String> {
    let deserializer: StrDeserializer<serde::de::value::Error> = name.into_deserializer();
    T::deserialize(deserializer).map_err(|error| error.to_string())
}
