//! Reference answers: what is known of a built-in scene, and how far a run is from it.
//!
//! One file an answer: a function from the scene to a [`Truth`], or none where the answer is not
//! known for those parameters. Constants (masses, lengths, gravity, friction) are read from the
//! scene, so that an answer follows its parameters.

mod bounce;
mod converged;
mod cradle;
mod dominoes;
mod elliptic;
mod far;
mod heavy_top;
mod incline;
mod instant;
mod painleve;
mod pendulum;
mod rolling;
mod slide_roll;
mod spheres;
mod statics;
mod stays_put;
mod top;
mod trajectory;
mod wall;

use bevy::math::{DQuat, DVec3};

use crate::physics::{RigidBody, SolverSettings};
use crate::scene::{BodySpec, SceneSpec};

pub use converged::{Unknown, converged};
pub use statics::Statics;

use super::run::Sample;

/// A reference answer, fed with the states of one run.
pub struct Truth {
    /// What is compared, in a few words.
    pub name: &'static str,
    /// The error's unit.
    pub unit: &'static str,
    /// What the scene's energy errors are relative to.
    pub energy_scale: EnergyScale,
    /// How far the answer itself may be off, in the error's unit.
    pub uncertainty: f64,
    /// Whether every body should stay where it starts.
    pub stays: bool,
    /// The error above which the scene's own condition is broken and a run fails.
    pub fails_above: Option<f64>,
    /// What the forces must add up to, in a scene at rest.
    pub statics: Option<Statics>,
    /// What else is known of the scene, each with an error of its own.
    pub further: Vec<Self>,
    summary: Summary,
    distance: Distance,
    /// The largest, the sum, or the last of the distances so far.
    value: f64,
    count: u64,
}

/// Of closed forms in double precision, in the units of scenes of metres, radians and seconds: some
/// 100 roundings of 1e-16 in phases and places of up to 100. Each answer that does better or worse
/// says so.
const ROUNDING: f64 = 1e-12;

/// Distance of a state from the answer; none where the answer says nothing about it.
type Distance = Box<dyn FnMut(&Sample) -> Option<f64> + Send>;

/// How the distances of a run become one number.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Summary {
    Largest,
    /// Over the states after each step.
    TimeMean,
    /// Of the last state seen.
    Last,
}

/// The energy S that errors of energy are relative to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EnergyScale {
    /// The answer's largest kinetic energy, J.
    Known(f64),
    /// The scene is at rest: weight of all that can fall × its height.
    WeightTimesHeight,
    /// The run's own largest kinetic energy.
    LargestKinetic,
}

impl Truth {
    /// The largest distance over the run.
    fn largest(
        name: &'static str,
        unit: &'static str,
        distance: impl FnMut(&Sample) -> Option<f64> + Send + 'static,
    ) -> Self {
        let (summary, energy_scale) = (Summary::Largest, EnergyScale::LargestKinetic);
        Self {
            name,
            unit,
            energy_scale,
            uncertainty: ROUNDING,
            stays: false,
            fails_above: None,
            statics: None,
            further: Vec::new(),
            summary,
            distance: Box::new(distance),
            value: 0.0,
            count: 0,
        }
    }

    /// The mean over the run's steps.
    fn time_mean(
        name: &'static str,
        unit: &'static str,
        distance: impl FnMut(&Sample) -> Option<f64> + Send + 'static,
    ) -> Self {
        Self { summary: Summary::TimeMean, ..Self::largest(name, unit, distance) }
    }

    /// The distance of the run's last state.
    fn last(
        name: &'static str,
        unit: &'static str,
        distance: impl FnMut(&Sample) -> Option<f64> + Send + 'static,
    ) -> Self {
        Self { summary: Summary::Last, ..Self::largest(name, unit, distance) }
    }

    fn with_energy_scale(mut self, scale: EnergyScale) -> Self {
        self.energy_scale = scale;
        self
    }

    fn with_uncertainty(mut self, uncertainty: f64) -> Self {
        self.uncertainty = uncertainty;
        self
    }

