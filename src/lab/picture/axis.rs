//! Logarithmic axes.

use std::ops::Range;

/// The range of some values with a margin in decades; one decade about 1 for none.
pub fn decades(values: impl Iterator<Item = f64>, margin: f64) -> Range<f64> {
    let [low, high] = values
        .filter(|value| value.is_finite() && *value > 0.0)
        .fold([f64::INFINITY, 0.0], |[low, high]: [f64; 2], value| [low.min(value), high.max(value)]);
    if high == 0.0 {
        return 0.1..10.0;
    }
    // Half a decade each way at least, so that a single point has an axis.
    let short = (0.5 - (high / low).log10() / 2.0).max(0.0);
    low / 10_f64.powf(margin + short)..high * 10_f64.powf(margin + short)
}

/// The least of 1, 2 and 5 times a power of ten that is no less.
pub fn round_step(least: f64) -> f64 {
    let power = 10_f64.powf(least.log10().floor());
    let step = [1.0, 2.0, 5.0].map(|factor| factor * power).into_iter().find(|step| *step >= least);
    step.unwrap_or(10.0 * power)
}

/// Powers of ten within a range, at most about eight; with 2 and 5 between them where there are few.
pub fn ticks(range: &Range<f64>) -> Vec<f64> {
    let (first, last) = (range.start.log10().ceil() as i32, range.end.log10().floor() as i32);
    let stride = ((last - first) / 8 + 1).max(1);
    if last - first >= 2 {
        return (first..=last).filter(|power| power.rem_euclid(stride) == 0).map(|power| 10_f64.powi(power)).collect();
    }
    let between = (first - 1..=last).flat_map(|power| [1.0, 2.0, 5.0].map(|digit| digit * 10_f64.powi(power)));
    between.filter(|value| range.contains(value)).collect()
}

/// `0.02`, `300`, `1e-6`.
pub fn number(value: f64) -> String {
    if (1e-3..1e5).contains(&value) {
        // Powers of ten are off by a rounding error.
        let digits = (-value.log10().floor()).max(0.0) as usize;
        format!("{value:.digits$}")
    } else {
        format!("{value:.0e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_few_and_short() {
        assert_eq!(
            ticks(&(0.05..200.0)).iter().map(|&tick| number(tick)).collect::<Vec<_>>(),
            ["0.1", "1", "10", "100"]
        );
        assert_eq!(ticks(&(0.9..6.0)).len(), 3);
        assert_eq!(number(1e-6), "1e-6");
    }
}
