//! Which settings a chart tries.

use crate::lab::sweep::Point;
use crate::physics::{Integrator, Method, Precision, SolverSettings};

/// A curve of the charts: a method at one precision, as its steps, substeps and iterations vary.
pub struct Series {
    /// Its name in legends and files.
    pub name: &'static str,
    /// What does not vary.
    pub base: fn() -> SolverSettings,
}

/// The same without sleep.
fn awake(mut settings: SolverSettings) -> SolverSettings {
    settings.impulse.sleep_speed = None;
    settings
}

/// All curves, in the order of their colours. Nothing sleeps in them: what a method does with a scene at rest is to be
/// seen.
pub const SERIES: [Series; 11] = [
    Series { name: "game f32", base: || awake(SolverSettings::game()) },
    Series { name: "sequential impulses f32", base: || awake(SolverSettings::sequential_impulses()) },
    Series { name: "xpbd f32", base: || awake(SolverSettings::xpbd()) },
    Series { name: "classic f32", base: SolverSettings::classic },
    Series { name: "steady f32", base: SolverSettings::steady },
    Series {
        name: "steady f64 Verlet",
        base: || {
            let mut settings = SolverSettings { precision: Precision::F64, ..SolverSettings::steady() };
            settings.sweeps.integrator = Integrator::VelocityVerlet;
            settings
        },
    },
    Series {
        name: "game, full effort f32",
        base: || {
            let mut settings = awake(SolverSettings::game());
            settings.impulse.fitted_effort = false;
            settings
        },
    },
    Series {
        name: "steady cg_pgs f32",
        base: || SolverSettings { method: Method::PrimedGaussSeidel, ..SolverSettings::steady() },
    },
    Series {
        name: "steady nncg f32",
        base: || SolverSettings { method: Method::NonsmoothConjugateGradient, ..SolverSettings::steady() },
    },
    Series {
        name: "steady joint_space f32",
        base: || SolverSettings { method: Method::JointSpace, ..SolverSettings::steady() },
    },
    Series { name: "accurate f64", base: SolverSettings::accurate },
];

/// Whether the settings are worth a point beside those of the same step: the exact method has no sweeps, and substeps
/// of it are shorter steps.
pub(in crate::lab) fn differs(settings: &SolverSettings, least: &SolverSettings) -> bool {
    settings.method != Method::Exact || settings.substeps == least.substeps && settings.iterations == least.iterations
}

/// How much a chart tries.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extent {
    /// A few points a curve and short runs: all scenes in minutes.
    Quick,
    /// Every combination, as long as the scene suggests.
    Full,
}

impl Extent {
    fn rates(self) -> &'static [f64] {
        match self {
            Self::Quick => &[60.0, 240.0],
            Self::Full => &[30.0, 60.0, 120.0, 240.0, 480.0, 960.0],
        }
    }

    fn substeps(self) -> &'static [u32] {
        match self {
            Self::Quick => &[1, 4],
            Self::Full => &[1, 2, 4, 8, 16],
        }
    }

    fn iterations(self) -> &'static [u32] {
        match self {
            Self::Quick => &[1, 10],
            Self::Full => &[1, 4, 10, 30, 100],
        }
    }

    /// Longest time that a quick run simulates, s.
    pub fn seconds(self, scene: f64) -> f64 {
        match self {
            Self::Quick => scene.min(2.0),
            Self::Full => scene,
        }
    }
}

/// The points of one scene's chart, cheap ones first.
pub fn points(scene: &str, parameters: &[(String, f64)], seconds: f64, extent: Extent) -> Vec<Point> {
    let mut points = Vec::new();
    for &hz in extent.rates() {
        for &substeps in extent.substeps() {
            for &iterations in extent.iterations() {
                for series in &SERIES {
                    let settings = SolverSettings { hz, substeps, iterations, threads: 1, ..(series.base)() };
                    let [substeps, iterations] = [extent.substeps()[0], extent.iterations()[0]];
                    if differs(&settings, &SolverSettings { substeps, iterations, ..settings }) {
                        points.push(Point {
                            scene: scene.to_owned(),
                            parameters: parameters.to_vec(),
                            settings,
                            seconds,
                            series: series.name.to_owned(),
                        });
                    }
                }
            }
        }
    }
    let work = |point: &Point| {
        let SolverSettings { hz, substeps, iterations, .. } = point.settings;
        hz * f64::from(substeps) * f64::from(iterations)
    };
    points.sort_by(|one, other| work(one).total_cmp(&work(other)));
    points
}
