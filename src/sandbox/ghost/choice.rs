//! What is drawn as ghosts.

use bevy::prelude::*;

use crate::lab::chart::SERIES;
use crate::lab::vary::Assignment;
use crate::physics::SolverSettings;

/// Most ghosts: more colors nobody tells apart.
pub const MOST_GHOSTS: usize = 3;

/// What runs beside the scene: no more than [`MOST_GHOSTS`]. A change lets all of them run on from where the scene is; a new
/// start of the scene lets them start with it.
#[derive(Resource, Clone, Debug, Default, PartialEq)]
pub struct Ghosts(pub Vec<GhostChoice>);

/// Who is a ghost.
#[derive(Clone, Debug, PartialEq)]
pub enum GhostChoice {
    /// The method of that index in [`SERIES`].
    Method(usize),
    /// The settings that the scene has when the ghosts start, but for one thing.
    Changed(Assignment),
    /// The settings of a file, under its name.
    Saved(String, Box<SolverSettings>),
    /// The reference answer, for scenes whose answer gives the whole motion.
    Reference,
}

/// What lists call the present settings with something changed.
pub(super) const CHANGED: &str = "these settings, but for";

impl GhostChoice {
    /// What tables and plots call it.
    pub fn name(&self) -> String {
        match self {
            Self::Method(index) => SERIES.get(*index).map_or_else(String::new, |series| series.name.to_owned()),
            Self::Changed(assignment) => assignment.to_string(),
            Self::Saved(name, _) => name.clone(),
            Self::Reference => "the answer".into(),
        }
    }

    /// The settings that it runs by, where the scene runs by others; none of the answer.
    pub(super) fn settings(&self, present: &SolverSettings) -> Option<SolverSettings> {
        let threads = present.threads;
        match self {
            Self::Method(index) => Some(SolverSettings { threads, ..(SERIES.get(*index)?.base)() }),
            Self::Saved(_, settings) => Some(**settings),
            Self::Changed(assignment) => {
                let mut settings = *present;
                assignment.put_in(&mut settings);
                Some(settings)
            }
            Self::Reference => None,
        }
    }
}
