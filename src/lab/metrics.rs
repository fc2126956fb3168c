//! What a run did, how true it was and what it cost: the object that `--json` prints.

use std::collections::{BTreeMap, HashMap};

use bevy::math::DVec3;
use serde::Serialize;

use crate::physics::{ConvexHull, Diagnostics, Inertia, Mass, RigidBody, SolverSettings, StepStats};
use crate::scene::{BodySpec, SceneSpec, ShapeSpec};

use super::run::{BodyState, Plan, Simulation};
use super::truth::{EnergyScale, Truth};

/// The measurements of one run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Metrics {
    /// The scene's name.
    pub scene: String,
    /// Every parameter of a built-in scene.
    pub parameters: BTreeMap<String, f64>,
    /// Every setting.
    pub settings: SolverSettings,
    /// Bodies, all kinds.
    pub bodies: u32,
    /// Joints.
    pub joints: u32,
    /// Contact points in the last step.
    pub contacts: u32,
    /// Steps taken.
    pub steps: u64,
    /// Time simulated.
    pub seconds: f64,
    /// What a step cost.
    pub ms_per_step: StepMilliseconds,
    /// What a step cost, in counts that no clock spoils.
    pub counts: StepCounts,
    /// Energy at both ends, and how far it strayed.
    pub energy: EnergyMetrics,
    /// Largest distance between the two anchors of a joint after any step.
    pub joint_error_max_m: f64,
    /// Largest contact depth found in any step.
    pub penetration_max_m: f64,
    /// Largest fall of any body below its start.
    pub sink_max_m: f64,
    /// Largest horizontal move of any body from its start.
    pub drift_max_m: f64,
    /// Distance from the scene's reference answer, where it has one.
    pub truth: Option<TruthMetrics>,
    /// How near it came to failing.
    pub shares: Shares,
    /// Bodies and joints set aside, and why.
    pub quarantined: Vec<QuarantinedEntity>,
    /// The vector instructions that the program was built for.
    pub simd: &'static str,
    /// 16 hex digits over all poses and velocities and what the solver carries over.
    pub state_hash: String,
}

/// Wall-clock time, ms, of the physics step alone.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct StepMilliseconds {
    /// Half of the steps took at most this.
    pub median: f64,
    /// 95 of 100 steps took at most this.
    pub p95: f64,
    /// All steps together.
    pub total: f64,
}

/// Work of the last step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct StepCounts {
    /// Row updates: rows × iterations × solves.
    pub row_updates: u64,
    /// Pairs that the narrow phase tested.
    pub pairs: u32,
}

/// Errors relative to what they are errors of: see [`judge`](super::verdict::judge).
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Shares {
    /// Largest joint separation over the smaller bounding diameter of the two bodies.
    pub joint_of_limb: f64,
    /// Largest (E − E₀)/S; none where S is 0.
    pub energy_rise: Option<f64>,
    /// Deepest contact over the smallest size of a body that moves; a size is the smallest full
    /// extent.
    pub sunk_of_size: f64,
    /// Largest move of a body over its size, in a scene that should stay as it is.
    pub moved_of_size: Option<f64>,
}

/// Σ ½mv² + ½ωᵀIω − m g·(x − x₀) over what moves, J, x₀ each body's start.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct EnergyMetrics {
    /// At the start.
    pub start: f64,
    /// At the end.
    pub end: f64,
    /// Largest |E − E₀|/S over the run; S is the largest kinetic energy of the answer, or of the
    /// run where the answer does not say, or for a scene at rest its weight × its height. None
    /// where S is 0.
    pub max_relative_drift: Option<f64>,
}

/// Distance from a reference answer.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TruthMetrics {
    /// What was compared.
    pub name: &'static str,
    /// How far off it was.
    pub error: f64,
    /// In this unit.
    pub unit: &'static str,
    /// How far the answer itself may be off.
    pub uncertainty: f64,
}

/// A body or joint that the step has set aside.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct QuarantinedEntity {
    /// Its name; a joint by its place in the scene.
    pub body: String,
    /// What was wrong.
    pub reason: String,
}

