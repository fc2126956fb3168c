//! What may be said on the command line.

use std::path::{Path, PathBuf};

use clap::{Args, Parser};
use serde::Deserialize;
use serde::de::IntoDeserializer;
use serde::de::value::StrDeserializer;

use crate::lab::settings_file::read_written;
use crate::lab::sweep::Shard;
use crate::lab::vary::{Assignment, write};
use crate::physics::{Method, Precision, SETTINGS, SolverSettings, WrittenSettings};
use crate::scene;

use super::outcome::CommandError;
use super::vary::VaryArguments;

/// A rigid-body sandbox that says how true it is and what that cost.
///
/// `plumb [SCENE]` opens the sandbox; the commands below need no window.
#[derive(Parser)]
#[command(name = "plumb", version, args_conflicts_with_subcommands = true)]
pub(super) struct Arguments {
    #[command(subcommand)]
    pub subcommand: Option<Subcommand>,
    #[command(flatten)]
    pub open: OpenArguments,
}

#[derive(clap::Subcommand)]
pub(super) enum Subcommand {
    /// List the built-in scenes, their parameters and what is known of their answers
    Scenes,
    /// Simulate a scene without a window and say what it did, how true it was and what it cost
    Run(Box<RunArguments>),
    /// Write a scene as a RON file that loads back to the same states
    Export(ExportArguments),
    /// Measure error against cost over many settings and draw both on one chart a scene
    Chart(ChartArguments),
    /// Map where methods hold, degrade and fail over two parameters of a scene
    Map(MapArguments),
    /// Find the cheapest settings that hold an error for a scene
    Fit(FitArguments),
}

#[derive(Args)]
pub(super) struct OpenArguments {
    /// A built-in scene or the path of a RON file [default: limbs]
    scene: Option<String>,
    #[command(flatten)]
    parameters: ParameterArguments,
    #[command(flatten)]
    settings: SettingsArguments,
}

/// What the sandbox opens with; the scene exists and its parameters are in range.
pub struct Open {
    /// A built-in scene or the path of a RON file.
    pub scene: String,
    /// Its parameters.
    pub parameters: Vec<(String, f64)>,
    /// The solver's settings.
    pub settings: SolverSettings,
}

#[derive(Args)]
pub(super) struct RunArguments {
    /// A built-in scene or the path of a RON file
    pub scene: String,
    #[command(flatten)]
    pub parameters: ParameterArguments,
    #[command(flatten)]
    pub settings: SettingsArguments,
    /// Time to simulate, s [default: the scene's own]
    #[arg(long, value_name = "T", allow_negative_numbers = true)]
    pub seconds: Option<f64>,
    /// Write the trajectory, one row per body and time, to this CSV file
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Time between the rows of the trajectory, s [default: every step]
    #[arg(long, value_name = "DT", requires = "out", value_parser = positive, allow_negative_numbers = true)]
    pub every: Option<f64>,
    /// Print one JSON object instead of a summary
    #[arg(long)]
    pub json: bool,
}

#[derive(Args)]
pub(super) struct ChartArguments {
    /// Built-in scenes or paths of RON files [default: all built-in scenes]
    pub scenes: Vec<String>,
    #[command(flatten)]
    pub parameters: ParameterArguments,
    /// Few points and short runs: all scenes within minutes
    #[arg(long)]
    pub quick: bool,
    #[command(flatten)]
    pub vary: VaryArguments,
    /// Measure points that are in points.csv once more; the later measurement counts
    #[arg(long)]
    pub again: bool,
    #[command(flatten)]
    pub sweep: SweepArguments,
    /// Draw what other engines did, from the folder that the peers crate wrote
    #[arg(long, value_name = "DIR", conflicts_with = "vary")]
    pub peers: Option<PathBuf>,
}

#[derive(Args)]
pub(super) struct MapArguments {
    /// Scenes that have a map, or any one with --vary [default: all that have one]
    pub scenes: Vec<String>,
    #[command(flatten)]
    pub parameters: ParameterArguments,
    #[command(flatten)]
    pub vary: VaryArguments,
    #[command(flatten)]
    pub sweep: SweepArguments,
}

#[derive(Args)]
pub(super) struct FitArguments {
    /// A built-in scene
    pub scene: String,
    #[command(flatten)]
    pub parameters: ParameterArguments,
    /// Largest error to hold, in the unit of the scene's answer
    #[arg(long, value_name = "E", value_parser = positive, allow_negative_numbers = true)]
    pub error: f64,
    /// Time to simulate, s [default: the scene's own]
    #[arg(long, value_name = "T", allow_negative_numbers = true)]
    pub seconds: Option<f64>,
    /// Folder for points.csv and the settings file
    #[arg(long, value_name = "DIR", default_value = "charts")]
    pub out: PathBuf,
}

/// Where a sweep's results go, and which share of it to do.
#[derive(Args)]
pub(super) struct SweepArguments {
    /// Folder for pictures and points.csv; points that are in it are not measured again
    #[arg(long, value_name = "DIR", default_value = "charts")]
    pub out: PathBuf,
    /// Measure only the I-th of N shares
    #[arg(long, value_name = "I/N", default_value = "1/1")]
    pub shard: Shard,
}

#[derive(Args)]
pub(super) struct ExportArguments {
    /// A built-in scene or the path of a RON file
    pub scene: String,
    #[command(flatten)]
    pub parameters: ParameterArguments,
    /// Write to this file instead of standard output; mesh files are named relative to it
    #[arg(long, value_name = "FILE.ron")]
    pub out: Option<PathBuf>,
}

#[derive(Args)]
pub(super) struct ParameterArguments {
    /// Set a parameter of a built-in scene; may be repeated
    #[arg(short = 'p', long = "parameter", value_name = "NAME=VALUE", value_parser = assignment)]
    pub list: Vec<(String, f64)>,
}

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

impl OpenArguments {
    /// Checks what the sandbox is to open with: a window that closes again is no error message.
    pub fn resolve(self) -> Result<Open, CommandError> {
        let start = || scene::catalog().first().map_or_else(String::new, |first| first.name.to_owned());
        let open = Open {
            scene: self.scene.unwrap_or_else(start),
            parameters: self.parameters.list,
            settings: self.settings.resolve()?,
        };
        scene::load(&open.scene, &open.parameters)?;
        Ok(open)
    }
}

/// `n=40`.
fn assignment(text: &str) -> Result<(String, f64), String> {
    let (name, value) = text.split_once('=').ok_or("a parameter is given as NAME=VALUE")?;
    if name.is_empty() {
        return Err("a parameter is given as NAME=VALUE, and the name is missing".into());
    }
    match value.parse::<f64>() {
        Ok(number) if number.is_finite() => Ok((name.to_owned(), number)),
        Ok(_) => Err(format!("{name} must be finite")),
        Err(_) => Err(format!("'{value}' is not a number")),
    }
}

/// A time or an error.
fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(seconds) if seconds.is_finite() && seconds > 0.0 => Ok(seconds),
        Ok(_) => Err("must be greater than 0 and finite".into()),
        Err(_) => Err("not a number".into()),
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
