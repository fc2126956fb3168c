//! The plot: dots, axes, and what the pointer means.

use bevy_egui::egui;
use egui_plot::{Line, MarkerShape, Plot, PlotPoint, PlotResponse, PlotTransform, Points};

use crate::lab::chart::{SERIES, front};
use crate::lab::sweep::Record;
use crate::lab::verdict::Verdict;
use crate::physics::{SolverSettings, StepStats};
use crate::sandbox::axes::{mark_now, power, powers, still};
use crate::sandbox::panel::palette;

/// A pointer this near to a point, in egui's points, means it.
const REACH: f32 = 12.0;

/// A point on logarithmic axes.
pub(super) struct Dot<'a> {
    record: &'a Record,
    settings: SolverSettings,
    place: [f64; 2],
    pub series: usize,
}

impl<'a> Dot<'a> {
    /// None where the error is not known.
    pub fn of(record: &'a Record) -> Option<Self> {
        let (cost, error) = (record.cost()?, record.error?.max(record.uncertainty.unwrap_or(0.0)).max(1e-16));
        let series = SERIES.iter().position(|series| series.name == record.series)?;
        let place = [cost.log10(), error.log10()];
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
            ui.colored_label(color(shade), egui::RichText::new(series.name).small());
        }
    });
}

/// Draws the chart; the settings of a point that was clicked. `pressed` is the key of the point that the pointer is
/// down on.
pub(super) fn draw(
    ui: &mut egui::Ui,
    dots: &[Dot],
    settings: &SolverSettings,
    cost: Option<f64>,
    pressed: &mut Option<String>,
) -> Option<SolverSettings> {
    let own = ["threads", "impulse.sleep_speed"];
    let alike = |dot: &&Dot| dot.settings.differences(settings).all(|setting| own.contains(&setting.path));
    let present = dots.iter().find(alike);
    let plot = still(Plot::new("chart"))
        .height(190.0)
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
            plot.line(Line::new("front", front_of(dots)).color(egui::Color32::from_gray(150)).width(1.0));
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
        mark_now(ui, &shown.transform, cost.log10(), &cost_text(cost));
    }
    let ring =
        if present.is_some() { "the ring has the present settings" } else { "no point has the present settings" };
    ui.weak(format!("error over ms per simulated second; {ring}; click a point to take its settings"))
        .on_hover_text("now: what the step costs in this window; points are measured alone, on one thread");
    follow_pointer(ui, dots, &shown, pressed)
}

/// What nothing beats on both axes.
fn front_of(dots: &[Dot]) -> Vec<[f64; 2]> {
    let held: Vec<&Dot> = dots.iter().filter(|dot| dot.holds()).collect();
    let places: Vec<(f64, f64)> = held.iter().map(|dot| (dot.place[0], dot.place[1])).collect();
    front(&places).into_iter().map(|index| held[index].place).collect()
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

#[cfg(test)]
mod tests {
    use super::*;
    use bevy::prelude::default;

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
