//! The present scene's chart of error against cost: measured by a process of its own, so that
//! game and measurement do not spoil each other, with marks where the present settings stand.

use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use bevy::prelude::*;
use bevy_egui::egui;
use egui_plot::{GridInput, GridMark, Line, MarkerShape, Plot, PlotPoint, PlotResponse, PlotTransform, Points};

use super::theme::palette;
use crate::lab::chart::{Extent, POINTS, SERIES, Subject, front};
use crate::lab::sweep::{Point, Record, read_records};
use crate::lab::verdict::Verdict;
use crate::physics::{ImpulseSettings, SolverSettings, StepStats};
use crate::sandbox::{CurrentScene, Notice, SandboxAction};

/// How often the file of a measurement at work is read.
const READ_EVERY: Duration = Duration::from_millis(500);

/// A pointer this near to a point, in egui's points, means it.
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
        let latest = |(key, point): (&String, &Point)| {
            let record = rows.iter().rev().find(|row| row.key == *key)?;
            Some(Record { series: point.series.clone(), ..record.clone() })
        };
        self.records = keys.iter().zip(&self.points).filter_map(latest).collect();
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
    mut notice: ResMut<Notice>,
    mut actions: MessageWriter<SandboxAction>,
    mut cost: Local<PresentCost>,
    mut pressed: Local<Option<String>>,
) {
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
    if let Some(picked) = draw(ui, &dots, &settings, cost, &mut pressed) {
        // The number of threads is the machine's, not the point's, and nothing sleeps where it is measured.
        let impulse = ImpulseSettings { sleep_speed: settings.impulse.sleep_speed, ..picked.impulse };
        *settings = SolverSettings { threads: settings.threads, impulse, ..picked };
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

    fn position(&self, transform: &PlotTransform) -> egui::Pos2 {
        transform.position_from_point(&PlotPoint::new(self.place[0], self.place[1]))
    }
}

/// What the present settings cost here and now.
#[derive(Default)]
pub(super) struct PresentCost {
    settings: SolverSettings,
    /// The last step that was looked at.
    steps: u64,
    /// Logarithm of the cost, ms a simulated second.
    exponent: Option<f64>,
}

impl PresentCost {
    /// Looks at the last step. The cost, ms a simulated second: the geometric mean over about the last twenty steps
    /// that were looked at, so that it can be read; none before the first step with these settings.
    fn follow(&mut self, settings: &SolverSettings, stats: &StepStats) -> Option<f64> {
        const SHARE: f64 = 0.05;
        if self.settings != *settings {
            *self = Self { settings: *settings, steps: stats.steps, exponent: None };
        }
        let exponent = (1e3 * stats.step_seconds * settings.hz).log10();
        if stats.steps != self.steps && exponent.is_finite() {
            let mean = self.exponent.get_or_insert(exponent);
            *mean += SHARE * (exponent - *mean);
            self.steps = stats.steps;
        }
        self.exponent.map(|exponent| 10_f64.powf(exponent))
    }
}

/// Shapes and colours by method, as in the pictures of `plumb chart`.
const MARKERS: [(MarkerShape, [u8; 3]); SERIES.len()] = [
    (MarkerShape::Circle, palette::SKY),
    (MarkerShape::Up, palette::VERMILION),
    (MarkerShape::Square, palette::GREEN),
    (MarkerShape::Cross, palette::PURPLE),
    (MarkerShape::Diamond, palette::ORANGE),
    (MarkerShape::Asterisk, palette::YELLOW),
    (MarkerShape::Down, palette::SKY),
    (MarkerShape::Left, palette::VERMILION),
    (MarkerShape::Right, palette::GREEN),
    (MarkerShape::Circle, palette::ORANGE),
    (MarkerShape::Plus, palette::PURPLE),
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

/// Draws the chart; the settings of a point that was clicked. `pressed` is the key of the point that the pointer is
/// down on.
fn draw(
    ui: &mut egui::Ui,
    dots: &[Dot],
    settings: &SolverSettings,
    cost: Option<f64>,
    pressed: &mut Option<String>,
) -> Option<SolverSettings> {
    let alike = |dot: &&Dot| {
        let own = ["threads", "impulse.sleep_speed"];
        dot.settings.differences(settings).all(|setting| own.contains(&setting.path))
    };
    let present = dots.iter().find(alike);
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
        // What a point is and what a click takes are found in one way, in `follow_pointer`.
        .show_x(false)
        .show_y(false);
    let shown = ui.push_id("chart", |ui| {
        plot.show(ui, |plot| {
            let held: Vec<&Dot> = dots.iter().filter(|dot| dot.holds()).collect();
            let places: Vec<(f64, f64)> = held.iter().map(|dot| (dot.place[0], dot.place[1])).collect();
            let line: Vec<[f64; 2]> = front(&places).into_iter().map(|index| held[index].place).collect();
            plot.line(Line::new("front", line).color(egui::Color32::from_gray(150)).width(1.0));
            for (series, (shape, shade)) in MARKERS.iter().enumerate() {
                for (holds, strength) in [(true, 1.0), (false, 0.25)] {
                    let of_kind = dots.iter().filter(|dot| dot.series == series && dot.holds() == holds);
                    let places: Vec<[f64; 2]> = of_kind.map(|dot| dot.place).collect();
                    let shade = color(*shade).gamma_multiply(strength);
                    plot.points(Points::new(SERIES[series].name, places).shape(*shape).color(shade).radius(4.0));
                }
            }
            if let Some(dot) = present {
                let ring = Points::new("present settings", vec![dot.place]).filled(false).radius(8.0);
                plot.points(ring.color(egui::Color32::WHITE));
            }
            // Of the last pass, in which the picture was drawn that the pointer is on.
            *plot.transform()
        })
    });
    let shown = shown.inner;
    if let Some(cost) = cost {
        mark_cost(ui, &shown.transform, cost);
    }
    let ring =
        if present.is_some() { "the ring has the present settings" } else { "no point has the present settings" };
    ui.weak(format!("error over ms per simulated second; {ring}; click a point to take its settings"))
        .on_hover_text("now: what the step costs in this window; points are measured alone, on one thread");
    follow_pointer(ui, dots, &shown, pressed)
}

/// A line at what the step costs now, with the number. Painted over the plot and no item of it: the axes follow the
/// points, and do not waver with the clock. Beyond the axes, an arrow points to where it would be.
fn mark_cost(ui: &egui::Ui, transform: &PlotTransform, cost: f64) {
    let frame = *transform.frame();
    let x = transform.position_from_point_x(cost.log10());
    let shade = egui::Color32::from_gray(215);
    let painter = ui.painter().with_clip_rect(frame.intersect(ui.clip_rect()));
    let now = cost_text(cost);
    let (anchor, x, text) = if x < frame.left() {
        (egui::Align2::LEFT_TOP, frame.left(), format!("◀ {now}"))
    } else if x > frame.right() {
        (egui::Align2::RIGHT_TOP, frame.right(), format!("{now} ▶"))
    } else {
        painter.vline(x, frame.y_range(), egui::Stroke::new(1.0, shade.gamma_multiply(0.5)));
        let on_the_left = x < frame.center().x;
        (if on_the_left { egui::Align2::LEFT_TOP } else { egui::Align2::RIGHT_TOP }, x, now)
    };
    let gap = if anchor == egui::Align2::LEFT_TOP { 4.0 } else { -4.0 };
    painter.text(egui::pos2(x + gap, frame.top() + 2.0), anchor, text, egui::FontId::proportional(11.0), shade);
}

/// Three digits.
fn cost_text(cost: f64) -> String {
    let digits = (2.0 - cost.log10().floor()).clamp(0.0, 6.0) as usize;
    format!("now: {cost:.digits$} ms a second")
}

/// Tells what the point under the pointer is; the settings of one that was clicked. A click takes the point that the
/// pointer went down on, whose text is shown till it goes up, even where new points rescale the chart meanwhile.
fn follow_pointer(
    ui: &egui::Ui,
    dots: &[Dot],
    shown: &PlotResponse<PlotTransform>,
    pressed: &mut Option<String>,
) -> Option<SolverSettings> {
    let PlotResponse { inner: last_transform, response, transform, .. } = shown;
    let (goes_down, is_down, pointer) =
        ui.input(|input| (input.pointer.primary_pressed(), input.pointer.primary_down(), input.pointer.interact_pos()));
    if goes_down {
        let dot = pointer.and_then(|pointer| dot_at(dots, last_transform, pointer));
        *pressed = dot.map(|dot| dot.record.key.clone());
    }
    let held = dots.iter().find(|dot| pressed.as_ref() == Some(&dot.record.key));
    let told = if response.is_pointer_button_down_on() {
        held
    } else {
        response.hover_pos().and_then(|pointer| dot_at(dots, transform, pointer))
    };
    if let Some(dot) = told {
        ui.painter().circle_stroke(dot.position(transform), 6.0, egui::Stroke::new(1.0, egui::Color32::WHITE));
        ui.ctx().set_cursor_icon(egui::CursorIcon::PointingHand);
        let anchor = egui::PopupAnchor::Pointer;
        let tooltip = egui::Tooltip::always_open(ui.ctx().clone(), response.layer_id, response.id, anchor).gap(12.0);
        tooltip.show(|ui| ui.label(about(dot)));
    }
    if !is_down {
        *pressed = None;
    }
    held.filter(|_| response.clicked()).map(|dot| dot.settings)
}

/// The point that a pointer means.
fn dot_at<'a, 'r>(dots: &'a [Dot<'r>], transform: &PlotTransform, pointer: egui::Pos2) -> Option<&'a Dot<'r>> {
    nearest(dots.iter().map(|dot| dot.position(transform)), pointer).map(|index| &dots[index])
}

/// The index of the place nearest to the pointer, within [`REACH`]; of several as near the last, drawn over the others.
fn nearest(places: impl Iterator<Item = egui::Pos2>, pointer: egui::Pos2) -> Option<usize> {
    let near = places.map(|place| place.distance(pointer)).enumerate().filter(|&(_, distance)| distance <= REACH);
    let nearest = near.min_by(|one, other| one.1.total_cmp(&other.1).then(other.0.cmp(&one.0)));
    nearest.map(|(index, _)| index)
}

/// What a point is.
fn about(dot: &Dot) -> String {
    let Record { series, hz, substeps, iterations, error, unit, verdict, reason, .. } = dot.record;
    let mut text = format!(
        "{series}\n{hz} Hz, substeps {substeps}, iterations {iterations}\nerror {:.2e} {unit}\n{:.3} ms a second",
        error.unwrap_or_default(),
        dot.record.cost().unwrap_or_default(),
    );
    if !dot.holds() {
        text.push_str(&format!("\n{verdict}: {reason}"));
    }
    text
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pointer_means_the_nearest_point_and_of_those_in_one_place_the_topmost() {
        let places = [egui::pos2(10.0, 10.0), egui::pos2(16.0, 10.0), egui::pos2(16.0, 10.0)];
        let at = |x: f32, y: f32| nearest(places.into_iter(), egui::pos2(x, y));
        assert_eq!(at(11.0, 11.0), Some(0));
        assert_eq!(at(15.0, 10.0), Some(2));
        assert_eq!(at(16.0, 10.0 + REACH), Some(2));
        assert_eq!(at(16.0, 11.0 + REACH), None);
    }

    #[test]
    fn the_present_cost_is_that_of_steps_with_the_present_settings() {
        let settings = SolverSettings { hz: 100.0, ..default() };
        let stats = |steps, step_seconds| {
            let mut stats = StepStats::default();
            (stats.steps, stats.step_seconds) = (steps, step_seconds);
            stats
        };
        let mut cost = PresentCost::default();
        // That step was made with other settings.
        assert_eq!(cost.follow(&settings, &stats(7, 1.0)), None);
        let first = cost.follow(&settings, &stats(8, 1e-3)).unwrap();
        assert!((first - 100.0).abs() < 1e-9, "{first}");
        // The same step once more says nothing new.
        assert_eq!(cost.follow(&settings, &stats(8, 1e-3)), Some(first));
        for steps in 9..200 {
            cost.follow(&settings, &stats(steps, 1e-2));
        }
        let later = cost.follow(&settings, &stats(199, 1e-2)).unwrap();
        assert!((later - 1000.0).abs() < 1.0, "{later}");
        assert_eq!(cost.follow(&SolverSettings { hz: 50.0, ..settings }, &stats(199, 1e-2)), None);
    }

    #[test]
    fn the_present_cost_is_told_in_three_digits() {
        assert_eq!(cost_text(0.0317), "now: 0.0317 ms a second");
        assert_eq!(cost_text(1.8), "now: 1.80 ms a second");
        assert_eq!(cost_text(1234.4), "now: 1234 ms a second");
    }
}
