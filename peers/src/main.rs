//! Plumb and other rigid-body engines on the same scenes, measured by the same code in one process.

mod accuracy;
mod engine;
mod joint;
mod load;
mod metrics;
mod overlap;
mod plan;
mod precision;
mod record;
mod scene;
mod speed;
mod statistics;
mod suite;
mod table;
mod threads;

use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Parser, Subcommand, value_parser};
use serde::Serialize;

use engine::{EngineKind, Settings};
use plan::{Plan, Report};
use record::Row;
use scene::Scene;

/// Measures Plumb and other engines on the same scenes, in alternation in one process.
#[derive(Parser)]
#[command(version)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
    /// Scenes, separated by commas, each a name and parameters: 'pyramid 40, joint_grid n=100 tilt=30'
    #[arg(long, global = true)]
    scenes: Option<String>,
    /// Engines, separated by commas: plumb, plumb:PRESET, rapier, box3d, avian [default: plumb and all peers]
    #[arg(long, global = true, value_delimiter = ',')]
    engines: Vec<EngineKind>,
    /// Threads a step may use
    #[arg(long, global = true, default_value_t = 1, value_parser = value_parser!(u32).range(1..=32))]
    threads: u32,
    /// Steps a second
    #[arg(long, global = true, default_value_t = 60.0, value_parser = positive)]
    hz: f64,
    /// Substeps of every engine, Plumb included [default: what each recommends]
    #[arg(long, global = true, value_parser = value_parser!(u32).range(1..=1000))]
    substeps: Option<u32>,
    /// Time to simulate, s [default: the command's own for each scene]
    #[arg(long, global = true, value_parser = positive)]
    seconds: Option<f64>,
    /// Let sleep what is at rest: off unless asked for
    #[arg(long, global = true)]
    sleep: bool,
    /// 'speed': the scenes of Box3D's own benchmark, or those of them in --scenes, for its numbers of steps, with 4 substeps
    #[arg(long, global = true)]
    suite: bool,
    /// How often the engines take turns
    #[arg(long, global = true, default_value_t = 9, value_parser = value_parser!(u32).range(1..))]
    rounds: u32,
    /// Print one JSON object instead of tables
    #[arg(long, global = true)]
    json: bool,
    /// Also write COMMAND.csv into this folder
    #[arg(long, global = true, value_name = "DIR")]
    out: Option<PathBuf>,
}

#[derive(Subcommand, Clone, Copy)]
enum Command {
    /// What a step costs
    Speed,
    /// How far off the engines are at their recommended settings
    Accuracy,
    /// Error against cost as the step gets smaller
    Precision,
}

/// What `--json` prints.
#[derive(Serialize)]
struct Output<'a> {
    machine: &'a Machine,
    rows: &'a [Row],
}

/// What the numbers depend on besides the code.
#[derive(Serialize)]
struct Machine {
    cpu: String,
    cores: usize,
    simd: &'static str,
}

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("peers: {error}");
            ExitCode::from(2)
        }
    }
}

fn run(arguments: &Arguments) -> Result<(), Box<dyn Error>> {
    check_build()?;
    threads::size_pools(arguments.threads);
    let (name, default_scenes, measure): (_, _, fn(&Plan) -> Report) = match arguments.command {
        Command::Speed => ("speed", speed::SCENES, speed::measure),
        Command::Accuracy => ("accuracy", accuracy::SCENES, accuracy::measure),
        Command::Precision => ("precision", precision::SCENES, precision::measure),
    };
    if arguments.suite && name != "speed" {
        return Err(format!("--suite is for 'speed', not '{name}'; give --scenes").into());
    }
    let scenes = match &arguments.scenes {
        Some(scenes) => scenes.split(',').map(Scene::parse).collect::<Result<_, _>>()?,
        None if arguments.suite => suite::SUITE.iter().map(|of| Scene::parse(of.scene)).collect::<Result<_, _>>()?,
        None => default_scenes.split(',').map(Scene::parse).collect::<Result<_, _>>()?,
    };
    let plan = Plan {
        scenes,
        engines: if arguments.engines.is_empty() { EngineKind::standard() } else { arguments.engines.clone() },
        settings: Settings {
            hz: arguments.hz,
            substeps: arguments.substeps.or(arguments.suite.then_some(suite::SUBSTEPS)),
            threads: arguments.threads,
            sleep: arguments.sleep,
        },
        suite: arguments.suite,
        rounds: arguments.rounds,
        seconds: arguments.seconds,
    };
    let machine = Machine::here();
    if !arguments.json {
        println!("{}", machine.describe(&plan));
    }
    let report = measure(&plan);
    if arguments.json {
        println!("{}", serde_json::to_string_pretty(&Output { machine: &machine, rows: &report.rows })?);
    } else {
        println!("{}", report.text);
    }
    if let Some(directory) = &arguments.out {
        record::write_csv(&report.rows, directory, name)
            .map_err(|error| format!("{}: cannot be written: {error}", directory.display()))?;
    }
    Ok(())
}

/// Numbers from a slow build would be wrong numbers.
fn check_build() -> Result<(), &'static str> {
    if cfg!(debug_assertions) {
        return Err("this is a debug build; measure with 'cargo run --profile measure -p peers'");
    }
    if !cfg!(all(target_feature = "avx2", target_feature = "fma")) {
        return Err("built without AVX2 and FMA; build inside the repository and without RUSTFLAGS, so that \
                    .cargo/config.toml holds");
    }
    Ok(())
}

impl Machine {
    fn here() -> Self {
        let info = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
        let model = info.lines().find_map(|line| line.strip_prefix("model name")?.split_once(':'));
        Self {
            cpu: model.map_or_else(|| std::env::consts::ARCH.to_owned(), |(_, name)| name.trim().to_owned()),
            cores: std::thread::available_parallelism().map_or(1, usize::from),
            simd: "avx2+fma",
        }
    }

    fn describe(&self, plan: &Plan) -> String {
        let Self { cpu, cores, simd } = self;
        let mut lines =
            vec![format!("{cpu}, {cores} cores, {simd}; {} Hz, threads {}", plan.settings.hz, plan.settings.threads)];
        for kind in &plan.engines {
            let engine::Method { version, precision, substeps, iterations } = kind.method(&plan.settings);
            lines.push(format!("{kind} {version}: {precision}, substeps {substeps}, iterations {iterations}"));
        }
        lines.push(String::new());
        lines.join("\n")
    }
}

fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(number) if number.is_finite() && number > 0.0 => Ok(number),
        Ok(_) => Err("must be greater than 0 and finite".into()),
        Err(_) => Err("not a number".into()),
    }
}
