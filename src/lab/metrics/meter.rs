//! Watches a run and sums it up.
//!
//! The clock of a step stops before anything here is looked at. What is measured lab-side costs a
//! few passes over bodies, joints and contacts a step, where the solver takes dozens.

use bevy::ecs::entity::EntityHashMap;

use super::contacts::ContactMeter;
use super::cost::{ExactCounts, StepCounts, StepMilliseconds, simd};
use super::energy::EnergyMeter;
use super::forces::ForceMeter;
use super::joints::JointMeter;
use super::momentum::MomentumMeter;
use super::moving::{Moving, moving};
use super::report::{Metrics, Shares, TruthMetrics};
use super::rest::RestMeter;
use crate::lab::plan::Plan;
use crate::lab::simulation::Simulation;
use crate::lab::truth::{EnergyScale, Truth, Unknown};
use crate::physics::{BodyState, ContactForces, Diagnostics, JointForces, Method, StepStats};

/// Time at the end of a run over which a scene that stays is looked at for jitter and forces, s.
const SETTLED_SECONDS: f64 = 1.0;

/// Watches a run and sums it up.
pub(in crate::lab) struct Meter {
    truth: Option<Truth>,
    unknown: Option<Unknown>,
    start: Vec<BodyState>,
    /// Places in the scene by entity.
    indices: EntityHashMap<usize>,
    /// Steps from this one on are the last [`SETTLED_SECONDS`].
    settled_from: u64,
    step_seconds: Vec<f64>,
    exact: ExactCounts,
    penetration: f64,
    joints: JointMeter,
    rest: RestMeter,
    forces: Option<ForceMeter>,
    /// From the first step on, when masses are known.
    motion: Option<Motion>,
}

/// What depends on masses.
struct Motion {
    bodies: Vec<Moving>,
    energy: EnergyMeter,
    momentum: MomentumMeter,
    contacts: ContactMeter,
}

impl Meter {
    /// For a simulation of a plan that has not taken a step yet.
    pub fn new(plan: &Plan, simulation: &mut Simulation, truth: Option<Result<Truth, Unknown>>) -> Self {
        let (mut truth, unknown) = match truth.transpose() {
            Ok(truth) => (truth, None),
            Err(unknown) => (None, Some(unknown)),
        };
        let world = simulation.world_mut();
        world.init_resource::<Diagnostics>();
        world.init_resource::<ContactForces>();
        world.init_resource::<JointForces>();
        let statics = truth.as_mut().and_then(|truth| truth.statics.take());
        if truth.as_ref().is_some_and(|truth| truth.reads_loads) {
            simulation.read_loads();
        }
        let sample = simulation.sample();
        if let Some(truth) = &mut truth {
            truth.observe(&sample);
        }
        let settled_steps = (SETTLED_SECONDS * plan.settings.hz).ceil() as u64;
        let indices = (0..).zip(&simulation.entities().bodies).map(|(index, &entity)| (entity, index)).collect();
        Self {
            truth,
            unknown,
            start: sample.bodies.to_vec(),
            settled_from: plan.steps.saturating_sub(settled_steps) + 1,
            step_seconds: Vec::new(),
            exact: ExactCounts::default(),
            penetration: 0.0,
            joints: JointMeter::new(simulation.scene()),
            rest: RestMeter::default(),
            forces: statics.map(|statics| ForceMeter::new(simulation, statics)),
            motion: None,
            indices,
        }
    }

    /// Takes in the state after a step.
    pub fn observe(&mut self, simulation: &Simulation) {
        let sample = simulation.sample();
        let world = simulation.world();
        let stats = world.resource::<StepStats>();
        self.step_seconds.push(stats.step_seconds);
        self.exact.add(stats);
        self.penetration = self.penetration.max(world.resource::<Diagnostics>().penetration);
        self.joints.observe(simulation);

        let start = &self.start;
        let Motion { bodies, energy, momentum, contacts } =
            self.motion.get_or_insert_with(|| Motion::new(simulation, start));
        let settled = sample.step >= self.settled_from;
        let contact_forces = world.resource::<ContactForces>();
        energy.observe(bodies, start, sample.bodies);
        contacts.observe(&self.indices, &contact_forces.0, sample.bodies);
        momentum.observe(bodies, sample.bodies, sample.time, contacts.touched_outside);
        self.rest.observe(bodies, start, sample.bodies, settled);
        if let Some(forces) = self.forces.as_mut().filter(|_| settled) {
            forces.observe(&self.indices, contact_forces, world.resource::<JointForces>());
        }
        if let Some(truth) = &mut self.truth {
            truth.observe(&sample);
        }
    }

    /// The measurements, after the last step of a plan.
    pub fn finish(self, plan: &Plan, simulation: &Simulation) -> Metrics {
        let motion = self.motion.unwrap_or_else(|| Motion::new(simulation, &self.start));
        let stats = simulation.world().resource::<StepStats>();
        let scale = self.truth.as_ref().map_or(EnergyScale::LargestKinetic, |truth| truth.energy_scale);
        let scale = motion.energy.scale(scale, &motion.bodies, &plan.scene);
        let stays = self.truth.as_ref().is_some_and(|truth| truth.stays);
        let joints = self.joints.finish();
        let least_size = motion.bodies.iter().map(|body| body.size).fold(f64::INFINITY, f64::min);
        Metrics {
            scene: plan.scene.name.clone(),
            parameters: plan.parameters.iter().cloned().collect(),
            settings: plan.settings,
            bodies: stats.bodies,
            joints: stats.joints,
            contacts: stats.contact_points,
            steps: stats.steps,
            seconds: simulation.sample().time,
            ms_per_step: StepMilliseconds::of(self.step_seconds),
            counts: StepCounts::of(stats),
            exact: (plan.settings.method == Method::Exact).then_some(self.exact),
            energy: motion.energy.metrics(scale),
            momentum: motion.momentum.metrics(),
            joint_error_max_m: joints.gaps.values().map(|gap| gap.gap_m).fold(0.0, f64::max),
            joint_gaps: joints.gaps,
            limit_overshoot_max: joints.overshoot,
            joint_load_max: joints.load,
            broken_joints: joints.broken,
            penetration_max_m: self.penetration,
            sink_max_m: self.rest.sink,
            drift_max_m: self.rest.drift,
            jitter_m_per_s: stays.then(|| self.rest.jitter()),
            force_error: self.forces.map(|forces| forces.error),
            contact_residual: motion.contacts.residual(),
            truth: self.truth.as_ref().and_then(TruthMetrics::of),
            truth_unknown: self.unknown.map(|unknown| unknown.to_string()),
            further_truths: self.truth.iter().flat_map(|truth| &truth.further).filter_map(TruthMetrics::of).collect(),
            shares: Shares {
                joint_of_limb: joints.of_limb,
                energy_rise: motion.energy.rise(scale),
                sunk_of_size: self.penetration / least_size,
                moved_of_size: stays.then_some(self.rest.of_size),
            },
            quarantined: simulation.quarantined(),
            simd: simd(),
            state_hash: format!("{:016x}", simulation.state_hash()),
        }
    }
}

impl Motion {
    fn new(simulation: &Simulation, start: &[BodyState]) -> Self {
        let bodies = moving(simulation);
        let settings = simulation.settings();
        Self {
            energy: EnergyMeter::new(&bodies, start),
            momentum: MomentumMeter::new(simulation.scene(), settings, &bodies, start),
            contacts: ContactMeter::new(simulation, &bodies, settings, start),
            bodies,
        }
    }
}
