//! The curve: points over the values, axes, and what the pointer means.

use bevy_egui::egui;
use egui_plot::{GridMark, Line, MarkerShape, Plot, PlotPoint, PlotResponse, PlotTransform, Points};

use crate::lab::sweep::Record;
use crate::lab::vary::{Assignment, Curves, Measure, Variation};
use crate::lab::verdict::Verdict;
use crate::sandbox::axes::{color32, mark_now, mark_text, power, powers, round_marks, still};
use crate::sandbox::panel::palette;

/// Decades below the least positive value at which a logarithmic axis has a zero.
const ZERO_BELOW: f64 = 0.5;

/// A value and what came of it.
pub struct Dot {
    /// Of the value.
    pub index: usize,
    place: [f64; 2],
    /// Of the quantity; none where it was not measured.
    quantity: Option<f64>,
    /// Why it failed, where it did.
    failed: Option<String>,
}

/// A quantity over values.
pub struct Shown<'a> {
    x: &'a Variation,
    /// What the quantity is, with its unit.
    label: String,
    /// In the order of the values.
    pub dots: Vec<Dot>,
    /// Whether the quantity's axis is logarithmic.
    pub is_logarithmic: bool,
    /// Whether it can be: with a positive value and without a negative one.
    pub can_be_logarithmic: bool,
}

impl<'a> Shown<'a> {
    /// With a logarithmic axis if that is asked for, or where values span more than a decade if nothing is, and can be.
    pub fn new(
        curves: &'a Curves,
        records: &[(usize, Record)],
        measure: &Measure,
        is_logarithmic: Option<bool>,
    ) -> Self {
        let quantity = |record: &Record| (measure.of)(record).filter(|value| value.is_finite());
        let values: Vec<f64> = records.iter().filter_map(|(_, record)| quantity(record)).collect();
        let positive = values.iter().copied().filter(|value| *value > 0.0);
        let (least, largest) = (positive.clone().fold(f64::INFINITY, f64::min), positive.fold(0.0, f64::max));
        let can_be_logarithmic = largest > 0.0 && values.iter().all(|value| *value >= 0.0);
        let is_logarithmic = can_be_logarithmic && is_logarithmic.unwrap_or(largest > 10.0 * least);
        let height = |value: f64| match is_logarithmic {
            true if value > 0.0 => value.log10(),
            true => least.log10() - ZERO_BELOW,
            false => value,
        };
        // What has no quantity stands at the bottom.
        let lowest = values.iter().copied().map(height).reduce(f64::min).unwrap_or(0.0);
        let dot = |(index, record): &(usize, Record)| {
            let quantity = quantity(record);
            let failed = record.verdict > Verdict::Degrades;
            Dot {
                index: *index,
                place: [curves.x.place(*index), quantity.map_or(lowest, height)],
                quantity,
                failed: failed.then(|| format!("{}: {}", record.verdict, record.reason)),
            }
        };
        let unit = records.iter().map(|(_, record)| &record.unit).find(|unit| !unit.is_empty());
        let label = match unit {
            // The unit of an error is the scene's.
            Some(unit) if measure.name == "error" => format!("error, {unit}"),
            _ => measure.about.to_owned(),
        };
        let dots = records.iter().map(dot).collect();
        Self { x: &curves.x, label, dots, is_logarithmic, can_be_logarithmic }
    }

    /// Whether the quantity is known of any value.
    pub fn is_measured(&self) -> bool {
        self.dots.iter().any(|dot| dot.quantity.is_some())
    }

