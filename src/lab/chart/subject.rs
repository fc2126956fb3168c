//! What a chart is drawn of.

use std::path::Path;

use super::grid::{Extent, SERIES, points};
use crate::lab::plan::{Plan, PlanError};
use crate::lab::sweep::Point;

/// A scene to draw a chart of.
#[derive(Clone, Debug, PartialEq)]
pub struct Subject {
    /// A built-in scene or the path of a RON file.
    pub scene: String,
    /// Its parameters that differ from their defaults.
    pub parameters: Vec<(String, f64)>,
}

impl Subject {
    /// The points of its chart.
    ///
    /// # Errors
    /// A scene or parameter that does not exist.
    pub fn points(&self, extent: Extent) -> Result<Vec<Point>, PlanError> {
        let plan = Plan::new(&self.scene, &self.parameters, (SERIES[0].base)(), None)?;
        let seconds = plan.steps as f64 / plan.settings.hz;
        Ok(points(&self.scene, &self.parameters, extent.seconds(seconds), extent))
    }

    /// What its picture's files are called, without extension.
    pub fn stem(&self) -> String {
        let scene = Path::new(&self.scene).file_stem().map_or(self.scene.clone(), |stem| stem.to_string_lossy().into());
        let parameters = self.parameters.iter().map(|(name, value)| format!("-{name}-{value}"));
        std::iter::once(scene).chain(parameters).collect()
    }

    /// `rods n=5`.
    pub fn title(&self) -> String {
        let parameters = self.parameters.iter().map(|(name, value)| format!(" {name}={value}"));
        std::iter::once(self.scene.clone()).chain(parameters).collect()
    }
}
