//! A scene, the settings that are compared on it, and what is varied.

use super::assignment::{Assignment, VaryError};
use super::variation::Variation;
use crate::lab::chart::{SERIES, Series};
use crate::lab::plan::{Plan, PlanError};
use crate::lab::sweep::Point;
use crate::physics::{SolverSettings, WrittenSettings};

/// Settings that are compared with others: a curve of a chart, a panel of a map.
#[derive(Clone, Debug, PartialEq)]
pub struct Candidate {
    /// Its name in legends and files.
    pub name: String,
    /// What does not vary.
    pub settings: SolverSettings,
    /// What it differs in from the others, put on top.
    pub with: Vec<Assignment>,
}

impl Candidate {
    /// Settings as they are.
    pub fn new(name: impl Into<String>, settings: SolverSettings) -> Self {
        Self { name: name.into(), settings, with: Vec::new() }
    }

    /// One of the charts' methods, on one thread.
    pub fn of(series: &Series) -> Self {
        Self::new(series.name, SolverSettings { threads: 1, ..(series.base)() })
    }

    /// All of the charts' methods.
    pub fn methods() -> Vec<Self> {
        SERIES.iter().map(Self::of).collect()
    }

    /// The same with some things changed, by a name that says which.
    pub fn changed(&self, changes: &[Assignment]) -> Self {
        let names: Vec<String> = changes.iter().map(Assignment::to_string).collect();
        let with = self.with.iter().chain(changes).copied().collect();
        Self { name: names.join(", "), with, ..self.clone() }
    }

    /// Its settings with what it differs in, none of which may go unread.
    fn written(&self) -> WrittenSettings {
        let mut written = WrittenSettings::from_preset(self.settings);
        self.with.iter().for_each(|assignment| write(assignment, &mut written));
        written
    }
}

/// Writes a setting as a user does; a parameter is none.
pub(in crate::lab) fn write(assignment: &Assignment, written: &mut WrittenSettings) {
    let Some(setting) = assignment.setting() else { return };
    let mut changed = written.settings;
    assignment.put_in(&mut changed);
    written.write(setting.path, Some(changed), |settings| settings);
}

/// What is run: every candidate on one scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Study {
    /// A built-in scene or the path of a RON file.
    pub scene: String,
    /// Its parameters that differ from their defaults and do not vary.
    pub parameters: Vec<(String, f64)>,
    /// Time to simulate, s.
    pub seconds: f64,
    /// What is compared.
    pub candidates: Vec<Candidate>,
}

impl Study {
    /// Candidates, of which there is at least one, on a scene, for `seconds` or as long as it suggests.
    ///
    /// # Errors
    /// A scene or parameter that does not exist, or a length that makes no run.
    pub fn new(
        scene: &str,
        parameters: &[(String, f64)],
        candidates: Vec<Candidate>,
        seconds: Option<f64>,
    ) -> Result<Self, PlanError> {
        let plan = Plan::new(scene, parameters, candidates[0].settings, seconds)?;
        let seconds = plan.steps as f64 / plan.settings.hz;
        Ok(Self { scene: scene.to_owned(), parameters: parameters.to_vec(), seconds, candidates })
    }

    /// The run of a candidate with some values.
    pub fn point(&self, candidate: &Candidate, values: &[Assignment]) -> Point {
        let mut point = Point {
            scene: self.scene.clone(),
            parameters: self.parameters.clone(),
            settings: candidate.settings,
            seconds: self.seconds,
            series: candidate.name.clone(),
        };
        candidate.with.iter().chain(values).for_each(|assignment| assignment.put(&mut point));
        point
    }

    /// What candidates differ in, for the name of a picture: `-and-contacts`; empty where nothing was put on top.
    pub fn compared(&self) -> String {
        let mut names: Vec<&str> = Vec::new();
        for assignment in self.candidates.iter().flat_map(|candidate| &candidate.with) {
            if !names.contains(&assignment.name()) {
                names.push(assignment.name());
            }
        }
        names.iter().map(|name| format!("-and-{name}")).collect()
    }

    /// Leaves out the candidates on which nothing varies, since their methods read none of it.
    pub fn keep_those_that_read(&mut self, varied: &[&Variation]) {
        self.candidates.retain(|candidate| varied.iter().any(|variation| reads(candidate, variation, varied)));
    }

    /// Checks that each candidate reads what it differs in, and that somebody reads each thing that varies.
    ///
    /// # Errors
    /// The first that nobody reads, and why.
    pub fn check(&self, varied: &[&Variation]) -> Result<(), VaryError> {
        for candidate in &self.candidates {
            candidate.written().check().map_err(|error| VaryError(format!("{}: {error}", candidate.name)))?;
        }
        for variation in varied {
            let unread = variation.values()[0].setting();
            if let (Some(setting), Some(first)) = (unread, self.candidates.first())
                && !self.candidates.iter().any(|candidate| reads(candidate, variation, varied))
            {
                let problem = setting.why_unread(&first.written().settings);
                return Err(VaryError(format!("{}: {problem}", setting.name)));
            }
        }
        Ok(())
    }
}

/// Whether a variation makes a difference to a candidate, at some values of the others.
fn reads(candidate: &Candidate, variation: &Variation, varied: &[&Variation]) -> bool {
    let others: Vec<&Variation> = varied.iter().copied().filter(|other| other.name() != variation.name()).collect();
    let mut settings = vec![candidate.written().settings];
    for other in others {
        let with = |settings: &SolverSettings| {
            let settings = *settings;
            let put = move |value: &Assignment| {
                let mut settings = settings;
                value.put_in(&mut settings);
                settings
            };
            other.values().iter().map(put).collect::<Vec<_>>()
        };
        settings = settings.iter().flat_map(with).collect();
    }
    // A choice may be of another method's setting: with some value it is read.
    let is_read = |value: &Assignment, settings: &SolverSettings| {
        let mut settings = *settings;
        value.put_in(&mut settings);
        value.setting().is_none_or(|setting| setting.is_read(&settings))
    };
    variation.values().iter().any(|value| settings.iter().any(|settings| is_read(value, settings)))
}
