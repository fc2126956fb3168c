//! The present scene's chart of error against cost: measured by a process of its own, so that
//! game and measurement do not spoil each other, with a mark where the present settings stand.

use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use bevy::prelude::*;
use bevy_egui::egui;
use egui_plot::{GridInput, GridMark, HoverPosition, Line, MarkerShape, Plot, PlotPoint, Points, VLine};

use super::theme::palette;
use crate::lab::chart::{Extent, POINTS, SERIES, Subject, front};
use crate::lab::sweep::{Point, Record, read_records};
use crate::lab::verdict::Verdict;
use crate::physics::{SolverSettings, StepStats};
use crate::sandbox::{CurrentScene, Notice, SandboxAction};

/// How often the file of a measurement at work is read.
const READ_EVERY: Duration = Duration::from_millis(500);

/// A click this near to a point, in egui's points, means it.
const REACH: f32 = 12.0;

/// Who measures charts, and where they are kept.
#[derive(Resource, Clone, Debug)]
pub struct ChartSource {
    /// The program, called as `plumb chart SCENE --quick --out FOLDER`.
    pub program: PathBuf,
    /// The folder.
    pub folder: PathBuf,
}

/// The chart on view.
#[derive(Resource, Default)]
pub(super) struct SceneChart {
    points: Vec<Point>,
    records: Vec<Record>,
    measuring: Option<Measuring>,
}

/// A measurement at work; ends with the sandbox.
struct Measuring {
    child: Child,
    read: Instant,
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
    .add_systems(PreUpdate, (follow_scene, follow_measurement).chain());
}

fn subject(scene: &CurrentScene) -> Subject {
    Subject { scene: scene.scene.clone(), parameters: scene.parameters.clone() }
}

impl SceneChart {
    /// Reads what the file has of the scene's quick chart.
    fn read(&mut self, source: &ChartSource) {
        let records = read_records(&source.folder.join(POINTS), &source.program);
        let series_of = |record: &Record| {
            let point = self.points.iter().find(|point| point.key() == record.key)?;
            Some(Record { series: point.series.clone(), ..record.clone() })
        };
        self.records = records.iter().filter_map(series_of).collect();
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

/// Starts a measurement of the present scene, unless one is at work.
pub fn measure_chart(world: &mut World) {
    if world.resource::<SceneChart>().measuring.is_some() {
        return;
    }
    let Some(scene) = world.get_resource::<CurrentScene>() else { return };
    match measure(scene, world.resource::<ChartSource>()) {
        Ok(measuring) => world.resource_mut::<SceneChart>().measuring = Some(measuring),
        Err(error) => {
            *world.resource_mut::<Notice>() = Notice::Error(format!("the chart cannot be measured: {error}"));
        }
    }
}

/// Starts `plumb chart` on the scene.
fn measure(scene: &CurrentScene, source: &ChartSource) -> std::io::Result<Measuring> {
    let mut command = Command::new(&source.program);
    command.arg("chart").arg(&scene.scene);
    for (name, value) in &scene.parameters {
        command.arg("-p").arg(format!("{name}={value}"));
    }
    command.arg("--quick").arg("--out").arg(&source.folder);
    let child = command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).spawn()?;
    Ok(Measuring { child, read: Instant::now() })
}

pub(super) fn show(
    InMut(ui): InMut<egui::Ui>,
    stats: Res<StepStats>,
    mut chart: ResMut<SceneChart>,
    mut settings: ResMut<SolverSettings>,
    mut notice: ResMut<Notice>,
    mut actions: MessageWriter<SandboxAction>,
) {
    ui.horizontal(|ui| {
        if chart.measuring.is_some() {
            ui.spinner();
            ui.label(format!("measured {} of {}", chart.records.len(), chart.points.len()));
            if ui.button("Stop").clicked() {
                chart.measuring = None;
            }
        } else if chart.records.len() < chart.points.len() {
            let label = if chart.records.is_empty() { "Measure" } else { "Measure the rest" };
            let about = "runs 'plumb chart --quick' on this scene in a process of its own";
            if ui.button(label).on_hover_text(about).clicked() {
                actions.write(SandboxAction::MeasureChart);
            }
        }
    });
    let dots: Vec<Dot> = chart.records.iter().filter_map(Dot::of).collect();
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
    if let Some(picked) = draw(ui, &dots, &settings, &stats) {
        // The number of threads is the machine's, not the point's.
        *settings = SolverSettings { threads: settings.threads, ..picked };
        *notice = Notice::Info("took over the settings of a point of the chart".into());
    }
}

/// A point on logarithmic axes.
struct Dot<'a> {
    record: &'a Record,
    settings: SolverSettings,
    place: [f64; 2],
    series: usize,
}

impl<'a> Dot<'a> {
    fn of(record: &'a Record) -> Option<Self> {
        let (cost, error) = (record.cost()?, record.error?.max(record.uncertainty.unwrap_or(0.0)).max(1e-16));
        let series = SERIES.iter().position(|series| series.name == record.series)?;
        let place = [cost.log10(), error.log10()];
        place.iter().all(|at| at.is_finite()).then_some(())?;
        Some(Self { record, settings: record.solver_settings()?, place, series })
    }

    fn holds(&self) -> bool {
        self.record.verdict <= Verdict::Degrades
    }
}

/// Shapes and colours by method, as in the pictures of `plumb chart`.
const MARKERS: [(MarkerShape, [u8; 3]); 4] = [
    (MarkerShape::Circle, palette::SKY),
    (MarkerShape::Up, palette::VERMILION),
    (MarkerShape::Square, palette::GREEN),
    (MarkerShape::Cross, palette::PURPLE),
];

