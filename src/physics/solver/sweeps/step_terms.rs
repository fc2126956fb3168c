//! What a step is to force-level sweeps, whatever the island.

use crate::physics::contact::restitution_threshold;
use crate::physics::settings::{FrictionModel, Integrator, Method, Precision, SolverSettings};

/// The settings as the substep loop reads them.
pub(crate) struct StepTerms {
    pub method: Method,
    pub integrator: Integrator,
    pub precision: Precision,
    pub substeps: u32,
    pub iterations: u32,
    pub warm_starting: bool,
    /// Length of a substep, s.
    pub h: f64,
    /// β: share of an error mended per second of a substep, 1/s.
    pub error_rate: f64,
    /// m; unlimited: infinite.
    pub slop: f64,
    /// m/s; infinite where there is no limit.
    pub correction_speed: f64,
    /// m/s; infinite where nothing bounces.
    pub restitution_speed: f64,
    pub friction: FrictionModel,
    /// |g|, m/s².
    pub gravity: f64,
    /// Whether somebody reads contact forces.
    pub record_forces: bool,
    /// Simulation time when the step began, s.
    pub start: f64,
}

impl StepTerms {
    pub fn new(settings: &SolverSettings, gravity: f64, record_forces: bool, start: f64) -> Self {
        let h = settings.step() / f64::from(settings.substeps);
        Self {
            method: settings.method,
            integrator: settings.sweeps.integrator,
            precision: settings.precision,
            substeps: settings.substeps,
            iterations: settings.iterations,
            warm_starting: settings.sweeps.warm_starting,
            h,
            error_rate: settings.sweeps.baumgarte / h,
            slop: settings.slop,
            correction_speed: settings.correction_speed.unwrap_or(f64::INFINITY),
            restitution_speed: restitution_threshold(settings),
            friction: settings.friction,
            gravity,
            record_forces,
            start,
        }
    }

    /// The greatest speed at which a contact of that depth is pushed out, m/s. Where there is a
    /// limit, no faster than gravity brings to rest on the way: a landing body would be thrown up
    /// again, whatever its restitution.
    pub fn greatest_push(&self, depth: f64) -> f64 {
        if self.gravity == 0.0 || self.correction_speed == f64::INFINITY {
            return self.correction_speed;
        }
        let way = (depth - self.slop).max(0.0);
        self.correction_speed.min((2.0 * self.gravity * way).sqrt())
    }
}
