//! Axes of plots: where their marks are and what they say.

use bevy_egui::egui;
use egui_plot::{GridInput, GridMark};

use super::panel::{Quantity, without_negative_zero};
use crate::lab::round_step;

/// Most marks on an axis of logarithms.
const MOST_MARKS: usize = 4;

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
    let (first, last) = ((from / 5.0).ceil() as i64, (to / 5.0).floor() as i64);
    (first..=last).map(|line| GridMark { value: 5.0 * line as f64, step_size: 5.0 }).collect()
}

/// Up to three lines, 1, 2 or 5 times a power of ten apart: egui leaves out numbers that stand
/// closer.
pub(super) fn round_marks(input: GridInput) -> Vec<GridMark> {
    let (low, high) = input.bounds;
    let least = (high - low) / 2.5;
    if !(least.is_normal() && least > 0.0) {
        return Vec::new();
    }
    let step_size = round_step(least);
    let (first, last) = ((low / step_size).ceil() as i64, (high / step_size).floor() as i64);
    (first..=last).map(|line| GridMark { value: line as f64 * step_size, step_size }).collect()
}

/// On an axis of decimal logarithms: lines at powers of ten, or at 1, 2 and 5 of each where few of them are on view.
pub(super) fn decade_marks(input: GridInput) -> Vec<GridMark> {
    let (low, high) = input.bounds;
    if !(low.is_finite() && high.is_finite() && high - low < 1e3) {
        return Vec::new();
    }
    let decades = low.floor() as i64..=high.floor() as i64;
    let within: Vec<f64> = decades
        .flat_map(|decade| [1.0_f64, 2.0, 5.0].map(|digit| decade as f64 + digit.log10()))
        .filter(|value| (low..=high).contains(value))
        .collect();
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
}
