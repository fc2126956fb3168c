//! One file an engine: how a scene becomes its bodies, colliders and joints, and how it is stepped
//! and read. All that is measured is computed elsewhere, from what is read here.

mod avian;
#[cfg(feature = "box3d")]
mod box3d;
#[cfg(test)]
mod joint_tests;
mod plumb;
mod rapier;
#[cfg(test)]
mod tests;

use std::any::Any;
use std::fmt::{self, Display};
use std::mem;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::str::FromStr;
use std::time::{Duration, Instant};

use ::plumb::lab::BodyState;
use ::plumb::physics::{Breakable, DistanceLaw, PrescribedMotion, RigidBody, SolverSettings};
use ::plumb::scene::{BodySpec, JointKindSpec, ShapeSpec};
use bevy::math::DVec3;

use crate::joint::{Drive, Joint, Motor};
use crate::scene::Scene;

/// A scene in an engine.
trait Engine {
    /// One step.
    fn step(&mut self);
    /// Every body now, in the order of the scene.
    fn read(&mut self, states: &mut Vec<BodyState>);
}

/// An engine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EngineKind {
    /// Plumb with the settings of a preset.
    Plumb {
        /// Its name.
        preset: &'static str,
    },
    /// Dimforge's Rapier.
    Rapier,
    /// Avian, an engine in Bevy's ECS.
    Avian,
    /// Erin Catto's Box3D.
    #[cfg(feature = "box3d")]
    Box3d,
}

/// What a run asks of each engine.
#[derive(Clone, Copy, Debug)]
pub struct Settings {
    /// Steps a second.
    pub hz: f64,
    /// Substeps of each step; none: what each engine recommends.
    pub substeps: Option<u32>,
    /// Threads a step may use, the calling one included.
    pub threads: u32,
    /// Whether what is at rest may sleep.
    pub sleep: bool,
}

/// What an engine makes of [`Settings`].
#[derive(Clone, Debug, PartialEq)]
pub struct Method {
    /// Its version.
    pub version: String,
    /// `f32` or `f64`, of the solver.
    pub precision: &'static str,
    /// Substeps of each step.
    pub substeps: u32,
    /// Sweeps over all constraints in each substep.
    pub iterations: u32,
}

/// Why an engine does not do a scene.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Unable {
    /// The scene has something that is not translated for it.
    #[error("{0} are not translated")]
    NotTranslated(&'static str),
    /// It panicked.
    #[error("panicked: {0}")]
    Panicked(String),
}

/// Substeps of a step that Rapier, Box3D and Avian come with, or recommend.
const PEER_SUBSTEPS: u32 = 4;

impl EngineKind {
    /// All that this build has, each Plumb preset last but the default one first.
    pub fn all() -> Vec<Self> {
        let presets = SolverSettings::PRESETS.map(|(preset, _)| Self::Plumb { preset });
        let mut all = vec![presets[0], Self::Rapier, Self::Avian];
        #[cfg(feature = "box3d")]
        all.insert(2, Self::Box3d);
        all.extend(&presets[1..]);
        all.push(Self::Plumb { preset: plumb::FULL_EFFORT });
        all
    }

    /// Plumb's default preset and every peer.
    pub fn standard() -> Vec<Self> {
        let default = Self::all()[0];
        Self::all().into_iter().filter(|kind| *kind == default || !kind.is_plumb()).collect()
    }

    /// Whether it is Plumb.
    pub fn is_plumb(self) -> bool {
        matches!(self, Self::Plumb { .. })
    }

    /// What it makes of these settings.
    pub fn method(self, settings: &Settings) -> Method {
        let substeps = settings.substeps.unwrap_or(PEER_SUBSTEPS);
        let peer = |version| Method { version, precision: "f32", substeps, iterations: 1 };
        match self {
            Self::Plumb { preset } => plumb::method(preset, settings),
            Self::Rapier => peer(locked_version("rapier3d")),
            Self::Avian => peer(locked_version("avian3d")),
            #[cfg(feature = "box3d")]
            Self::Box3d => peer(box3d::version()),
        }
    }

