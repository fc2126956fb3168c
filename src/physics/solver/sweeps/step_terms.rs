//! What a step is to force-level sweeps, whatever the island.

use crate::physics::settings::SolverSettings;

/// The settings, and what follows from them for every substep.
pub(crate) struct StepTerms<'a> {
    pub settings: &'a SolverSettings,
    /// Length of a substep, s.
    pub h: f64,
    /// β: share of an error mended per second of a substep, 1/s.
    pub error_rate: f64,
    /// The same of what is not mended apart from the velocities; zero where that is.
    pub bias_rate: f64,
    /// m/s; infinite where there is no limit.
    pub correction_speed: f64,
    /// |g|, m/s².
    pub gravity: f64,
    /// Whether somebody reads contact forces.
    pub record_forces: bool,
    /// Whether somebody reads the residual of each sweep.
    pub traces: bool,
    /// Simulation time when the step began, s.
    pub start: f64,
}

impl<'a> StepTerms<'a> {
    pub fn new(settings: &'a SolverSettings, gravity: f64, record_forces: bool, start: f64) -> Self {
        let h = settings.step() / f64::from(settings.substeps);
        let error_rate = settings.sweeps.baumgarte / h;
        let bias_rate = if settings.sweeps.nonlinear_projection { 0.0 } else { error_rate };
        let correction_speed = settings.correction_speed.unwrap_or(f64::INFINITY);
        Self { settings, h, error_rate, bias_rate, correction_speed, gravity, record_forces, traces: false, start }
    }

    /// The greatest speed at which a contact of that depth is pushed out, m/s. Where there is a
    /// limit, no faster than gravity brings to rest on the way: a landing body would be thrown up
    /// again, whatever its restitution.
    pub fn greatest_push(&self, depth: f64) -> f64 {
        if self.gravity == 0.0 || self.correction_speed == f64::INFINITY {
            return self.correction_speed;
        }
        let way = (depth - self.settings.slop).max(0.0);
        self.correction_speed.min((2.0 * self.gravity * way).sqrt())
    }
}
