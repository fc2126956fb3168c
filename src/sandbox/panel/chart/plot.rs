//! The plot: dots, axes, and what the pointer means.

use bevy_egui::egui;
use egui_plot::{GridInput, GridMark, Line, MarkerShape, Plot, PlotPoint, PlotResponse, PlotTransform, Points};

use crate::lab::chart::{SERIES, front};
use crate::lab::sweep::Record;
use crate::lab::vary::{Assignment, Curves, Scale, Variation};
use crate::lab::verdict::Verdict;
use crate::physics::{SolverSettings, StepStats};
use crate::sandbox::panel::palette;

/// A pointer this near to a point, in egui's points, means it.
const REACH: f32 = 12.0;

/// A point on logarithmic axes, or over what varies.
pub(super) struct Dot<'a> {
    record: &'a Record,
    settings: SolverSettings,
    place: [f64; 2],
    pub series: usize,
}

impl<'a> Dot<'a> {
    /// Of the point of that index.
    pub fn of(index: usize, record: &'a Record, curves: Option<&Curves>) -> Option<Self> {
        let (cost, error) = (record.cost()?, record.error?.max(record.uncertainty.unwrap_or(0.0)).max(1e-16));
        let (across, series) = match curves {
            Some(curves) => (curves.x.place(index), 0),
            None => (cost.log10(), SERIES.iter().position(|series| series.name == record.series)?),
        };
        let place = [across, error.log10()];
        place.iter().all(|at| at.is_finite()).then_some(())?;
        Some(Self { record, settings: record.solver_settings()?, place, series })
    }

