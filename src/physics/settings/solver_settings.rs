//! The settings of the step, by engine, and the presets.

use bevy::math::DVec3;
use bevy::prelude::*;
use bevy::reflect::GetPath;
use serde::de::MapAccess;
use serde::ser::{Serialize, SerializeStruct, Serializer};

use super::described::{one_line, settings};
use super::{Choice, Choices, ContactModel, ExactIntegrator, FrictionModel, Integrator, Method, Precision};

const EVERY: Readers = Readers { methods: |_| true, with: None };
const ALL_BUT_EXACT: Readers = Readers { methods: |method| method != Method::Exact, with: None };
const SWEEPS: Readers = Readers { methods: Method::is_force_level, with: None };
const IMPULSE: Readers = Readers { methods: Method::keeps_contacts, with: None };
const SOFT_STEP: Readers = Readers { methods: |method| method == Method::SoftStep, with: None };
const EXACT: Readers = Readers { methods: |method| method == Method::Exact, with: None };
const AT_EXTREMES: Readers = Readers {
    with: Some(("contacts: extreme_vertices or single_point", |settings| settings.sweeps.contacts.is_of_2009())),
    ..SWEEPS
};
const CLIPPED: Readers = Readers {
    with: Some(("contacts: clipping", |settings| settings.sweeps.contacts == ContactModel::Clipping)),
    ..SWEEPS
};

settings! {
    /// Every setting of the step. [`SolverSettings::default`] is [`SolverSettings::game`]. What belongs to an engine that
    /// the method is not of is not read.
    pub struct SolverSettings {
        common {
            /// Steps per second; the step is h = 1/hz. Positive.
            hz: f64 => EVERY;
            /// How contacts and joints are solved.
            method: Method => EVERY;
            /// Equal parts a step is cut into, at least 1. Collision is found once a step. Force-level methods make rows
            /// anew in each substep; impulse methods bring errors up to date, and rows where bodies on joints turn far.
            substeps: u32 => EVERY;
            /// Sweeps over all rows in each (sub)step, at least 1; what conjugate directions cost besides counts among
            /// them.
            iterations: u32 => ALL_BUT_EXACT;
            /// Scalar of rows and solver; poses are `f64` either way.
            precision: Precision => ALL_BUT_EXACT;
            /// Depth that contacts leave alone, m, ≥ 0.
            slop: f64 => ALL_BUT_EXACT;
            /// Greatest speed at which a contact or joint mends a position error, m/s, ≥ 0; contacts of force-level
            /// methods besides no faster than gravity takes back before the error is gone, joints of `xpbd` at any.
            /// None: no limit.
            correction_speed: Option<f64> => EVERY;
            /// How friction is solved.
            friction: FrictionModel => EVERY;
            /// Approach speed above which contacts bounce, m/s, ≥ 0; none: no contact bounces.
            restitution_speed: Option<f64> => EVERY;
            /// Drag on every body, 1/s, ≥ 0: v ← v/(1 + c h), ω likewise.
            drag: f64 => EVERY;
            /// Most threads a step uses, the calling one included; results do not depend on it. At least 1.
            threads: u32 => EVERY;
        }
        /// What force-level sweeps alone read: `pgs`, `cg_pgs`, `nncg` and `joint_space`.
        sweeps: SweepSettings {
            /// How velocities become poses.
            integrator: Integrator => SWEEPS;
            /// Whether contact rows start from the forces of the (sub)step before, points found again by feature,
            /// instead of from zero.
            warm_starting: bool => SWEEPS;
            /// Share of a position error that one (sub)step aims to remove, 0 to 1 (Baumgarte's β·h, or ODE's error
            /// reduction parameter); with `nonlinear_projection` the share that one sweep over the poses removes.
            baumgarte: f64 => SWEEPS;
            /// Whether poses are moved out of their errors on their own at the end of each (sub)step, in as many sweeps
            /// as over the forces, instead of by velocities. Drives with a largest force keep to velocities.
            nonlinear_projection: bool => SWEEPS;
            /// How contacts are found.
            contacts: ContactModel => SWEEPS;
            /// Whether what is above a half-space gets contacts across the gap that it may close in the step, instead of
            /// when it overlaps.
            contacts_ahead: bool => CLIPPED;
            /// L1 distance within which two candidate axes of the separating axis test count as one, 0 to 0.5.
            axis_epsilon: f64 => AT_EXTREMES;
            /// Whether n and −n count as one candidate axis.
            merge_opposite_axes: bool => AT_EXTREMES;
            /// Whether sweep and sort also prunes on y.
            prune_y: bool => AT_EXTREMES;
            /// Steps by which the solver's contacts lag behind the poses: 0, or 1 as in the 2009 engine's threaded loop.
            contact_lag: u32 => SWEEPS;
        }
        /// What methods with contacts that last alone read: `soft_step`, `sequential_impulses` and `xpbd`.
        impulse: ImpulseSettings {
            /// Whether effort follows need: islands at rest are solved at once and directly, where their bodies make a
            /// tree or nearly one, and what joints hold takes half the substeps while none of it turns by 0.05 to 0.2 rad in
            /// a step.
            fitted_effort: bool => SOFT_STEP;
            /// Speed under which a body counts as calm, m/s, ≥ 0; none: nothing sleeps. An island of bodies that touch
            /// or are joined sleeps once all have been calm for half a second and gained no speed, and then stays where
            /// it is, at rest, until it is disturbed. What creeps more slowly than that is stopped: leave it out where
            /// that matters.
            sleep_speed: Option<f64> => IMPULSE;
        }
        /// What the exact method alone reads.
        exact: ExactSettings {
            /// How what touches nothing is stepped.
            integrator: ExactIntegrator => EXACT;
            /// Time, ms, ≥ 0, after which a step looks for no better solution of what is in reach of something; none:
            /// never. It then goes on with the best that it has, told as not settled, within some tens of iterations
            /// more. What is solved by then depends on the machine: no such run can be repeated to the bit.
            time_budget: Option<f64> => EXACT;
        }
    }
}