/// Watches a run and sums it up.
pub(super) struct Meter {
    truth: Option<Truth>,
    start: Vec<BodyState>,
    moving: Vec<Moving>,
    step_seconds: Vec<f64>,
    energy_start: f64,
    energy_end: f64,
    energy_strays: f64,
    energy_rises: f64,
    kinetic_max: f64,
    limbs: Vec<Limb>,
    joint_of_limb: f64,
    moved_of_size: f64,
    joint_error: f64,
    penetration: f64,
    sink: f64,
    drift: f64,
}

/// What the energy of a body depends on besides its state.
struct Moving {
    index: usize,
    mass: f64,
    inertia: DVec3,
    gravity: DVec3,
    /// Smallest full extent, m.
    size: f64,
}

/// A rigid joint, to see how far it parts.
struct Limb {
    bodies: [usize; 2],
    anchors: [DVec3; 2],
    /// Smaller bounding diameter of the bodies that have a shape, m.
    diameter: f64,
}

impl Meter {
    /// For a simulation that has not taken a step yet.
    pub fn new(simulation: &Simulation, mut truth: Option<Truth>) -> Self {
        let sample = simulation.sample();
        if let Some(truth) = &mut truth {
            truth.observe(&sample);
        }
        Self {
            truth,
            start: sample.bodies.to_vec(),
            moving: Vec::new(),
            step_seconds: Vec::new(),
            energy_start: 0.0,
            energy_end: 0.0,
            energy_strays: 0.0,
            energy_rises: 0.0,
            limbs: limbs(simulation.scene()),
            joint_of_limb: 0.0,
            moved_of_size: 0.0,
            kinetic_max: 0.0,
            joint_error: 0.0,
            penetration: 0.0,
            sink: 0.0,
            drift: 0.0,
        }
    }

    /// Takes in the state after a step.
    pub fn observe(&mut self, simulation: &Simulation) {
        let sample = simulation.sample();
        if self.step_seconds.is_empty() {
            // Masses are known from the first step on.
            self.moving = moving(simulation);
            let (kinetic, potential) = self.energy(&self.start);
            self.energy_start = kinetic + potential;
            self.kinetic_max = kinetic;
        }
        let world = simulation.world();
        self.step_seconds.push(world.resource::<StepStats>().step_seconds);
        let diagnostics = world.resource::<Diagnostics>();
        self.joint_error = self.joint_error.max(diagnostics.joint_error);
        self.penetration = self.penetration.max(diagnostics.penetration);

        let (kinetic, potential) = self.energy(sample.bodies);
        self.energy_end = kinetic + potential;
        self.energy_strays = self.energy_strays.max((self.energy_end - self.energy_start).abs());
        self.energy_rises = self.energy_rises.max(self.energy_end - self.energy_start);
        self.kinetic_max = self.kinetic_max.max(kinetic);
        for (state, start) in sample.bodies.iter().zip(&self.start) {
            let moved = state.position - start.position;
            self.sink = self.sink.max(-moved.y);
            self.drift = self.drift.max(moved.x.hypot(moved.z));
        }
        for limb in &self.limbs {
            let [one, other] = [0, 1].map(|side| {
                let BodyState { position, rotation, .. } = sample.bodies[limb.bodies[side]];
                position + rotation * limb.anchors[side]
            });
            self.joint_of_limb = self.joint_of_limb.max(one.distance(other) / limb.diameter);
        }
        for body in &self.moving {
            let moved = sample.bodies[body.index].position.distance(self.start[body.index].position);
            self.moved_of_size = self.moved_of_size.max(moved / body.size);
        }
        if let Some(truth) = &mut self.truth {
            truth.observe(&sample);
        }
    }

    /// Kinetic and potential energy, J.
    fn energy(&self, states: &[BodyState]) -> (f64, f64) {
        self.moving.iter().fold((0.0, 0.0), |(kinetic, potential), body| {
            let BodyState { position, rotation, linear, angular } = states[body.index];
            let spin = rotation.inverse() * angular;
            let fallen = position - self.start[body.index].position;
            (
                kinetic + 0.5 * (body.mass * linear.length_squared() + (body.inertia * spin).dot(spin)),
                potential - body.mass * body.gravity.dot(fallen),
            )
        })
    }

