//! What can be wrong with a scene, each in one line that names the place and the cure.

use super::MAX_BODIES;

/// Why a scene could not be had. Displays as one line.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SceneError {
    /// No built-in scene of that name.
    #[error(
        "no scene '{name}'{}; 'plumb scenes' lists the built-in ones, a scene of your own is a path that ends in .ron",
        nearest.map(|nearest| format!(", did you mean '{nearest}'?")).unwrap_or_default()
    )]
    UnknownScene {
        /// What was asked for.
        name: String,
        /// The built-in name that is spelled most like it, if any is close.
        nearest: Option<&'static str>,
    },
    /// A parameter that the scene does not have.
    #[error("{scene}: no parameter '{parameter}'; {}", if known.is_empty() {
        "it has none".to_owned()
    } else {
        format!("it has {}", known.join(", "))
    })]
    UnknownParameter {
        /// The scene's name or path.
        scene: String,
        /// What was given.
        parameter: String,
        /// What it has.
        known: Vec<&'static str>,
    },
    /// The same parameter twice.
    #[error("{scene}: parameter '{parameter}' is given twice; give it once")]
    RepeatedParameter {
        /// The scene's name.
        scene: String,
        /// The parameter's.
        parameter: String,
    },
    /// A parameter's value out of its range, not whole where it must be, or not finite.
    #[error("{scene}: parameter {parameter} must be {must_be}, is {value}")]
    BadParameter {
        /// The scene's name.
        scene: String,
        /// The parameter's.
        parameter: &'static str,
        /// Its range.
        must_be: String,
        /// Its value.
        value: f64,
    },
    /// More bodies than [`MAX_BODIES`].
    #[error("{scene}: {bodies} bodies are more than the limit of {MAX_BODIES}; make the scene smaller")]
    TooManyBodies {
        /// The scene's name or path.
        scene: String,
        /// How many it has or would have.
        bodies: u64,
    },
    /// A file that cannot be read as text.
    #[error("{path}: {problem}")]
    Unreadable {
        /// The file.
        path: String,
        /// Why.
        problem: String,
    },
    /// What the parser sees: syntax, types, unknown fields, numbers out of their range.
    #[error("{path}:{line}:{column}: {problem}")]
    Parse {
        /// The file.
        path: String,
        /// From 1.
        line: usize,
        /// From 1, in characters.
        column: usize,
        /// What is wrong.
        problem: String,
    },
    /// What only the whole scene shows.
    #[error("{scene}: {place}: {problem}")]
    Flawed {
        /// The scene's name or path.
        scene: String,
        /// Where in it: `joints[3].body_b`.
        place: String,
        /// What is wrong.
        problem: String,
    },
}

/// Something wrong at a place of a scene.
#[derive(Debug)]
pub(super) struct Flaw {
    /// Where: `joints[3].body_b`.
    pub place: String,
    /// What.
    pub problem: String,
}

impl Flaw {
    pub fn new(place: impl Into<String>, problem: impl Into<String>) -> Self {
        Self { place: place.into(), problem: problem.into() }
    }

    /// As an error of the scene of that name or path.
    pub fn of(self, scene: &str) -> SceneError {
        SceneError::Flawed { scene: scene.to_owned(), place: self.place, problem: self.problem }
    }
}
