//! The present scene's chart, of error against cost or of error over something that varies: measured by a process of its
//! own, so that game and measurement do not spoil each other, with marks where the present settings stand.

mod plot;

use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use bevy::prelude::*;
use bevy_egui::egui;

use super::vary;
use crate::lab::chart::{Extent, POINTS, Subject};
use crate::lab::sweep::{Point, Record, read_records};
use crate::lab::vary::{Candidate, Curves, Study, Variation};
use crate::lab::{read_settings, write_settings};
use crate::physics::{ImpulseSettings, SolverSettings, StepStats};
use crate::sandbox::{CurrentScene, Notice, SandboxAction};
use plot::{Dot, PresentCost, draw, legend};

/// How often the file of a measurement at work is read.
const READ_EVERY: Duration = Duration::from_millis(500);

/// Who measures charts, and where they are kept.
#[derive(Resource, Clone, Debug)]
pub struct ChartSource {
    /// The program, called as `plumb chart SCENE --quick --out FOLDER`.
    pub program: PathBuf,
    /// The folder.
    pub folder: PathBuf,
}

/// What the chart is of.
#[derive(Resource, Clone, Debug, Default, PartialEq)]
pub enum ChartOf {
    /// The charts' methods, with several steps and sweeps: error against cost.
    #[default]
    Methods,
    /// The settings that the sandbox has when this is chosen, with one thing varied, as `plumb chart --vary` has it:
    /// error over its values.
    Varied(String),
}

/// The chart on view.
#[derive(Resource, Default)]
pub(super) struct SceneChart {
    /// What varies, unless methods are compared.
    curves: Option<Curves>,
    points: Vec<Point>,
    /// Each with the index of its point.
    records: Vec<(usize, Record)>,
    measuring: Option<Measuring>,
}

/// A measurement at work; ends with the sandbox.
struct Measuring {
    child: Child,
    read: Instant,
    /// The rows of the file before this one are of earlier measurements.
    since: usize,
    /// Points of the chart that it has, those among them that it found in the file.
    measured: usize,
}