    /// The measurements, after the last step of a plan.
    pub fn finish(self, plan: &Plan, simulation: &Simulation) -> Metrics {
        let stats = simulation.world().resource::<StepStats>();
        let scale = self.energy_scale(&plan.scene);
        let truth = self.truth.as_ref().and_then(|truth| {
            let error = truth.error()?;
            Some(TruthMetrics { name: truth.name, error, unit: truth.unit, uncertainty: truth.uncertainty })
        });
        Metrics {
            scene: plan.scene.name.clone(),
            parameters: plan.parameters.iter().cloned().collect(),
            settings: plan.settings,
            bodies: stats.bodies,
            joints: stats.joints,
            contacts: stats.contact_points,
            steps: stats.steps,
            seconds: simulation.sample().time,
            energy: EnergyMetrics {
                start: self.energy_start,
                end: self.energy_end,
                max_relative_drift: (scale > 0.0).then(|| self.energy_strays / scale),
            },
            joint_error_max_m: self.joint_error,
            penetration_max_m: self.penetration,
            sink_max_m: self.sink,
            drift_max_m: self.drift,
            truth,
            counts: StepCounts { row_updates: stats.row_updates, pairs: stats.pairs },
            shares: Shares {
                joint_of_limb: self.joint_of_limb,
                energy_rise: (scale > 0.0).then(|| self.energy_rises / scale),
                sunk_of_size: self.penetration / self.moving.iter().map(|body| body.size).fold(f64::INFINITY, f64::min),
                moved_of_size: self.truth.as_ref().filter(|truth| truth.stays).map(|_| self.moved_of_size),
            },
            quarantined: simulation.quarantined(),
            simd: simd(),
            state_hash: format!("{:016x}", simulation.state_hash()),
            ms_per_step: milliseconds(self.step_seconds),
        }
    }

    fn energy_scale(&self, scene: &SceneSpec) -> f64 {
        match self.truth.as_ref().map_or(EnergyScale::LargestKinetic, |truth| truth.energy_scale) {
            EnergyScale::Known(joules) => joules,
            EnergyScale::LargestKinetic => self.kinetic_max,
            EnergyScale::WeightTimesHeight => {
                let weight: f64 = self.moving.iter().map(|body| body.mass * body.gravity.length()).sum();
                weight * height(scene, self.moving.iter().map(|body| &scene.bodies[body.index]))
            }
        }
    }
}

fn moving(simulation: &Simulation) -> Vec<Moving> {
    let scene = simulation.scene();
    let bodies = scene.bodies.iter().zip(&simulation.entities().bodies).enumerate();
    bodies
        .filter(|(_, (body, _))| body.kind == RigidBody::Dynamic)
        .filter_map(|(index, (body, &entity))| {
            let mass = simulation.world().get::<Mass>(entity)?.0;
            let inertia = simulation.world().get::<Inertia>(entity)?.0;
            let size = body.shape.as_ref().map_or(f64::INFINITY, ShapeSpec::smallest_extent);
            Some(Moving { index, mass, inertia, gravity: scene.gravity * body.gravity_scale, size })
        })
        .collect()
}

/// The rigid joints of a scene.
fn limbs(scene: &SceneSpec) -> Vec<Limb> {
    let by_name: HashMap<&str, usize> =
        (0..).zip(&scene.bodies).map(|(index, body)| (body.name.as_str(), index)).collect();
    let diameter = |body: usize| {
        let body = &scene.bodies[body];
        let shape = body.shape.as_ref().filter(|_| body.kind == RigidBody::Dynamic);
        shape.map_or(f64::INFINITY, |shape| 2.0 * shape.bounding_radius())
    };
    let rigid = scene.joints.iter().filter(|joint| joint.softness.is_none());
    rigid
        .filter_map(|joint| {
            let bodies = [*by_name.get(joint.body_a.as_str())?, *by_name.get(joint.body_b.as_str())?];
            let diameter = diameter(bodies[0]).min(diameter(bodies[1]));
            Some(Limb { bodies, anchors: [joint.anchor_a, joint.anchor_b], diameter })
        })
        .collect()
}

