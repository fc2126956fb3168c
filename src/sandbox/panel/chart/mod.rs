//! The present scene's chart of error against cost: measured by a process of its own, with marks where the present settings
//! stand.

mod plot;

use bevy::prelude::*;
use bevy_egui::egui;

use super::measuring::{ChartSource, Measuring, Progress};
use crate::lab::chart::{Extent, Subject};
use crate::lab::sweep::{Point, Record};
use crate::physics::{ImpulseSettings, SolverSettings, StepStats};
use crate::sandbox::{CurrentScene, Notice, SandboxAction};
use plot::{Dot, PresentCost, draw, legend};

/// The chart on view.
#[derive(Resource, Default)]
pub(super) struct SceneChart {
    points: Vec<Point>,
    records: Vec<Record>,
    measuring: Option<Measuring>,
    /// Points of the chart that the measurement at work has, those among them that it found in the file.
    measured: usize,
}

pub(super) fn plugin(app: &mut App) {
    app.init_resource::<SceneChart>().add_systems(PreUpdate, (follow_scene, follow_measurement).chain());
}

fn subject(scene: &CurrentScene) -> Subject {
    Subject { scene: scene.scene.clone(), parameters: scene.parameters.clone() }
}

impl SceneChart {
    /// Reads what the file has of the scene's quick chart.
    fn read(&mut self, source: &ChartSource) {
        let rows = source.records();
        let keys: Vec<String> = self.points.iter().map(Point::key).collect();
        if let Some(measuring) = &self.measuring {
            let new = rows.get(measuring.since..).unwrap_or_default();
            self.measured = keys.iter().filter(|key| new.iter().any(|row| row.key == **key)).count();
        }
        let latest = |(point, key): (&Point, &String)| {
            let record = rows.iter().rev().find(|row| row.key == *key)?;
            Some(Record { series: point.series.clone(), ..record.clone() })
        };
        self.records = self.points.iter().zip(&keys).filter_map(latest).collect();
    }

    /// Whether every point is measured.
    fn is_whole(&self) -> bool {
        !self.points.is_empty() && self.records.len() == self.points.len()
    }
}

fn follow_scene(scene: Option<Res<CurrentScene>>, source: Res<ChartSource>, mut chart: ResMut<SceneChart>) {
    let Some(scene) = scene.filter(|scene| scene.is_changed()) else { return };
    let points = subject(&scene).points(Extent::Quick).unwrap_or_default();
    if points != chart.points {
        *chart = SceneChart { points, ..default() };
        chart.read(&source);
    }
}

fn follow_measurement(source: Res<ChartSource>, mut chart: ResMut<SceneChart>, mut notice: ResMut<Notice>) {
    let Some(measuring) = &mut chart.bypass_change_detection().measuring else { return };
    match measuring.look(&source) {
        Progress::Nothing => {}
        Progress::More => chart.read(&source),
        Progress::Ended(outcome) => {
            chart.measuring = None;
            chart.read(&source);
            if let Err(reason) = outcome {
                *notice = Notice::Error(format!("the chart could not be measured: {reason}"));
            }
        }
    }
}

/// Starts a measurement of the present scene, unless one is at work; once more where every point is measured.
pub fn measure_chart(world: &mut World) {
    let chart = world.resource::<SceneChart>();
    if chart.measuring.is_some() {
        return;
    }
    let Some(scene) = world.get_resource::<CurrentScene>() else { return };
    let (since, measured, again) = match chart.is_whole() {
        true => (world.resource::<ChartSource>().records().len(), 0, Some("--again")),
        false => (0, chart.records.len(), None),
    };
    let parameters = scene.parameters.iter().flat_map(|(name, value)| ["-p".to_owned(), format!("{name}={value}")]);
    let mut arguments: Vec<String> = std::iter::once(scene.scene.clone()).chain(parameters).collect();
    arguments.extend(std::iter::once("--quick").chain(again).map(str::to_owned));
    match Measuring::start(world.resource::<ChartSource>(), since, &arguments) {
        Ok(measuring) => {
            let mut chart = world.resource_mut::<SceneChart>();
            (chart.measuring, chart.measured) = (Some(measuring), measured);
        }
        Err(error) => {
            *world.resource_mut::<Notice>() = Notice::Error(format!("the chart cannot be measured: {error}"));
        }
    }
}

pub(super) fn show(
    InMut(ui): InMut<egui::Ui>,
    stats: Res<StepStats>,
    mut chart: ResMut<SceneChart>,
    mut settings: ResMut<SolverSettings>,
    mut notice: ResMut<Notice>,
    mut actions: MessageWriter<SandboxAction>,
    mut local: Local<Shown>,
) {
    let Shown { cost, pressed } = &mut *local;
    ui.horizontal(|ui| {
        if chart.measuring.is_some() {
            ui.spinner();
            ui.label(format!("measured {} of {}", chart.measured, chart.points.len()));
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
    let mut dots: Vec<Dot> = chart.records.iter().filter_map(Dot::of).collect();
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
    legend(ui);
    let cost = cost.follow(&settings, &stats);
    if let Some(picked) = draw(ui, &dots, &settings, cost, pressed) {
        // The number of threads is the machine's, not the point's, and nothing sleeps where methods are compared.
        let impulse = ImpulseSettings { sleep_speed: settings.impulse.sleep_speed, ..picked.impulse };
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
}
