//! Work–precision charts: error against cost, one picture a scene.
//!
//! `grid` says which settings are tried, the sweep measures them, `pareto` finds the front of
//! what nothing beats on both axes, `picture` draws it, `peers` reads what other engines did on
//! the same scenes, `page` puts all pictures on one page with a `remark` on each.

mod grid;
mod page;
mod pareto;
mod peers;
mod picture;
mod remark;
mod subject;

use std::io;
use std::path::{Path, PathBuf};

pub(in crate::lab) use grid::differs;
pub use grid::{Extent, SERIES, Series, points};
pub use pareto::front;
pub use peers::{PeerRecord, PeersError, read_peers};
pub use subject::Subject;

use super::picture::{PictureError, write};
use super::plan::PlanError;
use super::sweep::{Record, StoreError};
use super::verdict::Verdict;
use page::Entry;
use picture::{Chart, Curve, Dot};

/// The file of a folder's records.
pub const POINTS: &str = "points.csv";

/// Why there are no charts.
#[derive(Debug, thiserror::Error)]
pub enum ChartError {
    /// A scene that cannot be run.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// Records that cannot be kept.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// A picture that cannot be drawn.
    #[error(transparent)]
    Picture(#[from] PictureError),
    /// A page or folder that cannot be written.
    #[error("{}: cannot be written: {reason}", path.display())]
    Unwritable {
        /// The file.
        path: PathBuf,
        /// What the system said.
        reason: io::Error,
    },
}

/// Draws the chart of each subject from its records into a folder, and the page that shows all.
///
/// # Errors
/// A file that cannot be written.
pub fn draw_all(folder: &Path, subjects: &[(Subject, Vec<Record>)], peers: &[PeerRecord]) -> Result<(), ChartError> {
    let mut entries = Vec::new();
    for (subject, records) in subjects {
        let peers: Vec<&PeerRecord> = peers.iter().filter(|peer| peer.is_of(subject)).collect();
        write(&chart(subject, records, &peers), &folder.join(subject.stem()))?;
        entries.push(Entry {
            stem: subject.stem(),
            title: subject.title(),
            remark: remark::of(subject, records),
            dropped: dropped(records),
        });
    }
    page::write_page(folder, &entries)
        .map_err(|reason| ChartError::Unwritable { path: folder.join("index.html"), reason })
}

fn chart(subject: &Subject, records: &[Record], peers: &[&PeerRecord]) -> Chart {
    let known = records.iter().find(|record| record.error.is_some());
    let unit = known.map_or("", |record| record.unit.as_str());
    let own = SERIES.iter().enumerate().map(|(mark, series)| {
        let dots = records.iter().filter(|record| record.series == series.name).filter_map(dot).collect();
        Curve { name: series.name.to_owned(), mark, dots }
    });
    let others = peers::engines(peers).into_iter().enumerate().map(|(index, engine)| {
        let dots = peers.iter().filter(|peer| peer.engine == engine).filter_map(|peer| peer.dot()).collect();
        Curve { name: engine, mark: SERIES.len() + index, dots }
    });
    Chart {
        title: format!("{}: error against cost", subject.title()),
        error_label: format!("error, {unit}"),
        floor: known.and_then(|record| record.uncertainty).unwrap_or(0.0).max(f64::MIN_POSITIVE.sqrt()),
        curves: own.chain(others).filter(|curve| !curve.dots.is_empty()).collect(),
    }
}

fn dot(record: &Record) -> Option<Dot> {
    Some(Dot { cost: record.cost()?, error: record.error?, holds: record.verdict <= Verdict::Degrades })
}

/// One line a run that failed.
fn dropped(records: &[Record]) -> Vec<String> {
    let failed = records.iter().filter(|record| record.verdict > Verdict::Degrades);
    failed
        .map(|record| {
            let Record { series, hz, substeps, iterations, verdict, reason, .. } = record;
            format!("{series}, {hz} Hz, substeps {substeps}, iterations {iterations}: {verdict}: {reason}")
        })
        .collect()
}
