//! Runs the points of a sweep one after the other.

use std::time::{Duration, Instant};

use crate::lab::verdict::{Judgement, Verdict, judge};
use crate::lab::{Metrics, Plan, PlanError, measure};

use super::{Point, Record, Shard, Store, StoreError};

/// How long one point may take.
#[derive(Clone, Copy, Debug)]
pub struct Budget {
    /// Wall-clock time after which a run is given up.
    pub most: Duration,
    /// A run is repeated until this much time is spent on it, for a median that means something.
    pub least: Duration,
}

/// Most repeats of a run.
const MOST_REPEATS: usize = 5;

/// How far a sweep is.
pub struct Progress {
    /// Points done, those found in the file included.
    pub done: usize,
    /// All points of this shard.
    pub all: usize,
}

/// Runs every point of the shard that the store does not have yet and returns the records of
/// all `points` that it then has, in their order. `watch` sees the progress before each run.
///
/// # Errors
/// A point that makes no sense, or a store that cannot be written.
pub fn run<E: From<PlanError> + From<StoreError>>(
    points: &[Point],
    shard: Shard,
    budget: Budget,
    store: &mut Store,
    mut watch: impl FnMut(Progress, &Point),
) -> Result<Vec<Record>, E> {
    let keys: Vec<String> = points.iter().map(Point::key).collect();
    let mine = || keys.iter().zip(points).filter(|(key, _)| shard.has(key));
    let all = mine().count();
    let mut done = mine().filter(|(key, _)| store.has(key)).count();
    for (key, point) in mine() {
        if store.has(key) {
            continue;
        }
        watch(Progress { done, all }, point);
        let record = run_point(point, budget, store.program())?;
        store.add(record)?;
        done += 1;
    }
    // The file may hold a point under the series of another sweep; here it is this sweep's.
    let find = |(key, point): (&String, &Point)| {
        let record = store.records().iter().find(|record| record.key == *key)?;
        Some(Record { series: point.series.clone(), ..record.clone() })
    };
    Ok(keys.iter().zip(points).filter_map(find).collect())
}

/// The run took too long.
struct OverBudget;

fn run_point(point: &Point, budget: Budget, program: &str) -> Result<Record, PlanError> {
    // A point without an error is on no chart.
    let plan = Plan { converge: true, ..point.plan()? };
    let started = Instant::now();
    let mut best: Option<Metrics> = None;
    let mut medians = Vec::new();
    for _ in 0..MOST_REPEATS {
        let metrics = measure(&plan, |_| if started.elapsed() > budget.most { Err(OverBudget) } else { Ok(()) });
        if let Ok(metrics) = &metrics {
            medians.push(metrics.ms_per_step.median);
        }
        match (metrics, &best) {
            (Ok(metrics), Some(known)) if known.ms_per_step.median <= metrics.ms_per_step.median => {}
            (Ok(metrics), _) => best = Some(metrics),
            (Err(OverBudget), Some(_)) => break,
            (Err(OverBudget), None) => {
                let reason = format!("not done within {} s", budget.most.as_secs_f64());
                return Ok(Record::failed(point, program, Judgement { verdict: Verdict::Unknown, reason }));
            }
        }
        if started.elapsed() > budget.least {
            break;
        }
    }
    let metrics = best.expect("at least one run came to its end");
    let slowest = medians.iter().copied().fold(0.0, f64::max);
    let spread = (medians.len() > 1).then_some(slowest - metrics.ms_per_step.median);
    Ok(Record::of(point, program, &metrics, spread, judge(&metrics)))
}
