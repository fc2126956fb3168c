//! Axes of plots: where their marks are and what they say.

use bevy_egui::egui;
use egui_plot::{GridInput, GridMark, Plot, PlotTransform};

use super::panel::{Quantity, without_negative_zero};
use crate::lab::round_step;

/// Most marks on an axis of logarithms.
const MOST_MARKS: usize = 4;

/// A plot that shows what it is given and is not moved by hand.
pub(super) fn still(plot: Plot) -> Plot {
    plot.allow_zoom(false)
        .allow_scroll(false)
        .allow_drag(false)
        .allow_boxed_zoom(false)
        .allow_axis_zoom_drag(false)
        .allow_double_click_reset(false)
}

/// sRGB.
pub(super) fn color32([r, g, b]: [u8; 3]) -> egui::Color32 {
    egui::Color32::from_rgb(r, g, b)
}

/// A mark with the digits that its step has: of halves one.
pub(super) fn mark_text(mark: GridMark) -> String {
    let decimals = (-mark.step_size.log10()).ceil().max(0.0) as usize;
    without_negative_zero(format!("{:.decimals$}", mark.value))
}

/// A line every five seconds.
pub(super) fn fifth_seconds(from: f64, to: f64) -> Vec<GridMark> {
    every(5.0, (from, to))
}

/// Up to three lines, 1, 2 or 5 times a power of ten apart: egui leaves out numbers that stand
/// closer.
pub(super) fn round_marks(input: GridInput) -> Vec<GridMark> {
    let (low, high) = input.bounds;
    let least = (high - low) / 2.5;
    if !(least.is_normal() && least > 0.0) {
        return Vec::new();
    }
    every(round_step(least), input.bounds)
}

/// Lines at the multiples of a step.
pub(super) fn every(step_size: f64, (low, high): (f64, f64)) -> Vec<GridMark> {
    let (first, last) = ((low / step_size).ceil() as i64, (high / step_size).floor() as i64);
    (first..=last).map(|line| GridMark { value: line as f64 * step_size, step_size }).collect()
}

/// Decimal logarithms of 1, 2 and 5 times powers of ten.
fn ones_twos_fives((low, high): (f64, f64)) -> impl Iterator<Item = f64> {
    let decades = low.floor() as i64..=high.floor() as i64;
    let marks = decades.flat_map(|decade| [1.0_f64, 2.0, 5.0].map(|digit| decade as f64 + digit.log10()));
    marks.filter(move |value| (low..=high).contains(value))
}

/// On an axis of decimal logarithms: lines at powers of ten, or at 1, 2 and 5 of each where few of them are on view.
pub(super) fn decade_marks(input: GridInput) -> Vec<GridMark> {
    let (low, high) = input.bounds;
    if !(low.is_finite() && high.is_finite() && high - low < 1e3) {
        return Vec::new();
    }
    let within: Vec<f64> = ones_twos_fives(input.bounds).collect();
    let powers: Vec<f64> = within.iter().copied().filter(|value| value.fract() == 0.0).collect();
    let marks = if within.len() <= MOST_MARKS { within } else { powers };
    let every = marks.len().div_ceil(MOST_MARKS).max(1);
    // As far apart as any, so that none is fainter than another.
    marks.into_iter().step_by(every).map(|value| GridMark { value, step_size: high - low }).collect()
}

/// What a mark on an axis of decimal logarithms stands for.
pub(super) fn decade_text(mark: GridMark, unit: &str) -> String {
    // A little more, so that 1000 is not 999.99.
    let value = 10_f64.powf(mark.value) * (1.0 + 1e-9);
    let suiting = Quantity::suiting(value, unit);
    format!("{:.0} {}", value * suiting.factor, suiting.unit)
}

