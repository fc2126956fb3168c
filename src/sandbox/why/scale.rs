//! From numbers to colors.

use std::ops::RangeInclusive;

use crate::sandbox::panel::Quantity;

/// A color, sRGB.
pub type Rgb = [u8; 3];

/// Ordered in brightness as well as in hue, for color-blind people too: stops of viridis (van der Walt and Smith 2015).
const STOPS: [Rgb; 9] = [
    [68, 1, 84],
    [71, 44, 122],
    [59, 82, 139],
    [44, 114, 142],
    [33, 145, 140],
    [40, 174, 128],
    [94, 201, 98],
    [173, 220, 48],
    [253, 231, 37],
];

/// How many shades of a scale are told apart.
const SHADES: f32 = 64.0;

/// The color of a share of a scale, 0 to 1; what is no number has that of 0.
pub fn shade(share: f32) -> Rgb {
    let share = (share.clamp(0.0, 1.0) * SHADES).round() / SHADES;
    let place = share * (STOPS.len() - 1) as f32;
    let from = (place as usize).min(STOPS.len() - 2);
    mix(STOPS[from], STOPS[from + 1], place - from as f32)
}

/// Between two colors.
pub fn mix(one: Rgb, other: Rgb, share: f32) -> Rgb {
    let share = share.clamp(0.0, 1.0);
    std::array::from_fn(|channel| {
        let [from, to] = [one, other].map(|color| f32::from(color[channel]));
        (from + (to - from) * share).round() as u8
    })
}

/// A color that stands for a number: those of numbers near each other differ most.
pub fn category(number: u32) -> Rgb {
    const GOLDEN: f64 = 0.618_033_988_749_895;
    let hue = (0.55 + f64::from(number) * GOLDEN).fract() as f32;
    // Two rows of brightness: neighbors in hue, which are far apart in number, differ there.
    let (saturation, value) = [(0.55, 0.95), (0.75, 0.72)][number as usize / 5 % 2];
    let channel = |offset: f32| {
        let k = (offset + 6.0 * hue) % 6.0;
        value - value * saturation * k.min(4.0 - k).clamp(0.0, 1.0)
    };
    [5.0, 3.0, 1.0].map(|offset| (255.0 * channel(offset)).round() as u8)
}

/// Colors that stand for numbers, one after the other: each number's own, unless it is too near to that of one of the last
/// few, and then the next that is not.
pub fn categories(numbers: impl IntoIterator<Item = u32>) -> Vec<Rgb> {
    /// Over all channels: by less, two shades of a hue could be one.
    const APART: u32 = 70;
    const LAST: usize = 10;
    /// Each moves the hue by a golden share again.
    const TRIED: u32 = 12;
    let apart =
        |one: &Rgb, other: &Rgb| one.iter().zip(other).map(|(one, other)| u32::from(one.abs_diff(*other))).sum::<u32>();
    let mut colors: Vec<Rgb> = Vec::new();
    for number in numbers {
        let last = &colors[colors.len().saturating_sub(LAST)..];
        let is_free = |color: &Rgb| last.iter().all(|other| apart(color, other) > APART);
        let color = (0..TRIED).map(|shift| category(number.wrapping_add(shift))).find(is_free);
        colors.push(color.unwrap_or_else(|| category(number)));
    }
    colors
}

/// A range of numbers and how it is divided.
#[derive(Clone, Debug, PartialEq)]
pub struct Scale {
    /// Least and greatest, in the unit.
    range: [f64; 2],
    unit: &'static str,
    is_logarithmic: bool,
}

impl Scale {
    /// By powers of ten.
    pub fn logarithmic(range: RangeInclusive<f64>, unit: &'static str) -> Self {
        Self { range: [*range.start(), *range.end()], unit, is_logarithmic: true }
    }

    /// Shares of something, in percent.
    pub fn percent() -> Self {
        Self { range: [0.0, 1.0], unit: "%", is_logarithmic: false }
    }

