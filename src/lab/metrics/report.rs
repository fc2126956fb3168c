//! The measurements of one run, and how near it came to failing.

use std::collections::BTreeMap;

use serde::Serialize;

use super::contacts::ContactResidual;
use super::cost::{ExactCounts, StepCounts, StepMilliseconds};
use super::energy::EnergyMetrics;
use super::joints::{JointGap, JointLoadMax, LimitOvershoot};
use super::momentum::MomentumMetrics;
use crate::lab::simulation::QuarantinedEntity;
use crate::lab::truth::Truth;
use crate::physics::SolverSettings;

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
    /// What the exact method had to do besides; none of another method.
    pub exact: Option<ExactCounts>,
    /// Energy at both ends, and how far it strayed.
    pub energy: EnergyMetrics,
    /// How far linear and angular momentum strayed.
    pub momentum: MomentumMetrics,
    /// Largest distance between the two anchors of a rigid joint, along what it holds of it, after any step.
    pub joint_error_max_m: f64,
    /// How far rigid joints came from what they hold after any step, by kind: `ball`, `hinge`, `slider`, `fixed`,
    /// `distance`, `generic`, those that the scene has. What is broken holds nothing.
    pub joint_gaps: BTreeMap<&'static str, JointGap>,
    /// How far joints went beyond their limits after any step; none where none has limits.
    pub limit_overshoot_max: Option<LimitOvershoot>,
    /// The largest force and the largest torque of a joint in any step; none without joints.
    pub joint_load_max: Option<JointLoadMax>,
    /// Joints that are broken in the end.
    pub broken_joints: u32,
    /// Largest contact depth found in any step.
    pub penetration_max_m: f64,
    /// Largest fall of any body below its start.
    pub sink_max_m: f64,
    /// Largest horizontal move of any body from its start.
    pub drift_max_m: f64,
    /// Root mean square, over the last second, of the speed of the fastest body (its centre's and
    /// what its spin adds), where all should rest.
    pub jitter_m_per_s: Option<f64>,
    /// Largest error, in the last second, of the contact and joint forces across any level of a
    /// scene at rest, over the weight that they carry; none where statics does not say.
    pub force_error: Option<f64>,
    /// How far the contact solves were from the laws of contact and friction; none without
    /// contacts.
    pub contact_residual: Option<ContactResidual>,
    /// Distance from the scene's reference answer, where it has one.
    pub truth: Option<TruthMetrics>,
    /// Why it has none.
    pub truth_unknown: Option<String>,
    /// Distances from what else is known of the scene.
    pub further_truths: Vec<TruthMetrics>,
    /// How near it came to failing.
    pub shares: Shares,
    /// Bodies and joints set aside, and why.
    pub quarantined: Vec<QuarantinedEntity>,
    /// The vector instructions that the program was built for.
    pub simd: &'static str,
    /// 16 hex digits over all poses and velocities and what the solver carries over.
    pub state_hash: String,
}

/// Errors relative to what they are errors of: see [`judge`](crate::lab::verdict::judge).
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
    /// The error above which the scene's own condition is broken.
    pub fails_above: Option<f64>,
}

impl TruthMetrics {
    /// None where nothing could be compared.
    pub(super) fn of(truth: &Truth) -> Option<Self> {
        let &Truth { name, unit, uncertainty, fails_above, .. } = truth;
        Some(Self { name, error: truth.error()?, unit, uncertainty, fails_above })
    }
}