/// Acceleration of gravity, m/s² (default 9.81 downwards, y up).
#[derive(Resource, Reflect, Clone, Copy, Debug, PartialEq, Deref, DerefMut)]
#[reflect(Resource, Debug, Default, PartialEq)]
pub struct Gravity(pub DVec3);

impl Default for Gravity {
    fn default() -> Self {
        Self(DVec3::new(0.0, -9.81, 0.0))
    }
}

/// Which methods read a setting, and, where that depends on another setting, with which one.
#[derive(Clone, Copy)]
struct Readers {
    methods: fn(Method) -> bool,
    with: Option<(&'static str, fn(&SolverSettings) -> bool)>,
}

/// What is known of one setting.
pub struct Setting {
    /// Its name in files, on the command line and in messages. Integrators of two engines share one.
    pub name: &'static str,
    /// Its place in [`SolverSettings`], as paths of reflection have it.
    pub path: &'static str,
    /// What it may be, if it is a choice.
    pub choices: &'static [Choice],
    doc: &'static str,
    readers: Readers,
}

impl Setting {
    /// What it is: its doc comment.
    pub fn help(&self) -> String {
        one_line(self.doc)
    }

    /// The methods that read it.
    pub fn methods(&self) -> impl Iterator<Item = Method> {
        Method::ALL.iter().copied().filter(|&method| (self.readers.methods)(method))
    }

    /// What other setting it is read with only.
    pub fn with(&self) -> Option<&'static str> {
        self.readers.with.map(|(other, _)| other)
    }

    /// Whether a step with these settings reads it.
    pub fn is_read(&self, settings: &SolverSettings) -> bool {
        (self.readers.methods)(settings.method) && self.readers.with.is_none_or(|(_, is_met)| is_met(settings))
    }

    /// Why a step with these settings does not read it, and what can be done.
    pub fn why_unread(&self, settings: &SolverSettings) -> String {
        let method = settings.method.name();
        let names: Vec<_> = self.methods().map(Method::name).collect();
        match (names.as_slice(), self.with()) {
            (_, Some(other)) if names.contains(&method) => {
                format!("{method} reads it only with {other}: leave it out or set that too")
            }
            ([one], _) => format!("{method} does not read it, only {one} does: leave it out or choose that method"),
            (_, _) => format!(
                "{method} does not read it, only {} do: leave it out or choose one of these methods",
                names.join(", ")
            ),
        }
    }
}

impl Default for SolverSettings {
    fn default() -> Self {
        Self::game()
    }
}