    pub fn holds(&self) -> bool {
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
    pub fn follow(&mut self, settings: &SolverSettings, stats: &StepStats) -> Option<f64> {
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

/// Shapes and colours by method, the colours all different.
const MARKERS: [(MarkerShape, [u8; 3]); SERIES.len()] = [
    (MarkerShape::Circle, palette::SKY),
    (MarkerShape::Up, palette::VERMILION),
    (MarkerShape::Square, palette::GREEN),
    (MarkerShape::Cross, palette::PURPLE),
    (MarkerShape::Diamond, palette::ORANGE),
    (MarkerShape::Asterisk, palette::YELLOW),
    (MarkerShape::Down, [128, 138, 255]),
    (MarkerShape::Left, [255, 140, 150]),
    (MarkerShape::Right, [150, 220, 90]),
    (MarkerShape::Plus, [235; 3]),
    (MarkerShape::Diamond, [165, 125, 85]),
];

fn color([r, g, b]: [u8; 3]) -> egui::Color32 {
    egui::Color32::from_rgb(r, g, b)
}

pub(super) fn legend(ui: &mut egui::Ui) {
    ui.horizontal_wrapped(|ui| {
        for (series, (_, shade)) in SERIES.iter().zip(MARKERS) {
            ui.colored_label(color(shade), egui::RichText::new(series.name).size(11.0));
        }
    });
}

/// Draws the chart; the settings of a point that was clicked. `pressed` is the key of the point that the pointer is
/// down on.
pub(super) fn draw(
    ui: &mut egui::Ui,
    dots: &[Dot],
    curves: Option<&Curves>,
    settings: &SolverSettings,
    cost: Option<f64>,
    pressed: &mut Option<String>,
) -> Option<SolverSettings> {
    let alike = |dot: &&Dot| {
        let own: &[&str] = if curves.is_some() { &["threads"] } else { &["threads", "impulse.sleep_speed"] };
        dot.settings.differences(settings).all(|setting| own.contains(&setting.path))
    };
    let present = dots.iter().find(alike);
    let values = curves.map(|curves| Values::of(&curves.x));
    let marks = values.clone();
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
        .x_grid_spacer(move |input| marks.as_ref().map_or_else(|| powers(input), Values::marks))
        .y_grid_spacer(powers)
        .x_axis_formatter(move |mark, _| {
            values.as_ref().map_or_else(|| power(mark.value), |values| values.text(mark.value))
        })
        .y_axis_formatter(|mark, _| power(mark.value))
        // What a point is and what a click takes are found in one way, in `follow_pointer`.
        .show_x(false)
        .show_y(false);
    let shown = ui.push_id("chart", |ui| {
        plot.show(ui, |plot| {
            let line = if curves.is_some() { along(dots) } else { front_of(dots) };
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
    if let Some(cost) = cost.filter(|_| curves.is_none()) {
        mark_cost(ui, &shown.transform, cost);
    }
    let ring =
        if present.is_some() { "the ring has the present settings" } else { "no point has the present settings" };
    let over = curves.map_or("ms per simulated second", |curves| curves.x.name());
    ui.weak(format!("error over {over}; {ring}; click a point to take its settings"))
        .on_hover_text("now: what the step costs in this window; points are measured alone, on one thread");
    follow_pointer(ui, dots, &shown, pressed)
}

/// What nothing beats on both axes.
fn front_of(dots: &[Dot]) -> Vec<[f64; 2]> {
    let held: Vec<&Dot> = dots.iter().filter(|dot| dot.holds()).collect();
    let places: Vec<(f64, f64)> = held.iter().map(|dot| (dot.place[0], dot.place[1])).collect();
    front(&places).into_iter().map(|index| held[index].place).collect()
}

/// All points in the order of what varies.
fn along(dots: &[Dot]) -> Vec<[f64; 2]> {
    let mut places: Vec<[f64; 2]> = dots.iter().map(|dot| dot.place).collect();
    places.sort_by(|one, other| one[0].total_cmp(&other[0]));
    places
}

/// What is written at the axis of what varies.
#[derive(Clone)]
struct Values {
    /// Place and text of each.
    marks: Vec<(f64, String)>,
    /// Names are all written, of numbers only as many as there is room for.
    are_names: bool,
}

impl Values {
    fn of(variation: &Variation) -> Self {
        let text = |(index, value): (usize, &Assignment)| (variation.place(index), value.value.to_string());
        let marks = variation.values().iter().enumerate().map(text).collect();
        Self { marks, are_names: variation.scale == Scale::InOrder }
    }

    /// egui writes at marks that are far enough from each other.
    fn marks(&self) -> Vec<GridMark> {
        let span = self.marks.last().map_or(0.0, |last| last.0 - self.marks[0].0);
        let step_size = if self.are_names { 1.0 } else { (span / 4.0).max(f64::MIN_POSITIVE) };
        self.marks.iter().map(|(value, _)| GridMark { value: *value, step_size }).collect()
    }

    fn text(&self, place: f64) -> String {
        let distance = |mark: &&(f64, String)| (mark.0 - place).abs();
        let nearest = self.marks.iter().min_by(|one, other| distance(one).total_cmp(&distance(other)));
        nearest.map_or_else(String::new, |(_, text)| text.clone())
    }
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

/// Lines at whole powers of ten, four or five of them; in a short range at 2 and 5 times those too.
fn powers(input: GridInput) -> Vec<GridMark> {
    /// Decades in which lines at 1, 2 and 5 are as many as fit.
    const SHORT: f64 = 2.5;
    let (low, high) = input.bounds;
    if !(high - low).is_finite() {
        return Vec::new();
    }
    if high - low < SHORT {
        let decades = low.floor() as i64..=high.floor() as i64;
        let marks = decades.flat_map(|decade| [1.0, 2.0, 5.0].map(|digit: f64| decade as f64 + digit.log10()));
        let within = marks.filter(|value| (low..=high).contains(value));
        return within.map(|value| GridMark { value, step_size: 2_f64.log10() }).collect();
    }
    let step_size = ((high - low) / 5.0).ceil().max(1.0);
    let (first, last) = ((low / step_size).ceil() as i64, (high / step_size).floor() as i64);
    (first..=last).map(|line| GridMark { value: line as f64 * step_size, step_size }).collect()
}

/// Of a mark of [`powers`].
fn power(exponent: f64) -> String {
    // A mark is rounded: a hair below a whole power is that power.
    let decade = (exponent + 1e-9).floor();
    if (-2.0..=4.0).contains(&exponent) {
        let digits = (-decade).max(0.0) as usize;
        format!("{:.digits$}", 10_f64.powf(exponent))
    } else {
        format!("{:.0}e{decade}", 10_f64.powf(exponent - decade))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy::prelude::default;

    #[test]
    fn short_and_long_ranges_have_marks_that_say_what_they_are() {
        let texts = |low: f64, high: f64| -> Vec<String> {
            let marks = powers(GridInput { bounds: (low, high), base_step_size: 0.0 });
            marks.into_iter().map(|mark| power(mark.value)).collect()
        };
        assert_eq!(texts(-1.6, 0.4), ["0.05", "0.1", "0.2", "0.5", "1", "2"]);
        assert_eq!(texts(1.2, 1.8), ["20", "50"]);
        assert_eq!(texts(-9.4, -8.0), ["5e-10", "1e-9", "2e-9", "5e-9", "1e-8"]);
        assert_eq!(texts(-8.0, 1.0), ["1e-8", "1e-6", "1e-4", "0.01", "1"]);
    }

    #[test]
    fn no_two_methods_look_alike() {
        for (place, (_, shade)) in MARKERS.iter().enumerate() {
            for (_, other_shade) in &MARKERS[..place] {
                let apart: i32 =
                    shade.iter().zip(other_shade).map(|(a, b)| (i32::from(*a) - i32::from(*b)).abs()).sum();
                assert!(apart > 60, "{shade:?} is near {other_shade:?}");
            }
        }
    }

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
