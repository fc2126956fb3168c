//! What to see on a chart, in a sentence or two made from its records.

use super::pareto::front;
use super::subject::Subject;
use crate::lab::sweep::Record;
use crate::lab::verdict::Verdict;
use crate::scene;

pub(super) fn of(subject: &Subject, records: &[Record]) -> String {
    let known = scene::find(&subject.scene).map(|info| format!("Known of its answer: {}. ", info.truth));
    format!("{}{}{}", known.unwrap_or_default(), best(records), failures(records))
}

fn best(records: &[Record]) -> String {
    let held: Vec<&Record> = records.iter().filter(|record| record.verdict <= Verdict::Degrades).collect();
    let places: Vec<(f64, f64)> =
        held.iter().map(|record| (record.cost().unwrap_or(f64::NAN), record.error.unwrap_or(f64::NAN))).collect();
    let front = front(&places);
    let (Some(&cheapest), Some(&nearest)) = (front.first(), front.last()) else {
        return "No run held up. ".to_owned();
    };
    let describe = |index: usize| {
        let Record { series, hz, substeps, iterations, unit, .. } = held[index];
        let (cost, error) = places[index];
        format!(
            "{series} at {hz} Hz with {substeps} substeps of {iterations} sweeps: {error:.1e} {unit} for {cost:.2} ms \
             a simulated second"
        )
    };
    if cheapest == nearest {
        return format!("One point beats all others: {}. ", describe(nearest));
    }
    format!("The front runs from {} to {}. ", describe(cheapest), describe(nearest))
}

fn failures(records: &[Record]) -> String {
    let mut series: Vec<&str> = Vec::new();
    for record in records {
        if !series.contains(&record.series.as_str()) {
            series.push(&record.series);
        }
    }
    let counts = series.into_iter().filter_map(|name| {
        let of_series = || records.iter().filter(|record| record.series == name);
        let failed = of_series().filter(|record| record.verdict == Verdict::Fails).count();
        (failed > 0).then(|| format!("{name} in {failed} of {}", of_series().count()))
    });
    let counts: Vec<String> = counts.collect();
    if counts.is_empty() { "No run failed.".to_owned() } else { format!("Runs that failed: {}.", counts.join(", ")) }
}
