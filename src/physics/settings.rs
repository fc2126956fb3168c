//! Every number and choice of the step, with its unit and range, and the presets.

use bevy::math::DVec3;
use bevy::prelude::*;
use serde::{Deserialize, Serialize};

/// Acceleration of gravity, m/s² (default 9.81 downwards, y up).
#[derive(Resource, Reflect, Clone, Copy, Debug, PartialEq, Deref, DerefMut)]
#[reflect(Resource, Debug, Default, PartialEq)]
pub struct Gravity(pub DVec3);

impl Default for Gravity {
    fn default() -> Self {
        Self(DVec3::new(0.0, -9.81, 0.0))
    }
}

/// How contact and joint rows are solved: on the forces of each (sub)step, as `pgs`, `cg_pgs`, `nncg` and `joint_space`
/// do, or on velocities with contacts that last.
#[derive(Reflect, Serialize, Deserialize, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Method {
    /// Projected Gauss–Seidel on the force-level rows with λ from zero (Catto 2005).
    #[default]
    #[serde(rename = "pgs")]
    ProjectedGaussSeidel,
    /// The same sweeps, primed by conjugate residuals on the rows that no bound holds, where the sweeps alone are slow
    /// (Morales, Nocedal and Smelyanskiy 2008).
    #[serde(rename = "cg_pgs")]
    PrimedGaussSeidel,
    /// Conjugate directions with the same sweep for a gradient (Silcowitz, Niebe and Erleben 2010).
    #[serde(rename = "nncg")]
    NonsmoothConjugateGradient,
    /// Joints solved directly in each substep, and the sweeps over contacts move what is joined as one (contacts in
    /// joint space).
    #[serde(rename = "joint_space")]
    JointSpace,
    /// Substeps with soft constraints: impulses solved with springs, then relaxed without
    /// (Catto 2024).
    #[serde(rename = "soft_step")]
    SoftStep,
    /// Impulses on velocities, warm started, then positions moved out of their errors on their own
    /// (Catto 2006).
    #[serde(rename = "sequential_impulses")]
    SequentialImpulses,
    /// Positions of small substeps solved with compliance, velocities from how far they moved
    /// (Müller et al. 2020).
    #[serde(rename = "xpbd")]
    Xpbd,
    /// Joints by their exact forces, J M⁻¹ Jᵀ λ = b solved directly in each stage of an integrator that converges, all
    /// in `f64`. What is in reach of something goes by a step of second order instead, whose contacts obey Signorini's
    /// condition and Coulomb's cone to 1e-10 m/s; what bounces does so at the time at which it lands.
    #[serde(rename = "exact")]
    Exact,
}

impl Method {
    /// Whether contacts last from step to step, with their impulses, instead of being found and
    /// forgotten.
    pub(crate) fn keeps_contacts(self) -> bool {
        !matches!(
            self,
            Self::ProjectedGaussSeidel
                | Self::PrimedGaussSeidel
                | Self::NonsmoothConjugateGradient
                | Self::JointSpace
                | Self::Exact
        )
    }
}

/// Run condition of systems for contacts that last.
pub(crate) fn contacts_last(settings: Res<SolverSettings>) -> bool {
    settings.method.keeps_contacts()
}

/// How pairs of bodies that may touch are found.
#[derive(Reflect, Serialize, Deserialize, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[serde(rename_all = "snake_case")]
pub enum BroadPhase {
    /// Bounding spheres swept along x and sorted, in each step: the 2009 engine's. Its cost follows
    /// the number of bodies, and of those side by side along x and z.
    SweepAndSort,
    /// A tree of boxes a little larger than their bodies: its cost follows what moves.
    #[default]
    BoundingTree,
}

/// How velocities become poses.
#[derive(Reflect, Serialize, Deserialize, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[serde(rename_all = "snake_case")]
pub enum Integrator {
    /// v += h a, then x += h v with the new v. One solve a (sub)step.
    #[default]
    Euler,
    /// Kick by h/2, drift by h, kick by h/2. Two solves a (sub)step.
    VelocityVerlet,
    /// Gauss's collocation method, implicit and symmetric: of order 8 where nothing is stiff, of order 6 where
    /// something is, whatever the stiffness. Of `exact` only, as the one below.
    Gauss,
    /// RATTLE: kicks and free flight, symmetric, of order 2.
    Rattle,
}

impl Integrator {
    /// Whether it is one of those that a method has.
    fn is_of(self, method: Method) -> bool {
        match self {
            Self::Euler | Self::VelocityVerlet => method != Method::Exact,
            Self::Gauss | Self::Rattle => method == Method::Exact,
        }
    }
}

/// How the points of a contact are found once the separating axis test has given a normal.
#[derive(Reflect, Serialize, Deserialize, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[serde(rename_all = "snake_case")]
pub enum ContactModel {
    /// The extreme vertices of each shape toward the other, moved onto the contact plane, all
    /// with the same depth: the 2009 engine's.
    ExtremeVertices,
    /// The incident face clipped to the reference face, each point with its own depth; at most
    /// 4 points, chosen to keep the deepest one and the area.
    #[default]
    Clipping,
}