    /// Puts a scene into it.
    pub fn start(self, scene: &Scene, settings: &Settings) -> Result<Run, Unable> {
        let of_engine: fn(&Joint) -> Option<&'static str> = match self {
            Self::Plumb { .. } => |_| None,
            Self::Rapier => rapier::lacks,
            Self::Avian => avian::lacks,
            #[cfg(feature = "box3d")]
            Self::Box3d => box3d::lacks,
        };
        if !self.is_plumb() {
            check_translatable(scene)?;
        }
        if let Some(what) = scene.joints.iter().find_map(of_engine) {
            return Err(Unable::NotTranslated(what));
        }
        let substeps = settings.substeps.unwrap_or(PEER_SUBSTEPS);
        let build = || -> Box<dyn Engine> {
            match self {
                Self::Plumb { preset } => Box::new(plumb::Plumb::new(scene, plumb::settings(preset, settings))),
                Self::Rapier => Box::new(rapier::Rapier::new(scene, settings.hz, substeps, settings.sleep)),
                Self::Avian => Box::new(avian::Avian::new(scene, settings.hz, substeps, settings.sleep)),
                #[cfg(feature = "box3d")]
                Self::Box3d => {
                    Box::new(box3d::Box3d::new(scene, settings.hz, substeps, settings.threads, settings.sleep))
                }
            }
        };
        let engine = guard(build)?;
        let mut run = Run { engine: Some(engine), states: Vec::new(), steps: 0, hz: settings.hz };
        run.read()?;
        Ok(run)
    }
}

impl Display for EngineKind {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.write_str(&match self {
            Self::Plumb { preset } if *preset == SolverSettings::PRESETS[0].0 => "plumb".to_owned(),
            Self::Plumb { preset } => format!("plumb:{preset}"),
            Self::Rapier => "rapier".to_owned(),
            Self::Avian => "avian".to_owned(),
            #[cfg(feature = "box3d")]
            Self::Box3d => "box3d".to_owned(),
        })
    }
}

impl FromStr for EngineKind {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let all = Self::all();
        if let Some(kind) = all.iter().find(|kind| kind.to_string() == text) {
            return Ok(*kind);
        }
        let names: Vec<String> = all.iter().map(Self::to_string).collect();
        let missing = if cfg!(feature = "box3d") { "" } else { " (box3d needs the feature 'box3d')" };
        Err(format!("no engine '{text}': this build has {}{missing}", names.join(", ")))
    }
}

/// A scene in an engine, stepped under a watch: a panic ends the run with the reason.
pub struct Run {
    /// None once it has panicked.
    engine: Option<Box<dyn Engine>>,
    states: Vec<BodyState>,
    steps: u64,
    hz: f64,
}

impl Run {
    /// One step; returns what it took, reading it back excluded.
    pub fn step(&mut self) -> Result<Duration, Unable> {
        let start = Instant::now();
        self.with_engine(|engine, _| engine.step())?;
        let took = start.elapsed();
        self.steps += 1;
        Ok(took)
    }

    /// Reads the bodies.
    pub fn read(&mut self) -> Result<&[BodyState], Unable> {
        self.with_engine(|engine, states| engine.read(states))?;
        Ok(&self.states)
    }

    /// Steps so far.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// Time simulated so far, s.
    pub fn time(&self) -> f64 {
        self.steps as f64 / self.hz
    }

    fn with_engine(&mut self, act: impl FnOnce(&mut dyn Engine, &mut Vec<BodyState>)) -> Result<(), Unable> {
        let Self { engine, states, .. } = self;
        let Some(running) = engine else { return Err(Unable::Panicked("in an earlier step".into())) };
        let outcome = guard(|| act(running.as_mut(), states));
        if outcome.is_err() {
            // What a panic left behind may panic again when it is dropped.
            mem::forget(engine.take());
        }
        outcome
    }
}

/// Runs engine code and takes its panic for a result.
fn guard<T>(act: impl FnOnce() -> T) -> Result<T, Unable> {
    catch_unwind(AssertUnwindSafe(act)).map_err(|payload| Unable::Panicked(panic_message(payload.as_ref())))
}

fn panic_message(payload: &(dyn Any + Send)) -> String {
    let message = payload.downcast_ref::<String>().map(String::as_str);
    message.or_else(|| payload.downcast_ref::<&str>().copied()).unwrap_or("without a message").to_owned()
}

