//! What came of one run of a sweep: a row of the CSV.

use serde::{Deserialize, Serialize};

use crate::lab::Metrics;
use crate::lab::settings_file::{settings_from_ron, settings_to_ron};
use crate::lab::verdict::{Judgement, Verdict};
use crate::physics::SolverSettings;

use super::Point;

/// One row. Numbers that were not measured are empty.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// [`Point::key`].
    pub key: String,
    /// Fingerprint of the program that measured it.
    pub program: String,
    /// The scene.
    pub scene: String,
    /// Its parameters that differ from their defaults, as `n=5 tilt=30`.
    pub parameters: String,
    /// Time simulated, s.
    pub seconds: f64,
    /// The curve it belongs to.
    pub series: String,
    /// Steps per second.
    pub hz: f64,
    /// Substeps of a step.
    pub substeps: u32,
    /// Sweeps of a substep.
    pub iterations: u32,
    /// All settings, as a settings file has them.
    pub settings: String,
    /// Distance from the scene's answer.
    pub error: Option<f64>,
    /// Its unit.
    pub unit: String,
    /// The answer's own uncertainty, in the same unit.
    pub uncertainty: Option<f64>,
    /// Median wall-clock time of a step, ms, of the fastest of the repeats.
    pub ms_per_step: Option<f64>,
    /// How much larger the slowest repeat's median was, ms; none of a single run.
    pub ms_spread: Option<f64>,
    /// 95 of 100 steps took at most this, ms.
    pub ms_p95: Option<f64>,
    /// Row updates of the last step.
    pub row_updates: u64,
    /// Pairs tested in the last step.
    pub pairs: u32,
    /// Axes along which pairs were measured in the last step.
    pub axes_tested: u64,
    /// Largest |E − E₀|/S.
    pub energy_drift: Option<f64>,
    /// Largest relative drift of linear momentum, where nothing outside takes part.
    pub linear_momentum_drift: Option<f64>,
    /// Largest relative drift of angular momentum, where nothing outside takes part.
    pub angular_momentum_drift: Option<f64>,
    /// Worst joint separation, m.
    pub joint_error: Option<f64>,
    /// Worst penetration, m.
    pub penetration: Option<f64>,
    /// Largest fall of any body below its start, m.
    pub sink: Option<f64>,
    /// Largest horizontal move of any body, m.
    pub drift: Option<f64>,
    /// Speed that is left in the last second where all should rest, m/s.
    pub jitter: Option<f64>,
    /// Largest error of the forces across a level over the weight they carry.
    pub force_error: Option<f64>,
    /// Worst relative residual of the contacts' natural map.
    pub contact_residual: Option<f64>,
    /// That of the last step.
    pub contact_residual_last: Option<f64>,
    /// Holds, degrades or fails.
    pub verdict: Verdict,
    /// Why it degrades or fails.
    pub reason: String,
}

impl Record {
    /// A run that came to its end, the fastest of its repeats, whose medians spread by so much.
    pub(super) fn of(
        point: &Point,
        program: &str,
        metrics: &Metrics,
        ms_spread: Option<f64>,
        judgement: Judgement,
    ) -> Self {
        Self {
            error: metrics.truth.as_ref().map(|truth| truth.error),
            unit: metrics.truth.as_ref().map_or(String::new(), |truth| truth.unit.to_owned()),
            uncertainty: metrics.truth.as_ref().map(|truth| truth.uncertainty),
            ms_per_step: Some(metrics.ms_per_step.median),
            ms_spread,
            ms_p95: Some(metrics.ms_per_step.p95),
            row_updates: metrics.counts.row_updates,
            pairs: metrics.counts.pairs,
            axes_tested: metrics.counts.axes_tested,
            energy_drift: metrics.energy.max_relative_drift,
            linear_momentum_drift: metrics.momentum.linear_max_relative_drift,
            angular_momentum_drift: metrics.momentum.angular_max_relative_drift,
            joint_error: Some(metrics.joint_error_max_m),
            penetration: Some(metrics.penetration_max_m),
            sink: Some(metrics.sink_max_m),
            drift: Some(metrics.drift_max_m),
            jitter: metrics.jitter_m_per_s,
            force_error: metrics.force_error,
            contact_residual: metrics.contact_residual.map(|residual| residual.worst),
            contact_residual_last: metrics.contact_residual.map(|residual| residual.last),
            ..Self::failed(point, program, judgement)
        }
    }

    /// A run that did not.
    pub(in crate::lab) fn failed(point: &Point, program: &str, judgement: Judgement) -> Self {
        Self {
            key: point.key(),
            program: program.to_owned(),
            scene: point.scene.clone(),
            parameters: point.parameters_text(),
            seconds: point.seconds,
            series: point.series.clone(),
            hz: point.settings.hz,
            substeps: point.settings.substeps,
            iterations: point.settings.iterations,
            settings: settings_to_ron(&point.settings),
            error: None,
            unit: String::new(),
            uncertainty: None,
            ms_per_step: None,
            ms_spread: None,
            ms_p95: None,
            row_updates: 0,
            pairs: 0,
            axes_tested: 0,
            energy_drift: None,
            linear_momentum_drift: None,
            angular_momentum_drift: None,
            joint_error: None,
            penetration: None,
            sink: None,
            drift: None,
            jitter: None,
            force_error: None,
            contact_residual: None,
            contact_residual_last: None,
            verdict: judgement.verdict,
            reason: judgement.reason,
        }
    }

    /// Wall-clock time for a simulated second, ms.
    pub fn cost(&self) -> Option<f64> {
        self.ms_per_step.map(|ms| ms * self.hz)
    }

    /// The settings it ran with; none if they cannot be read.
    pub fn solver_settings(&self) -> Option<SolverSettings> {
        settings_from_ron(&self.settings).ok()
    }
}