    /// Where a number stands on it, 0 to 1.
    pub fn share(&self, value: f64) -> f32 {
        // What is no number is worse than all.
        if value.is_nan() {
            return 1.0;
        }
        let [low, high] = self.range;
        let share = match self.is_logarithmic {
            true => (value.max(low) / low).ln() / (high / low).ln(),
            false => (value - low) / (high - low),
        };
        share.clamp(0.0, 1.0) as f32
    }

    /// The color of a number.
    pub fn color(&self, value: f64) -> Rgb {
        shade(self.share(value))
    }

    /// Where it has marks, 0 to 1, with a text at some: 1, 2 and 5 times each power of ten, or quarters.
    pub fn marks(&self) -> Vec<(f32, Option<String>)> {
        let [low, high] = self.range;
        if !self.is_logarithmic {
            return [0.0, 0.25, 0.5, 0.75, 1.0].map(|share| (share, Some(format!("{:.0} %", 100.0 * share)))).to_vec();
        }
        let (first, last) = (low.log10().round() as i32, high.log10().round() as i32);
        let digits = (first..=last).flat_map(|power| [1.0, 2.0, 5.0].map(|digit| (digit, digit * 10_f64.powi(power))));
        let within = digits.filter(|(_, value)| *value <= high * (1.0 + 1e-9));
        within.map(|(digit, value)| (self.share(value), (digit == 1.0).then(|| self.text(value)))).collect()
    }

    fn text(&self, value: f64) -> String {
        if self.unit.is_empty() {
            return format!("{value:.0}");
        }
        // A power of ten is no rounding below itself.
        let suiting = Quantity::suiting(value * (1.0 + 1e-9), self.unit);
        format!("{:.0} {}", value * suiting.factor, suiting.unit)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn brightness([r, g, b]: Rgb) -> f64 {
        0.2126 * f64::from(r) + 0.7152 * f64::from(g) + 0.0722 * f64::from(b)
    }

    #[test]
    fn more_is_brighter() {
        let shades: Vec<f64> = (0..=64).map(|share| brightness(shade(share as f32 / 64.0))).collect();
        assert!(shades.is_sorted() && shades[64] > 4.0 * shades[0], "{shades:?}");
    }

    #[test]
    fn a_scale_by_powers_has_marks_at_one_two_and_five() {
        let scale = Scale::logarithmic(1e-6..=1e-2, "m");
        let marks = scale.marks();
        assert_eq!(marks.len(), 4 * 3 + 1);
        let texts: Vec<_> = marks.iter().filter_map(|(_, text)| text.clone()).collect();
        assert_eq!(texts, ["1 µm", "10 µm", "100 µm", "1 mm", "10 mm"]);
        assert!((marks[3].0 - 0.25).abs() < 1e-6 && (marks[12].0 - 1.0).abs() < 1e-6, "{marks:?}");
        for (value, share) in [(-1.0, 0.0), (0.0, 0.0), (1e-4, 0.5), (1.0, 1.0), (f64::NAN, 1.0), (f64::INFINITY, 1.0)]
        {
            assert!((scale.share(value) - share).abs() < 1e-6, "{value}: {}", scale.share(value));
        }
    }

    #[test]
    fn numbers_whose_colors_are_alike_get_others() {
        // Fibonacci numbers are golden shares of each other, nearly: 610 turns of the hue end where they began.
        let alike = [7, 617, 1227, 8, 618];
        let colors = categories(alike);
        assert_eq!(colors[0], category(7));
        for (place, one) in colors.iter().enumerate() {
            for other in &colors[place + 1..] {
                let apart: u32 = (0..3).map(|channel| u32::from(one[channel].abs_diff(other[channel]))).sum();
                assert!(apart > 70, "{colors:?}");
            }
        }
        assert_eq!(categories(0..8), (0..8).map(category).collect::<Vec<_>>(), "those that differ have their own");
        assert_eq!(categories(vec![3; 40]).len(), 40);
    }

    #[test]
    fn numbers_near_each_other_have_colors_that_differ() {
        for number in 0..200 {
            for other in number + 1..number + 8 {
                let (one, other) = (category(number), category(other));
                let apart: u32 = (0..3).map(|channel| u32::from(one[channel].abs_diff(other[channel]))).sum();
                assert!(apart > 40, "{number}: {one:?} {other:?}");
            }
        }
    }
}
