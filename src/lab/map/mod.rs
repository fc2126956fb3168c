//! Failure maps: over two parameters of a scene or of the settings, where a method holds, degrades
//! and fails.
//!
//! `atlas` lists the maps; the points of a map are measured by the sweep as those of a chart are,
//! and judged by [`judge`](super::verdict::judge); `picture` draws them.

mod atlas;
mod picture;

use std::path::Path;

pub use atlas::{ATLAS, Axis, MapInfo, Quantity};
pub use picture::Map;

use super::chart::{SERIES, Series};
use super::picture::{PictureError, write};
use super::sweep::{Point, Record};
use crate::physics::{Method, SolverSettings};

impl MapInfo {
    /// What is drawn, in words: the scene, and what is fixed.
    pub fn title(&self) -> String {
        let fixed = self.parameters.iter().map(|(name, value)| format!(" {name}={value}"));
        std::iter::once(self.scene.to_owned()).chain(fixed).collect()
    }

    /// The points of this map for every method, by method, row and column.
    pub fn points(&self) -> Vec<Point> {
        let mut points = Vec::new();
        for series in self.compared() {
            for &y in self.y.values {
                for &x in self.x.values {
                    points.push(self.point(series.name, (series.base)(), x, y));
                }
            }
        }
        points
    }

    /// The curves that it compares: the first ones, and the last, the true method.
    fn compared(&self) -> impl Iterator<Item = &'static Series> {
        SERIES[..self.series].iter().chain(SERIES.last())
    }

    /// The point at (x, y) for some settings. Sweeps of a method that has none are left as they are.
    pub fn point(&self, series: &str, base: SolverSettings, x: f64, y: f64) -> Point {
        let mut point = Point {
            scene: self.scene.to_owned(),
            parameters: self.parameters.iter().map(|&(name, value)| (name.to_owned(), value)).collect(),
            settings: SolverSettings { threads: 1, ..base },
            seconds: self.seconds,
            series: series.to_owned(),
        };
        for (axis, value) in [(&self.x, x), (&self.y, y)] {
            match axis.quantity {
                Quantity::Parameter(name) => point.parameters.push((name.to_owned(), value)),
                Quantity::Hz => point.settings.hz = value,
                Quantity::Substeps => point.settings.substeps = value as u32,
                Quantity::Iterations if base.method == Method::Exact => {}
                Quantity::Iterations => point.settings.iterations = value as u32,
            }
        }
        point
    }

    /// The maps, one a method, from the records of [`points`](Self::points).
    pub fn maps(&self, records: &[Record]) -> Vec<Map> {
        let verdict = |point: Point| {
            let key = point.key();
            records.iter().find(|record| record.key == key).map(|record| record.verdict)
        };
        let cells = |series: &Series| {
            let row = |&y: &f64| -> Vec<_> {
                self.x.values.iter().map(|&x| verdict(self.point(series.name, (series.base)(), x, y))).collect()
            };
            self.y.values.iter().map(row).collect()
        };
        self.compared().map(|series| Map { series: series.name, cells: cells(series) }).collect()
    }

    /// Draws the maps of all methods beside each other, `map-NAME.svg` and `.png`.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn draw(&self, maps: &[Map], folder: &Path) -> Result<(), PictureError> {
        write(&picture::Sheet { info: self, maps }, &folder.join(format!("map-{}", self.name)))
    }
}