    /// Draws the curve; the index of the value of a point that was clicked. `now` is where the present value is and what it
    /// is, `pressed` the index of the value that the pointer went down on.
    pub fn draw(&self, ui: &mut egui::Ui, now: Option<(f64, String)>, pressed: &mut Option<usize>) -> Option<usize> {
        let values = Values::of(self.x);
        let marks = values.marks(ui.available_width());
        let is_logarithmic = self.is_logarithmic;
        ui.label(egui::RichText::new(&self.label).small());
        let plot = still(Plot::new("sweep"))
            .height(170.0)
            .set_margin_fraction(egui::vec2(0.08, 0.12))
            .y_axis_min_width(36.0)
            // Points that are still to come have their room.
            .include_x(self.x.place(0))
            .include_x(self.x.place(self.x.values().len() - 1))
            .x_grid_spacer(move |_| marks.clone())
            .y_grid_spacer(move |input| if is_logarithmic { powers(input) } else { round_marks(input) })
            .x_axis_formatter(move |mark, _| values.text(mark.value))
            .y_axis_formatter(move |mark, _| if is_logarithmic { power(mark.value) } else { linear_text(mark) })
            // What a point is and what a click takes are found in one way, in `follow_pointer`.
            .show_x(false)
            .show_y(false);
        let [holds, fails] = [color32(palette::SKY), ui.visuals().error_fg_color];
        let shown = ui.push_id("sweep", |ui| {
            plot.show(ui, |plot| {
                let known = self.dots.iter().filter(|dot| dot.quantity.is_some());
                let line: Vec<[f64; 2]> = known.map(|dot| dot.place).collect();
                plot.line(Line::new("curve", line).color(egui::Color32::from_gray(150)).width(1.0));
                for (has_failed, name, shape, shade) in
                    [(false, "holds", MarkerShape::Circle, holds), (true, "fails", MarkerShape::Cross, fails)]
                {
                    let of_kind = self.dots.iter().filter(|dot| dot.failed.is_some() == has_failed);
                    let places: Vec<[f64; 2]> = of_kind.map(|dot| dot.place).collect();
                    plot.points(Points::new(name, places).shape(shape).color(shade).radius(4.5));
                }
                // Of the last pass, in which the picture was drawn that the pointer is on.
                *plot.transform()
            })
        });
        let shown = shown.inner;
        if let Some((place, text)) = now {
            mark_now(ui, &shown.transform, place, &text);
        }
        self.follow_pointer(ui, &shown, pressed)
    }

    /// Tells what the point above or below the pointer is; its index where it was clicked. A click takes the point that the
    /// pointer went down on, even where new ones come meanwhile.
    fn follow_pointer(
        &self,
        ui: &egui::Ui,
        shown: &PlotResponse<PlotTransform>,
        pressed: &mut Option<usize>,
    ) -> Option<usize> {
        let PlotResponse { inner: last_transform, response, transform, .. } = shown;
        let (goes_down, is_down, pointer) = ui.input(|input| {
            (input.pointer.primary_pressed(), input.pointer.primary_down(), input.pointer.interact_pos())
        });
        if goes_down {
            *pressed = pointer.and_then(|pointer| self.nearest(last_transform, pointer)).map(|dot| dot.index);
        }
        let held = self.dots.iter().find(|dot| *pressed == Some(dot.index));
        let told = match response.is_pointer_button_down_on() {
            true => held,
            false => response.hover_pos().and_then(|pointer| self.nearest(transform, pointer)),
        };
        if let Some(dot) = told {
            let place = transform.position_from_point(&PlotPoint::new(dot.place[0], dot.place[1]));
            ui.painter().circle_stroke(place, 6.0, egui::Stroke::new(1.0, egui::Color32::WHITE));
            ui.ctx().set_cursor_icon(egui::CursorIcon::PointingHand);
            let anchor = egui::PopupAnchor::Pointer;
            let tooltip = egui::Tooltip::always_open(ui.ctx().clone(), response.layer_id, response.id, anchor);
            tooltip.gap(12.0).show(|ui| ui.label(self.about(dot)));
        }
        if !is_down {
            *pressed = None;
        }
        held.filter(|_| response.clicked()).map(|dot| dot.index)
    }

