//! Measuring: scenes run without a window, what they did and cost, how far they are from their
//! reference answers; and the command line on top of it.

mod angle;
pub mod chart;
pub mod command;
mod contact_problem;
pub mod fit;
mod joined;
pub mod map;
mod metrics;
mod picture;
mod plan;
pub mod race;
pub mod recording;
mod run;
mod settings_file;
mod simulation;
pub mod sweep;
mod trajectory;
pub mod truth;
pub mod vary;
pub mod verdict;
mod whole_file;

pub use crate::physics::BodyState;
pub use angle::turn_between;
pub use contact_problem::{ContactProblemError, contact_problem_files, read_contact_problem, write_contact_problem};
pub use metrics::{
    ContactResidual, EnergyMetrics, ExactCounts, JointGap, JointLoadMax, LimitOvershoot, Metrics, MomentumMetrics,
    Shares, StepCounts, StepMilliseconds, TruthMetrics, widest_gap_of_limb,
};
pub use picture::{PictureError, round_step};
pub use plan::{MOST_STEPS, Plan, PlanError};
pub use run::measure;
pub use settings_file::{SettingsFileError, read_settings, settings_text, write_settings};
pub use simulation::{QuarantinedEntity, Sample, Simulation, state_hash};
pub use trajectory::TrajectoryWriter;
pub use whole_file::{Draft, write_whole};
