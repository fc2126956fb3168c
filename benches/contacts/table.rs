//! What came of it, as a table in Markdown.

use std::fmt::Write;
use std::time::Duration;

use crate::watch::{Seen, WANTED};
use crate::{Solver, Timed};

/// Which of [`WANTED`] the median is of.
pub const MEDIAN_OF: usize = 1;

/// One row for each solver, of each group and of all.
pub fn text(timed: &[Timed], limit: Duration) -> String {
    let mut groups: Vec<String> = timed.iter().map(Timed::group).collect();
    groups.dedup();
    let mut text = format!(
        "{} problems, {} s for each and solver. ms: median time to {:e} m/s, of those not solved too; then the share solved \
         to each residual, m/s.\n\n| problems | solver | ms |",
        timed.len(),
        limit.as_secs_f64(),
        WANTED[MEDIAN_OF],
    );
    WANTED.iter().for_each(|wanted| text.push_str(&format!(" {wanted:e} |")));
    text.push_str("\n| --- | --- | ---: |");
    text.push_str(&" ---: |".repeat(WANTED.len()));
    text.push('\n');
    for group in groups {
        rows(&mut text, &group, timed.iter().filter(|timed| timed.group() == group).collect());
    }
    rows(&mut text, "all", timed.iter().collect());
    text
}

fn rows(text: &mut String, name: &str, timed: Vec<&Timed>) {
    for (index, solver) in Solver::ALL.into_iter().enumerate() {
        let of = |wanted: usize| timed.iter().map(move |timed| timed.seen[index].times[wanted]);
        let mut times: Vec<f64> = of(MEDIAN_OF).map(|time| time.unwrap_or(f64::INFINITY)).collect();
        times.sort_by(f64::total_cmp);
        let first = if index == 0 { format!("{name}: {}", timed.len()) } else { String::new() };
        let median = times[times.len() / 2] * 1e3;
        let median = if median.is_finite() { format!("{median:.2}") } else { "–".to_owned() };
        // A string takes all that is written to it.
        let _ = write!(text, "| {first} | {} | {median} |", solver.name());
        for wanted in 0..WANTED.len() {
            let share = of(wanted).flatten().count() as f64 / timed.len() as f64;
            let _ = write!(text, " {:.0} % |", 100.0 * share);
        }
        text.push('\n');
    }
}

/// One row for each problem and solver: times in s, none where the residual was not met, and the least residual, m/s.
pub fn csv(timed: &[Timed]) -> String {
    let mut text = "problem,solver".to_owned();
    WANTED.iter().for_each(|wanted| text.push_str(&format!(",{wanted:e}")));
    text.push_str(",least\n");
    for Timed { file, seen } in timed {
        let name = file.file_stem().unwrap_or_default().to_string_lossy();
        for (solver, Seen { times, least }) in Solver::ALL.into_iter().zip(seen) {
            text.push_str(&format!("\"{name}\",\"{}\"", solver.name()));
            for time in times {
                text.push_str(&time.map_or_else(|| ",".to_owned(), |time| format!(",{time:e}")));
            }
            text.push_str(&format!(",{least:e}\n"));
        }
    }
    text
}
