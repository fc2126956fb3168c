//! What a map is of.

use crate::lab::chart::Subject;
use crate::lab::sweep::Point;
use crate::lab::vary::{Assignment, Candidate, Measure, Study, Variation};

/// What a map is of: a study over two variations.
#[derive(Clone, Debug, PartialEq)]
pub struct MapPlan {
    /// Its picture is `map-NAME.svg`.
    pub name: String,
    /// What is run.
    pub study: Study,
    /// Across.
    pub x: Variation,
    /// In words, with its unit.
    pub x_label: String,
    /// Upwards.
    pub y: Variation,
    /// In words, with its unit.
    pub y_label: String,
    /// What the border is expected to show, in a sentence; empty where nothing is.
    pub about: String,
    /// What is written into the cells; none: a cross where a run fails.
    pub measure: Option<&'static Measure>,
}

impl MapPlan {
    /// A map of whatever two things.
    pub fn new(study: Study, x: Variation, y: Variation) -> Self {
        let subject = Subject { scene: study.scene.clone(), parameters: study.parameters.clone() };
        let stem = subject.stem().replace('.', "_");
        Self {
            name: format!("{stem}-by-{}-{}{}", x.name(), y.name(), study.compared()),
            x_label: x.label().to_owned(),
            y_label: y.label().to_owned(),
            study,
            x,
            y,
            about: String::new(),
            measure: None,
        }
    }

    /// What is drawn, in words: the scene, and what is fixed.
    pub fn title(&self) -> String {
        let Study { scene, parameters, .. } = &self.study;
        Subject { scene: scene.clone(), parameters: parameters.clone() }.title()
    }

    /// The points of this map for every candidate, by candidate, row and column.
    pub fn points(&self) -> Vec<Point> {
        let mut points = Vec::new();
        for candidate in &self.study.candidates {
            for y in self.y.values() {
                for x in self.x.values() {
                    points.push(self.point(candidate, *x, *y));
                }
            }
        }
        points
    }

    /// The point at (x, y).
    pub fn point(&self, candidate: &Candidate, x: Assignment, y: Assignment) -> Point {
        self.study.point(candidate, &[x, y])
    }
}
