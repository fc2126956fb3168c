//! The built-in scenes, by name, with their parameters; and loading a scene by name or path.

use super::{MAX_BODIES, SceneError, SceneSpec, builtin, format};

/// A built-in scene.
pub struct SceneInfo {
    /// Its name on the command line.
    pub name: &'static str,
    /// What it is, in one line.
    pub about: &'static str,
    /// What is known of its answer, in one line.
    pub truth: &'static str,
    /// Its parameters, in order.
    pub parameters: &'static [Parameter],
    /// Seconds that `plumb run` simulates where none are asked for.
    pub seconds: f64,
    /// How many bodies [`build`](Self::build) makes, known before any is made.
    pub bodies: fn(&[f64]) -> f64,
    /// Builds it from one value per parameter, in order, each in its range;
    /// [`make`](Self::make) checks first.
    pub build: fn(&[f64]) -> SceneSpec,
}

/// A number that a built-in scene depends on.
pub struct Parameter {
    /// Its name on the command line.
    pub name: &'static str,
    /// What it is, with its unit.
    pub about: &'static str,
    /// Its value where none is given.
    pub default: f64,
    /// Smallest value.
    pub min: f64,
    /// Largest value.
    pub max: f64,
    /// Whether only whole numbers make sense.
    pub integer: bool,
}

impl SceneInfo {
    /// One value per parameter: its default.
    pub fn defaults(&self) -> Vec<f64> {
        self.parameters.iter().map(|parameter| parameter.default).collect()
    }

    /// Builds it from one value per parameter, in order.
    ///
    /// # Errors
    /// A value out of its range, or more than [`MAX_BODIES`], found before anything is built.
    ///
    /// # Panics
    /// There are not as many values as parameters.
    pub fn make(&self, values: &[f64]) -> Result<SceneSpec, SceneError> {
        assert_eq!(values.len(), self.parameters.len(), "one value per parameter of '{}'", self.name);
        for (parameter, &value) in self.parameters.iter().zip(values) {
            if !parameter.allows(value) {
                return Err(SceneError::BadParameter {
                    scene: self.name.to_owned(),
                    parameter: parameter.name,
                    must_be: parameter.range(),
                    value,
                });
            }
        }
        let bodies = (self.bodies)(values);
        if bodies > MAX_BODIES as f64 {
            return Err(SceneError::TooManyBodies { scene: self.name.to_owned(), bodies: bodies as u64 });
        }
        let scene = (self.build)(values);
        scene.validate()?;
        Ok(scene)
    }

    /// The parameters' values where some are given by name and the rest are at their default.
    fn values(&self, given: &[(String, f64)]) -> Result<Vec<f64>, SceneError> {
        let mut values = self.defaults();
        for (index, (name, value)) in given.iter().enumerate() {
            let Some(slot) = self.parameters.iter().position(|parameter| parameter.name == name) else {
                return Err(SceneError::UnknownParameter {
                    scene: self.name.to_owned(),
                    parameter: name.clone(),
                    known: self.parameters.iter().map(|parameter| parameter.name).collect(),
                });
            };
            if given[..index].iter().any(|(earlier, _)| earlier == name) {
                return Err(SceneError::RepeatedParameter { scene: self.name.to_owned(), parameter: name.clone() });
            }
            values[slot] = *value;
        }
        Ok(values)
    }
}

impl Parameter {
    /// A real number from `min` to `max`.
    pub(super) const fn real(name: &'static str, about: &'static str, default: f64, min: f64, max: f64) -> Self {
        Self { name, about, default, min, max, integer: false }
    }

    /// A whole number from `min` to `max`.
    pub(super) const fn whole(name: &'static str, about: &'static str, default: f64, min: f64, max: f64) -> Self {
        Self { name, about, default, min, max, integer: true }
    }

    /// Whether it may have that value.
    pub fn allows(&self, value: f64) -> bool {
        (self.min..=self.max).contains(&value) && (!self.integer || value.fract() == 0.0)
    }

    /// What it may be, in words.
    pub fn range(&self) -> String {
        let kind = if self.integer { "a whole number " } else { "" };
        format!("{kind}from {} to {}", self.min, self.max)
    }
}

/// All built-in scenes, the start scene first.
pub fn catalog() -> &'static [SceneInfo] {
    &builtin::ALL
}

/// The built-in scene of that name.
pub fn find(name: &str) -> Option<&'static SceneInfo> {
    catalog().iter().find(|scene| scene.name == name)
}

/// A scene by built-in name or path to a RON file, with parameters as given on the command line
/// (`n=40`); checked. [`is_path`] tells the one from the other.
///
/// # Errors
/// An unknown scene or parameter, a value out of range, or whatever is wrong with the file.
pub fn load(scene: &str, parameters: &[(String, f64)]) -> Result<SceneSpec, SceneError> {
    if is_path(scene) {
        return match parameters.first() {
            None => format::read(scene),
            Some((parameter, _)) => Err(SceneError::UnknownParameter {
                scene: scene.to_owned(),
                parameter: parameter.clone(),
                known: Vec::new(),
            }),
        };
    }
    let info =
        find(scene).ok_or_else(|| SceneError::UnknownScene { name: scene.to_owned(), nearest: nearest_name(scene) })?;
    info.make(&info.values(parameters)?)
}

/// Whether that is a path, and not the name of a built-in scene: it ends in `.ron` or has a path
/// separator in it.
pub fn is_path(scene: &str) -> bool {
    scene.ends_with(".ron") || scene.contains(std::path::is_separator)
}

/// The built-in name that takes the fewest edits to reach, if at most a third of it is wrong.
fn nearest_name(name: &str) -> Option<&'static str> {
    let name = name.to_lowercase();
    let (distance, nearest) =
        catalog().iter().map(|scene| (edit_distance(&name, scene.name), scene.name)).min_by_key(|&(edits, _)| edits)?;
    (distance <= nearest.chars().count().div_ceil(3)).then_some(nearest)
}

/// Levenshtein's distance: how many characters to insert, remove or replace.
fn edit_distance(from: &str, to: &str) -> usize {
    let to: Vec<char> = to.chars().collect();
    let mut row: Vec<usize> = (0..=to.len()).collect();
    for (i, a) in from.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, &b) in to.iter().enumerate() {
            let replaced = diagonal + usize::from(a != b);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[to.len()]
}