    /// A run is further from the answer than that: it fails.
    fn failing_above(mut self, error: f64) -> Self {
        self.fails_above = Some(error);
        self
    }

    /// Something else that is known of the scene.
    fn and(mut self, other: Self) -> Self {
        self.further.push(other);
        self
    }

    /// Of a scene in equilibrium.
    fn that_stays(mut self) -> Self {
        self.stays = true;
        self.with_energy_scale(EnergyScale::WeightTimesHeight)
    }

    /// Takes in the state at the start and after each step, in order.
    pub fn observe(&mut self, sample: &Sample) {
        let distance = (self.distance)(sample);
        // A mean is over what the steps made, not over what they were given.
        if let Some(distance) = distance.filter(|_| self.summary != Summary::TimeMean || sample.step > 0) {
            self.count += 1;
            self.value = match self.summary {
                Summary::Largest => self.value.max(distance),
                Summary::TimeMean => self.value + distance,
                Summary::Last => distance,
            };
        }
        self.further.iter_mut().for_each(|truth| truth.observe(sample));
    }

    /// The error so far; none before anything could be compared.
    pub fn error(&self) -> Option<f64> {
        match self.summary {
            _ if self.count == 0 => None,
            Summary::Largest | Summary::Last => Some(self.value),
            Summary::TimeMean => Some(self.value / self.count as f64),
        }
    }
}

/// The scenes that stay as they are.
const STAY: [&str; 8] = ["hanging", "joint_grid", "stack", "pyramid", "pyramids", "sandwich", "arch", "card_house"];

/// What is known of a built-in scene with these parameters, for a run with these settings.
pub fn of(scene: &SceneSpec, settings: &SolverSettings) -> Option<Truth> {
    match scene.name.as_str() {
        "pendulum" => pendulum::truth(scene),
        "rods" | "chain" => trajectory::truth(scene),
        name if STAY.contains(&name) => stays_put::truth(scene),
        "top" => top::truth(scene),
        "heavy_top" => heavy_top::truth(scene),
        "incline" => incline::truth(scene),
        "slide_roll" => slide_roll::truth(scene),
        "rolling" => rolling::truth(scene),
        "painleve" => painleve::truth(scene),
        "bounce" => bounce::truth(scene),
        "spheres" => spheres::truth(scene),
        "cradle" => cradle::truth(scene),
        "dominoes" => dominoes::truth(scene),
        "wall" => wall::truth(scene),
        "far" => far::truth(scene, settings),
        _ => None,
    }
}

/// Where bodies are at a time, s, after the answer: index in the scene's list, centre of mass,
/// orientation.
pub type Poses = Box<dyn Fn(f64) -> Vec<(usize, DVec3, DQuat)> + Send + Sync>;

/// The whole motion of a built-in scene, where the answer gives it.
pub fn poses(scene: &SceneSpec) -> Option<Poses> {
    match scene.name.as_str() {
        "pendulum" => pendulum::poses(scene),
        "heavy_top" => heavy_top::poses(scene),
        "incline" => incline::poses(scene),
        "bounce" => bounce::poses(scene),
        name if STAY.contains(&name) => stays_put::truth(scene).map(|_| stays_put::poses(scene)),
        _ => None,
    }
}

/// Indices of the bodies that move, in the scene's order.
fn dynamic(scene: &SceneSpec) -> Vec<usize> {
    let is_dynamic = |body: &BodySpec| body.kind == RigidBody::Dynamic;
    (0..scene.bodies.len()).filter(|&index| is_dynamic(&scene.bodies[index])).collect()
}

/// The joint that holds the body `index`, as the anchor on it, from its centre of mass in body axes.
fn anchor_on(scene: &SceneSpec, index: usize) -> Option<DVec3> {
    let name = &scene.bodies[index].name;
    scene.joints.iter().find_map(|joint| {
        if joint.body_b == *name {
            Some(joint.anchor_b)
        } else if joint.body_a == *name {
            Some(joint.anchor_a)
        } else {
            None
        }
    })
}