/// Extent of some bodies at their start along gravity, m.
fn height<'a>(scene: &SceneSpec, bodies: impl Iterator<Item = &'a BodySpec>) -> f64 {
    let Some(down) = scene.gravity.try_normalize() else { return 0.0 };
    let (lowest, highest) = bodies.fold((f64::NEG_INFINITY, f64::INFINITY), |(lowest, highest), body| {
        let depth = body.position.dot(down);
        (lowest.max(depth + reach(body, down)), highest.min(depth - reach(body, -down)))
    });
    (lowest - highest).max(0.0)
}

/// How far a body reaches from its centre of mass along a unit direction.
fn reach(body: &BodySpec, direction: DVec3) -> f64 {
    let direction = body.rotation.inverse() * direction;
    match &body.shape {
        None | Some(ShapeSpec::HalfSpace) => 0.0,
        Some(ShapeSpec::Sphere { radius }) => *radius,
        Some(ShapeSpec::Cuboid { size }) => (0.5 * *size).dot(direction.abs()),
        Some(ShapeSpec::Cone { radius, height }) => {
            let apex = 0.75 * height * direction.y;
            let rim = radius * direction.x.hypot(direction.z) - 0.25 * height * direction.y;
            apex.max(rim)
        }
        Some(shape @ (ShapeSpec::Hull(_) | ShapeSpec::Mesh(_))) => {
            let direction = shape.axes().inverse() * direction;
            let vertices = shape.convex_hull().into_iter().flat_map(ConvexHull::vertices);
            vertices.map(|vertex| vertex.dot(direction)).fold(0.0, f64::max)
        }
    }
}

fn milliseconds(mut seconds: Vec<f64>) -> StepMilliseconds {
    let total = 1e3 * seconds.iter().sum::<f64>();
    seconds.sort_unstable_by(f64::total_cmp);
    // Nearest rank: the smallest time that this share of the steps did not exceed.
    let rank = |share: f64| {
        let rank = (share * seconds.len() as f64).ceil() as usize;
        seconds.get(rank.max(1) - 1).map_or(0.0, |&seconds| 1e3 * seconds)
    };
    StepMilliseconds { median: rank(0.5), p95: rank(0.95), total }
}

/// The widest vector instructions that the compiler was allowed.
const fn simd() -> &'static str {
    if cfg!(target_feature = "avx512f") {
        "avx512"
    } else if cfg!(all(target_feature = "avx2", target_feature = "fma")) {
        "avx2+fma"
    } else if cfg!(target_feature = "avx2") {
        "avx2"
    } else if cfg!(target_feature = "sse2") {
        "sse2"
    } else if cfg!(target_feature = "neon") {
        "neon"
    } else {
        "none"
    }
}

#[cfg(test)]
mod tests {
    use bevy::math::DQuat;

    use super::*;

    #[test]
    fn percentiles_are_nearest_ranks() {
        let ms = milliseconds((1..=100).rev().map(|n| f64::from(n) * 1e-3).collect());
        assert!((ms.median - 50.0).abs() < 1e-9 && (ms.p95 - 95.0).abs() < 1e-9 && (ms.total - 5050.0).abs() < 1e-9);
        let one = milliseconds(vec![0.002]);
        assert!((one.median - 2.0).abs() < 1e-9 && one.median == one.p95);
    }

    #[test]
    fn height_is_the_extent_along_gravity() {
        let cuboid = ShapeSpec::Cuboid { size: DVec3::new(2.0, 4.0, 6.0) };
        let mut upright = BodySpec::new("a", cuboid, DVec3::new(0.0, 2.0, 0.0));
        let cone = BodySpec::new("b", ShapeSpec::Cone { radius: 1.0, height: 4.0 }, DVec3::new(0.0, 10.0, 0.0));
        let scene =
            |gravity| SceneSpec { name: "height".into(), gravity, bodies: Vec::new(), joints: Vec::new(), view: None };
        let down = scene(DVec3::NEG_Y * 9.81);
        assert_eq!(height(&down, [&upright, &cone].into_iter()), 13.0);
        assert_eq!(height(&down, [&upright].into_iter()), 4.0);
        assert_eq!(height(&scene(DVec3::Z), [&upright].into_iter()), 6.0);
        assert_eq!(height(&scene(DVec3::ZERO), [&upright].into_iter()), 0.0);
        upright.rotation = DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2);
        assert!((height(&down, [&upright].into_iter()) - 6.0).abs() < 1e-12);
    }
}
