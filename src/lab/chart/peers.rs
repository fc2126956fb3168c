//! What other engines did on the same scenes, as the `peers` crate of this repository writes it.

use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::picture::Dot;
use super::subject::Subject;
use crate::scene::{Parameter, find};

/// One row of a file of the `peers` crate; other columns are not read.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct PeerRecord {
    /// The scene.
    pub scene: String,
    /// Its parameters as `n=5 tilt=30`; those left out are at their default.
    #[serde(default)]
    pub parameters: String,
    /// The engine's name.
    pub engine: String,
    /// Steps per second.
    pub hz: f64,
    /// Distance from the scene's answer.
    pub error: Option<f64>,
    /// Median wall-clock time of a step, ms.
    pub ms_per_step: Option<f64>,
}

/// Rows that cannot be had.
#[derive(Debug, thiserror::Error)]
#[error("{}: {reason}", path.display())]
pub struct PeersError {
    /// The file or folder.
    pub path: PathBuf,
    /// What is wrong with it.
    pub reason: String,
}

/// The rows of all CSV files in a folder, in the order of their names. Plumb's own are left out:
/// a chart measures them itself.
///
/// # Errors
/// A folder without such files, or a file that is none of the `peers` crate.
pub fn read_peers(folder: &Path) -> Result<Vec<PeerRecord>, PeersError> {
    let failed = |path: &Path, reason: &dyn ToString| PeersError { path: path.to_owned(), reason: reason.to_string() };
    let entries = std::fs::read_dir(folder).map_err(|error| failed(folder, &error))?;
    let mut files: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    files.retain(|path| path.extension().is_some_and(|extension| extension == "csv"));
    files.sort();
    if files.is_empty() {
        return Err(failed(folder, &"has no CSV file; let the peers crate write some with --out"));
    }
    let mut records = Vec::new();
    for path in files {
        let mut reader = csv::Reader::from_path(&path).map_err(|error| failed(&path, &error))?;
        for row in reader.deserialize::<PeerRecord>() {
            let row = row.map_err(|error| failed(&path, &error))?;
            if !row.engine.eq_ignore_ascii_case("plumb") {
                records.push(row);
            }
        }
    }
    Ok(records)
}

impl PeerRecord {
    /// Whether it ran a chart's scene with its parameters; what either leaves out is at its default.
    pub(super) fn is_of(&self, subject: &Subject) -> bool {
        let assignments = self.parameters.split_whitespace().filter_map(|assignment| assignment.split_once('='));
        let own: Vec<(&str, f64)> = assignments.filter_map(|(name, value)| Some((name, value.parse().ok()?))).collect();
        let asked = |name: &str| subject.parameters.iter().rev().find(|(known, _)| known == name).map(|pair| pair.1);
        let ran = |name: &str| own.iter().find(|(known, _)| *known == name).map(|pair| pair.1);
        let parameters = find(&subject.scene).map_or(&[][..], |info| info.parameters);
        let same =
            |known: &Parameter| asked(known.name).unwrap_or(known.default) == ran(known.name).unwrap_or(known.default);
        self.scene == subject.scene && parameters.iter().all(same)
    }

    pub(super) fn dot(&self) -> Option<Dot> {
        Some(Dot { cost: self.ms_per_step? * self.hz, error: self.error?, holds: true })
    }
}

/// The engines of some rows, each once, in the order of their first row.
pub(super) fn engines(records: &[&PeerRecord]) -> Vec<String> {
    let mut engines: Vec<String> = Vec::new();
    for record in records {
        if !engines.contains(&record.engine) {
            engines.push(record.engine.clone());
        }
    }
    engines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_peer_ran_the_scene_if_all_parameters_agree_defaults_included() {
        let ran = |scene: &str, parameters: &str| PeerRecord {
            scene: scene.into(),
            parameters: parameters.into(),
            engine: "rapier".into(),
            hz: 60.0,
            error: Some(0.1),
            ms_per_step: Some(1.0),
        };
        let subject = |scene: &str, parameters: &[(&str, f64)]| Subject {
            scene: scene.into(),
            parameters: parameters.iter().map(|&(name, value)| (name.into(), value)).collect(),
        };
        // 5 rods are the default.
        for parameters in ["", "n=5"] {
            assert!(ran("rods", parameters).is_of(&subject("rods", &[])));
            assert!(ran("rods", parameters).is_of(&subject("rods", &[("n", 5.0)])));
            assert!(!ran("rods", parameters).is_of(&subject("rods", &[("n", 2.0)])));
        }
        assert!(!ran("rods", "n=2").is_of(&subject("rods", &[])));
        assert!(!ran("chain", "").is_of(&subject("rods", &[])));
        assert!(ran("joint_grid", "n=100 tilt=0").is_of(&subject("joint_grid", &[("n", 100.0)])));
    }
}