impl Drop for Measuring {
    fn drop(&mut self) {
        // It may have ended by itself; then there is nothing to do.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

pub(super) fn plugin(app: &mut App) {
    app.insert_resource(ChartSource {
        program: std::env::current_exe().unwrap_or_default(),
        folder: PathBuf::from("charts"),
    })
    .init_resource::<SceneChart>()
    .init_resource::<ChartOf>()
    .add_systems(PreUpdate, (follow_scene, follow_measurement).chain());
}

fn subject(scene: &CurrentScene) -> Subject {
    Subject { scene: scene.scene.clone(), parameters: scene.parameters.clone() }
}

impl SceneChart {
    /// Reads what the file has of the scene's quick chart.
    fn read(&mut self, source: &ChartSource) {
        let rows = read_records(&source.folder.join(POINTS), &source.program);
        let keys: Vec<String> = self.points.iter().map(Point::key).collect();
        if let Some(measuring) = &mut self.measuring {
            let new = rows.get(measuring.since..).unwrap_or_default();
            measuring.measured = keys.iter().filter(|key| new.iter().any(|row| row.key == **key)).count();
        }
        let latest = |(index, key): (usize, &String)| {
            let record = rows.iter().rev().find(|row| row.key == *key)?;
            Some((index, Record { series: self.points[index].series.clone(), ..record.clone() }))
        };
        self.records = keys.iter().enumerate().filter_map(latest).collect();
    }

    /// Whether what varies does so on that scene.
    fn is_of(&self, scene: &CurrentScene) -> bool {
        let study = self.curves.as_ref().map(|curves| &curves.study);
        study.is_some_and(|study| study.scene == scene.scene && study.parameters == scene.parameters)
    }

    /// Whether every point is measured.
    fn is_whole(&self) -> bool {
        !self.points.is_empty() && self.records.len() == self.points.len()
    }
}

fn follow_scene(
    scene: Option<Res<CurrentScene>>,
    source: Res<ChartSource>,
    settings: Res<SolverSettings>,
    mut of: ResMut<ChartOf>,
    mut chart: ResMut<SceneChart>,
    mut notice: ResMut<Notice>,
) {
    let Some(scene) = scene.filter(|scene| scene.is_changed() || of.is_changed()) else { return };
    let is_new = of.is_changed();
    let curves = match &*of {
        ChartOf::Methods => None,
        // What varied before varies on, with the settings from then.
        ChartOf::Varied(_) if !is_new && chart.is_of(&scene) => return,
        ChartOf::Varied(text) => match curves(&scene, text, &settings, &source) {
            Ok(curves) => Some(curves),
            Err(problem) => {
                *notice = Notice::Error(problem);
                *of = ChartOf::Methods;
                None
            }
        },
    };
    let points = match &curves {
        Some(curves) => curves.points(),
        None => subject(&scene).points(Extent::Quick).unwrap_or_default(),
    };
    if points != chart.points {
        *chart = SceneChart { curves, points, ..default() };
        chart.read(&source);
    }
}

/// The file with the settings that are varied, in the folder of the charts.
const VARIED_SETTINGS: &str = "varied.ron";

/// What `plumb chart --vary TEXT` draws of the settings, which it reads from a file.
fn curves(scene: &CurrentScene, text: &str, settings: &SolverSettings, source: &ChartSource) -> Result<Curves, String> {
    let x = Variation::parse(text, crate::scene::find(&scene.scene)).map_err(|error| error.to_string())?;
    let path = source.folder.join(VARIED_SETTINGS);
    let written = std::fs::create_dir_all(&source.folder);
    // Points are measured on one thread.
    let settings = SolverSettings { threads: 1, ..*settings };
    let written = written.and_then(|()| write_settings(&path, &settings));
    written.map_err(|error| format!("{}: cannot be written: {error}", path.display()))?;
    let settings = read_settings(&path).map_err(|error| error.to_string())?;
    let candidates = vec![Candidate::new("varied", settings)];
    let study = Study::new(&scene.scene, &scene.parameters, candidates, None).map_err(|error| error.to_string())?;
    study.check(&[&x]).map_err(|error| error.to_string())?;
    let seconds = Extent::Quick.seconds(study.seconds);
    Ok(Curves { study: Study { seconds, ..study }, x })
}

fn follow_measurement(source: Res<ChartSource>, mut chart: ResMut<SceneChart>, mut notice: ResMut<Notice>) {
    let Some(measuring) = &mut chart.bypass_change_detection().measuring else { return };
    let ended = measuring.child.try_wait().map(|status| status.map(|status| status.success()));
    if !matches!(ended, Ok(None)) {
        chart.measuring = None;
        chart.read(&source);
        if !matches!(ended, Ok(Some(true))) {
            *notice = Notice::Error("the chart could not be measured; 'plumb chart' says why".into());
        }
    } else if measuring.read.elapsed() > READ_EVERY {
        measuring.read = Instant::now();
        chart.read(&source);
    }
}

/// Starts a measurement of the present scene, unless one is at work; once more where every point is measured.
pub fn measure_chart(world: &mut World) {
    let chart = world.resource::<SceneChart>();
    if chart.measuring.is_some() {
        return;
    }
    let Some(scene) = world.get_resource::<CurrentScene>() else { return };
    match measure(scene, chart, world.resource::<ChartSource>()) {
        Ok(measuring) => world.resource_mut::<SceneChart>().measuring = Some(measuring),
        Err(error) => {
            *world.resource_mut::<Notice>() = Notice::Error(format!("the chart cannot be measured: {error}"));
        }
    }
}

/// Starts `plumb chart` on the scene.
fn measure(scene: &CurrentScene, chart: &SceneChart, source: &ChartSource) -> std::io::Result<Measuring> {
    let mut command = Command::new(&source.program);
    command.arg("chart").arg(&scene.scene);
    for (name, value) in &scene.parameters {
        command.arg("-p").arg(format!("{name}={value}"));
    }
    if let Some(curves) = &chart.curves {
        let path = source.folder.join(VARIED_SETTINGS);
        write_settings(&path, &curves.study.candidates[0].settings)?;
        command.arg("--vary").arg(curves.x.to_string()).arg("--settings").arg(path);
    }
    command.arg("--quick").arg("--out").arg(&source.folder);
    let (mut since, mut measured) = (0, chart.records.len());
    if chart.is_whole() {
        command.arg("--again");
        since = read_records(&source.folder.join(POINTS), &source.program).len();
        measured = 0;
    }
    let child = command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).spawn()?;
    Ok(Measuring { child, read: Instant::now(), since, measured })
}

pub(super) fn show(
    InMut(ui): InMut<egui::Ui>,
    stats: Res<StepStats>,
    mut chart: ResMut<SceneChart>,
    mut settings: ResMut<SolverSettings>,
    scene: Option<Res<CurrentScene>>,
    mut of: ResMut<ChartOf>,
    mut notice: ResMut<Notice>,
    mut actions: MessageWriter<SandboxAction>,
    mut local: Local<Shown>,
) {
    let Shown { cost, pressed, typed } = &mut *local;
    if let Some(scene) = &scene {
        choose(ui, scene, &settings, &mut of, typed);
    }
    ui.horizontal(|ui| {
        if let Some(measuring) = &chart.measuring {
            ui.spinner();
            ui.label(format!("measured {} of {}", measuring.measured, chart.points.len()));
            if ui.button("Stop").clicked() {
                chart.measuring = None;
            }
        } else if !chart.points.is_empty() {
            let label = match chart.records.len() {
                0 => "Measure",
                _ if chart.is_whole() => "Measure again",
                _ => "Measure the rest",
            };
            let about = "runs 'plumb chart --quick' on this scene in a process of its own";
            if ui.button(label).on_hover_text(about).clicked() {
                actions.write(SandboxAction::MeasureChart);
            }
        }
    });
    let curves = chart.curves.as_ref();
    let mut dots: Vec<Dot> = chart.records.iter().filter_map(|(index, run)| Dot::of(*index, run, curves)).collect();
    // In the order of drawing.
    dots.sort_by_key(|dot| (dot.series, !dot.holds()));
    if dots.is_empty() {
        if chart.measuring.is_none() {
            let text = if chart.records.is_empty() {
                "not measured yet"
            } else {
                "nothing is known of this scene's answer to measure an error from"
            };
            ui.weak(text);
        }
        return;
    }
    if curves.is_none() {
        legend(ui);
    }
    let cost = cost.follow(&settings, &stats);
    if let Some(picked) = draw(ui, &dots, curves, &settings, cost, pressed) {
        // The number of threads is the machine's, not the point's, and nothing sleeps where methods are compared.
        let sleep_speed = if curves.is_some() { picked.impulse.sleep_speed } else { settings.impulse.sleep_speed };
        let impulse = ImpulseSettings { sleep_speed, ..picked.impulse };
        *settings = SolverSettings { threads: settings.threads, impulse, ..picked };
        *notice = Notice::Info("took over the settings of a point of the chart".into());
    }
}

/// What the section keeps from frame to frame.
#[derive(Default)]
pub(super) struct Shown {
    cost: PresentCost,
    /// The key of the point that the pointer is down on.
    pressed: Option<String>,
    typed: Option<vary::Typed>,
}

/// What the chart is of: the methods, or one thing over its values.
fn choose(
    ui: &mut egui::Ui,
    scene: &CurrentScene,
    settings: &SolverSettings,
    of: &mut ResMut<ChartOf>,
    typed: &mut Option<vary::Typed>,
) {
    ui.horizontal(|ui| {
        if ui.selectable_label(typed.is_none(), "methods").on_hover_text("error against cost of all methods").clicked()
        {
            *typed = None;
            of.set_if_neq(ChartOf::Methods);
        }
        let about = "the present settings with one thing varied: error over its values";
        if ui.selectable_label(typed.is_some(), "vary").on_hover_text(about).clicked() {
            typed.get_or_insert_default();
        }
    });
    let Some(typed) = typed else { return };
    let info = crate::scene::find(&scene.scene);
    let parameters = info.iter().flat_map(|info| info.parameters).map(|parameter| parameter.name);
    // It is set for the whole scene then.
    let own = parameters.filter(|name| scene.parameters.iter().all(|(set, _)| set != name));
    let names: Vec<&str> = own.chain(vary::settings_names(settings)).collect();
    let suggest = |name: &str| vary::suggested_values(name, info, settings);
    let about = "values: a,b,c or from:to:lin:count or from:to:log:count; Enter takes them, with the present settings";
    if vary::show(ui, "varied", &names, typed, suggest, about) {
        let variation = Variation::parse(&typed.text(), info);
        typed.problem = variation.as_ref().err().map(ToString::to_string);
        if variation.is_ok() {
            **of = ChartOf::Varied(typed.text());
        }
    }
}
