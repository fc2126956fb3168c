//! Failure maps: over two parameters of a scene or of the settings, where a method holds, degrades
//! and fails.
//!
//! `atlas` lists the maps that are known by name; the points of a map are measured by the sweep as those of a chart are,
//! and judged by [`judge`](super::verdict::judge); `picture` draws them.

mod atlas;
mod picture;
mod plan;

use std::path::{Path, PathBuf};

pub use atlas::{ATLAS, Axis, Compared, MapInfo};
pub use picture::Map;
pub use plan::MapPlan;

use super::picture::{PictureError, write};
use super::sweep::{Point, Record};
use super::vary::{Assignment, Candidate};

impl MapPlan {
    /// The maps, one a candidate, from the records of [`points`](Self::points).
    pub fn maps(&self, records: &[Record]) -> Vec<Map> {
        let run = |point: Point| {
            let key = point.key();
            records.iter().find(|record| record.key == key).cloned()
        };
        let cells = |candidate: &Candidate| {
            let row = |&y: &Assignment| -> Vec<_> {
                self.x.values().iter().map(|&x| run(self.point(candidate, x, y))).collect()
            };
            self.y.values().iter().map(row).collect()
        };
        let candidates = self.study.candidates.iter();
        candidates.map(|candidate| Map { series: candidate.name.clone(), cells: cells(candidate) }).collect()
    }

    /// Draws the maps of all candidates beside each other, `map-NAME.svg` and `.png`, and tells the path of the first.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn draw(&self, maps: &[Map], folder: &Path) -> Result<PathBuf, PictureError> {
        let path = folder.join(format!("map-{}.svg", self.name));
        write(&picture::Sheet { plan: self, maps }, &path)?;
        Ok(path)
    }
}
