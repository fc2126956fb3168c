//! The cheapest settings that hold an error for a scene, found among measured points.
//!
//! A coarse grid over every method, from its coarse end on as far as points may still count, then, from the cheapest
//! point that holds, one setting at a time made cheaper for as long as the error holds. Costs are compared within one
//! sweep, errors with a margin, since a run that just holds may not hold with the next scene.

use crate::physics::{Method, SolverSettings};

use super::chart::{SERIES, Series, differs, front};
use super::sweep::{Point, Record};
use super::verdict::Verdict;

/// An error counts as held where it is below this share of what is asked for.
pub const MARGIN: f64 = 0.8;

/// What came of a fit.
#[derive(Clone, Debug)]
pub struct Fit {
    /// Everything tried, cheapest first; runs that failed last.
    pub tried: Vec<Record>,
    /// The cheapest record that holds the error.
    pub best: Option<Record>,
    /// Where none does: the nearest.
    pub nearest: Option<Record>,
}

/// Whether a run is good enough.
fn holds(record: &Record, error: f64) -> bool {
    record.verdict <= Verdict::Degrades && record.error.is_some_and(|found| found <= MARGIN * error)
}

/// Searches. `measure` runs points and gives their records.
///
/// # Errors
/// Those of `measure`.
pub fn fit<E>(
    scene: &str,
    parameters: &[(String, f64)],
    seconds: f64,
    error: f64,
    mut measure: impl FnMut(&[Point]) -> Result<Vec<Record>, E>,
) -> Result<Fit, E> {
    let point = |settings, series: &str| Point {
        scene: scene.to_owned(),
        parameters: parameters.to_vec(),
        settings,
        seconds,
        series: series.to_owned(),
    };
    let grid = |series: &Series| grid((series.base)()).into_iter().map(|settings| point(settings, series.name));
    let (exact, mut left): (Vec<Point>, Vec<Point>) =
        SERIES.iter().flat_map(grid).partition(|point| point.settings.method == Method::Exact);
    // The true method first: what costs more than its finest step, and than what holds, is neither the best nor says
    // where to switch.
    let mut tried = measure(&exact)?;
    let finest = tried.iter().filter_map(Record::cost).fold(0.0, f64::max);
    for level in 0..=MOST_LEVEL {
        let best = cheapest(&tried, error).and_then(|best| best.cost());
        let limit = best.map_or(f64::INFINITY, |best| best.max(finest));
        left.retain(|point| {
            !tried.iter().any(|known| known.cost().is_none_or(|cost| cost > limit) && is_finer(point, known))
        });
        let next: Vec<Point> = left.extract_if(.., |point| level_of(&point.settings) == level).collect();
        tried.extend(measure(&next)?);
    }
    let mut best = cheapest(&tried, error);
    while let Some(known) = &best {
        let Some(settings) = known.solver_settings() else { break };
        let next: Vec<Point> = cheaper(settings)
            .into_iter()
            .map(|settings| point(settings, &known.series))
            .filter(|point| tried.iter().all(|record| record.key != point.key()))
            .collect();
        if next.is_empty() {
            break;
        }
        tried.extend(measure(&next)?);
        let found = cheapest(&tried, error);
        if found.as_ref().map(|record| &record.key) == Some(&known.key) {
            break;
        }
        best = found;
    }
    let nearest = tried
        .iter()
        .filter(|record| record.verdict <= Verdict::Degrades && record.error.is_some())
        .min_by(|one, other| one.error.unwrap_or(f64::NAN).total_cmp(&other.error.unwrap_or(f64::NAN)))
        .cloned();
    let cost = |record: &Record| record.cost().unwrap_or(f64::INFINITY);
    tried.sort_by(|one, other| cost(one).total_cmp(&cost(other)));
    Ok(Fit { tried, best, nearest })
}

/// The error from which on downwards the true method is the cheapest of what was tried and holds; infinite where it is
/// for any, none where it nowhere is.
pub fn switch(tried: &[Record]) -> Option<f64> {
    let held: Vec<&Record> = tried.iter().filter(|record| record.verdict <= Verdict::Degrades).collect();
    let number = |value: Option<f64>| value.unwrap_or(f64::NAN);
    let points: Vec<(f64, f64)> = held.iter().map(|record| (number(record.cost()), number(record.error))).collect();
    let front = front(&points);
    let is_true =
        |&index: &usize| held[index].solver_settings().is_some_and(|settings| settings.method == Method::Exact);
    let first = front.iter().rposition(|index| !is_true(index)).map_or(0, |last| last + 1);
    (first < front.len()).then(|| if first == 0 { f64::INFINITY } else { points[front[first - 1]].1 })
}

/// Steps a second, substeps and sweeps over the whole range, coarsely.
const RATES: [f64; 3] = [60.0, 240.0, 960.0];
const SUBSTEPS: [u32; 3] = [1, 4, 16];
const ITERATIONS: [u32; 3] = [4, 20, 100];

fn grid(base: SolverSettings) -> Vec<SolverSettings> {
    let mut grid = Vec::new();
    for hz in RATES {
        for substeps in SUBSTEPS {
            for iterations in ITERATIONS {
                let settings = SolverSettings { hz, substeps, iterations, threads: 1, ..base };
                if differs(&settings, &SolverSettings { substeps: SUBSTEPS[0], iterations: ITERATIONS[0], ..settings })
                {
                    grid.push(settings);
                }
            }
        }
    }
    grid
}