impl SolverSettings {
    /// The 2009 engine to the letter: 4 sweeps of projected Gauss–Seidel, β = 0.7/(2h), slop
    /// 1 cm, extreme-vertex contacts, one friction tangent with its documented flaw, Euler.
    pub fn classic() -> Self {
        Self {
            hz: 60.0,
            method: Method::ProjectedGaussSeidel,
            substeps: 1,
            iterations: 4,
            precision: Precision::F32,
            slop: 0.01,
            correction_speed: None,
            friction: FrictionModel::OneTangent,
            restitution_speed: None,
            drag: 0.0,
            threads: 1,
            sweeps: SweepSettings {
                integrator: Integrator::Euler,
                warm_starting: false,
                baumgarte: 0.35,
                nonlinear_projection: false,
                contacts: ContactModel::ExtremeVertices,
                contacts_ahead: false,
                axis_epsilon: 1e-3,
                merge_opposite_axes: false,
                prune_y: false,
                contact_lag: 0,
            },
            impulse: ImpulseSettings { fitted_effort: false, sleep_speed: None },
            exact: ExactSettings { integrator: ExactIntegrator::Gauss, time_budget: None },
        }
    }

    /// The 2009 method with the improvements that its own document planned: contact manifolds by face clipping, and
    /// contact caching (warm starting). Besides these it has friction bounded by the contact's own normal force,
    /// restitution, and substeps, which do more for joints than sweeps of the same cost.
    pub fn steady() -> Self {
        let classic = Self::classic();
        Self {
            substeps: 4,
            iterations: 10,
            slop: 0.002,
            correction_speed: Some(3.0),
            friction: FrictionModel::TwoTangents,
            restitution_speed: Some(0.5),
            sweeps: SweepSettings {
                warm_starting: true,
                baumgarte: 0.2,
                contacts: ContactModel::Clipping,
                contacts_ahead: true,
                merge_opposite_axes: true,
                prune_y: true,
                ..classic.sweeps
            },
            ..classic
        }
    }

    /// The fastest that holds up: the soft step.
    pub fn game() -> Self {
        let steady = Self::steady();
        Self {
            method: Method::SoftStep,
            iterations: 1,
            slop: 0.0,
            impulse: ImpulseSettings { fitted_effort: true, sleep_speed: Some(0.02) },
            ..steady
        }
    }

    /// The one that converges with the step to rounding error: joints and contacts exactly, Gauss's method where
    /// nothing touches.
    pub fn accurate() -> Self {
        let steady = Self::steady();
        Self { method: Method::Exact, substeps: 1, precision: Precision::F64, restitution_speed: Some(0.0), ..steady }
    }

    /// Sequential impulses as their kind is used: one substep of many sweeps, and slop that keeps resting contacts in
    /// touch.
    pub fn sequential_impulses() -> Self {
        Self { method: Method::SequentialImpulses, substeps: 1, iterations: 10, slop: 0.005, ..Self::game() }
    }

    /// Position-based dynamics as its kind is used: many substeps of one sweep.
    pub fn xpbd() -> Self {
        Self { method: Method::Xpbd, substeps: 8, ..Self::game() }
    }