    /// The point that a pointer means: that whose value is nearest.
    fn nearest(&self, transform: &PlotTransform, pointer: egui::Pos2) -> Option<&Dot> {
        let distance = |dot: &&Dot| (transform.position_from_point_x(dot.place[0]) - pointer.x).abs();
        self.dots.iter().min_by(|one, other| distance(one).total_cmp(&distance(other)))
    }

    /// What a point is.
    fn about(&self, dot: &Dot) -> String {
        let quantity = dot.quantity.map_or_else(|| "not measured".into(), three_digits);
        let failed = dot.failed.as_ref().map_or_else(String::new, |reason| format!("\n{reason}"));
        format!("{}\n{}: {quantity}{failed}", self.x.values()[dot.index], self.label)
    }
}

/// `0.0123`, `45.6`, `7.89e-6`.
fn three_digits(value: f64) -> String {
    match value.abs() {
        0.0 => "0".into(),
        size if (1e-3..1e5).contains(&size) => {
            format!("{value:.*}", (2.0 - size.log10().floor()).max(0.0) as usize)
        }
        _ => format!("{value:.2e}"),
    }
}

/// Of a mark of a linear axis.
fn linear_text(mark: GridMark) -> String {
    match mark.value != 0.0 && !(1e-3..1e4).contains(&mark.step_size) {
        true => format!("{:.0e}", mark.value),
        false => mark_text(mark),
    }
}

/// What is written at the axis of what varies: place and text of each value.
struct Values(Vec<(f64, String)>);

impl Values {
    fn of(variation: &Variation) -> Self {
        let text = |(index, value): (usize, &Assignment)| (variation.place(index), value.value.to_string());
        Self(variation.values().iter().enumerate().map(text).collect())
    }

    /// Those that have room beside each other in a section so wide, points.
    fn marks(&self, width: f32) -> Vec<GridMark> {
        // What the other axis and the margins take of the width, a letter, and what is left between two texts.
        const BESIDE: f64 = 80.0;
        const LETTER: f64 = 6.5;
        const GAP: f64 = 8.0;
        const APART: f64 = 90.0;
        let room = (f64::from(width) - BESIDE).max(1.0);
        let span = self.0.last().map(|last| last.0 - self.0[0].0).filter(|span| *span > 0.0).unwrap_or(1.0);
        let mut end = f64::NEG_INFINITY;
        let mut marks = Vec::new();
        for (value, text) in &self.0 {
            let middle = (value - self.0[0].0) / span * room;
            let half = 0.5 * LETTER * text.len() as f64;
            if middle - half >= end + GAP {
                end = middle + half;
                // As if they were so far apart: egui writes all of them, and draws faint lines.
                marks.push(GridMark { value: *value, step_size: span * APART / room });
            }
        }
        marks
    }

    fn text(&self, place: f64) -> String {
        let distance = |mark: &&(f64, String)| (mark.0 - place).abs();
        let nearest = self.0.iter().min_by(|one, other| distance(one).total_cmp(&distance(other)));
        nearest.map_or_else(String::new, |(_, text)| text.clone())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_written_where_there_is_room() {
        let texts = |text: &str| -> Vec<String> {
            let values = Values::of(&Variation::parse(text, None).unwrap());
            values.marks(300.0).into_iter().map(|mark| values.text(mark.value)).collect()
        };
        assert_eq!(texts("iterations=1,2,4,8,16"), ["1", "2", "4", "8", "16"]);
        assert_eq!(texts("contacts=single_point,clipping"), ["single_point", "clipping"]);
        assert_eq!(texts("iterations=7"), ["7"]);
        let many = texts("hz=100:1000:lin:91");
        assert!((5..10).contains(&many.len()) && many[0] == "100", "{many:?}");
    }

    #[test]
    fn numbers_are_told_in_three_digits() {
        for (value, text) in [(0.01234, "0.0123"), (45.61, "45.6"), (7.894e-6, "7.89e-6"), (0.0, "0"), (-2.0, "-2.00")]
        {
            assert_eq!(three_digits(value), text);
        }
    }
}