/// How many of the grid's values lie below those of a point, in all three.
fn level_of(settings: &SolverSettings) -> usize {
    RATES.iter().filter(|hz| **hz < settings.hz).count()
        + SUBSTEPS.iter().filter(|substeps| **substeps < settings.substeps).count()
        + ITERATIONS.iter().filter(|iterations| **iterations < settings.iterations).count()
}

/// The level of the finest point.
const MOST_LEVEL: usize = RATES.len() + SUBSTEPS.len() + ITERATIONS.len() - 3;

/// Whether a point takes no fewer steps, substeps and sweeps of the same method, and so costs no less.
fn is_finer(point: &Point, known: &Record) -> bool {
    let settings = &point.settings;
    point.series == known.series
        && settings.hz >= known.hz
        && settings.substeps >= known.substeps
        && settings.iterations >= known.iterations
}

/// The same settings with one of them halved.
fn cheaper(settings: SolverSettings) -> Vec<SolverSettings> {
    let mut cheaper = Vec::new();
    if settings.hz >= 60.0 {
        cheaper.push(SolverSettings { hz: settings.hz / 2.0, ..settings });
    }
    if settings.method == Method::Exact {
        return cheaper;
    }
    if settings.substeps > 1 {
        cheaper.push(SolverSettings { substeps: settings.substeps / 2, ..settings });
    }
    if settings.iterations > 1 {
        cheaper.push(SolverSettings { iterations: settings.iterations / 2, ..settings });
    }
    cheaper
}

fn cheapest(records: &[Record], error: f64) -> Option<Record> {
    let held = records.iter().filter(|record| holds(record, error) && record.cost().is_some());
    held.min_by(|one, other| one.cost().unwrap_or(f64::NAN).total_cmp(&other.cost().unwrap_or(f64::NAN))).cloned()
}

#[cfg(test)]
mod tests {
    use std::convert::Infallible;

    use super::*;
    use crate::lab::verdict::Judgement;

    /// A world in which the true method costs `price` times as much as any other and has no error but 1e-12, and the
    /// others one of h², whatever their sweeps.
    fn imagined(price: f64) -> impl Fn(&[Point]) -> Result<Vec<Record>, Infallible> {
        move |points| {
            let record = |point: &Point| {
                let is_true = point.settings.method == Method::Exact;
                let substep = 1.0 / (point.settings.hz * f64::from(point.settings.substeps));
                let effort = f64::from(point.settings.substeps * point.settings.iterations);
                Record {
                    error: Some(if is_true { 1e-12 } else { substep * substep }),
                    ms_per_step: Some(if is_true { price } else { effort }),
                    ..Record::failed(point, "", Judgement { verdict: Verdict::Holds, reason: String::new() })
                }
            };
            Ok(points.iter().map(record).collect())
        }
    }

    fn best(price: f64, error: f64) -> (Method, Option<f64>) {
        let Ok(found) = fit("rods", &[], 1.0, error, imagined(price));
        let best = found.best.and_then(|best| best.solver_settings()).expect("something holds");
        (best.method, switch(&found.tried))
    }

    #[test]
    fn a_loose_error_takes_a_fast_method_and_a_tight_one_the_true_one() {
        let (loose, switches_at) = best(100.0, 1e-2);
        assert_ne!(loose, Method::Exact);
        let switches_at = switches_at.expect("there is an error that only the true method holds");
        assert_eq!(best(100.0, 1e-9).0, Method::Exact);
        // On either side of where the switch is said to lie; what is held is a share of what is asked for.
        assert_ne!(best(100.0, 1.1 * switches_at / MARGIN).0, Method::Exact);
        assert_eq!(best(100.0, 0.9 * switches_at / MARGIN).0, Method::Exact);
    }

    #[test]
    fn where_one_end_is_never_the_cheapest_there_is_no_switch() {
        assert_eq!(best(1e-3, 1e-2), (Method::Exact, Some(f64::INFINITY)));
        let without = |points: &[Point]| {
            let all = imagined(100.0)(points)?;
            Ok::<_, Infallible>(all.into_iter().filter(|record| record.error > Some(1e-11)).collect())
        };
        let Ok(found) = fit("rods", &[], 1.0, 1e-2, without);
        assert_eq!(switch(&found.tried), None);
    }

    #[test]
    fn what_costs_too_much_to_count_is_left_out_and_the_answers_stay() {
        let all = |series: &'static Series| grid((series.base)()).into_iter().map(|settings| (settings, series.name));
        let point = |(settings, series): (SolverSettings, &str)| Point {
            scene: "rods".to_owned(),
            parameters: Vec::new(),
            settings,
            seconds: 1.0,
            series: series.to_owned(),
        };
        let whole: Vec<Point> = SERIES.iter().flat_map(all).map(point).collect();
        for (price, error) in [(1.0, 1e-2), (1.0, 1e-5), (30.0, 1e-2), (1e3, 1e-2), (1e3, 1e-7), (1e3, 1e-13)] {
            let Ok(of_whole) = imagined(price)(&whole);
            let mut measured = 0;
            let Ok(found) = fit("rods", &[], 1.0, error, |points| {
                measured += points.len();
                imagined(price)(points)
            });
            assert_eq!(switch(&found.tried), switch(&of_whole), "switch at {price}, {error}");
            let cost = |best: Option<Record>| best.and_then(|best| best.cost()).unwrap_or(f64::INFINITY);
            assert!(cost(found.best) <= cost(cheapest(&of_whole, error)), "best at {price}, {error}");
            assert!(price > 1.0 || measured < whole.len() / 2, "{measured} of {} at {price}, {error}", whole.len());
        }
    }
}