/// On the axes of charts: lines at whole powers of ten, four or five of them; in a short range at 2 and 5 times those
/// too. Places are exponents.
pub(super) fn powers(input: GridInput) -> Vec<GridMark> {
    /// Decades in which lines at 1, 2 and 5 are as many as fit.
    const SHORT: f64 = 2.5;
    let (low, high) = input.bounds;
    if !(high - low).is_finite() {
        return Vec::new();
    }
    if high - low < SHORT {
        return ones_twos_fives(input.bounds).map(|value| GridMark { value, step_size: 2_f64.log10() }).collect();
    }
    every(((high - low) / 5.0).ceil().max(1.0), input.bounds)
}

/// The number at a mark of [`powers`].
pub(super) fn power(exponent: f64) -> String {
    // A mark is rounded: a hair below a whole power is that power.
    let decade = (exponent + 1e-9).floor();
    if (-2.0..=4.0).contains(&exponent) {
        let digits = (-decade).max(0.0) as usize;
        format!("{:.digits$}", 10_f64.powf(exponent))
    } else {
        format!("{:.0}e{decade}", 10_f64.powf(exponent - decade))
    }
}

/// A line at what is so now, with a text. Painted over the plot and no item of it: the axes follow the points, and do not
/// waver with the line. Beyond the axes, an arrow points to where it would be.
pub(super) fn mark_now(ui: &egui::Ui, transform: &PlotTransform, place: f64, now: &str) {
    let frame = *transform.frame();
    let x = transform.position_from_point_x(place);
    let shade = egui::Color32::from_gray(215);
    let painter = ui.painter().with_clip_rect(frame.intersect(ui.clip_rect()));
    let (anchor, x, text) = if x < frame.left() {
        (egui::Align2::LEFT_TOP, frame.left(), format!("◀ {now}"))
    } else if x > frame.right() {
        (egui::Align2::RIGHT_TOP, frame.right(), format!("{now} ▶"))
    } else {
        painter.vline(x, frame.y_range(), egui::Stroke::new(1.0, shade.gamma_multiply(0.5)));
        let on_the_left = x < frame.center().x;
        (if on_the_left { egui::Align2::LEFT_TOP } else { egui::Align2::RIGHT_TOP }, x, now.to_owned())
    };
    let gap = if anchor == egui::Align2::LEFT_TOP { 4.0 } else { -4.0 };
    painter.text(egui::pos2(x + gap, frame.top() + 2.0), anchor, text, egui::FontId::proportional(12.0), shade);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn input(low: f64, high: f64) -> GridInput {
        GridInput { bounds: (low, high), base_step_size: 0.0 }
    }

    #[test]
    fn axes_have_a_few_round_marks() {
        for (low, high) in [(0.0, 1.0), (-3.0, 17.0), (0.0, 999.0), (-0.002, 0.0035)] {
            let marks = round_marks(input(low, high));
            assert!((1..=3).contains(&marks.len()), "{low} to {high}: {marks:?}");
            assert!(marks.iter().all(|mark| (low..=high).contains(&mark.value)));
        }
        assert!(round_marks(input(0.0, f64::NAN)).is_empty());
    }

    #[test]
    fn marks_have_the_digits_of_their_step() {
        for (value, step_size, text) in
            [(0.5, 0.5, "0.5"), (0.002, 0.001, "0.002"), (40.0, 20.0, "40"), (3.0, 1.0, "3")]
        {
            assert_eq!(mark_text(GridMark { value, step_size }), text);
        }
    }

    #[test]
    fn an_axis_of_logarithms_has_a_few_marks_that_tell_the_value() {
        let texts = |low: f64, high: f64| -> Vec<String> {
            decade_marks(input(low, high)).into_iter().map(|mark| decade_text(mark, "m")).collect()
        };
        assert_eq!(texts(-3.5, 0.5), ["1 mm", "10 mm", "100 mm", "1 m"]);
        assert_eq!(texts(2.9, 3.8), ["1 km", "2 km", "5 km"]);
        assert!((2..=4).contains(&texts(-12.0, 9.0).len()));
        assert!(texts(f64::NEG_INFINITY, 0.0).is_empty() && texts(f64::NAN, 0.0).is_empty());
    }

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
}
