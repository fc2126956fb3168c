//! What is known of a built-in scene without building it, and its parameters.

use super::{MAX_BODIES, SceneError, SceneSpec};

/// A built-in scene.
pub struct SceneInfo {
    /// Its name on the command line.
    pub name: &'static str,
    /// Its name to people, no other scene's.
    pub title: &'static str,
    /// What it is looked at for.
    pub subject: Subject,
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

/// What a scene is looked at for before all else.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Subject {
    /// What joints hold, limit and bear.
    Joints,
    /// What touches, bounces and is stacked.
    Contacts,
    /// What slides, sticks and stands by it.
    Friction,
    /// What spins.
    Rotation,
    /// What is driven, and linkages.
    Machines,
    /// Hundreds of bodies, or large distances.
    Large,
}

impl Subject {
    /// All of them, with what each is called.
    pub const ALL: [(Self, &str); 6] = [
        (Self::Joints, "Joints"),
        (Self::Contacts, "Contacts"),
        (Self::Friction, "Friction"),
        (Self::Rotation, "Rotation"),
        (Self::Machines, "Machines"),
        (Self::Large, "Large"),
    ];
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
    pub(super) fn values(&self, given: &[(String, f64)]) -> Result<Vec<f64>, SceneError> {
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
