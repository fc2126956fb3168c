//! A reference answer: what is compared with it, and how the distances of a run from it add up.

use bevy::math::{DQuat, DVec3};

use super::statics::Statics;
use crate::lab::simulation::Sample;

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
    /// Whether [`Sample::loads`] are compared.
    pub reads_loads: bool,
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
pub(super) const ROUNDING: f64 = 1e-12;

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
    /// Motors, springs or torques do work: energy is none of the scene's errors.
    NotKept,
}

impl Truth {
    /// The largest distance over the run.
    pub(super) fn largest(
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
            reads_loads: false,
            further: Vec::new(),
            summary,
            distance: Box::new(distance),
            value: 0.0,
            count: 0,
        }
    }

    /// The mean over the run's steps.
    pub(super) fn time_mean(
        name: &'static str,
        unit: &'static str,
        distance: impl FnMut(&Sample) -> Option<f64> + Send + 'static,
    ) -> Self {
        Self { summary: Summary::TimeMean, ..Self::largest(name, unit, distance) }
    }

    /// The distance of the run's last state.
    pub(super) fn last(
        name: &'static str,
        unit: &'static str,
        distance: impl FnMut(&Sample) -> Option<f64> + Send + 'static,
    ) -> Self {
        Self { summary: Summary::Last, ..Self::largest(name, unit, distance) }
    }

    pub(super) fn with_energy_scale(mut self, scale: EnergyScale) -> Self {
        self.energy_scale = scale;
        self
    }

    pub(super) fn with_uncertainty(mut self, uncertainty: f64) -> Self {
        self.uncertainty = uncertainty;
        self
    }

    /// A run is further from the answer than that: it fails.
    pub(super) fn failing_above(mut self, error: f64) -> Self {
        self.fails_above = Some(error);
        self
    }

    /// It compares the loads of joints.
    pub(super) fn of_loads(mut self) -> Self {
        self.reads_loads = true;
        self
    }

    /// Something else that is known of the scene.
    pub(super) fn and(mut self, other: Self) -> Self {
        self.reads_loads |= other.reads_loads;
        self.further.push(other);
        self
    }

    /// Of a scene in equilibrium.
    pub(super) fn that_stays(mut self) -> Self {
        self.stays = true;
        self.with_energy_scale(EnergyScale::WeightTimesHeight)
    }

    /// What the forces must add up to, where statics says it.
    pub(super) fn with_statics(mut self, statics: Option<Statics>) -> Self {
        self.statics = statics;
        self
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

/// Where bodies are at a time, s, after the answer: index in the scene's list, centre of mass,
/// orientation.
pub type Poses = Box<dyn Fn(f64) -> Vec<(usize, DVec3, DQuat)> + Send + Sync>;
