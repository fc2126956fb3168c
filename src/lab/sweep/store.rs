//! Records in an append-only CSV.

use std::collections::HashSet;
use std::fs::{File, OpenOptions};
use std::hash::Hasher;
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use xxhash_rust::xxh3::Xxh3;

use super::Record;

/// The records of a folder's sweeps, in memory and in its file.
pub struct Store {
    path: PathBuf,
    file: File,
    program: String,
    records: Vec<Record>,
    keys: HashSet<String>,
    ignored: usize,
}

/// The file cannot be read or written.
#[derive(Debug, thiserror::Error)]
#[error("{}: {reason}", path.display())]
pub struct StoreError {
    /// The file.
    pub path: PathBuf,
    /// What the system said.
    pub reason: io::Error,
}

impl Store {
    /// Opens or makes the file of records at `path`. Rows that another build of this program
    /// measured, or that an interrupt cut short, are left in the file and ignored.
    ///
    /// # Errors
    /// The file cannot be read or written.
    pub fn open(path: &Path) -> Result<Self, StoreError> {
        let program = std::env::current_exe().map_or_else(|_| String::new(), |program| fingerprint(&program));
        let failed = |reason| StoreError { path: path.to_owned(), reason };
        let mut file = OpenOptions::new().read(true).append(true).create(true).open(path).map_err(failed)?;
        let mut text = Vec::new();
        file.read_to_end(&mut text).map_err(failed)?;
        if text.is_empty() {
            write_row(&mut file, None).map_err(failed)?;
        } else if text.last() != Some(&b'\n') {
            // An interrupt: what was being written is lost, what follows must not be.
            file.write_all(b"\n").map_err(failed)?;
        }
        let mut store =
            Self { path: path.to_owned(), file, program, records: Vec::new(), keys: HashSet::new(), ignored: 0 };
        for record in rows(&text) {
            match record {
                Some(record) if record.program == store.program => store.take_in(record),
                _ => store.ignored += 1,
            }
        }
        Ok(store)
    }

    /// Of two records of a point, the later counts.
    fn take_in(&mut self, record: Record) {
        if self.keys.insert(record.key.clone()) {
            self.records.push(record);
        } else if let Some(known) = self.records.iter_mut().find(|known| known.key == record.key) {
            *known = record;
        }
    }

    /// Forgets the records of those points, so that they are run again. In the file they stay until then.
    pub fn set_aside(&mut self, keys: &[String]) {
        let keys: HashSet<&String> = keys.iter().collect();
        self.keys.retain(|key| !keys.contains(key));
        self.records.retain(|record| !keys.contains(&record.key));
    }

    /// Whether a point has been run.
    pub fn has(&self, key: &str) -> bool {
        self.keys.contains(key)
    }

    /// All records, in the order of the file.
    pub fn records(&self) -> &[Record] {
        &self.records
    }

    /// Rows of the file that are not used: another build's, or cut short.
    pub fn ignored(&self) -> usize {
        self.ignored
    }

    /// What this program's records are marked with.
    pub fn program(&self) -> &str {
        &self.program
    }

    /// Adds a record, to the file at once.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn add(&mut self, record: Record) -> Result<(), StoreError> {
        write_row(&mut self.file, Some(&record)).map_err(|reason| StoreError { path: self.path.clone(), reason })?;
        self.take_in(record);
        Ok(())
    }
}

/// A record, or the header, in one write: two programs that append to one file do not mix lines.
fn write_row(file: &mut File, record: Option<&Record>) -> io::Result<()> {
    file.seek(SeekFrom::End(0))?;
    let mut writer = csv::WriterBuilder::new().has_headers(record.is_none()).from_writer(Vec::new());
    match record {
        Some(record) => writer.serialize(record)?,
        None => writer.write_record(HEADER)?,
    }
    let row = writer.into_inner().map_err(|error| error.into_error())?;
    file.write_all(&row)
}

/// The columns, in the order of [`Record`]'s fields.
const HEADER: [&str; 32] = [
    "key",
    "program",
    "scene",
    "parameters",
    "seconds",
    "series",
    "hz",
    "substeps",
    "iterations",
    "settings",
    "error",
    "unit",
    "uncertainty",
    "ms_per_step",
    "ms_spread",
    "ms_p95",
    "row_updates",
    "pairs",
    "axes_tested",
    "energy_drift",
    "linear_momentum_drift",
    "angular_momentum_drift",
    "joint_error",
    "penetration",
    "sink",
    "drift",
    "jitter",
    "force_error",
    "contact_residual",
    "contact_residual_last",
    "verdict",
    "reason",
];

/// The records in the file at `path` that the program at `program` measured, in the order of the file, all those of a
/// point that was measured again; none without a file.
pub fn read_records(path: &Path, program: &Path) -> Vec<Record> {
    let program = fingerprint(program);
    let text = std::fs::read(path).unwrap_or_default();
    rows(&text).flatten().filter(|record| record.program == program).collect()
}

/// The rows of a file; none for one that is cut short. The header of a file that was appended
/// whole is no row.
fn rows(text: &[u8]) -> impl Iterator<Item = Option<Record>> {
    let reader = csv::ReaderBuilder::new().flexible(true).from_reader(text);
    reader.into_records().filter_map(|row| {
        let row = row.ok();
        if row.as_ref().is_some_and(|row| row.iter().eq(HEADER)) {
            return None;
        }
        Some(row.and_then(|row| row.deserialize(None).ok()))
    })
}

/// 16 hex digits over a program's file: numbers of two builds are not to be mixed.
fn fingerprint(program: &Path) -> String {
    let mut hasher = Xxh3::new();
    if let Ok(mut file) = File::open(program) {
        let mut buffer = vec![0; 1 << 20];
        while let Ok(read @ 1..) = file.read(&mut buffer) {
            hasher.write(&buffer[..read]);
        }
    }
    format!("{:016x}", hasher.finish())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lab::sweep::Point;
    use crate::lab::verdict::{Judgement, Verdict};
    use crate::physics::SolverSettings;

    fn record(program: &str, scene: &str, reason: &str) -> Record {
        let point = Point {
            scene: scene.to_owned(),
            parameters: Vec::new(),
            settings: SolverSettings::default(),
            seconds: 2.0,
            series: "a".to_owned(),
        };
        Record::failed(&point, program, Judgement { verdict: Verdict::Unknown, reason: reason.to_owned() })
    }

    #[test]
    fn the_later_record_of_a_point_counts() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("points.csv");
        let reasons = |store: &Store| store.records().iter().map(|record| record.reason.clone()).collect::<Vec<_>>();
        let mut store = Store::open(&path).unwrap();
        let program = store.program().to_owned();
        store.add(record(&program, "one", "first")).unwrap();
        store.add(record(&program, "other", "other")).unwrap();
        let keys: Vec<String> = store.records().iter().map(|record| record.key.clone()).collect();

        store.set_aside(&keys[..1]);
        assert!(!store.has(&keys[0]) && store.has(&keys[1]));
        assert_eq!(reasons(&store), ["other"]);
        // An interrupt here loses nothing.
        assert_eq!(reasons(&Store::open(&path).unwrap()), ["first", "other"]);

        store.add(record(&program, "one", "second")).unwrap();
        assert_eq!(reasons(&store), ["other", "second"]);
        assert_eq!(reasons(&Store::open(&path).unwrap()), ["second", "other"]);
    }
}