    /// The presets by name, the default first.
    pub const PRESETS: [(&'static str, fn() -> Self); 4] =
        [("game", Self::game), ("steady", Self::steady), ("classic", Self::classic), ("accurate", Self::accurate)];

    /// The preset of that name.
    pub fn preset(name: &str) -> Option<Self> {
        Self::PRESETS.iter().find(|(known, _)| *known == name).map(|(_, preset)| preset())
    }

    /// How contact points are found: only force-level methods have a choice.
    pub(crate) fn contact_model(&self) -> ContactModel {
        if self.method.is_force_level() { self.sweeps.contacts } else { ContactModel::Clipping }
    }

    /// Steps by which contacts lag: only those of force-level methods can.
    pub(crate) fn contact_lag(&self) -> u32 {
        if self.method.is_force_level() { self.sweeps.contact_lag } else { 0 }
    }

    /// The settings in which two differ, of those that either's method reads.
    pub fn differences(&self, other: &Self) -> impl Iterator<Item = &'static Setting> {
        let read = SETTINGS.iter().filter(|setting| setting.is_read(self) || setting.is_read(other));
        read.filter(|setting| match (self.reflect_path(setting.path), other.reflect_path(setting.path)) {
            (Ok(one), Ok(other)) => one.reflect_partial_eq(other) != Some(true),
            _ => false,
        })
    }

    /// The step h, s.
    pub fn step(&self) -> f64 {
        1.0 / self.hz
    }

    /// Checks every range that the fields' docs state.
    ///
    /// # Errors
    /// The first setting that is out of its range, with the range.
    pub fn validate(&self) -> Result<(), SettingsError> {
        let check = |name, value: f64, range, holds: bool| {
            if value.is_finite() && holds { Ok(()) } else { Err(SettingsError::OutOfRange { name, value, range }) }
        };
        let at_least_0 = |name, value: f64| check(name, value, "at least 0", value >= 0.0);
        let at_least_1 = |name, value: u32| check(name, f64::from(value), "at least 1", value >= 1);
        let Self { sweeps, impulse, .. } = self;
        check("hz", self.hz, "greater than 0 and at most 1e9", self.hz > 0.0 && self.hz <= 1e9)?;
        at_least_1("substeps", self.substeps)?;
        at_least_1("iterations", self.iterations)?;
        at_least_0("slop", self.slop)?;
        at_least_0("correction_speed", self.correction_speed.unwrap_or(0.0))?;
        at_least_0("restitution_speed", self.restitution_speed.unwrap_or(0.0))?;
        at_least_0("drag", self.drag)?;
        at_least_1("threads", self.threads)?;
        check("baumgarte", sweeps.baumgarte, "0 to 1", (0.0..=1.0).contains(&sweeps.baumgarte))?;
        check("axis_epsilon", sweeps.axis_epsilon, "0 to 0.5", (0.0..=0.5).contains(&sweeps.axis_epsilon))?;
        check("contact_lag", f64::from(sweeps.contact_lag), "0 or 1", sweeps.contact_lag <= 1)?;
        at_least_0("sleep_speed", impulse.sleep_speed.unwrap_or(0.0))?;
        at_least_0("time_budget", self.exact.time_budget.unwrap_or(0.0))
    }
}

/// Run condition of systems for contacts that last.
pub(crate) fn contacts_last(settings: Res<SolverSettings>) -> bool {
    settings.method.keeps_contacts()
}

/// Run condition of what is for contacts of the 2009 way alone.
pub(crate) fn contacts_are_of_2009(settings: Res<SolverSettings>) -> bool {
    settings.contact_model().is_of_2009()
}

/// Why settings make no sense.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SettingsError {
    /// Out of its range.
    #[error("{name}: {value} is out of range, must be {range}")]
    OutOfRange {
        /// The setting's name.
        name: &'static str,
        /// Its value.
        value: f64,
        /// What it may be.
        range: &'static str,
    },
    /// Written by a user, and not read by the method.
    #[error("{name}: {problem}")]
    Unread {
        /// The setting's name.
        name: &'static str,
        /// [`Setting::why_unread`].
        problem: String,
    },
}

impl SettingsError {
    /// The setting's name.
    pub fn name(&self) -> &'static str {
        match self {
            Self::OutOfRange { name, .. } | Self::Unread { name, .. } => name,
        }
    }
}

#[cfg(test)]
mod tests {
    use bevy::reflect::{ReflectRef, TypeInfo, Typed};

    use super::*;

    #[test]
    fn every_field_is_in_the_table_and_has_its_doc_comment() {
        let settings = SolverSettings::default();
        let TypeInfo::Struct(info) = SolverSettings::type_info() else { panic!("settings are a struct") };
        let mut paths = Vec::new();
        for name in info.field_names() {
            match settings.reflect_path(*name).unwrap().reflect_ref() {
                ReflectRef::Struct(group) => {
                    paths.extend(
                        (0..group.field_len()).map(|index| format!("{name}.{}", group.name_at(index).unwrap())),
                    );
                }
                _ => paths.push((*name).to_owned()),
            }
        }
        assert_eq!(SETTINGS.iter().map(|setting| setting.path).collect::<Vec<_>>(), paths);

        let lines: Vec<&str> = include_str!("solver_settings.rs").lines().map(str::trim).collect();
        let mut declared = 0;
        for setting in SETTINGS {
            let is_it = |line: &str| line.starts_with(&format!("{}: ", setting.name)) && line.ends_with(';');
            declared += lines[declared..].iter().position(|line| is_it(line)).expect(setting.path);
            let first = lines[..declared].iter().rposition(|line| !line.starts_with("///")).unwrap() + 1;
            let doc: Vec<&str> = lines[first..declared].iter().map(|line| line[3..].trim()).collect();
            assert_eq!(setting.help(), doc.join(" "), "{}", setting.path);
            assert!(!doc.is_empty() && setting.methods().next().is_some(), "{}", setting.path);
            declared += 1;
        }
    }
}