/// How friction is solved.
#[derive(Reflect, Serialize, Deserialize, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[serde(rename_all = "snake_case")]
pub enum FrictionModel {
    /// No friction rows.
    Off,
    /// One row along the slip at the start of the step, |λ| ≤ μ m_c g: the 2009 engine's.
    OneTangent,
    /// Two rows, each bounded by μ times the contact's own normal force, which is updated each
    /// sweep.
    #[default]
    TwoTangents,
}

/// The scalar in which rows are built and solved. Poses are `f64` either way.
#[derive(Reflect, Serialize, Deserialize, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[serde(rename_all = "snake_case")]
pub enum Precision {
    /// Single precision, on quantities relative to each body.
    #[default]
    F32,
    /// Double precision.
    F64,
}

/// Every setting of the step. [`SolverSettings::default`] is [`SolverSettings::game`].
#[derive(Resource, Reflect, Serialize, Deserialize, Clone, Copy, Debug, PartialEq)]
#[reflect(Resource, Debug, Default, PartialEq)]
#[serde(default, deny_unknown_fields)]
pub struct SolverSettings {
    /// Steps per second; the step is h = 1/hz. Positive.
    pub hz: f64,
    /// How rows are solved.
    pub method: Method,
    /// How velocities become poses. A choice of force-level methods and of `exact` only: the others have their own
    /// way, `Euler` here.
    pub integrator: Integrator,
    /// Equal parts a step is cut into, at least 1. Collision is found once a step; contact
    /// depths, joints and rows are brought up to date each substep.
    pub substeps: u32,
    /// Sweeps over all rows in each (sub)step, at least 1; what conjugate directions cost besides counts among them.
    pub iterations: u32,
    /// Whether contact rows start from the forces of the (sub)step before, points found again by
    /// feature, instead of from zero. Of force-level methods only: `xpbd` never does, the others always do.
    pub warm_starting: bool,
    /// Whether effort follows need: islands at rest are solved at once and directly, where their bodies
    /// make a tree or nearly one, and what joints hold takes half the substeps while none of it turns by
    /// 0.05 rad in a step. Of the soft step only.
    pub fitted_effort: bool,
    /// Scalar of rows and solver.
    pub precision: Precision,
    /// Share of a position error that one (sub)step aims to remove, 0 to 1 (Baumgarte's β·h,
    /// or ODE's error reduction parameter). Of force-level methods only.
    pub baumgarte: f64,
    /// Depth that contacts leave alone, m, ≥ 0.
    pub slop: f64,
    /// Greatest speed at which a contact or joint mends a position error, m/s, ≥ 0; contacts of force-level methods
    /// besides no faster than gravity takes back before the error is gone, joints of `xpbd` at any. None: no limit.
    pub correction_speed: Option<f64>,
    /// How friction is solved.
    pub friction: FrictionModel,
    /// Drag on every body, 1/s, ≥ 0: v ← v/(1 + c h), ω likewise.
    pub drag: f64,
    /// Approach speed above which contacts bounce, m/s, ≥ 0; none: no contact bounces.
    pub restitution_speed: Option<f64>,
    /// How contact points are found.
    pub contacts: ContactModel,
    /// L1 distance within which two candidate axes of the separating axis test count as one, ≥ 0.
    /// Of extreme-vertex contacts only.
    pub axis_epsilon: f64,
    /// Whether n and −n count as one candidate axis. Of extreme-vertex contacts only.
    pub merge_opposite_axes: bool,
    /// How pairs that may touch are found. Of force-level methods only: `exact` sweeps and sorts, all others keep the
    /// tree.
    pub broad_phase: BroadPhase,
    /// Whether sweep and sort also prunes on y.
    pub prune_y: bool,
    /// Steps by which the solver's contacts lag behind the poses: 0, or 1 as in the 2009
    /// engine's threaded loop. Of force-level methods only.
    pub contact_lag: u32,
    /// Speed under which a body counts as calm, m/s, ≥ 0; none: nothing sleeps. An island of bodies that touch or are
    /// joined sleeps once all have been calm for half a second and gained no speed, and then stays where it is, at
    /// rest, until it is disturbed. What creeps more slowly than that is stopped: leave it out where that matters.
    /// Not of force-level methods: only contacts that last can be woken as they were.
    pub sleep_speed: Option<f64>,
    /// Most threads a step uses, the calling one included; results do not depend on it.
    /// At least 1.
    pub threads: u32,
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
            integrator: Integrator::Euler,
            substeps: 1,
            iterations: 4,
            warm_starting: false,
            fitted_effort: false,
            precision: Precision::F32,
            baumgarte: 0.35,
            slop: 0.01,
            correction_speed: None,
            friction: FrictionModel::OneTangent,
            drag: 0.0,
            restitution_speed: None,
            contacts: ContactModel::ExtremeVertices,
            axis_epsilon: 1e-3,
            merge_opposite_axes: false,
            broad_phase: BroadPhase::SweepAndSort,
            prune_y: false,
            contact_lag: 0,
            sleep_speed: None,
            threads: 1,
        }
    }

    /// The 2009 method with the improvements that its own document planned: contact manifolds by face clipping, and
    /// contact caching (warm starting). Besides these it has friction bounded by the contact's own normal force,
    /// restitution, and substeps, which do more for joints than sweeps of the same cost.
    pub fn steady() -> Self {
        Self {
            substeps: 4,
            iterations: 10,
            warm_starting: true,
            baumgarte: 0.2,
            slop: 0.002,
            correction_speed: Some(3.0),
            friction: FrictionModel::TwoTangents,
            restitution_speed: Some(0.5),
            contacts: ContactModel::Clipping,
            merge_opposite_axes: true,
            prune_y: true,
            ..Self::classic()
        }
    }

    /// The fastest that holds up: the soft step.
    pub fn game() -> Self {
        Self {
            method: Method::SoftStep,
            iterations: 1,
            fitted_effort: true,
            slop: 0.0,
            broad_phase: BroadPhase::BoundingTree,
            sleep_speed: Some(0.02),
            ..Self::steady()
        }
    }

    /// The one that converges with the step to rounding error: joints and contacts exactly, Gauss's method where
    /// nothing touches.
    pub fn accurate() -> Self {
        Self {
            method: Method::Exact,
            integrator: Integrator::Gauss,
            substeps: 1,
            precision: Precision::F64,
            slop: 0.0,
            restitution_speed: Some(0.0),
            ..Self::steady()
        }
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

    /// The same with another method, and an integrator of that method where the present one is not.
    pub fn with_method(self, method: Method) -> Self {
        let fits = self.integrator.is_of(method);
        let own = if method == Method::Exact { Integrator::Gauss } else { Integrator::Euler };
        Self { method, integrator: if fits { self.integrator } else { own }, ..self }
    }

    /// The step h, s.
    pub fn step(&self) -> f64 {
        1.0 / self.hz
    }

    /// Checks every range that the fields' docs state.
    ///
    /// # Errors
    /// The first field that is out of its range, with the range.
    pub fn validate(&self) -> Result<(), SettingsError> {
        let check = |field, value: f64, range, holds: bool| {
            if value.is_finite() && holds {
                Ok(())
            } else {
                Err(SettingsError { field, value: SettingValue::Number(value), range })
            }
        };
        check("hz", self.hz, "greater than 0 and at most 1e9", self.hz > 0.0 && self.hz <= 1e9)?;
        if !self.integrator.is_of(self.method) {
            let (value, range) = match self.method {
                Method::Exact => (SettingValue::Integrator(self.integrator), "Gauss or Rattle with the method exact"),
                _ => {
                    (SettingValue::Integrator(self.integrator), "Euler or VelocityVerlet with other methods than exact")
                }
            };
            return Err(SettingsError { field: "integrator", value, range });
        }
        check("substeps", f64::from(self.substeps), "at least 1", self.substeps >= 1)?;
        check("iterations", f64::from(self.iterations), "at least 1", self.iterations >= 1)?;
        check("baumgarte", self.baumgarte, "0 to 1", (0.0..=1.0).contains(&self.baumgarte))?;
        check("slop", self.slop, "at least 0", self.slop >= 0.0)?;
        if let Some(speed) = self.correction_speed {
            check("correction_speed", speed, "at least 0", speed >= 0.0)?;
        }
        check("drag", self.drag, "at least 0", self.drag >= 0.0)?;
        if let Some(speed) = self.restitution_speed {
            check("restitution_speed", speed, "at least 0", speed >= 0.0)?;
        }
        if let Some(speed) = self.sleep_speed {
            check("sleep_speed", speed, "at least 0", speed >= 0.0)?;
        }
        check("axis_epsilon", self.axis_epsilon, "0 to 0.5", (0.0..=0.5).contains(&self.axis_epsilon))?;
        check("contact_lag", f64::from(self.contact_lag), "0 or 1", self.contact_lag <= 1)?;
        check("threads", f64::from(self.threads), "at least 1", self.threads >= 1)
    }
}

/// What a setting was that is out of its range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SettingValue {
    /// A number.
    Number(f64),
    /// A choice.
    Integrator(Integrator),
}

impl std::fmt::Display for SettingValue {
    fn fmt(&self, formatter: &mut std::fmt::Formatter) -> std::fmt::Result {
        match self {
            Self::Number(value) => value.fmt(formatter),
            Self::Integrator(integrator) => write!(formatter, "{integrator:?}"),
        }
    }
}

/// A setting out of its range.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("{field}: {value} is out of range, must be {range}")]
pub struct SettingsError {
    /// The field's name.
    pub field: &'static str,
    /// Its value.
    pub value: SettingValue,
    /// What it may be.
    pub range: &'static str,
}
