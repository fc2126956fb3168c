//! One setting, or one parameter of a scene, and its value.

use std::fmt;

use bevy::reflect::enums::DynamicEnum;
use bevy::reflect::{GetPath, ReflectRef};

use crate::lab::sweep::Point;
use crate::physics::{SETTINGS, Setting, SolverSettings};
use crate::scene::{Parameter, SceneInfo};

/// Why an assignment or a variation cannot be understood, with what may be written.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct VaryError(pub(super) String);

/// What a setting or a parameter may be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value {
    /// A number.
    Number(f64),
    /// A switch.
    Switch(bool),
    /// A choice, by its name in files.
    Choice(&'static str),
    /// No limit, where a number may be left out.
    None,
}

impl Value {
    /// The number, if it is one.
    pub fn number(self) -> Option<f64> {
        if let Self::Number(value) = self { Some(value) } else { None }
    }
}

impl fmt::Display for Value {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Number(value) if *value != 0.0 && !(1e-3..1e5).contains(&value.abs()) => {
                write!(formatter, "{value:e}")
            }
            Self::Number(value) => write!(formatter, "{value}"),
            Self::Switch(value) => write!(formatter, "{value}"),
            Self::Choice(name) => formatter.write_str(name),
            Self::None => formatter.write_str("None"),
        }
    }
}

/// What can be set.
#[derive(Clone, Copy)]
pub(super) enum Quantity {
    Setting(&'static Setting),
    Parameter(&'static Parameter),
}

/// A value for a setting or for a parameter of a scene; in its range.
#[derive(Clone, Copy)]
pub struct Assignment {
    pub(super) quantity: Quantity,
    /// The value.
    pub value: Value,
}

impl fmt::Debug for Assignment {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        fmt::Display::fmt(self, formatter)
    }
}

impl PartialEq for Assignment {
    fn eq(&self, other: &Self) -> bool {
        self.name() == other.name() && self.value == other.value
    }
}

/// `baumgarte=0.2`.
impl fmt::Display for Assignment {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        write!(formatter, "{}={}", self.name(), self.value)
    }
}

impl Assignment {
    /// Reads `NAME=VALUE`, of a setting or, where a built-in scene is given, of one of its parameters.
    ///
    /// # Errors
    /// No such name, or a value that it cannot have.
    pub fn parse(text: &str, scene: Option<&SceneInfo>) -> Result<Self, VaryError> {
        let (name, value) = split(text)?;
        Self::new(name, value, scene)
    }

    /// The same of a name and a value.
    ///
    /// # Errors
    /// As [`parse`](Self::parse).
    pub fn new(name: &str, value: &str, scene: Option<&SceneInfo>) -> Result<Self, VaryError> {
        let parameters = scene.map_or(&[][..], |info| info.parameters);
        if let Some(parameter) = parameters.iter().find(|parameter| parameter.name == name) {
            return of_parameter(parameter, value);
        }
        let settings: Vec<&'static Setting> = SETTINGS.iter().filter(|setting| setting.name == name).collect();
        if settings.is_empty() {
            let known = parameters.iter().map(|parameter| parameter.name);
            let mut known: Vec<&str> = known.chain(SETTINGS.iter().map(|setting| setting.name)).collect();
            let last = known.len();
            // Integrators of two engines share a name.
            known =
                (0..last).filter(|&index| !known[..index].contains(&known[index])).map(|index| known[index]).collect();
            return Err(VaryError(format!("nothing is named '{name}'; there are {}", known.join(", "))));
        }
        // Integrators of two engines share a name: the value tells whose is meant.
        let of = |setting: &&&'static Setting| setting.choices.iter().any(|choice| choice.name == value);
        match settings.iter().find(of) {
            Some(setting) => of_setting(setting, value),
            None if settings.len() > 1 => Err(no_choice(name, &settings, value)),
            None => of_setting(settings[0], value),
        }
    }

    /// The value that settings have.
    pub fn of_settings(setting: &'static Setting, settings: &SolverSettings) -> Option<Self> {
        let value = settings.reflect_path(setting.path).ok()?;
        let value = if let Some(value) = value.try_downcast_ref::<f64>() {
            Value::Number(*value)
        } else if let Some(value) = value.try_downcast_ref::<u32>() {
            Value::Number(f64::from(*value))
        } else if let Some(value) = value.try_downcast_ref::<bool>() {
            Value::Switch(*value)
        } else if let Some(value) = value.try_downcast_ref::<Option<f64>>() {
            value.map_or(Value::None, Value::Number)
        } else {
            let ReflectRef::Enum(value) = value.reflect_ref() else { return None };
            Value::Choice(setting.choices.iter().find(|choice| choice.variant == value.variant_name())?.name)
        };
        Some(Self { quantity: Quantity::Setting(setting), value })
    }

