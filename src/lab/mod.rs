//! Measuring: scenes run without a window, what they did and cost, how far they are from their
//! reference answers; and the command line on top of it.

pub mod command;
mod metrics;
mod run;
mod settings_file;
mod trajectory;
pub mod truth;

pub use metrics::{EnergyMetrics, Metrics, QuarantinedEntity, StepMilliseconds, TruthMetrics};
pub use run::{BodyState, MOST_STEPS, Plan, PlanError, Sample, Simulation, measure};
pub use settings_file::{SettingsFileError, read_settings};
pub use trajectory::TrajectoryWriter;
