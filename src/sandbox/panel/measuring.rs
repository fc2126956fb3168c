//! Measuring by a process of its own, so that game and measurement do not spoil each other.

use std::io::Read;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use bevy::prelude::*;

use crate::lab::chart::POINTS;
use crate::lab::sweep::{Record, read_records};

/// How often a measurement at work is looked at.
const LOOK_EVERY: Duration = Duration::from_millis(250);

/// Who measures charts and sweeps, and where they are kept.
#[derive(Resource, Clone, Debug)]
pub struct ChartSource {
    /// The program, called as `plumb chart SCENE … --out FOLDER`.
    pub program: PathBuf,
    /// The folder.
    pub folder: PathBuf,
}

impl ChartSource {
    fn file(&self) -> PathBuf {
        self.folder.join(POINTS)
    }

    /// What the program has measured, in the order of the file.
    pub fn records(&self) -> Vec<Record> {
        read_records(&self.file(), &self.program)
    }
}

/// A measurement at work; ends when it is dropped.
pub struct Measuring {
    child: Child,
    looked: Instant,
    /// Of the file when it was read last, bytes.
    length: u64,
    /// Records of the file before this one are of earlier measurements.
    pub since: usize,
}

/// What became of a measurement since the last look.
#[derive(Debug, PartialEq)]
pub enum Progress {
    /// Nothing that is known.
    Nothing,
    /// The file has more.
    More,
    /// It has ended: why, in one line, where it failed.
    Ended(Result<(), String>),
}

impl Measuring {
    /// Starts `plumb chart` with those arguments; records of the file from `since` on count as its own.
    ///
    /// # Errors
    /// The program cannot be run.
    pub fn start(source: &ChartSource, since: usize, arguments: &[String]) -> std::io::Result<Self> {
        let mut command = Command::new(&source.program);
        command.arg("chart").args(arguments).arg("--out").arg(&source.folder);
        let child = command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped()).spawn()?;
        Ok(Self { child, looked: Instant::now(), length: 0, since })
    }

    /// Looks after it, now and then. What has ended has no more to tell.
    pub fn look(&mut self, source: &ChartSource) -> Progress {
        match self.child.try_wait() {
            Ok(Some(status)) if status.success() => Progress::Ended(Ok(())),
            Ok(Some(_)) => Progress::Ended(Err(self.last_words())),
            Err(error) => Progress::Ended(Err(error.to_string())),
            Ok(None) if self.looked.elapsed() < LOOK_EVERY => Progress::Nothing,
            Ok(None) => {
                self.looked = Instant::now();
                let length = std::fs::metadata(source.file()).map_or(0, |file| file.len());
                if std::mem::replace(&mut self.length, length) == length { Progress::Nothing } else { Progress::More }
            }
        }
    }

    /// The last line that it wrote to standard error, but for a panic's hint.
    fn last_words(&mut self) -> String {
        let mut said = String::new();
        if let Some(mut errors) = self.child.stderr.take() {
            // What cannot be read is not told.
            let _ = errors.read_to_string(&mut said);
        }
        let lines = said.lines().rev().map(str::trim).find(|line| !line.is_empty() && !line.starts_with("note:"));
        lines.map_or_else(|| "it ended too early".into(), |line| line.trim_start_matches("plumb: ").to_owned())
    }
}

impl Drop for Measuring {
    fn drop(&mut self) {
        // It may have ended by itself; then there is nothing to do.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

pub(super) fn plugin(app: &mut App) {
    app.insert_resource(ChartSource {
        program: std::env::current_exe().unwrap_or_default(),
        folder: PathBuf::from("charts"),
    });
}