    /// What it sets.
    pub fn name(&self) -> &'static str {
        match self.quantity {
            Quantity::Setting(setting) => setting.name,
            Quantity::Parameter(parameter) => parameter.name,
        }
    }

    /// The setting; none of a parameter.
    pub fn setting(&self) -> Option<&'static Setting> {
        match self.quantity {
            Quantity::Setting(setting) => Some(setting),
            Quantity::Parameter(_) => None,
        }
    }

    /// What it sets, for an axis: of a parameter with its unit, where that is short.
    pub fn label(&self) -> &'static str {
        const MOST_LETTERS: usize = 40;
        match self.quantity {
            Quantity::Setting(setting) => setting.name,
            Quantity::Parameter(parameter) => {
                let about = parameter.about.split(':').next().unwrap_or(parameter.about);
                if about.len() <= MOST_LETTERS { about } else { parameter.name }
            }
        }
    }

    /// Whether only whole numbers make sense.
    pub(super) fn is_whole(&self) -> bool {
        match self.quantity {
            Quantity::Setting(setting) => matches!(Kind::of(setting), Kind::Whole),
            Quantity::Parameter(parameter) => parameter.integer,
        }
    }

    /// Sets it for a run.
    pub fn put(&self, point: &mut Point) {
        match (self.quantity, self.value) {
            (Quantity::Parameter(parameter), Value::Number(value)) => {
                point.parameters.push((parameter.name.to_owned(), value));
            }
            _ => self.put_in(&mut point.settings),
        }
    }

    /// Sets it, if it is a setting.
    pub fn put_in(&self, settings: &mut SolverSettings) {
        let Quantity::Setting(setting) = self.quantity else { return };
        let field = settings.reflect_path_mut(setting.path).expect("paths of the table are of fields");
        match self.value {
            Value::Number(value) => {
                if let Some(field) = field.try_downcast_mut::<f64>() {
                    *field = value;
                } else if let Some(field) = field.try_downcast_mut::<u32>() {
                    *field = value as u32;
                } else if let Some(field) = field.try_downcast_mut::<Option<f64>>() {
                    *field = Some(value);
                }
            }
            Value::None => {
                if let Some(field) = field.try_downcast_mut::<Option<f64>>() {
                    *field = None;
                }
            }
            Value::Switch(value) => {
                if let Some(field) = field.try_downcast_mut::<bool>() {
                    *field = value;
                }
            }
            Value::Choice(name) => {
                if let Some(choice) = setting.choices.iter().find(|choice| choice.name == name) {
                    field.apply(&DynamicEnum::new(choice.variant, ()));
                }
            }
        }
    }
}

/// `NAME=VALUE` as two.
pub(super) fn split(text: &str) -> Result<(&str, &str), VaryError> {
    match text.split_once('=') {
        Some((name, value)) if !name.is_empty() && !value.is_empty() => Ok((name, value)),
        _ => Err(VaryError(format!("'{text}' is not NAME=VALUE, like baumgarte=0.2"))),
    }
}

/// How the values of a setting are written, by the type of its field.
enum Kind {
    Real,
    Whole,
    Optional,
    Switch,
    Choice,
}

impl Kind {
    fn of(setting: &Setting) -> Self {
        let settings = SolverSettings::default();
        let field = settings.reflect_path(setting.path).expect("paths of the table are of fields");
        if field.try_downcast_ref::<f64>().is_some() {
            Self::Real
        } else if field.try_downcast_ref::<u32>().is_some() {
            Self::Whole
        } else if field.try_downcast_ref::<Option<f64>>().is_some() {
            Self::Optional
        } else if field.try_downcast_ref::<bool>().is_some() {
            Self::Switch
        } else {
            Self::Choice
        }
    }
}

fn of_setting(setting: &'static Setting, text: &str) -> Result<Assignment, VaryError> {
    let Setting { name, .. } = setting;
    let kind = Kind::of(setting);
    let value = match kind {
        Kind::Choice => {
            let choice = setting.choices.iter().find(|choice| choice.name == text);
            Value::Choice(choice.ok_or_else(|| no_choice(name, &[setting], text))?.name)
        }
        Kind::Switch => {
            let switch = text.parse().map_err(|_| VaryError(format!("{name}: '{text}' is neither true nor false")))?;
            Value::Switch(switch)
        }
        Kind::Optional if ["none", "off"].iter().any(|none| text.eq_ignore_ascii_case(none)) => Value::None,
        Kind::Optional => number(name, text, "a number or None")?,
        Kind::Real => number(name, text, "a number")?,
        Kind::Whole => number(name, text, "a whole number")?,
    };
    if let (Kind::Whole, Value::Number(value)) = (&kind, value)
        && (value.fract() != 0.0 || !(0.0..=f64::from(u32::MAX)).contains(&value))
    {
        return Err(VaryError(format!("{name}: '{text}' is not a whole number")));
    }
    let assignment = Assignment { quantity: Quantity::Setting(setting), value };
    let mut settings = SolverSettings::default();
    assignment.put_in(&mut settings);
    settings.validate().map_err(|error| VaryError(error.to_string()))?;
    Ok(assignment)
}

fn of_parameter(parameter: &'static Parameter, text: &str) -> Result<Assignment, VaryError> {
    let value = number(parameter.name, text, "a number")?;
    match value {
        Value::Number(value) if !parameter.allows(value) => {
            Err(VaryError(format!("{}: {value} is out of range, must be {}", parameter.name, parameter.range())))
        }
        _ => Ok(Assignment { quantity: Quantity::Parameter(parameter), value }),
    }
}

fn number(name: &str, text: &str, what: &str) -> Result<Value, VaryError> {
    let value = text.parse::<f64>().ok().filter(|value| value.is_finite());
    value.map(Value::Number).ok_or_else(|| VaryError(format!("{name}: '{text}' is not {what}")))
}

fn no_choice(name: &str, settings: &[&'static Setting], text: &str) -> VaryError {
    let choices = settings.iter().flat_map(|setting| setting.choices).map(|choice| choice.name);
    VaryError(format!("{name}: there is no '{text}'; there are {}", choices.collect::<Vec<_>>().join(", ")))
}
