//! The time at which the first of some rows comes to the end of its mode.
//!
//! Sought is the root of the least of the readings, each as a share of what it is where it was first found to be over:
//! by Illinois' rule (Dowell and Jarratt 1971), with a tenth of the interval where the start is at an end itself. A limit
//! that has just been left is at its end at the start, too: of it, C/t is taken, which is Ċ there.

use super::bounded_rows::ModeReading;
use super::constants::TOUCHING;

/// The interval in which the event is.
#[derive(Clone, Debug)]
pub(super) struct EventSearch {
    /// s: nothing is over at the former.
    low: f64,
    pub high: f64,
    /// Readings of the rows at the former.
    at_low: Vec<f64>,
    /// Reading of each row where it was first over; 0 of others.
    pub scales: Vec<f64>,
    /// The least at both, with the factors of Illinois' rule: an end that stays a second time counts half.
    ends: [f64; 2],
    factors: [f64; 2],
    /// The end that was replaced last.
    replaced: Option<usize>,
}

impl EventSearch {
    /// Between a start with those readings and a time, s.
    pub fn new(first: &[ModeReading], high: f64) -> Self {
        let at_low: Vec<f64> = first.iter().map(|first| measure(first, first, 0.0)).collect();
        let scales = vec![0.0; at_low.len()];
        Self { low: 0.0, high, scales, at_low, ends: [0.0; 2], factors: [1.0; 2], replaced: None }
    }

    /// Takes in that this end is another, 0 or 1.
    fn replace(&mut self, end: usize) {
        self.factors[end] = 1.0;
        if self.replaced == Some(end) {
            self.factors[1 - end] *= 0.5;
        }
        self.replaced = Some(end);
    }

    /// Takes in the readings at a time, s. Whether the event is there.
    pub fn note(&mut self, first: &[ModeReading], last: &[ModeReading], time: f64) -> bool {
        let measures = first.iter().zip(last).map(|(first, last)| measure(first, last, time));
        let measures: Vec<f64> = measures.collect();
        for ((scale, last), measure) in self.scales.iter_mut().zip(last).zip(&measures) {
            if *scale == 0.0 && last.is_over() {
                *scale = measure.abs();
            }
        }
        if last.iter().any(ModeReading::is_over) {
            (self.high, self.ends[1]) = (time, least(&measures, &self.scales));
            self.replace(1);
        } else if last.iter().zip(&self.scales).any(|(last, scale)| *scale > 0.0 && last.is_at_end()) {
            return true;
        } else {
            (self.low, self.at_low) = (time, measures);
            self.replace(0);
        }
        self.ends[0] = least(&self.at_low, &self.scales);
        false
    }

    /// The time to try next, s; none where the interval has no more, or is at its start and as short as `shortest`, s.
    pub fn next(&self, trial: usize, shortest: f64) -> Option<f64> {
        let [low, high] = [0, 1].map(|end| self.ends[end] * self.factors[end]);
        let share = match trial % 8 {
            7 => 0.5,
            _ if low > 0.0 => low / (low - high),
            _ => 0.1,
        };
        let time = self.low + (self.high - self.low) * share;
        let is_over = self.low == 0.0 && self.high <= shortest;
        (time > self.low && time < self.high && !is_over).then_some(time)
    }
}

/// A reading as the search takes it, at a time, s.
fn measure(first: &ModeReading, last: &ModeReading, time: f64) -> f64 {
    match first.rate {
        Some(rate) if first.value <= TOUCHING => {
            if time > 0.0 {
                last.value / time
            } else {
                rate
            }
        }
        _ => last.value,
    }
}

/// The least measure of the rows that have a scale, in it.
fn least(measures: &[f64], scales: &[f64]) -> f64 {
    let scaled = measures.iter().zip(scales).filter(|(_, scale)| **scale > 0.0);
    scaled.map(|(measure, scale)| measure / scale).fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A limit 0.1 rad away that comes nearer at 1 rad/s, and by 30 rad/s² faster.
    #[test]
    fn a_stop_is_found_in_a_few_trials() {
        let at = |time: f64| {
            let value = 0.1 - time - 15.0 * time * time;
            vec![ModeReading { row: 0, value, tolerance: 1e-11, rate: Some(-1.0 - 30.0 * time) }]
        };
        let (first, high) = (at(0.0), 0.1);
        let mut search = EventSearch::new(&first, high);
        assert!(!search.note(&first, &at(high), high));
        let trials = (0..30).take_while(|&trial| {
            let time = search.next(trial, 1e-9).unwrap();
            !search.note(&first, &at(time), time)
        });
        let trials = trials.count();
        assert!(trials < 8, "{trials} trials");
    }
}
