//! What may be said on the command line.

use std::path::{Path, PathBuf};

use clap::{Args, Parser};

use crate::lab::recording::{Recording, is_recording};
use crate::lab::sweep::Shard;
use crate::physics::SolverSettings;
use crate::scene;

use super::outcome::CommandError;
use super::settings::SettingsArguments;
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
    /// Run a scene on from one moment by several methods side by side, and say when and how they part
    Race(RaceArguments),
    /// Run a recording again, and say the first step and body that come out otherwise
    Replay(ReplayArguments),
    /// Draw a scene or a recording frame by frame off screen: a GIF, a picture, a folder of pictures
    Film(Box<FilmArguments>),
    /// Do anything that hands can do with a scene, at random, and say what breaks
    Monkey(Box<MonkeyArguments>),
    /// Find the cheapest settings that hold an error for a scene
    Fit(FitArguments),
}

#[derive(Args)]
pub(super) struct OpenArguments {
    /// A built-in scene, or the path of a RON file or of a recording (.plumb) [default: limbs]
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
    /// Write a recording to this file, which 'plumb replay' runs again
    #[arg(long, value_name = "FILE.plumb")]
    pub record: Option<PathBuf>,
    /// Write the ten hardest contact problems that 'accurate' solved, of ten steps, to this folder, a text file each
    #[arg(long, value_name = "DIR")]
    pub problems: Option<PathBuf>,
    /// Print one JSON object instead of a summary
    #[arg(long)]
    pub json: bool,
}

#[derive(Args)]
pub(super) struct ReplayArguments {
    /// A recording, as 'plumb run --record' and Ctrl+R in the window write it
    pub file: PathBuf,
}

#[derive(Args)]
pub(super) struct FilmArguments {
    /// A built-in scene, or the path of a RON file or of a recording (.plumb)
    scene: String,
    #[command(flatten)]
    parameters: ParameterArguments,
    #[command(flatten)]
    settings: SettingsArguments,
    /// Time of the first frame, s after the start of the scene
    #[arg(long, value_name = "T", default_value_t = 0.0, value_parser = not_negative, allow_negative_numbers = true)]
    from: f64,
    /// How long it is, s [default: to the end of the recording, or as long as the scene suggests]
    #[arg(long, value_name = "T", value_parser = positive, allow_negative_numbers = true)]
    seconds: Option<f64>,
    /// Frames a second
    #[arg(long, value_name = "N", default_value_t = 25, value_parser = clap::value_parser!(u32).range(1..=50), allow_negative_numbers = true)]
    fps: u32,
    /// Width and height, pixels
    #[arg(long, value_name = "WxH", default_value = "640x360", value_parser = size)]
    size: [u16; 2],
    /// A file .gif, a file .png for the end alone, or a folder for numbered pictures
    #[arg(long, value_name = "DIR|FILE")]
    out: PathBuf,
}

/// What is to be filmed; the settings are in range.
pub struct Filming {
    /// A built-in scene, or the path of a RON file or of a recording.
    pub scene: String,
    /// The parameters of a scene.
    pub parameters: Vec<(String, f64)>,
    /// The solver's settings.
    pub settings: SolverSettings,
    /// Time of the first frame, s.
    pub from: f64,
    /// How long it is, s, where that is given.
    pub seconds: Option<f64>,
    /// Frames a second.
    pub fps: f64,
    /// Width and height, pixels.
    pub size: [u16; 2],
    /// A file or a folder.
    pub out: PathBuf,
}

#[derive(Args)]
pub(super) struct MonkeyArguments {
    /// A built-in scene or the path of a RON file
    scene: String,
    #[command(flatten)]
    parameters: ParameterArguments,
    #[command(flatten)]
    settings: SettingsArguments,
    /// What is done follows from this number, the scene and the settings
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Steps to play for
    #[arg(long, value_name = "N", default_value_t = 3600, value_parser = clap::value_parser!(u64).range(1..=100_000_000))]
    steps: u64,
    /// Where to record what broke [default: SCENE-monkey-SEED.plumb]
    #[arg(long, value_name = "FILE.plumb")]
    out: Option<PathBuf>,
}

