//! What a run did, how true it was and what it cost: the object that `--json` prints.
//!
//! One file a measure; the `meter` feeds them with each step of a run.

mod contacts;
mod cost;
mod energy;
mod extent;
mod forces;
mod joints;
mod meter;
mod momentum;
mod moving;
mod natural_map;
mod report;
mod rest;

pub use contacts::ContactResidual;
pub use cost::{ExactCounts, StepCounts, StepMilliseconds};
pub use energy::EnergyMetrics;
pub use joints::{JointGap, JointLoadMax, LimitOvershoot, widest_gap_of_limb};
pub(super) use meter::Meter;
pub use momentum::MomentumMetrics;
pub use report::{Metrics, Shares, TruthMetrics};