fn color([r, g, b]: [u8; 3]) -> egui::Color32 {
    egui::Color32::from_rgb(r, g, b)
}

fn legend(ui: &mut egui::Ui) {
    ui.horizontal_wrapped(|ui| {
        for (series, (_, shade)) in SERIES.iter().zip(MARKERS) {
            ui.colored_label(color(shade), egui::RichText::new(series.name).size(11.0));
        }
    });
}

/// Draws the chart; the settings of a point that was clicked.
fn draw(ui: &mut egui::Ui, dots: &[Dot], settings: &SolverSettings, stats: &StepStats) -> Option<SolverSettings> {
    let plot = Plot::new("chart")
        .height(190.0)
        .allow_zoom(false)
        .allow_scroll(false)
        .allow_drag(false)
        .allow_boxed_zoom(false)
        .allow_axis_zoom_drag(false)
        .allow_double_click_reset(false)
        .set_margin_fraction(egui::vec2(0.08, 0.1))
        .y_axis_min_width(36.0)
        .x_grid_spacer(powers)
        .y_grid_spacer(powers)
        .x_axis_formatter(|mark, _| power(mark.value))
        .y_axis_formatter(|mark, _| power(mark.value))
        .label_formatter(|position| match position {
            HoverPosition::NearDataPoint { position, .. } => hovered(dots, position),
            HoverPosition::Elsewhere { .. } => None,
        });
    let shown = ui.push_id("chart", |ui| {
        plot.show(ui, |plot| {
            let held: Vec<&Dot> = dots.iter().filter(|dot| dot.holds()).collect();
            let places: Vec<(f64, f64)> = held.iter().map(|dot| (dot.place[0], dot.place[1])).collect();
            let line: Vec<[f64; 2]> = front(&places).into_iter().map(|index| held[index].place).collect();
            plot.line(Line::new("front", line).color(egui::Color32::from_gray(150)).width(1.0).allow_hover(false));
            for (series, (shape, shade)) in MARKERS.iter().enumerate() {
                for (holds, strength) in [(true, 1.0), (false, 0.25)] {
                    let of_kind = dots.iter().filter(|dot| dot.series == series && dot.holds() == holds);
                    let places: Vec<[f64; 2]> = of_kind.map(|dot| dot.place).collect();
                    let shade = color(*shade).gamma_multiply(strength);
                    plot.points(Points::new(SERIES[series].name, places).shape(*shape).color(shade).radius(4.0));
                }
            }
            mark_present(plot, dots, settings, stats);
        })
    });
    let shown = shown.inner;
    ui.weak("error over ms per simulated second; click a point to take its settings");
    let click = shown.response.clicked().then(|| shown.response.interact_pointer_pos()).flatten()?;
    let distance =
        |dot: &&Dot| shown.transform.position_from_point(&PlotPoint::new(dot.place[0], dot.place[1])).distance(click);
    let nearest = dots.iter().min_by(|one, other| distance(one).total_cmp(&distance(other)))?;
    (distance(&nearest) <= REACH).then_some(nearest.settings)
}

/// A ring on the point with the present settings; a line at what the present step costs.
fn mark_present(plot: &mut egui_plot::PlotUi, dots: &[Dot], settings: &SolverSettings, stats: &StepStats) {
    let alike = |dot: &&Dot| dot.settings == SolverSettings { threads: dot.settings.threads, ..*settings };
    if let Some(dot) = dots.iter().find(alike) {
        let ring = Points::new("present settings", vec![dot.place]).filled(false).radius(8.0);
        plot.points(ring.color(egui::Color32::WHITE).allow_hover(false));
    }
    let cost = 1e3 * stats.step_seconds * settings.hz;
    if cost > 0.0 {
        let line = VLine::new("present cost", cost.log10()).color(egui::Color32::from_white_alpha(60));
        plot.vline(line.allow_hover(false));
    }
}

/// What a point is.
fn hovered(dots: &[Dot], position: &PlotPoint) -> Option<String> {
    let dot = dots.iter().find(|dot| dot.place == [position.x, position.y])?;
    let Record { series, hz, substeps, iterations, error, unit, verdict, reason, .. } = dot.record;
    let mut text = format!(
        "{series}\n{hz} Hz, substeps {substeps}, iterations {iterations}\nerror {:.2e} {unit}\n{:.3} ms a second",
        error.unwrap_or_default(),
        dot.record.cost().unwrap_or_default(),
    );
    if !dot.holds() {
        text.push_str(&format!("\n{verdict}: {reason}"));
    }
    Some(text)
}

/// Lines at whole powers of ten, four or five of them; closer ones for a short range.
fn powers(input: GridInput) -> Vec<GridMark> {
    let (low, high) = input.bounds;
    if !(high - low).is_finite() {
        return Vec::new();
    }
    let step_size = ((high - low) / 5.0).ceil().max(1.0);
    let (first, last) = ((low / step_size).ceil() as i64, (high / step_size).floor() as i64);
    (first..=last).map(|line| GridMark { value: line as f64 * step_size, step_size }).collect()
}

fn power(exponent: f64) -> String {
    if (-2.0..=4.0).contains(&exponent) {
        let digits = (-exponent).max(0.0) as usize;
        format!("{:.digits$}", 10_f64.powf(exponent))
    } else {
        format!("1e{exponent}")
    }
}