/// A scene with a part that the peers' files leave out would be another scene.
fn check_translatable(scene: &Scene) -> Result<(), Unable> {
    let bodies = &scene.spec.bodies;
    let missing = |condition, what| if condition { Err(Unable::NotTranslated(what)) } else { Ok(()) };
    let joints = &scene.spec.joints;
    missing(joints.iter().any(|joint| joint.softness.is_some()), "soft joints")?;
    missing(joints.iter().any(|joint| joint.friction != 0.0), "joints with friction")?;
    missing(joints.iter().any(|joint| joint.broken.is_some()), "broken joints")?;
    let weak = weakest_that_holds(scene);
    let may_break = |&Breakable { force, torque, .. }: &Breakable| force.min(torque) < weak;
    missing(joints.iter().any(|joint| joint.breakable.as_ref().is_some_and(may_break)), "joints that break")?;
    let bounces = |joint: &Joint| joint.limits.is_some_and(|limits| limits.restitution != 0.0);
    missing(scene.joints.iter().any(bounces), "limits with restitution")?;
    missing(scene.joints.iter().any(Joint::limits_turns), "limits beyond half a turn")?;
    let is_distance = |joint: &&Joint| matches!(joint.kind, JointKindSpec::Distance(_));
    let attached = |joint: &Joint| joint.limits.is_some() || joint.motor.is_some();
    missing(scene.joints.iter().filter(is_distance).any(attached), "limits and motors of distances")?;
    let is_spring = |joint: &Joint| matches!(joint.kind, JointKindSpec::Distance(DistanceLaw::Spring { .. }));
    missing(scene.joints.iter().any(is_spring), "springs between points")?;
    let moves = |body: &BodySpec| body.kind != RigidBody::Static;
    let is_surface = |body: &BodySpec| matches!(body.shape, Some(ShapeSpec::Surface(_)));
    missing(bodies.iter().any(|body| is_surface(body) && moves(body)), "surfaces that move")?;
    missing(bodies.iter().any(|body| body.locked != Default::default()), "locked axes")
}

/// Joints of this strength, N or N·m, are taken not to break in any scene here: 10 times the weight of all its bodies. The
/// planks of `bridge 100` pull with twice theirs. Peers have no joints that break, and do not need any where none does.
fn weakest_that_holds(scene: &Scene) -> f64 {
    const TIMES_THE_WEIGHT: f64 = 10.0;
    let mass: f64 = scene.bodies.iter().filter_map(|body| Some(body.mass?.mass)).sum();
    TIMES_THE_WEIGHT * mass * scene.spec.gravity.length()
}

/// A joint whose motor follows a motion prescribed in time, which no peer has: it is told anew each step what to do.
struct Follower<Handle> {
    joint: Joint,
    motion: PrescribedMotion,
    handle: Handle,
}

impl<Handle: Copy> Follower<Handle> {
    /// Those of a scene, whose joints are known to an engine by those handles.
    fn of(joints: &[Joint], handles: &[Handle]) -> Vec<Self> {
        let follower = |(joint, &handle): (&Joint, &Handle)| {
            let Drive::Motion(motion) = joint.motor?.drive else { return None };
            Some(Self { joint: *joint, motion, handle })
        };
        joints.iter().zip(handles).filter_map(follower).collect()
    }

    /// The speed that follows the motion over a step from that time on, rad/s or m/s, with that share of what the joint
    /// lags behind made good in it.
    fn speed(&self, times: [f64; 2], made_good: f64, state: impl Fn(usize) -> BodyState) -> f64 {
        let Self { joint, motion, .. } = self;
        joint.rate_along(motion, times, made_good, [&state(joint.a), &state(joint.b)])
    }
}

/// As f32, with its largest number for infinity.
fn finite(value: f64) -> f32 {
    value.clamp(f64::from(f32::MIN), f64::from(f32::MAX)) as f32
}

/// The speed that a motor starts with; none of a spring.
fn speed_of(motor: &Motor) -> Option<f64> {
    match motor.drive {
        Drive::Speed(speed) => Some(speed),
        Drive::Motion(_) => Some(0.0),
        Drive::Spring { .. } => None,
    }
}

/// From the centre of mass of a cone up to the middle of its height.
fn cone_middle(height: f64) -> DVec3 {
    height / 4.0 * DVec3::Y
}

/// The panic of an engine that makes no hull of what is one for Plumb.
const NO_HULL: &str = "it makes no convex hull of the corners";

/// The version of a dependency that this was built with.
fn locked_version(package: &str) -> String {
    let lock = include_str!("../../../Cargo.lock");
    let entry =
        lock.split("[[package]]").find(|entry| entry.lines().any(|line| line == format!("name = \"{package}\"")));
    let version = entry.and_then(|entry| entry.lines().find_map(|line| line.strip_prefix("version = ")));
    version.unwrap_or("unknown").trim_matches('"').to_owned()
}