/// What a monkey is to play with; scene and settings make sense.
#[derive(Clone, Debug)]
pub struct MonkeyRun {
    /// A built-in scene or the path of a RON file.
    pub scene: String,
    /// Its parameters.
    pub parameters: Vec<(String, f64)>,
    /// The solver's settings.
    pub settings: SolverSettings,
    /// What is done follows from it.
    pub seed: u64,
    /// How long it plays, steps.
    pub steps: u64,
    /// Where what broke is recorded.
    pub out: PathBuf,
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
pub(super) struct RaceArguments {
    /// A built-in scene or the path of a RON file
    pub scene: String,
    #[command(flatten)]
    pub parameters: ParameterArguments,
    /// Presets or settings files (.ron), with commas between. Distances are from the scene's answer where that gives the
    /// whole motion and the race begins with the scene, else from the first
    #[arg(long, value_name = "A,B,…", value_delimiter = ',', required = true)]
    pub by: Vec<String>,
    /// When the race begins, s after the start of the scene, which runs by the first until then
    #[arg(long, value_name = "T", default_value_t = 0.0, value_parser = not_negative, allow_negative_numbers = true)]
    pub from: f64,
    /// Time to simulate, s [default: the scene's own]
    #[arg(long, value_name = "T", allow_negative_numbers = true)]
    pub seconds: Option<f64>,
    /// The distance whose first time is told, m
    #[arg(long, value_name = "D", default_value_t = 0.01, value_parser = positive, allow_negative_numbers = true)]
    pub apart: f64,
    /// Folder for SCENE-race.csv, .svg and .png
    #[arg(long, value_name = "DIR", default_value = "charts")]
    pub out: PathBuf,
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

impl OpenArguments {
    /// Checks what the sandbox is to open with: a window that closes again is no error message.
    pub fn resolve(self) -> Result<Open, CommandError> {
        let start = || scene::catalog().first().map_or_else(String::new, |first| first.name.to_owned());
        if let Some(scene) = &self.scene {
            refuse_beside_recording(scene, &self.parameters, &self.settings)?;
        }
        let open = Open {
            scene: self.scene.unwrap_or_else(start),
            parameters: self.parameters.list,
            settings: self.settings.resolve()?,
        };
        if is_recording(&open.scene) {
            let path = Path::new(&open.scene);
            Recording::read(path)?.start(path)?;
        } else {
            scene::load(&open.scene, &open.parameters)?;
        }
        Ok(open)
    }
}

impl FilmArguments {
    /// Checks what belongs together; whether the scene is there is seen when it is read.
    pub fn resolve(self) -> Result<Filming, CommandError> {
        let Self { scene, parameters, settings, from, seconds, fps, size, out } = self;
        refuse_beside_recording(&scene, &parameters, &settings)?;
        let settings = settings.resolve()?;
        Ok(Filming { scene, parameters: parameters.list, settings, from, seconds, fps: fps.into(), size, out })
    }
}

impl MonkeyArguments {
    /// Checks that there is such a scene.
    pub fn resolve(self) -> Result<MonkeyRun, CommandError> {
        let Self { scene, parameters, settings, seed, steps, out } = self;
        let (settings, parameters) = (settings.resolve()?, parameters.list);
        let name = scene::load(&scene, &parameters)?.name;
        let out = out.unwrap_or_else(|| format!("{name}-monkey-{seed}.plumb").into());
        Ok(MonkeyRun { scene, parameters, settings, seed, steps, out })
    }
}

/// A recording has them already.
fn refuse_beside_recording(
    scene: &str,
    parameters: &ParameterArguments,
    settings: &SettingsArguments,
) -> Result<(), CommandError> {
    if is_recording(scene) && (settings.is_given() || !parameters.list.is_empty()) {
        return Err(CommandError::Usage(format!("{scene}: a recording has its own parameters and settings")));
    }
    Ok(())
}

/// `640x360`.
fn size(text: &str) -> Result<[u16; 2], String> {
    const RANGE: std::ops::RangeInclusive<u16> = 16..=4096;
    let side = |text: &str| text.parse().ok().filter(|side| RANGE.contains(side));
    text.split_once('x')
        .and_then(|(width, height)| Some([side(width)?, side(height)?]))
        .ok_or_else(|| format!("a size is given as WIDTHxHEIGHT, each {} to {} pixels", RANGE.start(), RANGE.end()))
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

/// A time, or none.
fn not_negative(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(seconds) if seconds.is_finite() && seconds >= 0.0 => Ok(seconds),
        Ok(_) => Err("must be 0 or greater, and finite".into()),
        Err(_) => Err("not a number".into()),
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
